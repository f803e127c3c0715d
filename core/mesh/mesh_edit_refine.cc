// MeshEdit, the part that halves many edges at once: only before the first commit.

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/touch_pages.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/refine_templates.h"

namespace pliant {
namespace {

/// Room for what the loop inserts on a level, one part in so many: few per cent, or arrays of half
/// a mesh would be moved for the last few elements.
constexpr std::size_t kSlackShare = 32;

constexpr std::int32_t kNone = -1;

/// The refined mesh, written from one end to the other.
class Refinement {
 public:
  Refinement(const Mesh& mesh, std::span<const EdgeSplit> splits, std::span<const TriangleId> order,
             Executor& executor)
      : mesh_(mesh),
        splits_(splits),
        order_(order),
        executor_(executor),
        chunks_(std::ssize(order)),
        split_at_(static_cast<std::size_t>(mesh.triangle_slots()), {kNone, kNone, kNone}),
        first_child_(split_at_.size(), kNone),
        codes_(split_at_.size(), 0),
        first_at_(static_cast<std::size_t>(mesh.vertex_slots()), INT32_MAX),
        last_at_(first_at_.size(), kNone),
        new_vertex_(first_at_.size(), kNone),
        new_middle_(splits.size(), kNone) {
    MarkSplits();
    ChooseTemplates();
    FindFirstAndLast();
    NumberVertices();
    PointAtTriangles();
    MakeTriangles();
  }

  MeshVector<VertexRecord> vertices;
  MeshVector<std::int32_t> hints;
  MeshVector<TriangleRecord> triangles;
  /// Children with a constrained side.
  std::vector<TriangleId> constrained;

  [[nodiscard]] VertexId NewVertex(VertexId old) const {
    return VertexId(new_vertex_[old.index()]);
  }
  [[nodiscard]] VertexId NewMiddle(std::size_t split) const { return VertexId(new_middle_[split]); }

 private:
  /// Runs function(triangle) for the parents of each chunk in order.
  template <class Function>
  void ForParentsOf(std::int32_t chunk, Function&& function) const {
    for (std::int64_t i = chunks_.begin(chunk); i < chunks_.end(chunk); ++i) {
      function(order_[static_cast<std::size_t>(i)]);
    }
  }

  void MarkSplits() {
    Chunks(std::ssize(splits_)).ForEach(executor_, [&](std::int32_t i) {
      const Side side = splits_[static_cast<std::size_t>(i)].side;
      const auto corner = static_cast<std::size_t>(side.corner);
      split_at_[side.triangle.index()][corner] = i;
      const TriangleId beyond = mesh_.triangle(side.triangle).neighbors[corner];
      if (!beyond.valid()) return;
      const auto back = static_cast<std::size_t>(mesh_.SideTowards(beyond, side.triangle));
      split_at_[beyond.index()][back] = i;
    });
  }

  void ChooseTemplates() {
    std::vector<std::size_t> begins(static_cast<std::size_t>(chunks_.count()) + 1, 0);
    executor_.Run(chunks_.count(), [&](std::int32_t chunk) {
      std::size_t count = 0;
      ForParentsOf(chunk, [&](TriangleId t) {
        const std::size_t code = CodeOf(mesh_.triangle(t), split_at_[t.index()]);
        codes_[t.index()] = static_cast<std::uint8_t>(code);
        count += kRefineTemplates[code].count;
      });
      begins[static_cast<std::size_t>(chunk) + 1] = count;
    });
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    executor_.Run(chunks_.count(), [&](std::int32_t chunk) {
      std::size_t first = begins[static_cast<std::size_t>(chunk)];
      ForParentsOf(chunk, [&](TriangleId t) {
        first_child_[t.index()] = static_cast<std::int32_t>(first);
        first += kRefineTemplates[codes_[t.index()]].count;
      });
    });
    ReserveTouched(triangles, begins.back() + begins.back() / kSlackShare, executor_);
    if (executor_.stopped()) return;  // Who stops does not want to wait for the memory either.
    triangles.resize(begins.back());
  }

