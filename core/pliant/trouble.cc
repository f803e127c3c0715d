#include "core/pliant/trouble.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>

#include "core/base/sort_unique.h"
#include "core/mesh/id_bits.h"
#include "core/mesh/scan_pays.h"
#include "core/mesh/star.h"
#include "core/metric/metric.h"

namespace pliant {
namespace {

constexpr double kAspectOfDirection = 2;  // Below this a metric has no direction to speak of.
constexpr double kSineCrossed = 0.5;      // Of 30 degrees.
constexpr double kTurnMax = 1;
constexpr double kSizeRatioMax = 2;
constexpr std::size_t kKindCount = static_cast<std::size_t>(TroubleKind::kUnsettled) + 1;

/// What is measured of a triangle; Q and lengths as TroubleKind and Trouble say.
struct Shape {
  double quality = 0;
  double squared_min = 0;
  double squared_max = 0;

  [[nodiscard]] bool bad() const {
    return !(quality >= kTroubleQuality && squared_min >= kTroubleLengthMin * kTroubleLengthMin &&
             squared_max <= kTroubleLengthMax * kTroubleLengthMax);
  }
};

Shape ShapeOf(const Mesh& mesh, TriangleId id) {
  const auto& v = mesh.triangle(id).vertices;
  const std::array corner{&mesh.vertex(v[0]), &mesh.vertex(v[1]), &mesh.vertex(v[2])};
  const Metric mean = (1.0 / 3) * (corner[0]->metric + corner[1]->metric + corner[2]->metric);
  Shape shape;
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const VertexRecord& a = *corner[k];
    const VertexRecord& b = *corner[(k + 1) % 3];
    const Vec2 e = b.position - a.position;
    sum += SquaredLength(mean, e);
    const double squared = 0.5 * (SquaredLength(a.metric, e) + SquaredLength(b.metric, e));
    shape.squared_min = k == 0 ? squared : std::min(shape.squared_min, squared);
    shape.squared_max = std::max(shape.squared_max, squared);
  }
  const double twice_area =
      Cross(corner[1]->position - corner[0]->position, corner[2]->position - corner[0]->position);
  constexpr double kTwoSqrt3 = 3.4641016151377544;
  shape.quality = kTwoSqrt3 * std::sqrt(std::max(Determinant(mean), 0.0)) * twice_area / sum;
  return shape;
}

/// Why a bad triangle is bad.
class Diagnosis {
 public:
  Diagnosis(const Mesh& mesh, const TroubleContext& context) : mesh_(mesh), context_(context) {}

  [[nodiscard]] TroubleKind KindOf(TriangleId id, const Shape& shape) const {
    if (IsConstrained(id)) return TroubleKind::kFrozen;
    if (HasNarrowGeometry(id)) return TroubleKind::kGeometry;
    if (context_.insertions_refused && shape.squared_max > kTroubleLengthMax * kTroubleLengthMax) {
      return TroubleKind::kVertexLimit;
    }
    // The surroundings count too: a jump spoils more than the triangles that it runs through.
    Evidence evidence;
    AddEdges(id, evidence);
    for (const TriangleId neighbor : mesh_.triangle(id).neighbors) {
      if (neighbor.valid()) AddEdges(neighbor, evidence);
    }
    if (evidence.crossed) return TroubleKind::kCrossed;
    if (evidence.curved) return TroubleKind::kCurvature;
    if (evidence.jumps) return TroubleKind::kSizeJump;
    return TroubleKind::kUnsettled;
  }

 private:
  struct Evidence {
    bool crossed = false;
    bool curved = false;
    bool jumps = false;
  };

  /// True if constraints had a say in how the triangle looks. Frozen triangles and edges have
  /// frozen corners.
  [[nodiscard]] bool IsConstrained(TriangleId id) const {
    const Permissions& may = context_.permissions;
    if (!may.insert || !may.swap || !may.move) return true;
    const auto& corners = mesh_.triangle(id).vertices;
    return std::any_of(corners.begin(), corners.end(), [&](VertexId corner) {
      const VertexRecord& vertex = mesh_.vertex(corner);
      return vertex.frozen || (vertex.edge.valid() && !may.surface);
    });
  }

