// Goal: tensors at vertices hold together with functions of place. Method: against intersections
// computed here by another formula, against sessions that had both from the beginning, and through
// motions, rollback, a saved session and a cancel.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/stop_signal.h"
#include "core/metric/metric_spec.h"
#include "core/motion/move.h"
#include "core/pliant/displace.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/remesher_testing.h"

namespace pliant {
namespace {

using testing::HashAtRest;
using testing::kNoLimits;
using testing::UniformSession;

constexpr MetricLimits kGradedByHalf{.gradation = {.gradation = 1.5}};

/// Fine at a point.
const FunctionsSpec kPoint{.parts = {SizeMetric{"0.02 + 0.3*hypot(x - 0.5, y - 0.5 - t)"}}};

double SizeAt(Vec2 p, double t = 0) { return 0.02 + 0.3 * std::hypot(p.x - 0.5, p.y - 0.5 - t); }

/// Of a tensor and a size: the axes are those of the tensor, by its angle.
Metric Finest(const Metric& m, double size) {
  const double angle = 0.5 * std::atan2(2 * m.m12, m.m11 - m.m22);
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const double along = std::max(m.m11 * c * c + 2 * m.m12 * c * s + m.m22 * s * s, 1 / size / size);
  const double across =
      std::max(m.m11 * s * s - 2 * m.m12 * c * s + m.m22 * c * c, 1 / size / size);
  return {along * c * c + across * s * s, (along - across) * c * s, along * s * s + across * c * c};
}

/// Long and slanted, the same everywhere: known in between to the last bits.
constexpr Metric kSlanted{60, 25, 40};

std::vector<Metric> Slanted(const Remesher& remesher) {
  return std::vector<Metric>(static_cast<std::size_t>(remesher.mesh().vertex_count()), kSlanted);
}

/// Another one at every vertex.
std::vector<Metric> Various(const Remesher& remesher) {
  std::vector<Metric> tensors;
  for (const VertexId vertex : testing::LiveVertices(remesher.mesh())) {
    const Vec2 p = remesher.mesh().position(vertex);
    const double h = 0.06 + 0.1 * p.x;
    tensors.push_back({1 / (h * h), 20 * p.y, 1.5 / (h * h)});
  }
  return tensors;
}

void ExpectFinestEverywhere(const Remesher& session, double t, double tolerance) {
  for (const VertexId vertex : testing::LiveVertices(session.mesh())) {
    const Vec2 p = session.mesh().position(vertex);
    ASSERT_LT(RelativeChange(Finest(kSlanted, SizeAt(p, t)), session.mesh().metric(vertex)),
              tolerance)
        << vertex;
  }
}

/// What vertices want and have, to the bit, whatever the way to it. Sums over the mesh, for of what
/// limits change by less than the tolerance a mesh may have the old or the new.
void ExpectSameLimits(const Remesher& a, const Remesher& b) {
  EXPECT_EQ(a.metric_report().limits, b.metric_report().limits);
  EXPECT_EQ(a.metric_report().gradation_count, b.metric_report().gradation_count);
  EXPECT_EQ(a.metric_report().raw_complexity, b.metric_report().raw_complexity);
  EXPECT_EQ(a.metric_report().limited_complexity, b.metric_report().limited_complexity);
}

/// At every vertex and in between.
void ExpectSameMetric(const Remesher& a, const Remesher& b) {
  ExpectSameLimits(a, b);
  for (const VertexId vertex : testing::LiveVertices(a.mesh())) {
    ASSERT_EQ(a.mesh().metric(vertex), b.mesh().metric(vertex)) << vertex;
  }
  std::int32_t hint = MetricField::kNoHint;
  for (double x = 0.05; x < 1; x += 0.09) {
    std::int32_t other = MetricField::kNoHint;
    EXPECT_EQ(a.field().At({x, 0.7 * x}, hint), b.field().At({x, 0.7 * x}, other)) << x;
  }
}

TEST(TensorFunctions, GiveEveryVertexTheFinestOfBoth) {
  const auto session = UniformSession();
  const auto vertices = testing::LiveVertices(session->mesh());
  const std::vector<Metric> tensors = Various(*session);
  ASSERT_TRUE(session->SetTensors({}, tensors, kNoLimits, kPoint).ok());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Metric& has = session->mesh().metric(vertices[i]);
    const double size = SizeAt(session->mesh().position(vertices[i]));
    EXPECT_LT(RelativeChange(Finest(tensors[i], size), has), 0.051) << "the tolerance";
  }
  ASSERT_NE(session->functions(), nullptr);
  EXPECT_EQ(*session->functions(), kPoint);
}

// Goal: functions are asked where vertices are that the loop puts in and moves, however coarse the
// mesh was that the tensors came on.
TEST(TensorFunctions, AreAskedWhereTheLoopPutsVertices) {
  const auto session = UniformSession();
  ASSERT_TRUE(session->SetTensors({}, Slanted(*session), kNoLimits, kPoint).ok());
  HashAtRest(*session);
  EXPECT_GT(session->mesh().vertex_count(), 130);
  ExpectFinestEverywhere(*session, 0, 0.051);
  EXPECT_FALSE(session->metric_report().limits);
  const Quality quality = MeasureQuality(session->mesh(), *session->raw_field());
  EXPECT_GT(quality.q_mean, 0.95);
  std::int32_t hint = MetricField::kNoHint;
  for (const Vec2 p : {Vec2{0.51, 0.503}, Vec2{0.2, 0.9}}) {
    EXPECT_LT(RelativeChange(Finest(kSlanted, SizeAt(p)), session->field().At(p, hint)), 1e-6);
  }
}

TEST(TensorFunctions, OfTheSameTensorsAgainChangeNothing) {
  const auto session = UniformSession();
  ASSERT_TRUE(session->SetTensors({}, Slanted(*session), kNoLimits, kPoint).ok());
  HashAtRest(*session);
  ASSERT_TRUE(session->SetTensors({}, Slanted(*session), kNoLimits, kPoint).ok());
  ASSERT_TRUE(session->SetFunctions(kPoint, kNoLimits).ok());
  ASSERT_TRUE(session->SetLimits(kNoLimits).ok());
  ASSERT_TRUE(session->Step({}).ok());
  EXPECT_TRUE(session->Commit().empty());
}

// Goal: tensors at some vertices change theirs alone, to the bits of tensors sent at once, with
// limits and without.
TEST(TensorFunctions, FollowTensorsAtSomeVerticesToTheBit) {
  for (const MetricLimits& limits : {kNoLimits, kGradedByHalf}) {
    const auto parts = UniformSession(limits);
    const auto whole = UniformSession(limits);
    const auto vertices = testing::LiveVertices(parts->mesh());
    std::vector<Metric> tensors = Various(*parts);
    ASSERT_TRUE(parts->SetTensors({}, tensors, limits, kPoint).ok());
    const std::vector<VertexId> few{vertices[40], vertices[7], vertices[23]};
    const std::vector<Metric> finer(3, Metric{900, 100, 2000});
    ASSERT_TRUE(parts->SetTensors(few, finer).ok());
    for (const std::size_t i : {40U, 7U, 23U}) tensors[i] = finer[0];
    ASSERT_TRUE(whole->SetTensors({}, tensors, limits, kPoint).ok());
    ExpectSameLimits(*parts, *whole);
    if (limits == kNoLimits) ExpectSameMetric(*parts, *whole);
    EXPECT_EQ(*parts->functions(), kPoint);
    EXPECT_EQ(parts->metric_report().limits, limits == kGradedByHalf);
  }
}

// Goal: what functions have made finer is not taken for the tensor: another function leaves the
// tensor as it was sent.
TEST(TensorFunctions, ChangeAndTheTensorsStay) {
  for (const MetricLimits& limits : {kNoLimits, kGradedByHalf}) {
    const auto session = UniformSession(limits);
    ASSERT_TRUE(session->SetTensors({}, Slanted(*session), limits, kPoint).ok());
    HashAtRest(*session);
    FunctionsSpec later = kPoint;
    later.time = 0.3;
    ASSERT_TRUE(session->SetFunctions(later, limits).ok());
    EXPECT_EQ(session->functions()->time, 0.3);
    if (limits == kNoLimits) ExpectFinestEverywhere(*session, 0.3, 0.051);
    HashAtRest(*session);
    if (limits == kNoLimits) ExpectFinestEverywhere(*session, 0.3, 0.051);
    // Tensors alone end the functions.
    ASSERT_TRUE(session->SetTensors({}, Slanted(*session)).ok());
    EXPECT_EQ(session->functions(), nullptr);
    HashAtRest(*session);
    for (const VertexId vertex : testing::LiveVertices(session->mesh())) {
      ASSERT_LT(RelativeChange(kSlanted, session->mesh().metric(vertex)), 0.051);
    }
    EXPECT_LT(session->mesh().vertex_count(), 110);
  }
}

TEST(TensorFunctions, EndWithAnotherMetric) {
  const auto session = UniformSession();
  ASSERT_TRUE(session->SetTensors({}, Slanted(*session), kNoLimits, kPoint).ok());
  HashAtRest(*session);
  const MetricSpec spec{.source = SizeMetric{"0.1"}, .gradation = kNoLimits.gradation};
  ASSERT_TRUE(session->SetMetric(spec).ok());
  EXPECT_EQ(session->functions(), nullptr);
  HashAtRest(*session);
  std::int32_t hint = MetricField::kNoHint;
  EXPECT_EQ(session->field().At({0.5, 0.5}, hint), Metric::Isotropic(0.1));
}

TEST(TensorFunctions, StandBesideTheTensorsThatAFormulaGaveVertices) {
  const auto session = UniformSession();
  const VertexId first = testing::LiveVertices(session->mesh())[30];
  const Metric fine = Metric::Isotropic(0.01);
  ASSERT_TRUE(session->SetTensors({&first, 1}, {&fine, 1}, kNoLimits, kPoint).ok());
  for (const VertexId vertex : testing::LiveVertices(session->mesh())) {
    const Metric raw = vertex == first ? fine : Metric::Isotropic(0.1);
    const double size = SizeAt(session->mesh().position(vertex));
    EXPECT_LT(RelativeChange(Finest(raw, size), session->mesh().metric(vertex)), 0.051);
  }
  // The functions change nothing of the tensor's own place, until they are finer.
  const Metric coarse = Metric::Isotropic(0.5);
  ASSERT_TRUE(session->SetTensors({&first, 1}, {&coarse, 1}).ok());
  const double size = SizeAt(session->mesh().position(first));
  EXPECT_LT(RelativeChange(Metric::Isotropic(size), session->mesh().metric(first)), 0.051);
}

// Goal: bounds and gradation come after the intersection, and other bounds reach the functions too.
TEST(TensorFunctions, AreLimitedAfterwards) {
  const auto session = UniformSession();
  MetricLimits bounded = kNoLimits;
  bounded.bounds.size_min = 0.05;
  ASSERT_TRUE(session->SetTensors({}, Slanted(*session), bounded, kPoint).ok());
  HashAtRest(*session);
  const auto finest = [&] {
    double most = 0;
    for (const VertexId vertex : testing::LiveVertices(session->mesh())) {
      most = std::max(most, EigenvaluesOf(session->mesh().metric(vertex)).high);
    }
    return 1 / std::sqrt(most);
  };
  EXPECT_NEAR(finest(), 0.05, 1e-9);
  ASSERT_TRUE(session->SetLimits(kNoLimits).ok());
  HashAtRest(*session);
  EXPECT_LT(finest(), 0.03) << "a formula forgets nothing";
  ASSERT_TRUE(session->SetLimits(kGradedByHalf).ok());
  HashAtRest(*session);
  EXPECT_TRUE(session->metric_report().limits);
  EXPECT_GE(session->metric_report().limited_complexity,
            session->metric_report().raw_complexity * (1 - 1e-6));
}

TEST(TensorFunctions, GoBackWithARollbackAndForthWithASavedSession) {
  for (const MetricLimits& limits : {kNoLimits, kGradedByHalf}) {
    const auto session = UniformSession(limits);
    ASSERT_TRUE(session->SetTensors({}, Various(*session)).ok());
    const std::uint64_t alone = HashAtRest(*session);
    ASSERT_TRUE(session->SetFunctions(kPoint, limits).ok());
    session->Rollback();
    EXPECT_EQ(session->functions(), nullptr);
    ASSERT_TRUE(session->SetFunctions(kPoint, limits).ok());
    const std::uint64_t with = HashAtRest(*session);
    const Bytes saved = *session->Save();
    const auto loaded = Remesher::Load(saved);
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    ExpectSameMetric(*session, **loaded);
    EXPECT_EQ(*(*loaded)->Save(), saved);
    const auto back = session->TakeUndo();
    ASSERT_TRUE(back.has_value());
    const RevisionDelta forth = session->InverseOf(*back);
    ASSERT_TRUE(session->Apply(*back, Revision(4)).ok());
    EXPECT_EQ(session->functions(), nullptr);
    EXPECT_EQ(session->Snapshot().summary.state_hash, alone);
    // Forwards again by what a journal keeps.
    RevisionDelta written = forth;
    written.base = Revision(4);
    const Bytes bytes = *WriteDelta(written);
    const auto read = session->ReadDelta(bytes);
    ASSERT_TRUE(read.ok()) << read.error().message;
    ASSERT_TRUE(session->Apply(*read, Revision(5)).ok());
    EXPECT_EQ(session->Snapshot().summary.state_hash, with);
    ExpectSameMetric(*session, **loaded);
    const VertexId vertex = testing::LiveVertices(session->mesh())[5];
    const Metric fine = Metric::Isotropic(0.015);
    for (Remesher* each : {session.get(), loaded->get()}) {
      ASSERT_TRUE(each->SetTensors({&vertex, 1}, {&fine, 1}).ok());
    }
    EXPECT_EQ(HashAtRest(*session), HashAtRest(**loaded));
  }
}

// Goal: a way back that another object of the same session made serves a copy of it too.
TEST(TensorFunctions, GoBackInACopyByTheWayOfTheOriginal) {
  const auto session = UniformSession();
  ASSERT_TRUE(session->SetTensors({}, Various(*session), kNoLimits, kPoint).ok());
  HashAtRest(*session);
  const Bytes first = *session->Save();
  const VertexId vertex = testing::LiveVertices(session->mesh())[50];
  const Metric fine = Metric::Isotropic(0.015);
  ASSERT_TRUE(session->SetTensors({&vertex, 1}, {&fine, 1}).ok());
  HashAtRest(*session);
  const auto copy = Remesher::Load(*session->Save());
  ASSERT_TRUE(copy.ok());
  const auto back = session->TakeUndo();
  ASSERT_TRUE(back.has_value());
  EXPECT_FALSE(back->raw.all) << "the price of the change";
  ASSERT_TRUE((*copy)->Apply(*back, back->revision).ok());
  EXPECT_EQ(*(*copy)->Save(), first);
}

/// Moves the vertices of a disc, which is all that a displacement is.
Status MoveDisc(Remesher& session, Vec2 by, bool carries) {
  MotionRequest request;
  std::vector<Vec2> shifts;
  for (const VertexId vertex : testing::LiveVertices(session.mesh())) {
    const Vec2 p = session.mesh().position(vertex);
    if (Length(p - Vec2{0.3, 0.5}) > 0.15) continue;
    request.vertices.push_back(vertex);
    request.positions.push_back(p + by);
    shifts.push_back(by);
  }
  if (carries) {
    DisplaceVertices displacement(request.vertices, shifts);
    return session.Apply(displacement);
  }
  const auto report = MoveVertices(session, request);
  return report.ok() ? Status() : Status(report.error());
}

// Goal: vertices that a client moves ask the functions where they are now; what goes along with a
// displacement is the tensor without what the functions had made of it.
TEST(TensorFunctions, AreAskedWhereVerticesAreMovedTo) {
  for (const bool carries : {false, true}) {
    const auto session = UniformSession();
    ASSERT_TRUE(session->SetTensors({}, Slanted(*session), kNoLimits, kPoint).ok());
    HashAtRest(*session);
    ASSERT_TRUE(MoveDisc(*session, {0.05, 0.02}, carries).ok());
    HashAtRest(*session);
    ExpectFinestEverywhere(*session, 0, 0.051);
    const VertexId any = testing::LiveVertices(session->mesh())[3];
    ASSERT_TRUE(session->SetTensors({&any, 1}, {&kSlanted, 1}).ok());
    ASSERT_TRUE(session->Step({}).ok());
    EXPECT_TRUE(session->Commit().empty()) << "the tensors are as they were sent";
  }
}

// Goal: a displacement takes the tensors along and leaves the functions where they are.
TEST(TensorFunctions, StayBehindWhereTensorsGoAlong) {
  const Vec2 center{0.3, 0.5};
  const Vec2 by{0.1, 0};
  const auto session = UniformSession();
  const FunctionsSpec functions{.parts = {SizeMetric{"0.01 + 0.5*hypot(x - 0.3, y - 0.5)"}}};
  const auto tensors = [&] {
    std::vector<Metric> all;
    for (const VertexId vertex : testing::LiveVertices(session->mesh())) {
      all.push_back(
          Metric::Isotropic(0.02 + 0.3 * Length(session->mesh().position(vertex) - center)));
    }
    return all;
  };
  // Twice, for the first mesh is too coarse to know them.
  for (int i = 0; i < 2; ++i) {
    ASSERT_TRUE(session->SetTensors({}, tensors(), kNoLimits, functions).ok());
    HashAtRest(*session);
  }
  const auto size_at = [&](Vec2 p) {
    std::int32_t hint = MetricField::kNoHint;
    return 1 / std::sqrt(session->field().At(p, hint).m11);
  };
  EXPECT_LT(size_at(center), 0.013) << "of the function";
  ASSERT_TRUE(MoveDisc(*session, by, /*carries=*/true).ok());
  HashAtRest(*session);
  EXPECT_NEAR(size_at(center + by), 0.025, 0.007) << "of the tensor: neither 0.01 nor 0.05";
  EXPECT_LT(size_at(center), 0.015) << "the function is still here";
}

TEST(TensorFunctions, ThatHadNoValueForAStepThatWasTakenBackAreAskedAgain) {
  const auto session = UniformSession();
  const VertexId corner = [&] {
    for (const VertexId vertex : testing::LiveVertices(session->mesh())) {
      if (session->mesh().position(vertex) == Vec2{1, 1}) return vertex;
    }
    return VertexId();
  }();
  ASSERT_TRUE(corner.valid());
  const FunctionsSpec here{.parts = {SizeMetric{"x < 1.001 ? 0.1 : sqrt(x - 9)"}}};
  ASSERT_TRUE(session->SetTensors({}, Slanted(*session), kNoLimits, here).ok());
  HashAtRest(*session);
  const MotionRequest motion{.vertices = {corner}, .positions = {{1.05, 1}}, .tags = {}};
  ASSERT_TRUE(MoveVertices(*session, motion).ok());
  const auto step = session->Step({});
  ASSERT_FALSE(step.ok());
  EXPECT_EQ(step.error().code, ErrorCode::kExpressionValue);
  session->Rollback();
  ASSERT_TRUE(session->SetFunctions(here, kNoLimits).ok());
  EXPECT_TRUE(session->Step({}).ok());
}

TEST(TensorFunctions, ThatHaveNoValueAreRefusedAndNothingChanges) {
  const auto session = UniformSession();
  ASSERT_TRUE(session->SetTensors({}, Slanted(*session), kNoLimits, kPoint).ok());
  const std::uint64_t hash = HashAtRest(*session);
  const auto code = [&](const FunctionsSpec& functions) {
    const Status status = session->SetTensors({}, Various(*session), kNoLimits, functions);
    return status.ok() ? ErrorCode{} : status.error().code;
  };
  EXPECT_EQ(code({.parts = {SizeMetric{"0.1 +"}}}), ErrorCode::kExpressionSyntax);
  EXPECT_EQ(code({.parts = {SizeMetric{"sqrt(x - 0.5)"}}}), ErrorCode::kExpressionValue);
  EXPECT_EQ(code({}), ErrorCode::kEmpty);
  EXPECT_EQ(*session->functions(), kPoint);
  ASSERT_TRUE(session->Step({}).ok());
  const MeshDiff diff = session->Commit();
  EXPECT_TRUE(diff.empty());
  EXPECT_EQ(diff.summary.state_hash, hash);
}

TEST(TensorFunctions, NeedARevision) {
  const MetricSpec spec{.source = SizeMetric{"0.1"}, .gradation = kNoLimits.gradation};
  const auto session = Remesher::Create(testing::GridData(8, 8), spec, {});
  ASSERT_TRUE(session.ok());
  const Status status = (*session)->SetTensors({}, Slanted(**session), kNoLimits, kPoint);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kRevisionNotFound);
}

TEST(TensorFunctions, ThatAreCancelledLeaveThoseOfBefore) {
  const auto session = UniformSession();
  ASSERT_TRUE(session->SetTensors({}, Slanted(*session), kNoLimits, kPoint).ok());
  HashAtRest(*session);
  const StopFlag stop(true);
  session->ListenTo(&stop);
  FunctionsSpec later = kPoint;
  later.time = 0.2;
  EXPECT_EQ(session->SetFunctions(later, kNoLimits).error().code, ErrorCode::kCancelled);
  EXPECT_EQ(session->SetTensors({}, Various(*session)).error().code, ErrorCode::kCancelled);
  EXPECT_EQ(session->SetTensors({}, Various(*session), kGradedByHalf, kPoint).error().code,
            ErrorCode::kCancelled);
  session->ListenTo(nullptr);
  EXPECT_EQ(*session->functions(), kPoint);
  EXPECT_EQ(session->limits(), kNoLimits);
  ASSERT_TRUE(session->Step({}).ok());
  EXPECT_TRUE(session->Commit().empty());
}

}  // namespace
}  // namespace pliant
