// Goal: a session that refines and coarsens the same place for a week has the mesh that it had on
// the first day: what one update leaves is not worse for all that came before it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/metric/function_field.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

constexpr double kWornNodes = 5'000;
constexpr double kRadius = 0.25;

/// The metric of a mesh of kWornNodes nodes in the unit square, and in a disc in its middle one for
/// edges `factor` times shorter, with a transition of half a radius.
std::unique_ptr<MetricField> FieldWith(double factor) {
  const double size = std::sqrt(2 / (std::sqrt(3.0) * kWornNodes));
  const auto field = [=](Vec2 p) {
    const double distance = std::hypot(p.x - 0.5, p.y - 0.5);
    const double outwards = std::clamp((distance - kRadius) / (0.5 * kRadius), 0.0, 1.0);
    return Metric::Isotropic(size * std::pow(factor, outwards - 1));
  };
  return std::make_unique<FunctionField<decltype(field)>>(field);
}

/// What updates have left, on average over some of them.
struct Left {
  double share_125 = 0;
  double q_mean = 0;
  double vertices = 0;
  double q_min = 1;
};

class Wear : public ::testing::TestWithParam<double> {
 protected:
  Wear()
      : remesher_(Remesher::Create(testing::DiscCase(100, testing::DiscState::kOff).domain,
                                   FieldWith(1), Options{})
                      .value()) {
    Follow(FieldWith(1));
  }

  void Follow(std::unique_ptr<MetricField> field) {
    ASSERT_TRUE(remesher_->SetField(std::move(field)).ok());
    ASSERT_TRUE(remesher_->Step({}).ok());
    remesher_->Commit();
  }

  /// Refines and coarsens so many times.
  Left Cycle(int count) {
    Left left;
    for (int i = 0; i < count; ++i) {
      Follow(FieldWith(GetParam()));
      Follow(FieldWith(1));
      const Quality quality = MeasureQuality(remesher_->mesh(), remesher_->field());
      left.share_125 += quality.integrated.share_125 / count;
      left.q_mean += quality.q_mean / count;
      left.vertices += static_cast<double>(quality.vertex_count) / count;
      left.q_min = std::min(left.q_min, quality.q_min);
    }
    return left;
  }

  std::unique_ptr<Remesher> remesher_;
};

// Method: 24 times there and back; the last six against the first six, and against bounds.
TEST_P(Wear, DoesNotShowAfterManyUpdates) {
  const Left first = Cycle(6);
  (void)Cycle(12);
  const Left last = Cycle(6);
  EXPECT_GT(last.share_125, first.share_125 - 0.004);
  EXPECT_GT(last.q_mean, first.q_mean - 0.002);
  EXPECT_NEAR(last.vertices, first.vertices, 0.01 * first.vertices);
  EXPECT_GT(last.share_125, 0.97);
  EXPECT_GT(last.q_mean, 0.97);
  EXPECT_GT(last.q_min, 0.75);
  EXPECT_EQ(testing::Faults(remesher_->mesh()), "");
}

// By a factor at which edges are halved in bulk, and by one at which none is.
INSTANTIATE_TEST_SUITE_P(Factors, Wear, ::testing::Values(2, 1.3));

}  // namespace
}  // namespace pliant