  [[nodiscard]] bool IsBound(const VertexRecord& vertex) const {
    return vertex.fixed || vertex.edge.valid();
  }

  /// True for two vertices inside one segment, which the loop could thin out.
  [[nodiscard]] bool OnOneSegment(const VertexRecord& a, const VertexRecord& b) const {
    return !a.fixed && !b.fixed && a.edge.valid() && b.edge.valid() &&
           mesh_.edge(a.edge).segment == mesh_.edge(b.edge).segment;
  }

  [[nodiscard]] bool HasNarrowGeometry(TriangleId id) const {
    const TriangleRecord& triangle = mesh_.triangle(id);
    for (std::size_t k = 0; k < 3; ++k) {
      const VertexRecord& a = mesh_.vertex(triangle.vertices[(k + 1) % 3]);
      const VertexRecord& b = mesh_.vertex(triangle.vertices[(k + 2) % 3]);
      const double length = Distance(a.position, a.metric, b.position, b.metric);
      if (length < kTroubleLengthMin && IsBound(a) && IsBound(b) && !OnOneSegment(a, b)) {
        return true;
      }
      const auto other_sides = static_cast<unsigned>(7 & ~(1 << k));
      if (mesh_.vertex(triangle.vertices[k]).fixed &&
          (triangle.constrained & other_sides) == other_sides) {
        return true;
      }
    }
    return false;
  }

  void AddEdges(TriangleId id, Evidence& evidence) const {
    const auto& v = mesh_.triangle(id).vertices;
    for (std::size_t k = 0; k < 3; ++k) {
      AddEdge(mesh_.vertex(v[k]), mesh_.vertex(v[(k + 1) % 3]), evidence);
    }
  }

  static void AddEdge(const VertexRecord& a, const VertexRecord& b, Evidence& evidence) {
    const MetricAxes of_a = AxesFromMetric(a.metric);
    const MetricAxes of_b = AxesFromMetric(b.metric);
    const double aspect = std::min(AspectOf(of_a), AspectOf(of_b));
    if (aspect >= kAspectOfDirection) {
      const double sine = std::fabs(Cross(of_a.major_direction, of_b.major_direction));
      evidence.crossed = evidence.crossed || sine >= kSineCrossed;
      evidence.curved = evidence.curved || sine * aspect >= kTurnMax;
    }
    const double areas = Determinant(a.metric) / Determinant(b.metric);
    constexpr double kAreasMax = kSizeRatioMax * kSizeRatioMax * kSizeRatioMax * kSizeRatioMax;
    const Vec2 e = b.position - a.position;
    const double squares = SquaredLength(a.metric, e) / SquaredLength(b.metric, e);
    constexpr double kSquaresMax = kSizeRatioMax * kSizeRatioMax;
    evidence.jumps = evidence.jumps || areas >= kAreasMax || areas <= 1 / kAreasMax ||
                     squares >= kSquaresMax || squares <= 1 / kSquaresMax;
  }

  static double AspectOf(const MetricAxes& axes) { return axes.major_radius / axes.minor_radius; }

  const Mesh& mesh_;
  const TroubleContext& context_;
};

struct BadTriangle {
  TriangleId id;
  Shape shape;
  TroubleKind kind = TroubleKind::kUnsettled;
};

/// Joins vertices to places: union and find over those near bad triangles.
class Places {
 public:
  Places(const Mesh& mesh, std::span<const BadTriangle> bad) {
    std::vector<VertexId> corners;
    for (const BadTriangle& triangle : bad) {
      const auto& v = mesh.triangle(triangle.id).vertices;
      corners.insert(corners.end(), v.begin(), v.end());
    }
    SortUnique(corners);
    std::vector<std::pair<VertexId, VertexId>> joints;
    Star star;
    for (const VertexId corner : corners) {
      for (const TriangleId fan : FansOf(mesh, corner)) {
        star.Gather(mesh, corner, fan);
        for (const VertexId near : star.ring()) joints.emplace_back(corner, near);
      }
    }
    for (const auto& [corner, near] : joints) vertices_.push_back(near);
    vertices_.insert(vertices_.end(), corners.begin(), corners.end());
    SortUnique(vertices_);
    parents_.resize(vertices_.size());
    std::iota(parents_.begin(), parents_.end(), std::size_t{0});
    for (const auto& [corner, near] : joints) {
      const std::size_t a = Find(corner);
      const std::size_t b = Find(near);
      parents_[std::max(a, b)] = std::min(a, b);
    }
  }

