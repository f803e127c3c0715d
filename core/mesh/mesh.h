#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/check.h"
#include "core/base/ids.h"
#include "core/base/large_pages.h"
#include "core/base/prefetch.h"
#include "core/geometry/vec2.h"
#include "core/mesh/slots.h"
#include "core/metric/metric.h"

namespace pliant {

/// What the loop remembers about a node between its visits; part of the vertex so that a visit
/// touches one cache line and a rollback restores it with the rest.
struct VisitState {
  /// How far the node has moved since its neighbours last heard of it, in domain units.
  float drift_x = 0;
  float drift_y = 0;
  std::uint32_t epoch =
      0;                 ///< Update in which `age` and `hop` were set; other values mean "never".
  std::uint8_t age = 0;  ///< Visits in that update, see core/README.md on termination.
  std::uint8_t hop = 0;  ///< Edges between the node and what the update changed.
  bool active : 1 = false;  ///< Waits in the queue.
  bool cold : 1 = false;    ///< In that update: only its surroundings changed; it began old.
  bool tired : 1 = false;   ///< Was cooled in its last update: its surroundings cannot be met.
  bool mended : 1 = false;  ///< Stands where mending has put it.

  friend bool operator==(const VisitState&, const VisitState&) = default;
};

/// One vertex, one cache line.
struct alignas(64) VertexRecord {
  Vec2 position;
  Metric metric;
  TriangleId triangle;  ///< Any triangle at the vertex.
  EdgeId edge;          ///< Head of the list of its constrained edges; none in the interior.
  [[no_unique_address]] VisitState visit;  // The flags below use its last byte.
  bool live : 1 = false;
  bool fixed : 1 = false;      ///< Given by the domain: the loop neither moves nor deletes it.
  bool pinched : 1 = false;    ///< Several fans of triangles meet here (touching loops); is fixed.
  bool touched : 1 = false;    ///< The change log has its state of the last commit.
  bool committed : 1 = false;  ///< Was live at the last commit: others know this slot.
  bool frozen : 1 = false;     ///< A constraint keeps it: as `fixed`, until that is lifted.
};
static_assert(sizeof(VertexRecord) == 64);

/// The squared length of the edge between two vertices in the mean of their metrics.
[[nodiscard]] inline double SquaredEdgeLength(const VertexRecord& a, const VertexRecord& b) {
  return SquaredLength(0.5 * (a.metric + b.metric), b.position - a.position);
}

/// One triangle; side i lies opposite corner i.
struct TriangleRecord {
  std::array<VertexId, 3> vertices;     ///< Counter-clockwise.
  std::array<TriangleId, 3> neighbors;  ///< Across side i; none on the boundary.
  std::int32_t region = 0;
  std::uint8_t constrained = 0;  ///< Bit i: side i is a constrained edge.
  bool live : 1 = false;
  bool touched : 1 = false;    ///< As for vertices.
  bool committed : 1 = false;  ///< As for vertices.
  bool frozen : 1 = false;     ///< A constraint keeps it; its corners and edges are frozen too.

  [[nodiscard]] constexpr bool IsConstrained(std::integral auto side) const {
    return ((constrained >> side) & 1) != 0;
  }
  [[nodiscard]] constexpr bool HasCorner(VertexId vertex) const {
    return vertices[0] == vertex || vertices[1] == vertex || vertices[2] == vertex;
  }
};
static_assert(sizeof(TriangleRecord) == 32);

/// One constrained edge: a piece of a segment.
struct EdgeRecord {
  std::array<VertexId, 2> vertices;    ///< In the direction of the segment.
  std::array<double, 2> parameters{};  ///< Where on the segment the ends lie, in [0, 1], ascending.
  std::array<EdgeId, 2> next;          ///< Next edge in the list of vertices[i].
  TriangleId triangle;                 ///< A triangle at the edge.
  std::int32_t tag = 0;
  std::int32_t segment = -1;  ///< Index into Mesh::segments().
  bool live : 1 = false;
  bool touched : 1 = false;    ///< As for vertices.
  bool committed : 1 = false;  ///< As for vertices.
  bool frozen : 1 = false;     ///< A constraint keeps it whole; its ends are frozen too.
};

/// An array over the elements of a mesh.
template <class Record>
using MeshVector = LargeVector<Record>;

/// A straight line that constrained edges lie on, by its end vertices, which are fixed. Without `b`
/// a given point that is on no line; without `a` too, a place that a later one may take.
struct SegmentRecord {
  VertexId a;
  VertexId b;