  /// For each old vertex, the first and the last parent that has it, by their first children, which
  /// ascend in the order of parents. Chunks share vertices; lowest and highest do not depend on who
  /// comes first.
  void FindFirstAndLast() {
    const auto replace = [](std::int32_t& place, std::int32_t rank, auto&& is_better) {
      const std::atomic_ref<std::int32_t> shared(place);
      std::int32_t known = shared.load(std::memory_order_relaxed);
      while (is_better(rank, known) &&
             !shared.compare_exchange_weak(known, rank, std::memory_order_relaxed)) {
      }
    };
    executor_.Run(chunks_.count(), [&](std::int32_t chunk) {
      ForParentsOf(chunk, [&](TriangleId t) {
        for (const VertexId vertex : mesh_.triangle(t).vertices) {
          replace(first_at_[vertex.index()], first_child_[t.index()], std::less<>());
        }
      });
      for (std::int64_t i = chunks_.end(chunk); i-- > chunks_.begin(chunk);) {
        const TriangleId t = order_[static_cast<std::size_t>(i)];
        for (const VertexId vertex : mesh_.triangle(t).vertices) {
          replace(last_at_[vertex.index()], first_child_[t.index()], std::greater<>());
        }
      }
    });
  }

  /// Gives vertices their new slots: the given ones keep theirs, the others get them in the order
  /// in which triangles first have them.
  void NumberVertices() {
    if (executor_.stopped()) return;
    const std::size_t count = static_cast<std::size_t>(mesh_.vertex_count()) + splits_.size();
    ReserveTouched(vertices, count + count / kSlackShare, executor_);
    if (executor_.stopped()) return;
    vertices.resize(count);
    hints.reserve(count + count / kSlackShare);
    hints.resize(count);
    std::int32_t next = 0;
    for (std::int32_t v = 0; v < mesh_.vertex_slots(); ++v) {
      if (!mesh_.vertex(VertexId(v)).fixed) continue;
      PutVertex(VertexId(v), next++);
      first_at_[static_cast<std::size_t>(v)] = kNone;  // No parent is to number it.
    }
    std::vector<std::int32_t> begins(static_cast<std::size_t>(chunks_.count()) + 1, next);
    executor_.Run(chunks_.count(), [&](std::int32_t chunk) {
      std::int32_t& points = begins[static_cast<std::size_t>(chunk) + 1] = 0;
      ForPointsTakenIn(chunk, [&](TriangleId, std::size_t) { ++points; });
    });
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    executor_.Run(chunks_.count(), [&](std::int32_t chunk) {
      std::int32_t number = begins[static_cast<std::size_t>(chunk)];
      ForPointsTakenIn(chunk, [&](TriangleId t, std::size_t point) {
        if (point < 3) {
          PutVertex(mesh_.triangle(t).vertices[point], number++);
        } else {
          PutMiddle(static_cast<std::size_t>(split_at_[t.index()][point - 3]), number++);
        }
      });
    });
  }

  /// Runs function(parent, point) for all points that a parent of the chunk is the first to have.
  template <class Function>
  void ForPointsTakenIn(std::int32_t chunk, Function&& function) const {
    ForParentsOf(chunk, [&](TriangleId t) {
      const std::int32_t rank = first_child_[t.index()];
      for (const std::size_t point : {0U, 5U, 4U, 1U, 3U, 2U}) {
        if (point < 3) {
          const VertexId old = mesh_.triangle(t).vertices[point];
          if (first_at_[old.index()] == rank) function(t, point);
        } else if (split_at_[t.index()][point - 3] >= 0) {
          const TriangleId beyond = mesh_.triangle(t).neighbors[point - 3];
          if (!beyond.valid() || rank < first_child_[beyond.index()]) function(t, point);
        }
      }
    });
  }

  /// Every vertex names a child of the last parent that has it.
  void PointAtTriangles() {
    executor_.Run(chunks_.count(), [&](std::int32_t chunk) {
      ForParentsOf(chunk, [&](TriangleId t) {
        const std::int32_t rank = first_child_[t.index()];
        const auto& child_of_point = kRefineTemplates[codes_[t.index()]].child_of_point;
        for (std::size_t i = 0; i < 3; ++i) {
          const VertexId old = mesh_.triangle(t).vertices[i];
          if (last_at_[old.index()] == rank) {
            vertices[NewVertex(old).index()].triangle = TriangleId(rank + child_of_point[i]);
          }
          const std::int32_t split = split_at_[t.index()][i];
          if (split < 0) continue;
          const TriangleId beyond = mesh_.triangle(t).neighbors[i];
          if (beyond.valid() && rank < first_child_[beyond.index()]) continue;
          vertices[NewMiddle(static_cast<std::size_t>(split)).index()].triangle =
              TriangleId(rank + child_of_point[3 + i]);
        }
      });
    });
  }