  /// The place of a vertex, as the number of its lowest vertex.
  [[nodiscard]] std::size_t Find(VertexId vertex) {
    std::size_t i = static_cast<std::size_t>(
        std::lower_bound(vertices_.begin(), vertices_.end(), vertex) - vertices_.begin());
    while (parents_[i] != i) {
      parents_[i] = parents_[parents_[i]];
      i = parents_[i];
    }
    return i;
  }

 private:
  std::vector<VertexId> vertices_;
  std::vector<std::size_t> parents_;
};

/// The trouble that the bad triangles of one place make.
Trouble TroubleOf(const Mesh& mesh, std::span<const BadTriangle> place) {
  Trouble trouble;
  std::array<std::int64_t, kKindCount> votes{};
  std::vector<VertexId> corners;
  for (const BadTriangle& triangle : place) {
    const auto& v = mesh.triangle(triangle.id).vertices;
    const Vec2 a = mesh.position(v[0]);
    const Vec2 b = mesh.position(v[1]);
    const Vec2 c = mesh.position(v[2]);
    const bool first = corners.empty();
    if (first) {
      trouble.box = {a, a};
      trouble.length_min = triangle.shape.squared_min;
    }
    if (first || triangle.shape.quality < trouble.q_min) {
      trouble.q_min = triangle.shape.quality;
      trouble.center = (1.0 / 3) * (a + b + c);
    }
    for (const Vec2 p : {a, b, c}) Extend(trouble.box, {p, p});
    trouble.length_min = std::min(trouble.length_min, triangle.shape.squared_min);
    trouble.length_max = std::max(trouble.length_max, triangle.shape.squared_max);
    corners.insert(corners.end(), v.begin(), v.end());
    if (triangle.kind != TroubleKind::kUnsettled) ++votes[static_cast<std::size_t>(triangle.kind)];
  }
  trouble.length_min = std::sqrt(trouble.length_min);
  trouble.length_max = std::sqrt(trouble.length_max);
  SortUnique(corners);
  trouble.vertex_count = std::ssize(corners);
  const auto most = std::max_element(votes.begin(), votes.end());
  if (*most > 0) trouble.kind = static_cast<TroubleKind>(most - votes.begin());
  return trouble;
}

void Absorb(Trouble& into, const Trouble& other) {
  into.vertex_count += other.vertex_count;
  into.place_count += other.place_count;
  if (other.q_min < into.q_min) into.center = other.center;
  into.q_min = std::min(into.q_min, other.q_min);
  into.length_min = std::min(into.length_min, other.length_min);
  into.length_max = std::max(into.length_max, other.length_max);
  Extend(into.box, other.box);
}

/// Puts the smallest together, by kind, so that at most kTroublesMax are left.
void Shorten(std::vector<Trouble>& troubles) {
  if (troubles.size() <= kTroublesMax) return;
  constexpr std::size_t kKept = kTroublesMax - kKindCount;
  std::array<std::optional<Trouble>, kKindCount> rest;
  for (std::size_t i = kKept; i < troubles.size(); ++i) {
    std::optional<Trouble>& sum = rest[static_cast<std::size_t>(troubles[i].kind)];
    if (sum) {
      Absorb(*sum, troubles[i]);
    } else {
      sum = troubles[i];
    }
  }
  troubles.resize(kKept);
  for (const std::optional<Trouble>& sum : rest) {
    if (sum) troubles.push_back(*sum);
  }
}

/// Ascending, each once. Triangles that lie close together by slot, as they do around a change, are
/// marked in bits instead of sorted: a fan names each three times.
void SortTriangles(std::vector<TriangleId>& triangles) {
  if (triangles.empty()) return;
  constexpr std::size_t kBits = 64;
  const auto [low, high] = std::minmax_element(triangles.begin(), triangles.end());
  const std::size_t first = low->index();
  const std::size_t range = high->index() - first + 1;
  if (range > kBits * triangles.size()) {
    SortUnique(triangles);
    return;
  }
  std::vector<std::uint64_t> words((range + kBits - 1) / kBits);
  for (const TriangleId id : triangles) {
    const std::size_t bit = id.index() - first;
    words[bit / kBits] |= std::uint64_t{1} << (bit % kBits);
  }
  triangles.clear();
  for (std::size_t w = 0; w < words.size(); ++w) {
    for (std::uint64_t word = words[w]; word != 0; word &= word - 1) {
      const auto bit = static_cast<std::size_t>(std::countr_zero(word));
      triangles.push_back(TriangleId::FromIndex(first + w * kBits + bit));
    }
  }
}

}  // namespace

