#include "core/delaunay/metric_flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "core/base/rng.h"
#include "core/geometry/predicates.h"
#include "core/mesh/star.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Faults;
using testing::GridData;
using testing::ImportedMesh;

Metric RandomMetric(Rng& rng, double aspect_max) {
  const double angle = rng.Uniform(0, 3.14);
  const double aspect = rng.Uniform(1, aspect_max);
  return MetricFromAxes({.major_radius = aspect,
                         .minor_radius = 1,
                         .major_direction = {std::cos(angle), std::sin(angle)}});
}

/// L' p for M = L L' (Cholesky): lengths and angles there are those of the metric.
struct Transform {
  explicit Transform(const Metric& m)
      : l11(std::sqrt(static_cast<long double>(m.m11))),
        l21(m.m12 / l11),
        l22(std::sqrt(m.m22 - l21 * l21)) {}
  long double l11;
  long double l21;
  long double l22;

  [[nodiscard]] std::array<long double, 2> operator()(Vec2 p) const {
    return {l11 * p.x + l21 * p.y, l22 * p.y};
  }
  [[nodiscard]] Vec2 Rounded(Vec2 p) const {
    const auto [x, y] = (*this)(p);
    return {static_cast<double>(x), static_cast<double>(y)};
  }
};

long double AngleAt(const Transform& t, Vec2 apex, Vec2 from, Vec2 to) {
  const auto a = t(apex);
  const auto u = t(from);
  const auto w = t(to);
  const long double ux = u[0] - a[0];
  const long double uy = u[1] - a[1];
  const long double wx = w[0] - a[0];
  const long double wy = w[1] - a[1];
  return std::atan2(std::fabs(ux * wy - uy * wx), ux * wx + uy * wy);
}

// Goal: eq. 6 decides what it stands for: whether the angles opposite the edge, measured in the
// metric, add up to more than 180 degrees. Method: angles by atan2 in long double.
TEST(WantsSwap, ComparesTheSumOfTheOppositeAnglesWith180Degrees) {
  Rng rng(1996);
  int wanted = 0;
  int decided = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    const Vec2 x{rng.Uniform(-1, 1), rng.Uniform(-1, 1)};
    const Vec2 y{rng.Uniform(-1, 1), rng.Uniform(-1, 1)};
    const Vec2 z{rng.Uniform(-1, 1), rng.Uniform(-1, 1)};
    const Vec2 w{rng.Uniform(-1, 1), rng.Uniform(-1, 1)};
    if (Orient2d(x, y, z) <= 0 || Orient2d(z, w, x) <= 0) continue;
    const Metric m = RandomMetric(rng, 50);
    const Transform t(m);
    const long double sum = AngleAt(t, y, z, x) + AngleAt(t, w, x, z);
    const long double excess = sum - 3.14159265358979323846L;
    if (std::fabs(excess) < 1e-8L) continue;
    ++decided;
    wanted += excess > 0 ? 1 : 0;
    ASSERT_EQ(WantsSwap(x, y, z, w, m), excess > 0) << "trial " << trial;
  }
  EXPECT_GT(decided, 3'000);
  EXPECT_GT(wanted, 500);
  EXPECT_GT(decided - wanted, 500);
}

