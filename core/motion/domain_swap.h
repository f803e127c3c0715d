#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/geometry/domain.h"
#include "core/geometry/locate.h"
#include "core/mesh/mesh_edit.h"
#include "core/motion/domain_cavity.h"
#include "core/motion/domain_fill.h"
#include "core/motion/domain_match.h"
#include "core/motion/replace_domain.h"
#include "core/pliant/mesh_change.h"

namespace pliant {

/// Carries out ReplaceDomain on a mesh, once.
///
/// What goes is gathered in a cavity: the triangles at edges that go, and those that new edges
/// cross or touch. Walls are drawn around it, along what stays, and along the new edges; they may
/// enclose places where there was no mesh. What the walls enclose is triangulated and takes the
/// region that the new domain has there, or stays empty. Triangles behind the walls that are in
/// another region now, or outside, are found from the walls by going from neighbour to neighbour.
/// *Threads*: one caller at a time.
class DomainSwap {
 public:
  using Outcome = MeshChange::Outcome;

  /// @param stop  asked between the stages, null: nobody. Both outlive this object.
  explicit DomainSwap(const Domain& domain, const StopSignal* stop = nullptr)
      : domain_(domain), stop_(stop) {}

  /// Errors: those of ReplaceDomain; kCancelled.
  Result<Outcome> Apply(MeshEdit& edit);

  [[nodiscard]] const DomainReport& report() const { return report_; }

 private:
  using Ends = std::pair<VertexId, VertexId>;
  struct CavityWall {
    Wall wall;
    TriangleId covered;  ///< The triangle on a kCovered side.
  };

  [[nodiscard]] Status GoOn() const;
  void ListPieces(const Mesh& mesh);
  [[nodiscard]] std::vector<std::int32_t> GroupsOfPoints() const;
  [[nodiscard]] bool LosesAllEdges(const Mesh& mesh, VertexId vertex) const;
  [[nodiscard]] std::vector<VertexId> CornersOfCavity(const Mesh& mesh) const;
  Status SettlePoints(MeshEdit& edit);
  void SplitChains(const Mesh& mesh);
  void InsertInChain(const Mesh& mesh, std::size_t segment, std::vector<VertexId> inside);

  void DrawWalls(const Mesh& mesh);
  void DrawAroundCavity(const Mesh& mesh);
  void DrawChains(const Mesh& mesh);
  void DrawKept(const Mesh& mesh, EdgeId edge);
  void LookBehind(const Mesh& mesh, EdgeId edge, std::span<const EdgeId> alike);
  [[nodiscard]] FillRequest RequestFill(const Mesh& mesh);
  [[nodiscard]] StateAround StateAt(const Mesh& mesh, VertexId vertex);

  Status FloodBehind(const Mesh& mesh, const Filling& filling);
  Status Flood(const Mesh& mesh, TriangleId start, const SideState& wanted);
  Result<bool> Mark(TriangleId id, const SideState& wanted);
  void KeepAlike(const Mesh& mesh, std::vector<NewTriangle>& triangles);

  void ReplaceEdges(MeshEdit& edit);
  Status ReplaceTriangles(MeshEdit& edit, std::vector<NewTriangle> triangles);
  Status RemoveVertices(MeshEdit& edit, std::span<const VertexId> corners);
  Status ListGoing(const Mesh& mesh);
  [[nodiscard]] Outcome Finish(const Mesh& mesh, std::span<const NewTriangle> triangles) const;
  [[nodiscard]] Error Unclear() const;

  const Domain& domain_;
  const StopSignal* const stop_;
  DomainTriangulation inside_;
  DomainMatch match_;
  CavityRequest request_;
  std::vector<std::size_t> segment_of_piece_;  // The loose points' pieces come after these.
  TriangleSet cavity_;
  std::vector<VertexId> expelled_;  // Stand where rounding leaves no room for them; ascending.
  std::vector<VertexId> created_;
  std::set<VertexId> on_chains_;  // Vertices of new segments.
  std::map<Ends, CavityWall> walls_;
  std::vector<std::pair<TriangleId, SideState>> behind_;  // To be something else.
  TriangleSet flooded_;                                   // Triangles behind the walls...
  std::vector<SideState> flooded_as_;                     // ...and what becomes of them.
  std::vector<TriangleId> going_;  // All triangles that are replaced or removed.
  std::unique_ptr<TriangleLocator> locator_;
  DomainReport report_;
};

}  // namespace pliant
