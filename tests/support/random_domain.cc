#include "tests/support/random_domain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <sstream>
#include <utility>
#include <vector>

#include "core/base/as_index.h"
#include "core/base/check.h"
#include "core/base/rng.h"
#include "core/delaunay/triangulate.h"
#include "core/geometry/predicates.h"
#include "core/mesh/validate.h"
#include "core/metric/function_field.h"
#include "tests/support/mesh_testing.h"

namespace pliant::testing {
namespace {

using Triangle = DomainTriangulation::Triangle;

/// A unit vector without libm: turns by rational rotations.
Vec2 RandomDirection(Rng& rng) {
  const double t = rng.Uniform(-1, 1);
  const Vec2 half{(1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)};
  return rng.Below(2) == 0 ? half : -half;
}

/// 10 to the power of a number in [low, high], by repeated square roots instead of pow.
double RandomPower(Rng& rng, double low, double high) {
  const double exponent = rng.Uniform(low, high);
  const double whole = std::floor(exponent);
  double value = 1;
  for (double k = 0; k < std::fabs(whole); ++k) value *= whole > 0 ? 10 : 0.1;
  double root = 10;
  for (double bit = 0.5, rest = exponent - whole; bit > 1e-6; bit /= 2) {
    root = std::sqrt(root);
    if (rest >= bit) {
      value *= root;
      rest -= bit;
    }
  }
  return value;
}

class DomainMaker {
 public:
  explicit DomainMaker(std::uint64_t seed) : rng_(seed) {}

  RandomCase Make() {
    MakePoints();
    Triangulate();
    Stretch();
    ChooseOutside();
    ChooseSegments();
    FillRegions();
    Collect();
    return std::move(made_);
  }

 private:
  [[nodiscard]] Vec2 PointAt(std::int32_t i) const { return base_.points[AsIndex(i)]; }
  void MakePoints() {
    base_.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    base_.segments = {{0, 1, 0}, {1, 2, 0}, {2, 3, 0}, {3, 0, 0}};
    const std::uint64_t kind = rng_.Below(3);
    const std::uint64_t count = rng_.Below(30);
    for (std::uint64_t i = 0; i < count; ++i) {
      Vec2 p{rng_.Uniform(0.01, 0.99), rng_.Uniform(0.01, 0.99)};
      if (kind == 1) {
        p = {0.125 * static_cast<double>(1 + rng_.Below(7)),
             0.125 * static_cast<double>(1 + rng_.Below(7))};
      } else if (kind == 2 && i % 2 == 1) {
        p = base_.points.back() + RandomPower(rng_, -6, -1) * RandomDirection(rng_);
      }
      const bool inside = 0 < p.x && p.x < 1 && 0 < p.y && p.y < 1;
      const bool fresh =
          std::find(base_.points.begin(), base_.points.end(), p) == base_.points.end();
      if (inside && fresh) base_.points.push_back(p);
    }
  }

  void Triangulate() {
    auto cdt = TriangulateDomain(base_);
    PLIANT_CHECK(cdt.ok(), "error", cdt.error().message);
    triangles_ = std::move(cdt->triangles);
  }

  /// An affine map, if rounding turns no triangle over.
  void Stretch() {
    if (rng_.Below(2) == 0) return;
    const double stretch = RandomPower(rng_, 0, 3);
    const double scale = RandomPower(rng_, -3, 3);
    const Vec2 u = RandomDirection(rng_);
    std::vector<Vec2> mapped;
    for (const Vec2 p : base_.points) {
      const Vec2 q = scale * Vec2{stretch * p.x, p.y};
      mapped.push_back({u.x * q.x - u.y * q.y, u.y * q.x + u.x * q.y});
    }
    for (const Triangle& t : triangles_) {
      const auto& [a, b, c] = t.points;
      if (Orient2d(mapped[AsIndex(a)], mapped[AsIndex(b)], mapped[AsIndex(c)]) <= 0) return;
    }
    base_.points = std::move(mapped);
  }

  [[nodiscard]] Vec2 Centroid(const Triangle& t) const {
    return (1.0 / 3) * (PointAt(t.points[0]) + PointAt(t.points[1]) + PointAt(t.points[2]));
  }
  /// False for a sliver so thin that its centroid rounds out of it.
  [[nodiscard]] bool HoldsItsCentroid(const Triangle& t) const {
    const Vec2 m = Centroid(t);
    for (std::size_t k = 0; k < 3; ++k) {
      if (Orient2d(PointAt(t.points[k]), PointAt(t.points[(k + 1) % 3]), m) <= 0) return false;
    }
    return true;
  }

  void ChooseOutside() {
    outside_.assign(triangles_.size(), false);
    const double share = rng_.Uniform(0, 0.6);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      outside_[t] = rng_.Unit() < share && HoldsItsCentroid(triangles_[t]);
    }
    if (std::find(outside_.begin(), outside_.end(), false) == outside_.end()) outside_[0] = false;
  }

  [[nodiscard]] bool Outside(std::int32_t t) const { return t < 0 || outside_[AsIndex(t)]; }

