#include "core/pliant/refine.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <set>
#include <utility>

#include "core/base/touch_pages.h"
#include "core/delaunay/insertion_order.h"
#include "core/geometry/predicates.h"
#include "core/metric/metric.h"

namespace pliant {
namespace {

/// Edges longer than this are halved; anything from 1.15 to 1.6 does as well, because a converged
/// mesh for twice the size has edges near 2. Short input edges stay whole.
constexpr double kSplitLength = 1.3;

/// Largest shift of a midpoint, as a share of the edge, in the metric.
constexpr double kShiftMax = 0.175;

/// How bold the middle of an edge is: given up in steps where a child would not be positive.
enum class Boldness : std::uint8_t { kWhole, kStraight, kGeodesic };

class RefinementPlan {
 public:
  RefinementPlan(const Mesh& mesh, double growth, Executor& executor)
      : mesh_(mesh),
        executor_(executor),
        squared_split_length_(kSplitLength * kSplitLength / growth),
        split_at_(static_cast<std::size_t>(mesh.triangle_slots())) {}

  std::vector<EdgeSplit> Make() {
    MarkLongSides();
    MakeChildrenPositive();
    if (std::ranges::find(boldness_, Boldness::kWhole) == boldness_.end()) {
      return std::move(splits_);
    }
    std::vector<EdgeSplit> splits;
    splits.reserve(splits_.size());
    for (std::size_t i = 0; i < splits_.size(); ++i) {
      if (boldness_[i] != Boldness::kWhole) splits.push_back(splits_[i]);
    }
    return splits;
  }

 private:
  [[nodiscard]] VertexId Corner(TriangleId t, int corner) const {
    return mesh_.triangle(t).vertices[static_cast<std::size_t>(corner)];
  }

  /// Finds the long sides and places their middles; a side belongs to the lower of its triangles.
  void MarkLongSides() {
    const Chunks chunks(mesh_.triangle_slots());
    std::vector<std::uint8_t> long_sides(split_at_.size());
    std::vector<std::size_t> begins(static_cast<std::size_t>(chunks.count()) + 1, 0);
    executor_.Run(chunks.count(), [&](std::int32_t chunk) {
      std::size_t count = 0;
      for (std::int64_t t = chunks.begin(chunk); t < chunks.end(chunk); ++t) {
        const auto index = static_cast<std::size_t>(t);
        split_at_[index] = {-1, -1, -1};
        long_sides[index] = LongSidesOf(TriangleId::FromIndex(index));
        count += static_cast<std::size_t>(std::popcount(long_sides[index]));
      }
      begins[static_cast<std::size_t>(chunk) + 1] = count;
    });
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    ReserveTouched(splits_, begins.back(), executor_);
    if (executor_.stopped()) return;  // Who stops does not want to wait for the memory either.
    splits_.resize(begins.back());
    boldness_.assign(begins.back(), Boldness::kGeodesic);
    executor_.Run(chunks.count(), [&](std::int32_t chunk) {
      std::size_t split = begins[static_cast<std::size_t>(chunk)];
      for (std::int64_t t = chunks.begin(chunk); t < chunks.end(chunk); ++t) {
        for (int side = 0; side < 3; ++side) {
          if (((long_sides[static_cast<std::size_t>(t)] >> side) & 1) == 0) continue;
          SplitSide({TriangleId(static_cast<std::int32_t>(t)), side}, split++);
        }
      }
    });
  }

  /// Bits of the sides that are long and belong to the triangle.
  [[nodiscard]] std::uint8_t LongSidesOf(TriangleId t) const {
    unsigned bits = 0;
    if (!mesh_.triangle(t).live) return 0;
    for (int side = 0; side < 3; ++side) {
      const TriangleId beyond = mesh_.triangle(t).neighbors[static_cast<std::size_t>(side)];
      if (beyond.valid() && beyond < t) continue;
      const VertexRecord& a = mesh_.vertex(Corner(t, NextCorner(side)));
      const VertexRecord& b = mesh_.vertex(Corner(t, PreviousCorner(side)));
      const double squared = SquaredEdgeLength(a, b);
      if (squared > squared_split_length_) bits |= 1U << side;
    }
    return static_cast<std::uint8_t>(bits);
  }

  /// Makes split `index` that of a side.
  void SplitSide(Side side, std::size_t index) {
    splits_[index].side = side;
    Place(splits_[index], Boldness::kGeodesic);
    const auto corner = static_cast<std::size_t>(side.corner);
    split_at_[side.triangle.index()][corner] = static_cast<std::int32_t>(index);
    const TriangleId beyond = mesh_.triangle(side.triangle).neighbors[corner];
    if (!beyond.valid()) return;
    const auto back = static_cast<std::size_t>(mesh_.SideTowards(beyond, side.triangle));
    split_at_[beyond.index()][back] = static_cast<std::int32_t>(index);
  }

