// Goal: at the ends of what doubles can say the loop still ends, in bounded work, with a valid mesh
// of the domain. Method: one extreme at a time: aspect ratio, range of sizes, distance from the
// origin, needles and slivers, points that nearly coincide, very many given points. The mesh is
// checked by Validate, its area and its given points; the number of visits has a bound that is far
// above what is needed and far below what a loop that runs in circles takes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/mesh/validate.h"
#include "core/metric/function_field.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Rectangle;

template <class Function>
std::unique_ptr<MetricField> MakeField(Function function) {
  return std::make_unique<FunctionField<Function>>(std::move(function));
}

std::unique_ptr<MetricField> ConstantSize(double size) {
  return MakeField([size](Vec2) { return Metric::Isotropic(size); });
}

/// Appends a closed loop of segments through points.
void AddLoop(Domain& domain, const std::vector<Vec2>& loop, std::int32_t tag) {
  const auto first = static_cast<std::int32_t>(domain.points.size());
  const auto count = static_cast<std::int32_t>(loop.size());
  domain.points.insert(domain.points.end(), loop.begin(), loop.end());
  for (std::int32_t k = 0; k < count; ++k) {
    domain.segments.push_back({first + k, first + (k + 1) % count, tag});
  }
}

/// Builds, lets the loop run to its end and checks what can be checked of any mesh.
void ExpectMeshOf(const Domain& domain, std::unique_ptr<MetricField> field,
                  std::pair<std::int32_t, std::int32_t> vertices) {
  auto made = Remesher::Create(domain, std::move(field), {});
  ASSERT_TRUE(made.ok()) << made.error().message;
  const double area = Area((*made)->mesh());
  const std::int64_t visits_max = 200 * std::int64_t{vertices.second};
  const auto progress = (*made)->Step({.visits_max = visits_max});
  ASSERT_TRUE(progress.ok()) << progress.error().message;
  EXPECT_EQ(progress->stop_reason, StopReason::kConverged) << visits_max << " visits";
  (void)(*made)->Commit();
  const Mesh& mesh = (*made)->mesh();
  EXPECT_EQ(testing::Faults(mesh), "");
  const double extent = std::fabs(domain.points[0].x) + std::fabs(domain.points[0].y);
  EXPECT_NEAR(Area(mesh), area, 1e-9 * area + 1e-13 * extent);
  EXPECT_GE(mesh.vertex_count(), vertices.first);
  EXPECT_LE(mesh.vertex_count(), vertices.second);
  for (std::size_t i = 0; i < domain.points.size(); ++i) {
    ASSERT_EQ(mesh.position(VertexId::FromIndex(i)), domain.points[i]) << "point " << i;
  }
}

class AspectRatio : public ::testing::TestWithParam<double> {};

