// That updates equal a full run to the bit is tested by limiter_test.cc, against LimitMetrics.
#include "core/metric/tensor_smoothing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/base/rng.h"
#include "core/mesh/mesh_rings.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

Metric RandomTensor(Rng& rng) {
  const double major = std::pow(10, rng.Uniform(-1, 1));
  const double angle = rng.Uniform(0, std::numbers::pi);
  return MetricFromAxes(
      {major, major * std::pow(10, -rng.Uniform(0, 2)), {std::cos(angle), std::sin(angle)}});
}

/// The logarithm by another formula: eigenvalues and the projection onto one eigenvector.
std::array<double, 3> PlainLog(const Metric& m) {
  const double mean = (m.m11 + m.m22) / 2;
  const double radius = std::hypot((m.m11 - m.m22) / 2, m.m12);
  const double high = std::log(mean + radius);
  const double low = std::log((m.m11 * m.m22 - m.m12 * m.m12) / (mean + radius));
  if (radius == 0) return {high, 0, high};
  const double slope = (high - low) / (2 * radius);
  return {low + slope * (m.m11 - mean + radius), slope * m.m12,
          low + slope * (m.m22 - mean + radius)};
}

class Smoothed : public ::testing::Test {
 protected:
  void Set(VertexId v, const Metric& tensor) { smoothing_.Set(v.value(), tensor); }
  void Update(const std::vector<VertexId>& vertices) {
    std::vector<std::int32_t> touched;
    for (const VertexId v : vertices) touched.push_back(v.value());
    (void)smoothing_.Update(rings_, touched);
  }

  std::unique_ptr<testing::EditedMesh> made_ = testing::ImportedMesh(testing::GridData(9, 9));
  MeshRings rings_{made_->mesh};
  std::vector<VertexId> live_ = testing::LiveVertices(made_->mesh);
  TensorSmoothing smoothing_{2};
};

// Method: means of plain logarithms, computed twice over with no care for order.
TEST_F(Smoothed, AveragesTheLogarithmsOfRings) {
  Rng rng(3);
  std::vector<std::array<double, 3>> logs(live_.size());
  for (const VertexId v : live_) {
    const Metric tensor = RandomTensor(rng);
    Set(v, tensor);
    logs[v.index()] = PlainLog(tensor);
  }
  Update(live_);
  for (int pass = 0; pass < 2; ++pass) {
    const auto before = logs;
    for (const VertexId v : live_) {
      const auto ring = rings_.Neighbors(v.value());
      for (std::size_t k = 0; k < 3; ++k) {
        double sum = before[v.index()][k];
        for (const std::int32_t q : ring) sum += before[static_cast<std::size_t>(q)][k];
        logs[v.index()][k] = sum / static_cast<double>(ring.size() + 1);
      }
    }
  }
  for (const VertexId v : live_) {
    const std::array<double, 3> found = PlainLog(smoothing_.At(v.value()));
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(found[k], logs[v.index()][k], 1e-12) << v << " entry " << k;
    }
    EXPECT_TRUE(smoothing_.Differs(v.value()));
  }
}

TEST_F(Smoothed, LeavesAConstantAsItIsToTheBit) {
  const Metric tensor = MetricFromAxes({0.7, 0.03, {std::cos(0.3), std::sin(0.3)}});
  for (const VertexId v : live_) Set(v, tensor);
  Update(live_);
  for (const VertexId v : live_) EXPECT_FALSE(smoothing_.Differs(v.value())) << v;
  // One other tensor reaches as far as there are passes, and no farther.
  const VertexId middle(44);
  Set(middle, Metric::Isotropic(5));
  Update({middle});
  const Vec2 center = made_->mesh.position(middle);
  int differing_count = 0;
  for (const VertexId v : live_) {
    const Vec2 d = made_->mesh.position(v) - center;
    const double rings = std::max(std::abs(d.x), std::abs(d.y));
    if (rings > 2) {
      EXPECT_FALSE(smoothing_.Differs(v.value())) << v;
    }
    differing_count += smoothing_.Differs(v.value()) ? 1 : 0;
  }
  EXPECT_GT(differing_count, 7);
}

TEST(RingMean, DoesNotDependOnTheOrder) {
  Rng rng(5);
  std::vector<PlacedLog> ring;
  for (int i = 0; i < 7; ++i) {
    ring.push_back({{rng.Uniform(0, 1), rng.Uniform(0, 1)}, Log(RandomTensor(rng))});
  }
  ring[3].position.x = ring[4].position.x;
  const LogMetric own = Log(RandomTensor(rng));
  std::vector<PlacedLog> sorted = ring;
  const LogMetric mean = RingMean(own, sorted);
  for (int turn = 0; turn < 50; ++turn) {
    for (std::size_t i = ring.size(); i > 1; --i) std::swap(ring[i - 1], ring[rng.Below(i)]);
    std::vector<PlacedLog> shuffled = ring;
    ASSERT_EQ(RingMean(own, shuffled), mean);
  }
}

// Goal: what it is for: the noise in the sizes of a smooth metric becomes less than half, also at
// the boundary, where rings are small.
TEST_F(Smoothed, TakesNoiseAway) {
  Rng rng(8);
  const auto size = [&](VertexId v) { return 1 + 0.05 * made_->mesh.position(v).x; };
  for (const VertexId v : live_)
    Set(v, Metric::Isotropic(size(v) * std::exp(rng.Uniform(-0.3, 0.3))));
  Update(live_);
  double noise = 0;
  for (const VertexId v : live_) {
    const double ratio = 1 / std::sqrt(smoothing_.At(v.value()).m11) / size(v);
    noise += std::log(ratio) * std::log(ratio);
  }
  noise = std::sqrt(noise / static_cast<double>(live_.size()));
  EXPECT_LT(noise, 0.6 / std::sqrt(12.0) / 2);
}

TEST_F(Smoothed, RollsBackToTheBit) {
  Rng rng(9);
  for (const VertexId v : live_) Set(v, RandomTensor(rng));
  Update(live_);
  smoothing_.Commit();
  std::vector<Metric> before;
  for (const VertexId v : live_) before.push_back(smoothing_.At(v.value()));
  for (int turn = 0; turn < 3; ++turn) {
    const VertexId v = live_[rng.Below(live_.size())];
    for (int again = 0; again < 2; ++again) {
      Set(v, RandomTensor(rng));
      Update({v});
    }
    smoothing_.Rollback();
    for (std::size_t i = 0; i < live_.size(); ++i) {
      ASSERT_EQ(smoothing_.At(live_[i].value()), before[i]) << "vertex " << i;
    }
  }
}

}  // namespace
}  // namespace pliant