  /// Sets position and parameter of a split.
  void Place(EdgeSplit& split, Boldness boldness) const {
    const Side side = split.side;
    const VertexId a = Corner(side.triangle, NextCorner(side.corner));
    const VertexId b = Corner(side.triangle, PreviousCorner(side.corner));
    const Vec2 e = mesh_.position(b) - mesh_.position(a);
    const Vec2 shift = boldness == Boldness::kGeodesic ? GeodesicShift(side, a, b) : Vec2{};
    if (!mesh_.triangle(side.triangle).IsConstrained(side.corner)) {
      split.position = 0.5 * (mesh_.position(a) + mesh_.position(b)) + shift;
      return;
    }
    const EdgeRecord& edge = mesh_.edge(mesh_.FindEdge(a, b));
    const Metric sum = mesh_.metric(a) + mesh_.metric(b);
    const double along = InnerProduct(sum, shift, e) / SquaredLength(sum, e);
    const double sign = edge.vertices[0] == a ? 1 : -1;
    split.t = edge.parameters[0] + (0.5 + sign * along) * (edge.parameters[1] - edge.parameters[0]);
    split.position = mesh_.PointOnSegment(edge.segment, split.t);
  }

  [[nodiscard]] Vec2 GeodesicShift(Side side, VertexId a, VertexId b) const {
    const Vec2 e = mesh_.position(b) - mesh_.position(a);
    Vec2 gradient = GradientOfSquaredLength(side.triangle, e);
    const TriangleId beyond =
        mesh_.triangle(side.triangle).neighbors[static_cast<std::size_t>(side.corner)];
    if (beyond.valid()) gradient = 0.5 * (gradient + GradientOfSquaredLength(beyond, e));
    const Metric change = mesh_.metric(b) - mesh_.metric(a);
    const Vec2 force =
        Vec2{change.m11 * e.x + change.m12 * e.y, change.m12 * e.x + change.m22 * e.y} -
        0.5 * gradient;
    const Metric mean = 0.5 * (mesh_.metric(a) + mesh_.metric(b));
    const double scale = 0.125 / Determinant(mean);
    const Vec2 shift = {scale * (mean.m22 * force.x - mean.m12 * force.y),
                        scale * (mean.m11 * force.y - mean.m12 * force.x)};
    const double share = std::sqrt(SquaredLength(mean, shift) / SquaredLength(mean, e));
    if (!(share > kShiftMax)) return std::isfinite(share) ? shift : Vec2{};
    return (kShiftMax / share) * shift;
  }

  /// Gradient of e' M(x) e over a triangle, for M linear between its corners.
  [[nodiscard]] Vec2 GradientOfSquaredLength(TriangleId t, Vec2 e) const {
    const VertexRecord& a = mesh_.vertex(Corner(t, 0));
    const VertexRecord& b = mesh_.vertex(Corner(t, 1));
    const VertexRecord& c = mesh_.vertex(Corner(t, 2));
    const Vec2 ab = b.position - a.position;
    const Vec2 ac = c.position - a.position;
    const double at_a = SquaredLength(a.metric, e);
    const double to_b = SquaredLength(b.metric, e) - at_a;
    const double to_c = SquaredLength(c.metric, e) - at_a;
    const double inverse = 1 / Cross(ab, ac);
    return {inverse * (to_b * ac.y - to_c * ab.y), inverse * (to_c * ab.x - to_b * ac.x)};
  }

  /// Takes back boldness around triangles with a child that is not positive, until there is none.
  /// Ends because boldness only falls.
  void MakeChildrenPositive() {
    // In ascending order, and with those above that a change made suspect: as if all triangles were
    // looked at one after the other.
    std::set<TriangleId> suspects = FindBadTriangles();
    while (!suspects.empty()) {
      std::set<TriangleId> later;
      while (!suspects.empty()) {
        const TriangleId t = *suspects.begin();
        suspects.erase(suspects.begin());
        if (ChildrenArePositive(t)) continue;
        for (std::size_t side = 0; side < 3; ++side) {
          if (!TakeBack(split_at_[t.index()][side])) continue;
          const TriangleId beyond = mesh_.triangle(t).neighbors[side];
          if (beyond.valid()) (beyond > t ? suspects : later).insert(beyond);
        }
        later.insert(t);
      }
      suspects = std::move(later);
    }
  }

