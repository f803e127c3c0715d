#include "core/pliant/displace_tensors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/mesh/export_mesh.h"
#include "core/pliant/displace.h"
#include "core/pliant/frozen.h"
#include "core/pliant/remesher.h"
#include "core/pliant/slide.h"
#include "tests/support/cases.h"
#include "tests/support/loop_mesh.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Faults;

/// What RelativeChange makes of rounding: it has a square root.
constexpr double kExact = 1e-7;

/// Isotropic, its logarithm linear in place: exact wherever it is interpolated.
Metric Smooth(Vec2 p) { return Metric::Isotropic(0.05 * std::exp(0.7 * p.x)); }
Metric SmoothInBoth(Vec2 p) { return Metric::Isotropic(0.05 * std::exp(0.7 * p.x - 0.4 * p.y)); }

/// What a client sends: some vertices go along, and all, or some, have a tensor of where they go.
struct SentAhead {
  std::vector<VertexId> displaced;
  std::vector<Vec2> by;
  std::vector<VertexId> vertices;  ///< Empty: all.
  std::vector<Metric> tensors;

  [[nodiscard]] TensorsAhead request() const {
    return {.displaced = displaced, .by = by, .vertices = vertices, .tensors = tensors};
  }
};

SentAhead SendAhead(const Mesh& mesh, Vec2 by, const std::function<bool(Vec2)>& moves,
                    const std::function<Metric(Vec2)>& field) {
  SentAhead sent;
  for (const VertexId vertex : testing::LiveVertices(mesh)) {
    const Vec2 p = mesh.position(vertex);
    const bool goes = moves(p);
    if (goes) sent.displaced.push_back(vertex);
    sent.tensors.push_back(field(goes ? p + by : p));
  }
  sent.by.assign(sent.displaced.size(), by);
  return sent;
}

double WorstOf(const Mesh& mesh, const DisplaceWithTensors& change,
               const std::function<Metric(Vec2)>& field) {
  double worst = 0;
  for (std::size_t i = 0; i < change.vertices().size(); ++i) {
    const Metric expected = field(mesh.position(change.vertices()[i]));
    worst = std::max(worst, RelativeChange(expected, change.tensors()[i]));
  }
  return worst;
}

bool IsInStrip(Vec2 p) { return p.x > 0.2 && p.x < 0.6; }

// Goal: whoever has come to his place has the tensor that was sent for it, and everybody else what
// the tensors are where he is: on walls that slide or must stay, frozen, or new in the gap. Method:
// a field that is exact between the places; strips of a square of 300 vertices with walls.
TEST(DisplaceWithTensors, HasTheTensorOfWhereEverybodyIs) {
  for (const bool freezes : {false, true}) {
    for (const Vec2 by : {Vec2{0.15, 0}, Vec2{-0.1, 0.01}, Vec2{0.04, 0.03}}) {
      SCOPED_TRACE(::testing::Message() << by.x << " " << by.y << " frozen " << freezes);
      auto square = testing::LoopMesh(testing::DiscCase(300, testing::DiscState::kOff));
      const Mesh& mesh = square->mesh;
      Constraints constraints;
      for (const VertexId vertex : testing::LiveVertices(mesh)) {
        const Vec2 p = mesh.position(vertex);
        if (freezes && std::fabs(p.x - 0.4) < 0.05 && std::fabs(p.y - 0.5) < 0.05)
          constraints.vertices.push_back(vertex);
      }
      (void)ChangeFrozen(square->edit, {}, WhatFreezes(mesh, constraints).value());
      const SentAhead sent = SendAhead(mesh, by, IsInStrip, Smooth);
      DisplaceWithTensors change(sent.request());
      const auto outcome = change.Apply(square->edit);
      ASSERT_TRUE(outcome.ok()) << outcome.error().message;
      EXPECT_EQ(Faults(mesh), "");
      EXPECT_EQ(std::vector(change.vertices().begin(), change.vertices().end()),
                testing::LiveVertices(mesh));
      EXPECT_LT(WorstOf(mesh, change, Smooth), 0.02);
      for (std::size_t i = 0; i < change.vertices().size(); ++i) {
        const VertexId vertex = change.vertices()[i];
        const Vec2 p = mesh.position(vertex);
        if (mesh.vertex(vertex).edge.valid()) continue;  // May lie beside the places.
        EXPECT_LT(RelativeChange(Smooth(p), change.tensors()[i]), kExact) << p.x << " " << p.y;
      }
    }
  }
}