  /// Bits of the sides that are split, and the shorter diagonal where two are: in the mean metric
  /// of the parent's corners, because middles have none yet.
  [[nodiscard]] std::size_t CodeOf(const TriangleRecord& parent,
                                   const std::array<std::int32_t, 3>& split_at) const {
    const std::size_t code =
        (split_at[0] >= 0 ? 1U : 0U) | (split_at[1] >= 0 ? 2U : 0U) | (split_at[2] >= 0 ? 4U : 0U);
    if (code != 3 && code != 5 && code != 6) return code;
    const std::size_t whole = code == 6 ? 0 : code == 5 ? 1 : 2;
    const std::size_t j = (whole + 1) % 3;
    const std::size_t k = (whole + 2) % 3;
    const auto& v = parent.vertices;
    const Metric sum = mesh_.metric(v[0]) + mesh_.metric(v[1]) + mesh_.metric(v[2]);
    const auto middle = [&](std::size_t side) {
      return splits_[static_cast<std::size_t>(split_at[side])].position;
    };
    const double from_k = SquaredLength(sum, mesh_.position(v[k]) - middle(k));
    const double from_j = SquaredLength(sum, middle(j) - mesh_.position(v[j]));
    return from_k <= from_j ? code : code + RefineTemplate::kOtherDiagonal;
  }

  void PutVertex(VertexId old, std::int32_t number) {
    new_vertex_[old.index()] = number;
    vertices[static_cast<std::size_t>(number)] = mesh_.vertex(old);
    hints[static_cast<std::size_t>(number)] = mesh_.hint(old);
  }

  void PutMiddle(std::size_t split, std::int32_t number) {
    new_middle_[split] = number;
    VertexRecord& record = vertices[static_cast<std::size_t>(number)];
    record.position = splits_[split].position;
    record.live = true;
    const Side side = splits_[split].side;
    const auto& corners = mesh_.triangle(side.triangle).vertices;
    const VertexId a = corners[static_cast<std::size_t>(NextCorner(side.corner))];
    const VertexId b = corners[static_cast<std::size_t>(PreviousCorner(side.corner))];
    record.metric = GeometricMean(mesh_.metric(a), mesh_.metric(b));
    hints[static_cast<std::size_t>(number)] = mesh_.hint(a);
  }

  void MakeTriangles() {
    std::vector<std::vector<TriangleId>> found(static_cast<std::size_t>(chunks_.count()));
    executor_.Run(chunks_.count(), [&](std::int32_t chunk) {
      ForParentsOf(chunk,
                   [&](TriangleId t) { MakeChildren(t, found[static_cast<std::size_t>(chunk)]); });
    });
    for (const auto& ids : found) constrained.insert(constrained.end(), ids.begin(), ids.end());
  }

  /// Writes the children of a parent, and the ids of those with a constrained side.
  void MakeChildren(TriangleId t, std::vector<TriangleId>& found) {
    const TriangleRecord& parent = mesh_.triangle(t);
    const RefineTemplate& children = kRefineTemplates[codes_[t.index()]];
    std::array<VertexId, 6> points;
    for (std::size_t i = 0; i < 3; ++i) {
      points[i] = NewVertex(parent.vertices[i]);
      const std::int32_t split = split_at_[t.index()][i];
      if (split >= 0) points[3 + i] = NewMiddle(static_cast<std::size_t>(split));
    }
    const std::array<std::array<TriangleId, 2>, 3> beyond = ChildrenBeyond(t);
    const auto first = static_cast<std::size_t>(first_child_[t.index()]);
    for (std::size_t c = 0; c < children.count; ++c) {
      TriangleRecord& child = triangles[first + c];
      for (std::size_t side = 0; side < 3; ++side) {
        child.vertices[side] = points[children.points[c][side]];
        const std::size_t behind = children.behind[c][side];
        if (behind < RefineTemplate::kOutside) {
          child.neighbors[side] = TriangleId::FromIndex(first + behind);
          continue;
        }
        const std::size_t half = behind - RefineTemplate::kOutside;
        child.neighbors[side] = beyond[half / 2][half % 2];
        const unsigned is_constrained = (parent.constrained >> (half / 2)) & 1U;
        child.constrained = static_cast<std::uint8_t>(child.constrained | is_constrained << side);
      }
      child.region = parent.region;
      child.live = true;
      if (child.constrained != 0) found.push_back(TriangleId::FromIndex(first + c));
    }
  }