TEST(WantsSwap, NeverWantsBothDiagonals) {
  Rng rng(7);
  for (int trial = 0; trial < 20'000; ++trial) {
    const Metric m = RandomMetric(rng, 1000);
    // Nearly co-circular in the Euclidean metric; exactly so every other time.
    std::array<Vec2, 4> p{Vec2{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    if (trial % 2 == 1) {
      for (Vec2& q : p) q += 1e-14 * Vec2{rng.Uniform(-1, 1), rng.Uniform(-1, 1)};
    }
    const Metric metric = trial % 4 < 2 ? Metric{1, 0, 1} : m;
    ASSERT_FALSE(WantsSwap(p[0], p[1], p[2], p[3], metric) &&
                 WantsSwap(p[1], p[2], p[3], p[0], metric))
        << "trial " << trial;
  }
}

/// A mesh with nothing regular about it, and constrained edges inside.
std::unique_ptr<testing::EditedMesh> ShakenMesh(std::uint64_t seed) {
  MeshData data = GridData(8, 8);
  data.edges = {{30, 31}, {31, 32}, {32, 42}, {42, 52}};
  auto made = ImportedMesh(data);
  testing::RandomEditor editor(*made, seed);
  for (int i = 0; i < 1500; ++i) editor.Step();
  return made;
}

/// Swaps until no star wants any.
int FlipAll(testing::EditedMesh& made, int rounds_max) {
  MetricFlipper flipper(made.edit);
  Star star;
  for (int round = 0; round < rounds_max; ++round) {
    int swaps = 0;
    for (const VertexId id : testing::LiveVertices(made.mesh)) {
      star.Gather(made.mesh, id);
      swaps += flipper.AroundMoved(star);
    }
    if (swaps == 0) return round;
  }
  return rounds_max;
}

// Goal: with one metric everywhere the swaps end, and end Delaunay in the metric's space.
// Method: exact in-circle tests on the transformed points.
TEST(MetricFlipper, EndsDelaunayInTheTransformedSpace) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto made = ShakenMesh(seed);
    Rng rng(seed);
    const Metric metric = RandomMetric(rng, 20);
    for (const VertexId id : testing::LiveVertices(made->mesh)) made->edit.SetMetric(id, metric);
    const Mesh before = made->mesh;
    ASSERT_LT(FlipAll(*made, 50), 50);
    ASSERT_EQ(Faults(made->mesh), "");
    EXPECT_EQ(testing::TagLengths(made->mesh), testing::TagLengths(before));
    EXPECT_EQ(made->mesh.edge_count(), before.edge_count());
    const Transform t(metric);
    for (const TriangleId id : testing::LiveTriangles(made->mesh)) {
      const TriangleRecord& triangle = made->mesh.triangle(id);
      for (int side = 0; side < 3; ++side) {
        const TriangleId other = triangle.neighbors[static_cast<std::size_t>(side)];
        if (triangle.IsConstrained(side) || !other.valid()) continue;
        const auto far = made->mesh.triangle(other)
                             .vertices[static_cast<std::size_t>(made->mesh.SideTowards(other, id))];
        const auto at = [&](std::size_t k) {
          return t.Rounded(made->mesh.position(triangle.vertices[k]));
        };
        EXPECT_LE(InCircle(at(0), at(1), at(2), t.Rounded(made->mesh.position(far))), 0)
            << "seed " << seed << " triangle " << id << " side " << side;
      }
    }
  }
}

// Where every vertex has another metric the criterion has no potential; runs end all the same.
TEST(MetricFlipper, EndsWhateverTheMetrics) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto made = ShakenMesh(seed);
    Rng rng(seed);
    for (const VertexId id : testing::LiveVertices(made->mesh)) {
      made->edit.SetMetric(id, RandomMetric(rng, 100));
    }
    const auto lengths = testing::TagLengths(made->mesh);
    FlipAll(*made, 20);
    ASSERT_EQ(Faults(made->mesh), "");
    EXPECT_EQ(testing::TagLengths(made->mesh), lengths);
  }
}

TEST(MetricFlipper, AfterAnInsertionSwapsOnlyTowardsTheNewVertex) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto made = ShakenMesh(seed);
    Rng rng(seed);
    const TriangleId t = testing::LiveTriangles(made->mesh)[rng.Below(100)];
    const auto& v = made->mesh.triangle(t).vertices;
    if (made->mesh.FindEdge(v[1], v[2]).valid()) continue;
    const Vec2 middle = 0.5 * (made->mesh.position(v[1]) + made->mesh.position(v[2]));
    const VertexId born = made->edit.SplitEdge({t, 0}, middle, 0);
    if (!Faults(made->mesh).empty()) continue;  // The middle rounded off a flat triangle.
    Star star;
    star.Gather(made->mesh, born);
    const std::size_t degree = star.ring().size();
    MetricFlipper flipper(made->edit);
    const std::int32_t swaps = flipper.AroundInserted(born);
    star.Gather(made->mesh, born);
    EXPECT_EQ(star.ring().size(), degree + static_cast<std::size_t>(swaps));
    EXPECT_EQ(Faults(made->mesh), "");
  }
}

TEST(MetricFlipper, WithinATriangleSetLeavesTheOthersAlone) {
  const auto made = ShakenMesh(3);
  Rng rng(3);
  std::vector<TriangleId> inside;
  for (const TriangleId id : testing::LiveTriangles(made->mesh)) {
    if (rng.Below(2) == 0) inside.push_back(id);
  }
  const Mesh before = made->mesh;
  MetricFlipper flipper(made->edit);
  EXPECT_GT(flipper.Within(inside, {1, 0, 1}), 0);
  EXPECT_EQ(Faults(made->mesh), "");
  for (const TriangleId id : testing::LiveTriangles(made->mesh)) {
    if (std::find(inside.begin(), inside.end(), id) != inside.end()) continue;
    EXPECT_EQ(made->mesh.triangle(id).vertices, before.triangle(id).vertices);
  }
}

}  // namespace
}  // namespace pliant
