// MeshEdit, the part that halves many edges at once: only before the first commit.

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

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
  Refinement(const Mesh& mesh, std::span<const EdgeSplit> splits, std::span<const TriangleId> order)
      : mesh_(mesh),
        splits_(splits),
        order_(order),
        split_at_(static_cast<std::size_t>(mesh.triangle_slots()), {kNone, kNone, kNone}),
        first_child_(split_at_.size(), kNone),
        codes_(split_at_.size(), 0),
        new_vertex_(static_cast<std::size_t>(mesh.vertex_slots()), kNone),
        new_middle_(splits.size(), kNone) {
    MarkSplits();
    NumberVertices();
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
  void MarkSplits() {
    for (std::size_t i = 0; i < splits_.size(); ++i) {
      const Side side = splits_[i].side;
      const auto corner = static_cast<std::size_t>(side.corner);
      split_at_[side.triangle.index()][corner] = static_cast<std::int32_t>(i);
      const TriangleId beyond = mesh_.triangle(side.triangle).neighbors[corner];
      if (!beyond.valid()) continue;
      const auto back = static_cast<std::size_t>(mesh_.SideTowards(beyond, side.triangle));
      split_at_[beyond.index()][back] = static_cast<std::int32_t>(i);
    }
  }

  /// Chooses templates and gives vertices their new slots: the given ones keep theirs, the others
  /// get them in the order in which triangles first have them.
  void NumberVertices() {
    const std::size_t count = static_cast<std::size_t>(mesh_.vertex_count()) + splits_.size();
    vertices.reserve(count + count / kSlackShare);
    hints.reserve(count + count / kSlackShare);
    for (std::int32_t v = 0; v < mesh_.vertex_slots(); ++v) {
      if (mesh_.vertex(VertexId(v)).fixed) TakeVertex(VertexId(v));
    }
    std::size_t triangle_count = 0;
    for (const TriangleId t : order_) {
      const TriangleRecord& parent = mesh_.triangle(t);
      const std::size_t code = CodeOf(parent, split_at_[t.index()]);
      codes_[t.index()] = static_cast<std::uint8_t>(code);
      first_child_[t.index()] = static_cast<std::int32_t>(triangle_count);
      for (const std::size_t point : {0U, 5U, 4U, 1U, 3U, 2U}) {
        const VertexId vertex = TakePoint(t, point);
        if (!vertex.valid()) continue;
        vertices[vertex.index()].triangle =
            TriangleId::FromIndex(triangle_count + kRefineTemplates[code].child_of_point[point]);
      }
      triangle_count += kRefineTemplates[code].count;
    }
    triangles.reserve(triangle_count + triangle_count / kSlackShare);
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

  /// The new slot of a parent's point, taken now if it has none; none for a side that is whole.
  VertexId TakePoint(TriangleId t, std::size_t point) {
    if (point < 3) {
      const VertexId old = mesh_.triangle(t).vertices[point];
      if (new_vertex_[old.index()] < 0) TakeVertex(old);
      return NewVertex(old);
    }
    const std::int32_t split = split_at_[t.index()][point - 3];
    if (split < 0) return VertexId();
    const auto index = static_cast<std::size_t>(split);
    if (new_middle_[index] < 0) TakeMiddle(index);
    return NewMiddle(index);
  }

  void TakeVertex(VertexId old) {
    new_vertex_[old.index()] = static_cast<std::int32_t>(vertices.size());
    vertices.push_back(mesh_.vertex(old));
    hints.push_back(mesh_.hint(old));
  }

  void TakeMiddle(std::size_t split) {
    new_middle_[split] = static_cast<std::int32_t>(vertices.size());
    VertexRecord& record = vertices.emplace_back();
    record.position = splits_[split].position;
    record.live = true;
    const Side side = splits_[split].side;
    const auto end = static_cast<std::size_t>(NextCorner(side.corner));
    hints.push_back(mesh_.hint(mesh_.triangle(side.triangle).vertices[end]));
  }

  void MakeTriangles() {
    for (const TriangleId t : order_) {
      const TriangleRecord& parent = mesh_.triangle(t);
      const RefineTemplate& children = kRefineTemplates[codes_[t.index()]];
      std::array<VertexId, 6> points;
      for (std::size_t i = 0; i < 3; ++i) {
        points[i] = NewVertex(parent.vertices[i]);
        const std::int32_t split = split_at_[t.index()][i];
        if (split >= 0) points[3 + i] = NewMiddle(static_cast<std::size_t>(split));
      }
      const std::array<std::array<TriangleId, 2>, 3> beyond = ChildrenBeyond(t);
      const std::size_t first = triangles.size();
      for (std::size_t c = 0; c < children.count; ++c) {
        TriangleRecord& child = triangles.emplace_back();
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
        if (child.constrained != 0) constrained.push_back(TriangleId::FromIndex(first + c));
      }
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
  std::vector<std::array<std::int32_t, 3>> split_at_;  // Per triangle side: its split, or kNone.
  std::vector<std::int32_t> first_child_;              // Per triangle.
  std::vector<std::uint8_t> codes_;                    // Per triangle: of kRefineTemplates.
  std::vector<std::int32_t> new_vertex_;               // Per old vertex.
  std::vector<std::int32_t> new_middle_;               // Per split.
};

}  // namespace

void MeshEdit::Refine(std::span<const EdgeSplit> splits, std::span<const TriangleId> order) {
  PLIANT_CHECK(!logging());
  PLIANT_CHECK(std::ssize(order) == mesh_.triangle_count(), "order", order.size());
  Refinement refined(mesh_, splits, order);
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
    if (((mesh_.triangle(side.triangle).constrained >> side.corner) & 1) == 0) continue;
    const auto [from, to] = constrained_ends(splits[i]);
    edges_to_split.push_back({from, to, refined.NewMiddle(i), splits[i].t});
  }
  for (EdgeRecord& edge : mesh_.edges_) {
    if (!edge.live) continue;
    for (VertexId& end : edge.vertices) end = refined.NewVertex(end);
  }
  for (SegmentRecord& segment : mesh_.segments_) {
    segment = {refined.NewVertex(segment.a), refined.NewVertex(segment.b)};
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
}

}  // namespace pliant
