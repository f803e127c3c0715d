#pragma once

#include <limits>
#include <vector>

#include "core/geometry/box_tree.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// How far vertices of constrained edges are from what faces them, through the domain.
///
/// What counts are the input segments, not the edges that the mesh has made of them: a vertex looks
/// along the normals of its segments into the domain, as far as the first segment that has no end
/// in common with the one it stands on. So a sharp corner is no gap. *Threads*: immutable once
/// built.
class BoundaryGaps {
 public:
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  /// A gap counts as at least this share of the reach: one that closes must not ask for ever
  /// smaller elements.
  static constexpr double kFloor = 0.01;

  /// @par Cost O(s log s) for s segments
  explicit BoundaryGaps(const Mesh& mesh);

  /// The segments of `mesh` are those of the one that this was made from. @par Cost O(s)
  [[nodiscard]] bool IsOf(const Mesh& mesh) const;

  /// The narrowest gap that begins at a vertex; kNone if none is below `reach`.
  /// @param mesh  has the segments that this was made from.
  /// @par Cost a search among the segments within `reach`; O(1) for vertices inside the domain.
  [[nodiscard]] double WidthAt(const Mesh& mesh, VertexId vertex, double reach) const;

 private:
  struct Line {
    VertexId a;
    VertexId b;
    Vec2 from;
    Vec2 to;

    friend bool operator==(const Line&, const Line&) = default;
  };
  struct Ray {
    Vec2 origin;
    Vec2 direction;  ///< Of length 1.
    double length;
  };

  [[nodiscard]] static std::vector<Line> LinesOf(const Mesh& mesh);
  [[nodiscard]] double FirstHit(const Ray& ray, const Line& own) const;

  std::vector<Line> lines_;          ///< By segment; those that are no line have no `b`.
  std::vector<std::int32_t> boxed_;  ///< The lines in the tree.
  BoxTree tree_;
};

}  // namespace pliant
