// Goal: nodes in the interior may be sent anywhere inside, all of them or a few, past each other
// and across holes; what cannot be is refused at once by the entry that is wrong. Method: swirls,
// shaken nodes and exchanged places, with sub-steps counted: their number must not grow with the
// mesh.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/metric/metric_spec.h"
#include "core/motion/move.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/stop_after.h"

namespace pliant {
namespace {

using testing::Faults;

class NamedNodes : public ::testing::Test {
 protected:
  void Start(const Domain& domain, const char* size) {
    auto made = Remesher::Create(domain, {.source = SizeMetric{size}}, {});
    ASSERT_TRUE(made.ok());
    remesher_ = std::move(*made);
    ASSERT_TRUE(remesher_->Step({}).ok());
    (void)remesher_->Commit();
  }

  [[nodiscard]] const Mesh& mesh() const { return remesher_->mesh(); }

  /// Live vertices on no constrained edge, ascending.
  [[nodiscard]] std::vector<VertexId> Inner() const {
    std::vector<VertexId> inner = testing::LiveVertices(mesh());
    std::erase_if(inner, [&](VertexId v) { return mesh().vertex(v).edge.valid(); });
    return inner;
  }

  /// Moves and lets the loop run; everybody must have arrived, before it. @return the sub-steps
  std::int64_t Move(const MotionRequest& request) {
    const auto report = MoveVertices(*remesher_, request);
    EXPECT_TRUE(report.ok()) << report.error().message;
    if (!report.ok()) return -1;
    for (std::size_t i = 0; i < request.vertices.size(); ++i) {
      EXPECT_TRUE(mesh().IsLive(request.vertices[i]));
      EXPECT_EQ(mesh().position(request.vertices[i]), request.positions[i]);
    }
    EXPECT_EQ(Faults(mesh()), "");
    const auto progress = remesher_->Step({});
    EXPECT_TRUE(progress.ok());
    EXPECT_EQ(Faults(mesh()), "");
    EXPECT_GT(MeasureQuality(mesh(), remesher_->field()).q_mean, 0.95);
    return report->sub_step_count;
  }

  [[nodiscard]] std::unique_ptr<Remesher>& remesher() { return remesher_; }