// About 2000 elements of one shape, slanted. The corners of the square cannot be met.
TEST_P(AspectRatio, OfAConstantMetric) {
  const double aspect = GetParam();
  const double size = std::sqrt(1.0 / 2'000);
  const Metric metric = MetricFromAxes({.major_radius = size * std::sqrt(aspect),
                                        .minor_radius = size / std::sqrt(aspect),
                                        .major_direction = {0.8, 0.6}});
  ExpectMeshOf(Rectangle({0, 0}, {1, 1}), MakeField([metric](Vec2) { return metric; }),
               {1'000, 200'000});
}

// A layer along the bottom, as thick as the aspect ratio says, with the size across growing away
// from it.
TEST_P(AspectRatio, OfALayer) {
  const double thin = 0.1 / GetParam();
  ExpectMeshOf(Rectangle({0, 0}, {1, 1}), MakeField([thin](Vec2 p) {
                 const double across = std::min(thin + 0.2 * p.y, 0.1);
                 return Metric{100, 0, 1 / (across * across)};
               }),
               {100, 5'000});
}

INSTANTIATE_TEST_SUITE_P(Extremes, AspectRatio, ::testing::Values(1e2, 1e4, 1e5, 1e6));

TEST(Extremes, SizesOverNineDecades) {
  ExpectMeshOf(Rectangle({0, 0}, {1, 1}), MakeField([](Vec2 p) {
                 return Metric::Isotropic(std::min(1e-9 + 0.25 * Length(p), 1.0));
               }),
               {300, 5'000});
}

TEST(Extremes, SizesOverNineDecadesInADomainOfAMillion) {
  ExpectMeshOf(Rectangle({-5e5, -5e5}, {5e5, 5e5}), MakeField([](Vec2 p) {
                 return Metric::Isotropic(1e-4 + 0.3 * Length(p - Vec2{100, 200}));
               }),
               {200, 5'000});
}

class FarFromTheOrigin : public ::testing::TestWithParam<double> {};

// A hole of 1 % of a unit square; at 1e9 a double has steps of 1.2e-7, at 1e12 of 1.2e-4.
TEST_P(FarFromTheOrigin, KeepsItsShape) {
  const Vec2 far{GetParam(), -GetParam()};
  Domain domain = Rectangle(far, far + Vec2{1, 1});
  AddLoop(domain,
          {far + Vec2{.5, .5}, far + Vec2{.5, .51}, far + Vec2{.51, .51}, far + Vec2{.51, .5}}, 5);
  domain.holes = {far + Vec2{.505, .505}};
  ExpectMeshOf(domain, MakeField([far](Vec2 p) {
                 return Metric::Isotropic(0.01 + 0.2 * Length(p - far - Vec2{.5, .5}));
               }),
               {100, 3'000});
}

INSTANTIATE_TEST_SUITE_P(Extremes, FarFromTheOrigin, ::testing::Values(1e3, 1e6, 1e9, 1e12));

TEST(Extremes, Needle) {
  Domain domain;
  AddLoop(domain, {{0, 0}, {1, 0}, {1, 1e-7}}, 1);
  ExpectMeshOf(domain, ConstantSize(0.05), {20, 100});
  ExpectMeshOf(domain, ConstantSize(1e-4), {1'000, 40'000});
}

TEST(Extremes, Sliver) {
  ExpectMeshOf(Rectangle({0, 0}, {1, 1e-12}), ConstantSize(.01), {50, 500});
}

// Lines from one corner that a double can just tell apart, cut off by the far side.
TEST(Extremes, FanOfNeedles) {
  Domain domain;
  AddLoop(domain, {{0, 0}, {1, 0}, {1, 1}}, 1);
  for (int k = 1; k <= 40; ++k) {
    domain.points.push_back({0.9, 0.4 + k * 1e-14});
    domain.segments.push_back({0, static_cast<std::int32_t>(domain.points.size() - 1), 2});
  }
  ExpectMeshOf(domain, ConstantSize(0.1), {43, 3'000});
}

TEST(Extremes, PointsThatNearlyCoincide) {
  Domain domain = Rectangle({0, 0}, {1, 1});
  Rng rng(7);
  for (int k = 0; k < 500; ++k) {
    const double radius = 1e-15 * static_cast<double>(1 << (k % 20));
    const Vec2 p = Vec2{0.25, 0.25} + radius * Vec2{rng.Uniform(-1, 1), rng.Uniform(-1, 1)};
    const auto& points = domain.points;
    if (std::find(points.begin(), points.end(), p) == points.end()) domain.points.push_back(p);
  }
  ExpectMeshOf(domain, ConstantSize(0.05), {500, 5'000});
}

// A side in pieces between 1e-3 and 1e-10, exactly on one line.
TEST(Extremes, ChainOfCollinearPieces) {
  std::vector<Vec2> loop{{0, 0}};
  double piece = 1e-10;
  for (double x = 0; x < 0.999; x += piece, piece = std::min(piece * 1.5, 1e-3)) {
    if (x > 0) loop.push_back({x, 0});
  }
  loop.insert(loop.end(), {{1, 0}, {1, 1}, {0, 1}});
  Domain domain;
  AddLoop(domain, loop, 1);
  ExpectMeshOf(domain, ConstantSize(0.02), {static_cast<std::int32_t>(loop.size()), 20'000});
}

// Diamonds that touch their neighbours at their tips: every tip is a vertex of several fans.
TEST(Extremes, HolesThatTouchAtTheirTips) {
  Domain domain = Rectangle({0, 0}, {11, 2});
  std::int32_t tip = -1;
  for (int k = 0; k < 10; ++k) {
    const double x = 0.5 + k;
    const auto next = static_cast<std::int32_t>(domain.points.size());
    if (tip < 0) domain.points.push_back({x, 1});
    const std::int32_t left = tip < 0 ? next : tip;
    const auto low = static_cast<std::int32_t>(domain.points.size());
    domain.points.insert(domain.points.end(), {{x + .5, .8}, {x + 1, 1}, {x + .5, 1.2}});
    domain.segments.insert(
        domain.segments.end(),
        {{left, low, 5}, {low, low + 1, 5}, {low + 1, low + 2, 5}, {low + 2, left, 5}});
    domain.holes.push_back({x + .5, 1});
    tip = low + 1;
  }
  ExpectMeshOf(domain, ConstantSize(0.1), {1'000, 5'000});
  ExpectMeshOf(domain, ConstantSize(10), {35, 200});
}

class Comb : public ::testing::TestWithParam<std::int32_t> {};

// Teeth far narrower than the wanted size, all given points.
TEST_P(Comb, HasATriangulationOfItsPoints) {
  const std::int32_t teeth = GetParam();
  const double pitch = 1.0 / teeth;
  std::vector<Vec2> loop{{1, 1}, {0, 1}};
  for (std::int32_t k = 0; k < teeth; ++k) {
    loop.push_back({k * pitch, k == 0 ? 0 : 0.5});
    if (k == 0) loop.push_back({0.25 * pitch, 0});
    loop.push_back({(k + 0.5) * pitch, 0.5});
    loop.push_back({(k + 0.75) * pitch, 0});
  }
  loop.push_back({1, 0});
  Domain domain;
  AddLoop(domain, loop, 1);
  const auto count = static_cast<std::int32_t>(loop.size());
  ExpectMeshOf(domain, ConstantSize(0.2), {count, 3 * count});
}

INSTANTIATE_TEST_SUITE_P(Extremes, Comb, ::testing::Values(10, 1'000, 100'000));

TEST(Extremes, ManyGivenPoints) {
  Domain domain = Rectangle({0, 0}, {1, 1});
  Rng rng(3);
  for (int k = 0; k < 200'000; ++k) {
    domain.points.push_back({rng.Uniform(0.001, 0.999), rng.Uniform(0.001, 0.999)});
  }
  ExpectMeshOf(domain, ConstantSize(0.01), {200'000, 260'000});
}

}  // namespace
}  // namespace pliant
