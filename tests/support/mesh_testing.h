#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/delaunay/metric_flip.h"
#include "core/geometry/domain.h"
#include "core/geometry/mesh_data.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_diff.h"
#include "core/mesh/mesh_edit.h"
#include "core/pliant/followed_metric.h"

namespace pliant::testing {

/// Of a triangle with three sides of length 1.
inline constexpr double kEquilateralHeight = 0.8660254037844386;

/// A mesh with its editor, which holds on to its address.
struct EditedMesh {
  EditedMesh() = default;
  EditedMesh(const EditedMesh&) = delete;
  EditedMesh& operator=(const EditedMesh&) = delete;

  Mesh mesh;
  MeshEdit edit{mesh};
};

/// @pre the import succeeds; a failure ends the test program with the reason.
[[nodiscard]] std::unique_ptr<EditedMesh> ImportedMesh(const MeshData& data);
[[nodiscard]] std::unique_ptr<EditedMesh> DomainMesh(const Domain& domain);

/// A grid of nx times ny unit cells from (0, 0), each cut along its rising diagonal; vertex
/// y * (nx + 1) + x lies at (x, y).
[[nodiscard]] MeshData GridData(std::int32_t nx, std::int32_t ny);

/// What Validate finds, one fault a line; empty for a valid mesh.
[[nodiscard]] std::string Faults(const Mesh& mesh);

/// The first difference between two meshes, record by record and bit by bit; empty if there is
/// none. Hints are left out: they decide nothing.
[[nodiscard]] std::string DifferenceOf(const Mesh& a, const Mesh& b);

/// A client's copy of a mesh: does what a diff says and knows nothing else.
class Replica {
 public:
  /// Removes and writes. @return what the diff does that no diff may; empty if it is in order.
  std::string Apply(const MeshDiff& diff);

  /// The first difference to the mesh itself; empty if there is none.
  [[nodiscard]] std::string DifferenceTo(const Mesh& mesh) const;

  /// Counts and hash from nothing but the replica's contents.
  [[nodiscard]] MeshSummary Summary() const;

 private:
  struct Triangle {
    std::array<VertexId, 3> vertices;
    std::int32_t region = 0;
    friend bool operator==(const Triangle&, const Triangle&) = default;
  };
  struct Edge {
    std::array<VertexId, 2> vertices;
    std::int32_t tag = 0;
    friend bool operator==(const Edge&, const Edge&) = default;
  };

  Revision revision_ = Revision::kNone;
  std::map<VertexId, Vec2> vertices_;
  std::map<VertexId, Metric> metrics_;
  std::map<TriangleId, Triangle> triangles_;
  std::map<EdgeId, Edge> edges_;
};

/// Random valid edits of a mesh: swaps, splits, moves, slides, deletions, metrics.
class RandomEditor {
 public:
  RandomEditor(EditedMesh& target, std::uint64_t seed) : target_(target), rng_(seed) {}

  /// Tries one edit. @return its name, or nothing where the draw could not be done.
  std::string Step();

  [[nodiscard]] Rng& rng() { return rng_; }

 private:
  bool Swap();
  bool Split();
  bool Move();
  bool Slide();
  bool Remove();
  bool ChangeMetric();
  [[nodiscard]] Side RandomSide();
  [[nodiscard]] VertexId RandomVertex();

  EditedMesh& target_;
  MetricFlipper flipper_{target_.edit};
  Rng rng_;
};

using pliant::LiveVertices;
/// Live triangles, ascending.
[[nodiscard]] std::vector<TriangleId> LiveTriangles(const Mesh& mesh);

/// Area of the triangles of each region.
[[nodiscard]] std::map<std::int32_t, double> RegionAreas(const Mesh& mesh);
/// Length of the constrained edges of each tag.
[[nodiscard]] std::map<std::int32_t, double> TagLengths(const Mesh& mesh);

}  // namespace pliant::testing