// Goal: the corners of a domain that the displacement leaves behind have the nearest place's
// tensor, and those that it would push out nothing strange.
TEST(DisplaceWithTensors, TakesTheNearestPlaceBehindADisplacement) {
  auto square = testing::LoopMesh(testing::DiscCase(300, testing::DiscState::kOff));
  const SentAhead sent = SendAhead(
      square->mesh, {0.1, 0}, [](Vec2) { return true; }, Smooth);
  DisplaceWithTensors change(sent.request());
  ASSERT_TRUE(change.Apply(square->edit).ok());
  for (std::size_t i = 0; i < change.vertices().size(); ++i) {
    const Vec2 p = square->mesh.position(change.vertices()[i]);
    const Metric expected = Smooth({std::max(p.x, 0.1), p.y});
    // New ones are between them and who has gone.
    EXPECT_LT(RelativeChange(expected, change.tensors()[i]), 0.08) << p.x << " " << p.y;
  }
}

// Goal: a displacement that is blocked leaves everybody where he was, with what the tensors are
// there, not with that of the place that he did not come to.
TEST(DisplaceWithTensors, ServesThoseWhoseWayIsBlocked) {
  auto square = testing::LoopMesh(testing::DiscCase(300, testing::DiscState::kOff));
  const Mesh& mesh = square->mesh;
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    const TriangleId id(t);
    if (!mesh.triangle(id).live) continue;
    const bool is_ahead = std::ranges::any_of(mesh.triangle(id).vertices, [&](VertexId v) {
      return std::fabs(mesh.position(v).x - 0.72) < 0.03;
    });
    if (is_ahead) square->edit.SetHold(id, MeshEdit::Hold::kFrozen);
  }
  const auto same = testing::LoopMesh(testing::DiscCase(300, testing::DiscState::kOff));
  const auto in_middle = [](Vec2 p) { return IsInStrip(p) && p.y > 0.2 && p.y < 0.8; };
  const SentAhead sent = SendAhead(mesh, {0.2, 0.05}, in_middle, SmoothInBoth);
  DisplaceWithTensors change(sent.request());
  ASSERT_TRUE(change.Apply(square->edit).ok());
  for (const VertexId vertex : testing::LiveVertices(same->mesh)) {
    ASSERT_EQ(mesh.position(vertex), same->mesh.position(vertex));
  }
  EXPECT_LT(WorstOf(mesh, change, SmoothInBoth), kExact);
}

// Goal: random displacements, given vertices and walls among them, leave nobody without a tensor.
TEST(DisplaceWithTensors, ServesEverybodyWhateverIsAsked) {
  const std::uint64_t seed = 7;
  Rng rng(seed);
  for (int trial = 0; trial < 100; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << " trial " << trial);
    auto grid = testing::ImportedMesh(testing::GridData(12, 12));
    const double reach = trial % 2 == 0 ? 0.6 : 3;
    SentAhead sent;
    std::vector<double> least_and_most;
    for (const VertexId vertex : testing::LiveVertices(grid->mesh)) {
      grid->edit.SetMetric(vertex, Metric::Isotropic(1));
      if (rng.Below(3) != 0) {
        sent.displaced.push_back(vertex);
        sent.by.push_back({rng.Uniform(-reach, reach), rng.Uniform(-reach, reach)});
      }
      if (trial % 3 == 0 && rng.Below(2) == 0) continue;
      if (trial % 3 == 0) sent.vertices.push_back(vertex);
      sent.tensors.push_back(Metric::Isotropic(rng.Uniform(1, 2)));
    }
    DisplaceWithTensors change(sent.request());
    ASSERT_TRUE(change.Apply(grid->edit).ok());
    ASSERT_EQ(Faults(grid->mesh), "");
    std::vector<VertexId> given(change.vertices().begin(), change.vertices().end());
    if (sent.vertices.empty()) {
      ASSERT_EQ(given, testing::LiveVertices(grid->mesh));
    }
    std::ranges::sort(given);
    ASSERT_EQ(std::ranges::adjacent_find(given), given.end());
    for (std::size_t i = 0; i < given.size(); ++i) {
      ASSERT_TRUE(grid->mesh.IsLive(given[i]));
      const double size = 1 / std::sqrt(change.tensors()[i].m11);
      ASSERT_TRUE(size > 1 - 1e-9 && size < 2 + 1e-9) << size;
    }
  }
}

