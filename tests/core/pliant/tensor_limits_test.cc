// Goal: limits of tensors at vertices change with the tensors and after them, hold for all of them,
// and go away again. Method: against sessions that had the limits all along, against what was sent,
// and through rollback, a saved session and a cancel.

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/stop_signal.h"
#include "core/metric/metric_spec.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "core/pliant/trouble.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/remesher_testing.h"

namespace pliant {
namespace {

using testing::HashAtRest;
using testing::kNoLimits;
using testing::LeastQuality;
using testing::UniformSession;

constexpr MetricLimits kGraded{.gradation = {.gradation = 1.5, .rotation = 0.7}};

/// Of every vertex: fine on the left, coarse on the right.
std::vector<Metric> Jump(const Remesher& remesher) {
  std::vector<Metric> tensors;
  for (const VertexId vertex : testing::LiveVertices(remesher.mesh())) {
    const double x = remesher.mesh().position(vertex).x;
    tensors.push_back(Metric::Isotropic(x < 0.5 ? 0.01 : 0.2));
  }
  return tensors;
}

TEST(TensorLimits, WithTensorsAreThoseOfASessionThatHadThemBefore) {
  const auto before = UniformSession(kGraded);
  const auto with = UniformSession();
  ASSERT_TRUE(before->SetTensors({}, Jump(*before)).ok());
  ASSERT_TRUE(with->SetTensors({}, Jump(*with), kGraded).ok());
  EXPECT_EQ(HashAtRest(*before), HashAtRest(*with));
  EXPECT_EQ(with->limits(), kGraded);
  EXPECT_GT(LeastQuality(*with), kTroubleQuality);
}

/// How far the metric on the right is from what Jump wants there.
double ChangeOnTheRight(const Remesher& session) {
  std::int32_t hint = MetricField::kNoHint;
  return RelativeChange(Metric::Isotropic(0.2), session.field().At({0.9, 0.5}, hint));
}

TEST(TensorLimits, ComeAfterTensorsAndGoAwayAgain) {
  const auto session = UniformSession();
  ASSERT_TRUE(session->SetTensors({}, Jump(*session)).ok());
  HashAtRest(*session);
  EXPECT_LT(ChangeOnTheRight(*session), 0.05);
  ASSERT_TRUE(session->SetLimits(kGraded).ok());
  HashAtRest(*session);
  EXPECT_TRUE(session->metric_report().limits);
  EXPECT_GT(ChangeOnTheRight(*session), 0.2) << "it grows from 0.01 by ln 1.5 times the distance";
  ASSERT_TRUE(session->SetLimits(kNoLimits).ok());
  HashAtRest(*session);
  EXPECT_FALSE(session->metric_report().limits);
  EXPECT_LT(ChangeOnTheRight(*session), 0.05) << "what was sent, not what limits made of it";
}

TEST(TensorLimits, BoundsHoldForTheOthersToo) {
  const auto session = UniformSession();
  const VertexId vertex = testing::LiveVertices(session->mesh()).back();
  const Metric fine = Metric::Isotropic(0.02);
  MetricLimits bounded = kNoLimits;
  bounded.bounds = {.size_min = 0.04, .size_max = 0.06};
  ASSERT_TRUE(session->SetTensors({&vertex, 1}, {&fine, 1}, bounded).ok());
  for (const VertexId each : testing::LiveVertices(session->mesh())) {
    const double size = each == vertex ? 0.04 : 0.06;
    EXPECT_LT(RelativeChange(session->mesh().metric(each), Metric::Isotropic(size)), 1e-12);
  }
  HashAtRest(*session);
  const std::uint64_t hash = session->Snapshot().summary.state_hash;
  ASSERT_TRUE(session->SetLimits(kNoLimits).ok()) << "what was cut off is lost";
  EXPECT_EQ(HashAtRest(*session), hash);
  EXPECT_EQ(session->limits(), kNoLimits);
}

TEST(TensorLimits, ThatHoldAlreadyChangeNothing) {
  const auto session = UniformSession();
  ASSERT_TRUE(session->SetTensors({}, Jump(*session), kGraded).ok());
  HashAtRest(*session);
  ASSERT_TRUE(session->SetLimits(kGraded).ok());
  ASSERT_TRUE(session->Step({}).ok());
  EXPECT_TRUE(session->Commit().empty());
}

TEST(TensorLimits, ThatAreImpossibleAreRefusedAndNothingChanges) {
  const auto session = UniformSession();
  MetricLimits wrong = kGraded;
  wrong.gradation.gradation = 0.5;
  Status status = session->SetLimits(wrong);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(status.error().field, "metric.limits.gradation");
  wrong = kGraded;
  wrong.bounds = {.size_min = 2, .size_max = 1};
  status = session->SetTensors({}, Jump(*session), wrong);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().field, "metric.limits.size_max");
  EXPECT_EQ(session->limits(), kNoLimits);
  ASSERT_TRUE(session->Step({}).ok());
  EXPECT_TRUE(session->Commit().empty());
}

TEST(TensorLimits, GoBackWithARollbackAndForthWithASavedSession) {
  const auto session = UniformSession();
  ASSERT_TRUE(session->SetTensors({}, Jump(*session)).ok());
  const std::uint64_t raw_hash = HashAtRest(*session);
  ASSERT_TRUE(session->SetLimits(kGraded).ok());
  session->Rollback();
  EXPECT_EQ(session->limits(), kNoLimits);
  ASSERT_TRUE(session->SetLimits(kGraded).ok());
  const std::uint64_t graded_hash = HashAtRest(*session);
  const auto loaded = Remesher::Load(*session->Save());
  ASSERT_TRUE(loaded.ok());
  EXPECT_EQ((*loaded)->limits(), kGraded);
  const auto back = session->TakeUndo();
  ASSERT_TRUE(back.has_value());
  ASSERT_TRUE(session->Apply(*back, Revision(4)).ok());
  EXPECT_EQ(session->limits(), kNoLimits);
  EXPECT_EQ(session->Snapshot().summary.state_hash, raw_hash);
  ASSERT_TRUE(session->SetLimits(kGraded).ok());
  EXPECT_EQ(HashAtRest(*session), graded_hash) << "as the first time";
  ASSERT_TRUE((*loaded)->SetLimits(kNoLimits).ok());
  ASSERT_TRUE(session->SetLimits(kNoLimits).ok());
  EXPECT_EQ(HashAtRest(**loaded), HashAtRest(*session));
}

TEST(TensorLimits, ThatAreCancelledLeaveThoseOfBefore) {
  const auto session = UniformSession();
  const StopFlag stop(true);
  session->ListenTo(&stop);
  const Status status = session->SetTensors({}, Jump(*session), kGraded);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kCancelled);
  EXPECT_EQ(session->SetLimits(kGraded).error().code, ErrorCode::kCancelled);
  session->ListenTo(nullptr);
  EXPECT_EQ(session->limits(), kNoLimits);
  ASSERT_TRUE(session->Step({}).ok());
  EXPECT_TRUE(session->Commit().empty());
}

TEST(TensorLimits, HoldBeforeTheFirstCommitToo) {
  const MetricSpec spec{.source = SizeMetric{"0.1"}, .gradation = kNoLimits.gradation};
  auto session = Remesher::Create(testing::GridData(8, 8), spec, {});
  ASSERT_TRUE(session.ok());
  ASSERT_TRUE((*session)->SetTensors({}, Jump(**session), kGraded).ok());
  HashAtRest(**session);
  EXPECT_TRUE((*session)->metric_report().limits);
  EXPECT_GT(LeastQuality(**session), kTroubleQuality);
}

}  // namespace
}  // namespace pliant