  /// The children of the neighbours at each half of each side of a parent.
  [[nodiscard]] std::array<std::array<TriangleId, 2>, 3> ChildrenBeyond(TriangleId t) const {
    std::array<std::array<TriangleId, 2>, 3> result;
    for (std::size_t side = 0; side < 3; ++side) {
      const TriangleId beyond = mesh_.triangle(t).neighbors[side];
      if (!beyond.valid()) continue;
      const auto back = static_cast<std::size_t>(mesh_.SideTowards(beyond, t));
      const auto& child_at = kRefineTemplates[codes_[beyond.index()]].child_at[back];
      const std::size_t last = split_at_[t.index()][side] >= 0 ? 1 : 0;
      for (std::size_t half = 0; half <= last; ++half) {
        result[side][half] = TriangleId(first_child_[beyond.index()] + child_at[last - half]);
      }
    }
    return result;
  }

  const Mesh& mesh_;
  std::span<const EdgeSplit> splits_;
  std::span<const TriangleId> order_;
  Executor& executor_;
  const Chunks chunks_;                                // Of `order_`.
  std::vector<std::array<std::int32_t, 3>> split_at_;  // Per triangle side: its split, or kNone.
  std::vector<std::int32_t> first_child_;              // Per triangle.
  std::vector<std::uint8_t> codes_;                    // Per triangle: of kRefineTemplates.
  std::vector<std::int32_t> first_at_;                 // Per old vertex: FindFirstAndLast.
  std::vector<std::int32_t> last_at_;
  std::vector<std::int32_t> new_vertex_;  // Per old vertex.
  std::vector<std::int32_t> new_middle_;  // Per split.
};

}  // namespace

void MeshEdit::Refine(std::span<const EdgeSplit> splits, std::span<const TriangleId> order) {
  InlineExecutor alone;
  (void)Refine(splits, order, alone);
}

bool MeshEdit::Refine(std::span<const EdgeSplit> splits, std::span<const TriangleId> order,
                      Executor& executor) {
  PLIANT_CHECK(!logging());
  PLIANT_CHECK(std::ssize(order) == mesh_.triangle_count(), "order", order.size());
  Refinement refined(mesh_, splits, order, executor);
  if (executor.stopped()) return false;
  const auto constrained_ends = [&](const EdgeSplit& split) {
    const auto& v = mesh_.triangle(split.side.triangle).vertices;
    return std::pair(
        refined.NewVertex(v[static_cast<std::size_t>(NextCorner(split.side.corner))]),
        refined.NewVertex(v[static_cast<std::size_t>(PreviousCorner(split.side.corner))]));
  };
  struct EdgeToSplit {
    VertexId from;
    VertexId to;
    VertexId middle;
    double t;
  };
  std::vector<EdgeToSplit> edges_to_split;
  for (std::size_t i = 0; i < splits.size(); ++i) {
    const Side side = splits[i].side;
    if (!mesh_.triangle(side.triangle).IsConstrained(side.corner)) continue;
    const auto [from, to] = constrained_ends(splits[i]);
    edges_to_split.push_back({from, to, refined.NewMiddle(i), splits[i].t});
  }
  for (EdgeRecord& edge : mesh_.edges_) {
    if (!edge.live) continue;
    for (VertexId& end : edge.vertices) end = refined.NewVertex(end);
  }
  for (SegmentRecord& segment : mesh_.segments_) {
    if (segment.a.valid()) segment.a = refined.NewVertex(segment.a);
    if (segment.b.valid()) segment.b = refined.NewVertex(segment.b);
  }
  mesh_.vertices_ = std::move(refined.vertices);
  mesh_.hints_ = std::move(refined.hints);
  mesh_.triangles_ = std::move(refined.triangles);
  mesh_.vertex_allocator_.Reset(static_cast<std::int32_t>(mesh_.vertices_.size()));
  mesh_.triangle_allocator_.Reset(static_cast<std::int32_t>(mesh_.triangles_.size()));
  for (const EdgeToSplit& edge : edges_to_split) {
    SplitConstrainedEdge(mesh_.FindEdge(edge.from, edge.to), edge.middle, edge.t);
  }
  for (const TriangleId id : refined.constrained) PointEdgesAt(id);
  edges_ahead_ = false;
  if constexpr (kValidateEvery) {
    std::vector<TriangleId> all;
    for (std::size_t t = 0; t < mesh_.triangles_.size(); ++t) {
      all.push_back(TriangleId::FromIndex(t));
    }
    CheckAfter(all);
  }
  return true;
}

}  // namespace pliant
