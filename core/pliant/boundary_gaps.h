#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "core/base/lazy.h"
#include "core/geometry/bounding_box.h"
#include "core/geometry/box_tree.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// The input segments of a mesh as they were once, and how far vertices of constrained edges are
/// from what faces them, through the domain.
///
/// What counts are the input segments, not the edges that the mesh has made of them: a vertex looks
/// along the normals of its segments into the domain, as far as the first segment that has no end
/// in common with the one it stands on. So a sharp corner is no gap.
/// *Threads*: immutable once built.
class BoundaryGaps {
 public:
  static constexpr double kNone = std::numeric_limits<double>::infinity();
  /// A gap counts as at least this share of the reach: one that closes must not ask for ever
  /// smaller elements.
  static constexpr double kFloor = 0.01;

  /// @par Cost O(s) for s segments, and O(s log s) for the first question
  explicit BoundaryGaps(const Mesh& mesh);

  /// True if a segment of `mesh` has other ends or another place than here.
  [[nodiscard]] bool Differs(const Mesh& mesh, std::int32_t segment) const;
  /// Holds all segments that differ, as they are here and as they are in `mesh`; none if there are
  /// none. @par Cost O(s)
  [[nodiscard]] std::optional<BoundingBox> DifferenceTo(const Mesh& mesh) const;

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
  struct Boxed {
    std::vector<std::int32_t> segments;  ///< Those that are lines, in the order of their boxes.
    BoxTree tree;
  };
  struct Ray {
    Vec2 origin;
    Vec2 direction;  ///< Of length 1.
    double length;
  };

  [[nodiscard]] static Line LineOf(const Mesh& mesh, const SegmentRecord& segment);
  [[nodiscard]] Boxed MakeBoxes() const;
  [[nodiscard]] double FirstHit(const Ray& ray, const Line& own) const;

  std::vector<Line> lines_;    ///< By segment; what is no line has no `b`.
  mutable Lazy<Boxed> boxed_;  ///< Segments may change often and only their lengths count.
};

}  // namespace pliant