  /// Bit 0 of each triangle side: it is a segment.
  void ChooseSegments() {
    const double share = rng_.Below(2) == 0 ? 0 : rng_.Uniform(0, 0.5);
    is_segment_.assign(triangles_.size(), {});
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t n = triangles_[t].neighbors[k];
        if (n >= 0 && AsIndex(n) < t) continue;  // Decided from the other side.
        const bool border = outside_[t] != Outside(n);
        const bool inner = !outside_[t] && !Outside(n) && rng_.Unit() < share;
        if (!border && !inner) continue;
        is_segment_[t][k] = true;
        if (n < 0) continue;
        const auto& back = triangles_[AsIndex(n)].neighbors;
        const auto at = std::find(back.begin(), back.end(), static_cast<std::int32_t>(t));
        is_segment_[AsIndex(n)][static_cast<std::size_t>(at - back.begin())] = true;
      }
    }
  }

  /// The triangles that can be reached from one without crossing a segment.
  std::vector<std::size_t> Flood(std::size_t start, std::vector<bool>& seen) const {
    std::vector<std::size_t> found{start};
    seen[start] = true;
    for (std::size_t i = 0; i < found.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t n = triangles_[found[i]].neighbors[k];
        if (n < 0 || is_segment_[found[i]][k] || seen[AsIndex(n)]) continue;
        seen[AsIndex(n)] = true;
        found.push_back(AsIndex(n));
      }
    }
    return found;
  }

  [[nodiscard]] double AreaOf(std::size_t t) const {
    const auto& [a, b, c] = triangles_[t].points;
    return 0.5 * Cross(PointAt(b) - PointAt(a), PointAt(c) - PointAt(a));
  }

  void FillRegions() {
    std::vector<bool> seen(triangles_.size(), false);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (seen[t]) continue;
      const std::vector<std::size_t> part = Flood(t, seen);
      if (outside_[t]) {
        const bool open = std::any_of(part.begin(), part.end(), [&](std::size_t member) {
          const auto& n = triangles_[member].neighbors;
          return std::find(n.begin(), n.end(), -1) != n.end();
        });
        if (!open) made_.domain.holes.push_back(Centroid(triangles_[t]));
        continue;
      }
      std::int32_t tag = 0;
      if (rng_.Below(3) != 0 && HoldsItsCentroid(triangles_[t])) {
        tag = static_cast<std::int32_t>(1 + rng_.Below(5));
        made_.domain.regions.push_back({Centroid(triangles_[t]), tag});
      }
      for (const std::size_t member : part) {
        made_.area += AreaOf(member);
        made_.region_areas[tag] += AreaOf(member);
      }
    }
  }

  /// Points and segments that are left, numbered anew.
  void Collect() {
    std::vector<bool> on_segment(base_.points.size(), false);
    std::vector<bool> inside(base_.points.size(), true);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (outside_[t]) inside[AsIndex(triangles_[t].points[k])] = false;
        if (!is_segment_[t][k]) continue;
        on_segment[AsIndex(triangles_[t].points[(k + 1) % 3])] = true;
        on_segment[AsIndex(triangles_[t].points[(k + 2) % 3])] = true;
      }
    }
    std::vector<std::int32_t> number(base_.points.size(), -1);
    for (std::size_t i = 0; i < base_.points.size(); ++i) {
      if (!on_segment[i] && !(inside[i] && rng_.Below(3) == 0)) continue;
      number[i] = static_cast<std::int32_t>(made_.domain.points.size());
      made_.domain.points.push_back(base_.points[i]);
    }
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t n = triangles_[t].neighbors[k];
        if (!is_segment_[t][k] || (n >= 0 && AsIndex(n) < t)) continue;
        std::int32_t a = triangles_[t].points[(k + 1) % 3];
        std::int32_t b = triangles_[t].points[(k + 2) % 3];
        if (rng_.Below(2) == 0) std::swap(a, b);
        const auto tag = static_cast<std::int32_t>(made_.domain.segments.size());
        made_.domain.segments.push_back({number[AsIndex(a)], number[AsIndex(b)], tag});
        made_.tag_lengths[tag] = Length(PointAt(b) - PointAt(a));
      }
    }
    Vec2 low = made_.domain.points.front();
    Vec2 high = low;
    for (const Vec2 p : made_.domain.points) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
    made_.extent = Length(high - low);
  }

  Rng rng_;
  Domain base_;
  std::vector<Triangle> triangles_;
  std::vector<bool> outside_;
  std::vector<std::array<bool, 3>> is_segment_;
  RandomCase made_;
};

/// Eigenvalues 1/aspect and aspect: determinant 1.
Metric UnitDeterminant(Vec2 direction, double aspect) {
  const double p = 1 / aspect;
  const double q = aspect;
  const Vec2 n = direction;
  return {p * n.x * n.x + q * n.y * n.y, (p - q) * n.x * n.y, p * n.y * n.y + q * n.x * n.x};
}

/// What a random metric is made of; every kind uses a part of it.
struct MetricPlan {
  std::uint64_t kind = 0;
  Metric first;
  Metric second;
  Vec2 center;
  Vec2 direction;
  double radius = 1;
  double contrast = 1;