std::vector<Trouble> FindTroubles(const Mesh& mesh, std::span<const TriangleId> triangles,
                                  const TroubleContext& context) {
  std::vector<BadTriangle> bad;
  const Diagnosis diagnosis(mesh, context);
  for (const TriangleId id : triangles) {
    const Shape shape = ShapeOf(mesh, id);
    if (shape.bad()) bad.push_back({id, shape, diagnosis.KindOf(id, shape)});
  }
  if (bad.empty()) return {};

  Places places(mesh, bad);
  std::vector<std::pair<std::size_t, std::size_t>> by_place;  // Place, number in `bad`.
  for (std::size_t i = 0; i < bad.size(); ++i) {
    by_place.emplace_back(places.Find(mesh.triangle(bad[i].id).vertices[0]), i);
  }
  std::sort(by_place.begin(), by_place.end());
  std::vector<Trouble> troubles;
  for (std::size_t begin = 0; begin < by_place.size();) {
    std::vector<BadTriangle> place;
    std::size_t end = begin;
    while (end < by_place.size() && by_place[end].first == by_place[begin].first) {
      place.push_back(bad[by_place[end++].second]);
    }
    troubles.push_back(TroubleOf(mesh, place));
    begin = end;
  }
  std::stable_sort(troubles.begin(), troubles.end(), [](const Trouble& a, const Trouble& b) {
    return a.vertex_count > b.vertex_count;
  });
  Shorten(troubles);
  return troubles;
}

std::vector<TriangleId> LiveTrianglesOf(const Mesh& mesh) {
  std::vector<TriangleId> triangles;
  triangles.reserve(static_cast<std::size_t>(mesh.triangle_count()));
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    if (mesh.triangle(TriangleId(t)).live) triangles.emplace_back(t);
  }
  return triangles;
}

std::vector<TriangleId> TrianglesAt(const Mesh& mesh, std::span<const VertexId> vertices) {
  std::vector<TriangleId> triangles;
  if (ScanPays(mesh, std::ssize(vertices))) {
    IdBits<VertexId> named(mesh.vertex_slots());
    for (const VertexId vertex : vertices) {
      if (mesh.IsLive(vertex)) named.Add(vertex);
    }
    for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
      const TriangleRecord& triangle = mesh.triangle(TriangleId(t));
      const auto& v = triangle.vertices;
      if (!triangle.live) continue;
      if (named.Has(v[0]) || named.Has(v[1]) || named.Has(v[2])) triangles.emplace_back(t);
    }
    return triangles;
  }
  Star star;
  const auto add = [&](VertexId center, TriangleId fan) {
    star.Gather(mesh, center, fan);
    triangles.insert(triangles.end(), star.triangles().begin(), star.triangles().end());
  };
  for (const VertexId vertex : vertices) {
    if (!mesh.IsLive(vertex)) continue;
    if (!mesh.vertex(vertex).pinched) {
      add(vertex, mesh.vertex(vertex).triangle);
      continue;
    }
    for (const TriangleId fan : FansOf(mesh, vertex)) add(vertex, fan);
  }
  SortTriangles(triangles);
  return triangles;
}

}  // namespace pliant