  [[nodiscard]] std::set<TriangleId> FindBadTriangles() const {
    const Chunks chunks(mesh_.triangle_slots());
    std::vector<std::vector<TriangleId>> bad(static_cast<std::size_t>(chunks.count()));
    executor_.Run(chunks.count(), [&](std::int32_t chunk) {
      for (std::int64_t t = chunks.begin(chunk); t < chunks.end(chunk); ++t) {
        const TriangleId id(static_cast<std::int32_t>(t));
        if (!mesh_.triangle(id).live || ChildrenArePositive(id)) continue;
        bad[static_cast<std::size_t>(chunk)].push_back(id);
      }
    });
    std::set<TriangleId> all;
    for (const auto& part : bad) all.insert(part.begin(), part.end());
    return all;
  }

  /// Takes one step of boldness back. @return false if there is none, or no split (index -1)
  bool TakeBack(std::int32_t index) {
    if (index < 0) return false;
    const auto i = static_cast<std::size_t>(index);
    if (boldness_[i] == Boldness::kWhole) return false;
    boldness_[i] = boldness_[i] == Boldness::kGeodesic ? Boldness::kStraight : Boldness::kWhole;
    Place(splits_[i], boldness_[i]);
    return true;
  }

  /// Enough for every template: the middles lie strictly inside the parent's sides as seen from
  /// each other and from the corners.
  [[nodiscard]] bool ChildrenArePositive(TriangleId t) const {
    std::array<Vec2, 3> v;
    std::array<const EdgeSplit*, 3> m{};
    bool any = false;
    for (std::size_t i = 0; i < 3; ++i) {
      v[i] = mesh_.position(mesh_.triangle(t).vertices[i]);
      const std::int32_t index = split_at_[t.index()][i];
      if (index < 0 || boldness_[static_cast<std::size_t>(index)] == Boldness::kWhole) continue;
      m[i] = &splits_[static_cast<std::size_t>(index)];
      any = true;
    }
    if (!any) return true;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const std::size_t k = (i + 2) % 3;
      // Both triangles that corner i makes with the middle opposite, and the corner triangle at i.
      if (m[i] != nullptr && (Orient2d(v[i], v[j], m[i]->position) <= 0 ||
                              Orient2d(v[i], m[i]->position, v[k]) <= 0)) {
        return false;
      }
      if (m[j] == nullptr || m[k] == nullptr) continue;
      const Vec2 on_ij = m[k]->position;
      const Vec2 on_ki = m[j]->position;
      if (Orient2d(v[i], on_ij, on_ki) <= 0) return false;
      if (Orient2d(on_ij, v[j], on_ki) <= 0 || Orient2d(on_ij, v[k], on_ki) <= 0) return false;
      if (m[i] != nullptr && Orient2d(m[i]->position, on_ki, on_ij) <= 0) return false;
    }
    return true;
  }

  const Mesh& mesh_;
  Executor& executor_;
  const double squared_split_length_;
  std::vector<EdgeSplit> splits_;
  std::vector<Boldness> boldness_;
  std::vector<std::array<std::int32_t, 3>> split_at_;  // Per triangle side, or -1.
};

}  // namespace

std::vector<EdgeSplit> PlanRefinement(const Mesh& mesh, double growth, Executor& executor) {
  return RefinementPlan(mesh, growth, executor).Make();
}

std::vector<EdgeSplit> PlanRefinement(const Mesh& mesh, double growth) {
  InlineExecutor alone;
  return PlanRefinement(mesh, growth, alone);
}

std::vector<TriangleId> TrianglesAlongCurve(const Mesh& mesh) {
  const std::vector<TriangleId> triangles = TrianglesBySlot(mesh);
  std::vector<Vec2> centers;
  centers.reserve(triangles.size());
  for (const TriangleId id : triangles) {
    const auto& v = mesh.triangle(id).vertices;
    centers.push_back((1.0 / 3.0) *
                      (mesh.position(v[0]) + mesh.position(v[1]) + mesh.position(v[2])));
  }
  std::vector<TriangleId> order;
  order.reserve(triangles.size());
  for (const std::int32_t index : HilbertOrder(centers)) {
    order.push_back(triangles[static_cast<std::size_t>(index)]);
  }
  return order;
}

std::vector<TriangleId> TrianglesBySlot(const Mesh& mesh) {
  std::vector<TriangleId> triangles;
  triangles.reserve(static_cast<std::size_t>(mesh.triangle_count()));
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    if (mesh.triangle(TriangleId(t)).live) triangles.emplace_back(t);
  }
  return triangles;
}

}  // namespace pliant