  [[nodiscard]] Metric At(Vec2 p) const {
    const Vec2 e = p - center;
    const double r2 = Dot(e, e) / (radius * radius);
    switch (kind) {
      case 0:
        return first;
      case 1:  // Jump across a line.
        return Dot(e, direction) > 0 ? contrast * second : first;
      case 2: {  // Checkerboard.
        const double s = std::floor(4 * e.x / radius) + std::floor(4 * e.y / radius);
        return s - 2 * std::floor(s / 2) > 0.5 ? second : first;
      }
      case 3:  // Fine around a point.
        return (1 + contrast / (1 + 50 * r2)) * first;
      default: {  // Around a point, stretched along circles.
        const double r = Length(e);
        const Vec2 n = r > 0 ? (1 / r) * e : Vec2{1, 0};
        return UnitDeterminant({-n.y, n.x}, 1 + contrast / (1 + r2));
      }
    }
  }
};

/// Integral of sqrt(det M), sampled: the node count a metric asks for, roughly.
double Complexity(const RandomCase& of, const MetricPlan& plan, Rng& rng) {
  const auto cdt = TriangulateDomain(of.domain);
  PLIANT_CHECK(cdt.ok(), "error", cdt.error().message);
  double sum = 0;
  for (const Triangle& t : cdt->triangles) {
    const auto at = [&](std::size_t k) {
      return of.domain.points[static_cast<std::size_t>(t.points[k])];
    };
    const Vec2 u = at(1) - at(0);
    const Vec2 w = at(2) - at(0);
    constexpr int kSamples = 20;
    for (int i = 0; i < kSamples; ++i) {
      double a = rng.Unit();
      double b = rng.Unit();
      if (a + b > 1) {
        a = 1 - a;
        b = 1 - b;
      }
      const Metric m = plan.At(at(0) + a * u + b * w);
      sum += 0.5 * Cross(u, w) * std::sqrt(std::max(Determinant(m), 0.0)) / kSamples;
    }
  }
  return sum;
}

}  // namespace

RandomCase MakeRandomCase(std::uint64_t seed) { return DomainMaker(seed).Make(); }

std::string FaultsAgainst(const RandomCase& expected, const Mesh& mesh) {
  std::ostringstream faults;
  faults.precision(17);
  faults << Faults(mesh);
  const double slack = 1e-12 * expected.extent;
  const auto compare = [&](const char* what, std::int32_t tag, double is, double wanted,
                           double allowed) {
    if (std::fabs(is - wanted) <= allowed) return;
    faults << what << ' ' << tag << " is " << is << ", must be " << wanted << '\n';
  };
  const auto compare_all = [&](const char* what, const std::map<std::int32_t, double>& are,
                               const std::map<std::int32_t, double>& wanted, double allowed) {
    if (are.size() != wanted.size()) faults << are.size() << ' ' << what << "s\n";
    for (const auto& [tag, value] : wanted) {
      compare(what, tag, are.contains(tag) ? are.at(tag) : 0, value, allowed);
    }
  };
  compare("area", 0, Area(mesh), expected.area, slack * expected.extent);
  compare_all("region area", RegionAreas(mesh), expected.region_areas, slack * expected.extent);
  compare_all("segment length", TagLengths(mesh), expected.tag_lengths, slack);
  for (std::size_t i = 0; i < expected.domain.points.size(); ++i) {
    const VertexId id = VertexId::FromIndex(i);
    if (mesh.IsLive(id) && mesh.position(id) == expected.domain.points[i]) continue;
    faults << "point " << i << " is gone or has moved\n";
  }
  return faults.str();
}

std::unique_ptr<MetricField> RandomMetric(const RandomCase& of, double node_count,
                                          std::uint64_t seed, std::string* description) {
  Rng rng(seed ^ 0x6d65747269630000);
  MetricPlan plan;
  plan.kind = rng.Below(5);
  const double aspect = rng.Below(3) == 0 ? 1 : RandomPower(rng, 0, 4);
  plan.direction = RandomDirection(rng);
  plan.first = UnitDeterminant(RandomDirection(rng), aspect);
  plan.second = UnitDeterminant(RandomDirection(rng), RandomPower(rng, 0, 2));
  plan.center = of.domain.points[rng.Below(of.domain.points.size())];
  plan.radius = of.extent * rng.Uniform(0.05, 1);
  plan.contrast = RandomPower(rng, 0, 3);
  const double wanted = RandomPower(rng, -2, 0) * node_count;
  const double scale = wanted / Complexity(of, plan, rng);
  if (description != nullptr) {
    std::ostringstream text;
    text << "metric kind " << plan.kind << ", aspect " << aspect << ", contrast " << plan.contrast
         << ", complexity " << wanted;
    *description = text.str();
  }
  auto function = [plan, scale](Vec2 p) { return scale * plan.At(p); };
  return std::make_unique<FunctionField<decltype(function)>>(std::move(function));
}

}  // namespace pliant::testing
