#include "core/pliant/metric_shift.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "core/base/rng.h"
#include "core/metric/function_field.h"
#include "core/metric/metric_spec.h"
#include "tests/support/cases.h"

namespace pliant {
namespace {

/// Random points within 0.1 of the front of case C at 0.4, with its tensors.
std::vector<PlacedTensor> SamplesOfTheFront(std::uint64_t seed = 7) {
  const testing::Case shock = testing::ShockCase(10000, 0.4);
  Rng rng(seed);
  std::vector<PlacedTensor> samples;
  std::int32_t hint = MetricField::kNoHint;
  while (samples.size() < 96) {
    const Vec2 p{0.3 + 0.3 * rng.Unit(), rng.Unit()};
    samples.push_back({p, shock.field->At(p, hint), hint});
  }
  return samples;
}

// Goal: a curved front that moved as it is, across and along itself, is found to a small part of
// its thickness, 7e-4.
TEST(FindShift, FindsHowFarAFrontHasMoved) {
  for (const Vec2 by : {Vec2{0.02, 0}, Vec2{-0.05, 0}, Vec2{0.01, -0.015}, Vec2{0.0007, 0}}) {
    const auto before = std::shared_ptr<MetricField>(testing::ShockCase(10000, 0.4).field);
    const FunctionField now([&](Vec2 p) {
      std::int32_t hint = MetricField::kNoHint;
      return before->At(p - by, hint);
    });
    const std::optional<Vec2> found = FindShift(SamplesOfTheFront(), now);
    ASSERT_TRUE(found.has_value()) << by.x << ' ' << by.y;
    EXPECT_NEAR(found->x, by.x, 2e-5);
    EXPECT_NEAR(found->y, by.y, 2e-4);
  }
}

// Goal: whichever places are asked, the search does not end in a valley beside the right one, where
// a curved front fits itself badly. Method: 200 random sets of places.
TEST(FindShift, FindsItFromAnyPlaces) {
  const auto before = std::shared_ptr<MetricField>(testing::ShockCase(10000, 0.4).field);
  const FunctionField now([&](Vec2 p) {
    std::int32_t hint = MetricField::kNoHint;
    return before->At(p - Vec2{0.02, 0}, hint);
  });
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    const std::optional<Vec2> found = FindShift(SamplesOfTheFront(seed), now);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->x, 0.02, 1e-3);
    EXPECT_NEAR(found->y, 0, 6e-3);
  }
}

// Goal: a shift that is off by several times the front's thickness is put right.
TEST(RefineShift, FindsTheRestOfTheWay) {
  const Vec2 by{0.01, -0.015};
  const auto before = std::shared_ptr<MetricField>(testing::ShockCase(10000, 0.4).field);
  const FunctionField now([&](Vec2 p) {
    std::int32_t hint = MetricField::kNoHint;
    return before->At(p - by, hint);
  });
  const Vec2 found = RefineShift(SamplesOfTheFront(), now, by + Vec2{0.002, -0.003});
  EXPECT_NEAR(found.x, by.x, 2e-5);
  EXPECT_NEAR(found.y, by.y, 2e-4);
  EXPECT_EQ(RefineShift({}, now, by), by);
}

TEST(FindShift, FindsNoneWhereTheMetricChangesOtherwise) {
  const auto before = std::shared_ptr<MetricField>(testing::ShockCase(10000, 0.4).field);
  const FunctionField finer([&](Vec2 p) {
    std::int32_t hint = MetricField::kNoHint;
    return 4 * before->At(p, hint);
  });
  EXPECT_FALSE(FindShift(SamplesOfTheFront(), finer).has_value());
  const FunctionField uniform([](Vec2) { return Metric::Isotropic(0.01); });
  EXPECT_FALSE(FindShift(SamplesOfTheFront(), uniform).has_value());
  const FunctionField turned([&](Vec2 p) {
    std::int32_t hint = MetricField::kNoHint;
    return before->At({p.y, p.x}, hint);
  });
  EXPECT_FALSE(FindShift(SamplesOfTheFront(), turned).has_value());
  EXPECT_FALSE(FindShift({}, uniform).has_value());
}

// Goal: that nothing has moved is found out with a fraction of the questions of a search: 24
// samples at 160 shifts would be 3,840.
TEST(FindShift, AsksLittleWhereNothingHasMoved) {
  std::int64_t questions = 0;
  const FunctionField uniform([&](Vec2) {
    ++questions;
    return Metric::Isotropic(0.01);
  });
  EXPECT_FALSE(FindShift(SamplesOfTheFront(), uniform).has_value());
  EXPECT_GT(questions, 160);
  EXPECT_LE(questions, 1500);
}

// Goal: to look where a formula has no value is no error of the formula.
TEST(FindShift, LeavesNoTraceInTheField) {
  const BoundingBox box{{0, 0}, {1, 1}};
  const auto field = MakeMetricField(MetricSpec{.source = SizeMetric{"0.02+0.1*sqrt(x)"}}, box);
  ASSERT_TRUE(field.ok());
  (void)FindShift(SamplesOfTheFront(), **field);
  EXPECT_TRUE((*field)->status().ok());
  std::int32_t hint = MetricField::kNoHint;
  EXPECT_FALSE((*field)->Probe({-1, 0}, hint).has_value());
  EXPECT_TRUE((*field)->status().ok());
  EXPECT_TRUE((*field)->Probe({0.25, 0}, hint).has_value());
}

}  // namespace
}  // namespace pliant