// Goal: tensors of some vertices leave the others with what they have.
TEST(DisplaceWithTensors, KeepsWhatIsNotSent) {
  auto square = testing::LoopMesh(testing::DiscCase(300, testing::DiscState::kOff));
  const Mesh& mesh = square->mesh;
  SentAhead sent = SendAhead(mesh, {0.15, 0}, IsInStrip, Smooth);
  sent.vertices = sent.displaced;
  sent.tensors.clear();
  std::vector<Vec2> places;
  for (const VertexId vertex : sent.vertices) {
    places.push_back(mesh.position(vertex) + Vec2{0.15, 0});
    sent.tensors.push_back(Smooth(places.back()));
  }
  DisplaceWithTensors change(sent.request());
  const auto outcome = change.Apply(square->edit);
  ASSERT_TRUE(outcome.ok());
  EXPECT_GT(change.vertices().size(), sent.vertices.size() / 2);
  const auto arrived = [&](VertexId vertex) {
    // A new vertex may have the slot of one that is gone.
    const auto row = std::ranges::lower_bound(sent.vertices, vertex);
    return row != sent.vertices.end() && *row == vertex &&
           mesh.position(vertex) == places[static_cast<std::size_t>(row - sent.vertices.begin())];
  };
  std::size_t new_count = 0;
  for (std::size_t i = 0; i < change.vertices().size(); ++i) {
    const VertexId vertex = change.vertices()[i];
    ASSERT_TRUE(mesh.IsLive(vertex));
    if (arrived(vertex)) {
      EXPECT_LT(RelativeChange(Smooth(mesh.position(vertex)), change.tensors()[i]), kExact);
    } else {
      ++new_count;
    }
  }
  EXPECT_GT(new_count, 0U) << "new vertices beside the strip";
  EXPECT_LE(new_count, outcome->carriers.size());
}