  [[nodiscard]] bool is_line() const { return b.valid(); }
};

/// Index of the next corner counter-clockwise, and of the one after it.
constexpr int NextCorner(int corner) { return corner == 2 ? 0 : corner + 1; }
constexpr int PreviousCorner(int corner) { return corner == 0 ? 2 : corner - 1; }

/// A conforming triangulation with constrained edges and a metric at its vertices.
///
/// Only MeshEdit changes it; everything else reads. Elements are records in arrays indexed by slot;
/// dead slots keep their place until they are used again.
///
/// *Invariants*: those that Validate checks.
/// *Threads*: any number of readers, or one writer.
class Mesh {
 public:
  [[nodiscard]] const VertexRecord& vertex(VertexId id) const { return vertices_[id.index()]; }
  [[nodiscard]] const TriangleRecord& triangle(TriangleId id) const {
    return triangles_[id.index()];
  }
  [[nodiscard]] const EdgeRecord& edge(EdgeId id) const { return edges_[id.index()]; }
  /// Asks the memory for a record that will be read soon. Changes nothing but the time that takes.
  void Prefetch(VertexId id) const { PrefetchToRead(&vertices_[id.index()]); }
  void Prefetch(TriangleId id) const { PrefetchToRead(&triangles_[id.index()]); }

  [[nodiscard]] Vec2 position(VertexId id) const { return vertices_[id.index()].position; }
  [[nodiscard]] const Metric& metric(VertexId id) const { return vertices_[id.index()].metric; }

  /// Where the metric field found the vertex last; never decides anything.
  [[nodiscard]] std::int32_t hint(VertexId id) const { return hints_[id.index()]; }

  /// One past the highest slot in use or once used; loops over elements run to here and skip the
  /// dead.
  [[nodiscard]] std::int32_t vertex_slots() const { return vertex_allocator_.size(); }
  [[nodiscard]] std::int32_t triangle_slots() const { return triangle_allocator_.size(); }
  [[nodiscard]] std::int32_t edge_slots() const { return edge_allocator_.size(); }
  /// Live elements.
  [[nodiscard]] std::int32_t vertex_count() const { return vertex_allocator_.live_count(); }
  [[nodiscard]] std::int32_t triangle_count() const { return triangle_allocator_.live_count(); }
  [[nodiscard]] std::int32_t edge_count() const { return edge_allocator_.live_count(); }

  [[nodiscard]] bool IsLive(VertexId id) const {
    return id.valid() && id.value() < vertex_slots() && vertex(id).live;
  }

  /// Records by slot, dead ones included: for saving, and for loops over all of them.
  [[nodiscard]] std::span<const VertexRecord> vertex_records() const { return vertices_; }
  [[nodiscard]] std::span<const TriangleRecord> triangle_records() const { return triangles_; }
  [[nodiscard]] std::span<const EdgeRecord> edge_records() const { return edges_; }

  [[nodiscard]] const std::vector<SegmentRecord>& segments() const { return segments_; }

  /// The point of a segment at parameter t in [0, 1]; its end vertices exactly at 0 and 1.
  [[nodiscard]] Vec2 PointOnSegment(std::int32_t segment, double t) const;

  /// The corner of `triangle` that is `vertex`. @pre it has that corner
  [[nodiscard]] int CornerOf(TriangleId triangle_id, VertexId vertex_id) const {
    const auto& corners = triangle(triangle_id).vertices;
    PLIANT_DCHECK(corners[0] == vertex_id || corners[1] == vertex_id || corners[2] == vertex_id,
                  "triangle", triangle_id, "vertex", vertex_id);
    return IndexAmong(corners[1] == vertex_id, corners[2] == vertex_id);
  }

  /// The side of `triangle` behind which `neighbor` lies. @pre they are neighbours
  [[nodiscard]] int SideTowards(TriangleId triangle_id, TriangleId neighbor) const {
    const auto& neighbors = triangle(triangle_id).neighbors;
    PLIANT_DCHECK(neighbors[0] == neighbor || neighbors[1] == neighbor || neighbors[2] == neighbor,
                  "triangle", triangle_id, "neighbor", neighbor);
    return IndexAmong(neighbors[1] == neighbor, neighbors[2] == neighbor);
  }

  /// The constrained edge between two vertices, in either direction; none if there is no such edge.
  /// @par Cost O(constrained edges at a)
  [[nodiscard]] EdgeId FindEdge(VertexId a, VertexId b) const;

  /// The constrained edges at a vertex of which it has exactly two: those of a vertex inside a
  /// segment, first the one that ends there, then the one that begins there.
  [[nodiscard]] std::array<EdgeId, 2> SegmentEdges(VertexId vertex_id) const;

  /// The most clockwise triangle of the fan of `vertex` that contains `start`; `start` itself if
  /// the fan is closed.
  [[nodiscard]] TriangleId FanStart(VertexId vertex_id, TriangleId start) const;

 private:
  /// 0, 1 or 2 without a branch: which of three it is cannot be predicted.
  static int IndexAmong(bool is_second, bool is_third) {
    return static_cast<int>(is_second) + 2 * static_cast<int>(is_third && !is_second);
  }

  friend class MeshEdit;
  friend class MeshBreaker;  // Of validate_test.cc: makes every fault that Validate looks for.

  MeshVector<VertexRecord> vertices_;
  MeshVector<std::int32_t> hints_;  // Per vertex slot; apart, because the log does not hold them.
  MeshVector<TriangleRecord> triangles_;
  std::vector<EdgeRecord> edges_;
  std::vector<SegmentRecord> segments_;
  SlotAllocator vertex_allocator_;
  SlotAllocator triangle_allocator_;
  SlotAllocator edge_allocator_;
};

}  // namespace pliant
