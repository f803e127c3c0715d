#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh_edit.h"
#include "core/pliant/mesh_change.h"
#include "core/pliant/refill.h"

namespace pliant {

/// A vertex and where it is to lie.
struct Displacement {
  VertexId vertex;
  Vec2 to;
};

/// What became of the others.
struct Displaced {
  std::vector<VertexId> disturbed;  ///< Live vertices at triangles of another shape, ascending.
  std::vector<VertexId> created;    ///< New ones, where others were: among them; ascending.
  std::vector<GapVertex> fillers;   ///< The same in the order in which they were made.
  std::int64_t removed_count = 0;   ///< Vertices that were run over.
};

/// True for a vertex of the interior that is neither given nor frozen.
[[nodiscard]] bool IsDisplaceable(const Mesh& mesh, VertexId vertex);

/// What becomes of the gap behind displaced vertices.
enum class Behind {
  kLeft,      ///< Nothing.
  kRefilled,  ///< It gets new vertices, at most as many as are run over.
};

/// Where a vertex comes to lie that follows a displacement as far as it may: a displaceable one all
/// the way, one inside a segment along it; nothing for others, which stay.
[[nodiscard]] std::optional<Vec2> PlaceAfter(const Mesh& mesh, VertexId vertex, Vec2 by);

/// Puts vertices elsewhere in one go. Those that they run over are removed, displaced ones that
/// would leave the domain too, and the cavity that this leaves is triangulated, so that every
/// triangle is positive. Vertices inside segments slide along them, and others there are run over
/// in the same way, as long as none of them would change places.
/// @param list  vertices that are displaceable or slidable, none twice
/// @return nothing, and everyone where he was, if the cavity has no triangulation or is frozen
/// @par Cost O(k log k) for k vertices
[[nodiscard]] std::optional<Displaced> Displace(MeshEdit& edit, std::span<const Displacement> list,
                                                Behind behind = Behind::kLeft);

/// A displacement that a client sends with a metric, because it knows how a feature moves that the
/// metric follows: a help, no order. Given vertices stay, others on constrained edges slide along
/// them where the displacement leads there; if the way is blocked, everyone stays. Tensors go along
/// with their vertices, so that tensors that are set afterwards are those of the vertices where
/// they are then; DisplaceWithTensors takes them beforehand. Errors of Apply, with `field`
/// "metric.displacements": kArrayLength, kIndexOutOfRange (not a live vertex), kDuplicateId,
/// kNotFinite; index = position in the given span.
class DisplaceVertices final : public MeshChange {
 public:
  /// @param by  one for each vertex, in domain units. Both must outlive this.
  DisplaceVertices(std::span<const VertexId> vertices, std::span<const Vec2> by)
      : vertices_(vertices), by_(by) {}

  Result<Outcome> Apply(MeshEdit& edit) override;
  void Permit(const Permissions& permissions) override {
    slides_ = permissions.surface;
    behind_ = permissions.insert ? Behind::kRefilled : Behind::kLeft;
  }

  /// The errors of Apply, before anything is done.
  [[nodiscard]] Status Check(const Mesh& mesh) const;

  /// Vertices that were displaced; 0 if the way was blocked.
  [[nodiscard]] std::int64_t displaced_count() const { return displaced_count_; }
  /// New vertices in the gap, in the order in which they were made.
  [[nodiscard]] std::span<const GapVertex> fillers() const { return fillers_; }

 private:
  std::span<const VertexId> vertices_;
  std::span<const Vec2> by_;
  bool slides_ = true;
  Behind behind_ = Behind::kRefilled;
  std::int64_t displaced_count_ = 0;
  std::vector<GapVertex> fillers_;
};

}  // namespace pliant