 private:
  std::unique_ptr<Remesher> remesher_;
};

/// Around the middle of the unit square, the more the nearer to it.
Vec2 Swirled(Vec2 p, double angle) {
  const Vec2 arm = p - Vec2{0.5, 0.5};
  const double turn = angle * std::exp(-Dot(arm, arm) / (0.15 * 0.15));
  return Vec2{0.5, 0.5} + Vec2{std::cos(turn) * arm.x - std::sin(turn) * arm.y,
                               std::sin(turn) * arm.x + std::cos(turn) * arm.y};
}

TEST_F(NamedNodes, ASwirlOfAllTakesOneStepInMeshesOfAnySize) {
  for (const char* size : {"0.05", "0.01"}) {
    ASSERT_NO_FATAL_FAILURE(Start(testing::Rectangle({0, 0}, {1, 1}), size));
    MotionRequest request;
    for (const VertexId vertex : testing::LiveVertices(mesh())) {
      const Vec2 p = mesh().position(vertex);
      request.vertices.push_back(vertex);
      request.positions.push_back(mesh().vertex(vertex).edge.valid() ? p : Swirled(p, 6));
    }
    EXPECT_EQ(Move(request), 1) << size;
  }
}

TEST_F(NamedNodes, ShakenByThreeLengthsTheyArriveInOneStep) {
  ASSERT_NO_FATAL_FAILURE(Start(testing::Rectangle({0, 0}, {1, 1}), "0.02"));
  Rng rng(7);
  MotionRequest request;
  for (const VertexId vertex : Inner()) {
    const Vec2 by{rng.Uniform(-0.06, 0.06), rng.Uniform(-0.06, 0.06)};
    const Vec2 to = mesh().position(vertex) + by;
    const auto inside = [](double x) { return x < 0 ? -x : x > 1 ? 2 - x : x; };
    request.vertices.push_back(vertex);
    request.positions.push_back({inside(to.x), inside(to.y)});
  }
  EXPECT_EQ(Move(request), 1);
}

// Few of many are named, and their straight ways lead over a hole.
TEST_F(NamedNodes, SomeChangePlacesAcrossAHole) {
  Domain domain = testing::Rectangle({0, 0}, {1, 1});
  for (const Vec2 p : {Vec2{0.3, 0.3}, {0.7, 0.3}, {0.7, 0.7}, {0.3, 0.7}})
    domain.points.push_back(p);
  for (std::int32_t k = 0; k < 4; ++k) domain.segments.push_back({4 + k, 4 + (k + 1) % 4, 9});
  domain.holes.push_back({0.5, 0.5});
  for (const std::size_t share : {1, 3, 20}) {
    ASSERT_NO_FATAL_FAILURE(Start(domain, "0.03"));
    const std::vector<VertexId> inner = Inner();
    MotionRequest request;
    for (std::size_t i = 0; i < inner.size(); i += share) request.vertices.push_back(inner[i]);
    const std::size_t count = request.vertices.size();
    for (std::size_t i = 0; i < count; ++i) {
      request.positions.push_back(mesh().position(request.vertices[(i + count / 2) % count]));
    }
    EXPECT_GE(Move(request), 1) << share;
  }
}

TEST_F(NamedNodes, WhatCannotBeIsRefusedByItsEntryAndChangesNothing) {
  ASSERT_NO_FATAL_FAILURE(Start(testing::Rectangle({0, 0}, {1, 1}), "0.05"));
  const std::vector<VertexId> inner = Inner();
  const std::uint64_t hash = remesher()->Commit().summary.state_hash;
  struct Fault {
    Vec2 place;
    ErrorCode code;
    std::int64_t other;
    const char* words;
  };
  const Vec2 taken = mesh().position(inner[4]);
  for (const auto& [place, code, other, words] :
       {Fault{{1.5, 0.5}, ErrorCode::kPointOutsideDomain, -1, "outside of the domain"},
        Fault{{0.3, 1}, ErrorCode::kPointOnSegment, -1, "on a constrained edge"},
        Fault{{1, 1}, ErrorCode::kDuplicatePoint, -1, "where vertex 2"},
        Fault{taken, ErrorCode::kDuplicatePoint, 4, "comes to be"}}) {
    MotionRequest request;
    for (std::size_t i = 0; i < 30; ++i) {
      request.vertices.push_back(inner[i]);
      request.positions.push_back(mesh().position(inner[i]));
    }
    request.positions[17] = place;
    const auto refused = MoveVertices(*remesher(), request);
    ASSERT_FALSE(refused.ok()) << words;
    EXPECT_EQ(refused.error().code, code);
    EXPECT_EQ(refused.error().field, "motion.positions");
    // Of two that meet, the lower one.
    EXPECT_EQ(refused.error().index, other < 0 ? 17 : std::min<std::int64_t>(17, other));
    EXPECT_EQ(refused.error().other_index, other < 0 ? -1 : std::max<std::int64_t>(17, other));
    EXPECT_NE(refused.error().message.find(words), std::string::npos) << refused.error().message;
    EXPECT_EQ(remesher()->Commit().summary.state_hash, hash);
  }
}

TEST_F(NamedNodes, AskedToStopTheyGoAsFarAsTheyCan) {
  ASSERT_NO_FATAL_FAILURE(Start(testing::Rectangle({0, 0}, {1, 1}), "0.05"));
  MotionRequest request;
  request.on_impossible = ImpossibleMotion::kStop;
  for (const VertexId vertex : Inner()) {
    request.vertices.push_back(vertex);
    request.positions.push_back(mesh().position(vertex));
  }
  const std::size_t runaway = request.vertices.size() / 2;
  const Vec2 from = request.positions[runaway];
  request.positions[runaway] = {1 + (1 - from.x), from.y};  // The wall is half of the way.
  const auto report = MoveVertices(*remesher(), request);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_LT(report->fraction, 0.5);
  EXPECT_GT(report->fraction, 0.49);
  EXPECT_EQ(Faults(mesh()), "");
}

// Goal: a place that is hard to get through is not where it ends, if nobody has nowhere to go
// there.
TEST_F(NamedNodes, AskedToStopTheyGoOnThroughACrowd) {
  ASSERT_NO_FATAL_FAILURE(Start(testing::Rectangle({0, 0}, {1, 1}), "0.02"));
  Rng rng(3);
  MotionRequest request;
  request.on_impossible = ImpossibleMotion::kStop;
  for (const VertexId vertex : Inner()) {
    const Vec2 by{rng.Uniform(-0.02, 0.02), rng.Uniform(-0.02, 0.02)};
    const Vec2 to = mesh().position(vertex) + by;
    request.vertices.push_back(vertex);
    request.positions.push_back(
        {std::clamp(to.x, 1e-4, 1 - 1e-4), std::clamp(to.y, 1e-4, 1 - 1e-4)});
  }
  const std::size_t one = request.vertices.size() / 2;
  request.positions[one] = request.positions[one + 7];  // They meet at the very end.
  const auto report = MoveVertices(*remesher(), request);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_GT(report->fraction, 0.99);
  EXPECT_LT(report->fraction, 1);
  EXPECT_EQ(Faults(mesh()), "");
}

// Goal: however long the list, and whenever it is asked, somebody who cancels is heard.
TEST_F(NamedNodes, ASwirlCanBeStoppedAnywhere) {
  ASSERT_NO_FATAL_FAILURE(Start(testing::Rectangle({0, 0}, {1, 1}), "0.03"));
  MotionRequest request;
  for (const VertexId vertex : Inner()) {
    request.vertices.push_back(vertex);
    request.positions.push_back(Swirled(mesh().position(vertex), 6));
  }
  const std::uint64_t hash = remesher()->Commit().summary.state_hash;
  std::int64_t stopped_count = 0;
  for (std::int64_t after = 1;; ++after) {
    const testing::StopAfter stop(after);
    remesher()->ListenTo(&stop);
    const auto report = MoveVertices(*remesher(), request);
    remesher()->ListenTo(nullptr);
    if (report.ok()) break;
    ASSERT_EQ(report.error().code, ErrorCode::kCancelled) << report.error().message;
    ++stopped_count;
    ASSERT_EQ(Faults(mesh()), "");
    ASSERT_EQ(remesher()->Commit().summary.state_hash, hash);
  }
  EXPECT_GT(stopped_count, 10);
}

}  // namespace
}  // namespace pliant