TEST(DisplaceWithTensors, RefusesWhatItCannotReadBeforeAnybodyMoves) {
  auto square = testing::LoopMesh(testing::DiscCase(300, testing::DiscState::kOff));
  const auto same = testing::LoopMesh(testing::DiscCase(300, testing::DiscState::kOff));
  const SentAhead good = SendAhead(square->mesh, {0.1, 0}, IsInStrip, Smooth);
  const auto error = [&](const std::function<void(SentAhead&)>& spoil) {
    SentAhead bad = good;
    spoil(bad);
    const auto outcome = DisplaceWithTensors(bad.request()).Apply(square->edit);
    EXPECT_FALSE(outcome.ok());
    EXPECT_EQ(testing::DifferenceOf(square->mesh, same->mesh), "");
    return outcome.ok() ? Error{} : outcome.error();
  };
  EXPECT_EQ(error([](SentAhead& s) { s.tensors.pop_back(); }).code, ErrorCode::kArrayLength);
  const Error indefinite = error([](SentAhead& s) { s.tensors[3] = {1, 2, 1}; });
  EXPECT_EQ(indefinite.code, ErrorCode::kNotPositiveDefinite);
  EXPECT_EQ(indefinite.index, 3);
  EXPECT_EQ(indefinite.field, "metric.tensors");
  const Error twice = error([](SentAhead& s) { s.displaced[1] = s.displaced[0]; });
  EXPECT_EQ(twice.code, ErrorCode::kDuplicateId);
  EXPECT_EQ(twice.field, "metric.displacements");
  const Error dead = error([](SentAhead& s) {
    s.vertices = {VertexId(99'999)};
    s.tensors.resize(1);
  });
  EXPECT_EQ(dead.code, ErrorCode::kIndexOutOfRange);
  EXPECT_EQ(dead.field, "metric.vertex_ids");
}

/// A session at rest for a front at 0.4, and what is sent when that has moved to 0.42.
struct FrontUpdate {
  std::unique_ptr<Remesher> session;
  SentAhead sent;
  std::shared_ptr<MetricField> now;
};

FrontUpdate MakeFrontUpdate(double nodes) {
  testing::Case shock = testing::ShockCase(nodes, 0.4);
  FrontUpdate made{.session = Remesher::Create(shock.domain, std::move(shock.field), {}).value(),
                   .sent = {},
                   .now = testing::ShockCase(nodes, 0.42).field};
  EXPECT_TRUE(made.session->Step({}).ok());
  (void)made.session->Commit();
  const auto near = [](Vec2 p) {
    return std::fabs(p.x - (std::sqrt(0.25 + 0.25 * (p.y - 0.5) * (p.y - 0.5)) - 0.1)) < 0.15;
  };
  made.sent = SendAhead(made.session->mesh(), {0.02, 0}, near, [&](Vec2 p) {
    std::int32_t hint = MetricField::kNoHint;
    return made.now->At(p, hint);
  });
  return made;
}

// Goal: a client that knows both gets the front's mesh in one update, as good and as cheap as if it
// had seen where the displacement puts vertices and sent tensors for these.
TEST(SetTensorsAhead, CarriesAFrontInOneUpdate) {
  const FrontUpdate ahead = MakeFrontUpdate(3000);
  const FrontUpdate seen = MakeFrontUpdate(3000);
  const MetricLimits none{.gradation = {.automatic = false}};
  ASSERT_TRUE(SetTensorsAhead(*ahead.session, ahead.sent.request(), {none}).ok());
  DisplaceVertices displace(seen.sent.displaced, seen.sent.by);
  ASSERT_TRUE(seen.session->Apply(displace).ok());
  std::vector<Metric> tensors;
  std::int32_t hint = MetricField::kNoHint;
  for (const Vec2 p : ExportMesh(seen.session->mesh()).data.points) {
    tensors.push_back(seen.now->At(p, hint));
  }
  ASSERT_TRUE(seen.session->SetTensors({}, tensors, none).ok());
  const auto visits_of = [](Remesher& session) {
    const Result<Progress> progress = session.Step({});
    EXPECT_TRUE(progress.ok());
    (void)session.Commit();
    EXPECT_EQ(Faults(session.mesh()), "");
    return static_cast<double>(progress->counts.visits);
  };
  EXPECT_LT(visits_of(*ahead.session), 1.2 * visits_of(*seen.session));
  const Quality quality = MeasureQuality(ahead.session->mesh(), *ahead.now);
  EXPECT_GT(quality.q_mean, 0.98);
  EXPECT_GT(quality.q_min, 0.5);
}

// Goal: functions and limits hold beside the tensors, and are refused without a revision that
// would have a trace of it after a rollback.
TEST(SetTensorsAhead, TakesFunctionsAndLimits) {
  FrontUpdate made = MakeFrontUpdate(500);
  Remesher& session = *made.session;
  const std::uint64_t before = session.Snapshot().summary.state_hash;
  const MetricLimits limits{.gradation = {.gradation = 1.5}};
  const FunctionsSpec bad{.parts = {SizeMetric{"log(-1)"}}};
  EXPECT_FALSE(SetTensorsAhead(session, made.sent.request(), {limits, &bad}).ok());
  session.Rollback();
  EXPECT_EQ(session.Snapshot().summary.state_hash, before);
  const FunctionsSpec functions{.parts = {SizeMetric{"0.02 + 0.1*y"}}};
  ASSERT_TRUE(SetTensorsAhead(session, made.sent.request(), {limits, &functions}).ok());
  EXPECT_EQ(session.limits(), limits);
  ASSERT_NE(session.functions(), nullptr);
  ASSERT_TRUE(session.Step({}).ok());
  (void)session.Commit();
  EXPECT_EQ(Faults(session.mesh()), "");
}

}  // namespace
}  // namespace pliant
