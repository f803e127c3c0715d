// The client library against a real pliantd, and against the same calls on the core in this
// process.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <string>

#include "client/cpp/client.h"
#include "core/motion/replace_domain.h"
#include "core/pliant/displace.h"
#include "core/pliant/remesher.h"
#include "tests/client/live/inputs.h"
#include "tests/client/live/pliantd_process.h"

namespace pliant::client {
namespace {

/// A plate with a square hole and an internal line: boundary, constraint and tags are all there.
Domain Plate() {
  return {.points = {{0, 0},
                     {2, 0},
                     {2, 1},
                     {0, 1},
                     {0.4, 0.4},
                     {0.6, 0.4},
                     {0.6, 0.6},
                     {0.4, 0.6},
                     {1, 0.25},
                     {1, 0.75}},
          .segments = {{0, 1, 1},
                       {1, 2, 2},
                       {2, 3, 3},
                       {3, 0, 4},
                       {4, 5, 5},
                       {5, 6, 5},
                       {6, 7, 5},
                       {7, 4, 5},
                       {8, 9, 6}},
          .holes = {{0.5, 0.5}},
          .regions = {{{1.5, 0.5}, 9}}};
}

class LiveServer : public testing::Test {
 protected:
  void SetUp() override {
    Result<Client> connected = Client::Connect(server_.address());
    ASSERT_TRUE(connected.ok()) << connected.error().message;
    client_ = std::make_unique<Client>(std::move(connected).value());
  }
  std::unique_ptr<Session> Create(const Start& start, const MetricSpec& metric,
                                  const SessionSettings& settings = {}) {
    Result<std::unique_ptr<Session>> session = client_->CreateSession(start, metric, settings);
    EXPECT_TRUE(session.ok()) << session.error().message;
    return std::move(session).value();
  }

  PliantdProcess server_;
  std::unique_ptr<Client> client_;
};

/// A session, and a remesher in this process that is told the same.
struct Twins {
  std::unique_ptr<Session> session;
  std::unique_ptr<Remesher> remesher;
  MeshReplica local;

  void Advance(const AdvanceOptions& options = {}) {
    const Result<AdvanceReport> report = session->Advance(options);
    ASSERT_TRUE(report.ok()) << report.error().message;
    Budget budget;
    if (options.visits_max) budget.visits_max = *options.visits_max;
    const Result<Progress> progress = remesher->Step(budget);
    ASSERT_TRUE(progress.ok()) << progress.error().message;
    ASSERT_TRUE(local.Apply(remesher->Commit()).ok());
    EXPECT_EQ(report->visits, progress->counts.visits);
    EXPECT_EQ(report->active_count, progress->active_count);
    ASSERT_NO_FATAL_FAILURE(ExpectAllSame());
  }
  /// The promise: the mirror is what GetMesh returns, and what the core makes here, bit for bit.
  void ExpectAllSame() {
    const Result<MeshReplica> downloaded = session->GetMesh();
    ASSERT_TRUE(downloaded.ok()) << downloaded.error().message;
    ASSERT_TRUE(SameMesh(session->replica(), *downloaded))
        << "Complete: the mirror differs from GetMesh at revision "
        << static_cast<std::int64_t>(downloaded->revision());
    ASSERT_TRUE(SameMesh(session->replica(), local))
        << "Deterministic: the server's mesh differs from the local one at revision "
        << static_cast<std::int64_t>(local.revision());
  }
};

TEST_F(LiveServer, TheMirrorIsTheServersMeshAtEveryRevision) {
  Twins twins{
      Create(Plate(), Size("0.05")), Remesher::Create(Plate(), Size("0.05"), {}).value(), {}};
  ASSERT_NO_FATAL_FAILURE(twins.Advance());
  for (const char* formula : {"0.02+0.2*abs(x-0.8)", "0.02+0.2*abs(x-0.9)", "0.01+0.1*hypot(x,y)",
                              "0.01+0.1*hypot(x,y)", "0.2"}) {
    SCOPED_TRACE(formula);
    ASSERT_TRUE(twins.session->UpdateMetric(Size(formula)).ok());
    ASSERT_TRUE(twins.remesher->SetMetric(Size(formula)).ok());
    ASSERT_NO_FATAL_FAILURE(twins.Advance());
  }
  EXPECT_EQ(twins.session->replica().revision(), Revision{6});
}

// Goal: the same with large diffs in chunks, budgets that cut the loop, and random metrics.
// Replay: the seed is fixed; --gtest_filter=LiveServer.TheMirrorFollowsRandomUpdates
TEST_F(LiveServer, TheMirrorFollowsRandomUpdates) {
  std::mt19937_64 rng(/*seed=*/20261122);
  const auto number = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(rng);
  };
  MetricSpec first = Size("0.012");
  first.gradation.gradation = 1.5;
  Twins twins{Create(Plate(), first), Remesher::Create(Plate(), first, {}).value(), {}};
  ASSERT_NO_FATAL_FAILURE(twins.Advance());
  ASSERT_GT(twins.local.summary().vertex_count, 5000) << "must need chunks to test them";
  for (int round = 0; round < 8; ++round) {
    SCOPED_TRACE(testing::Message() << "round " << round);
    if (round % 2 == 0) {
      MetricSpec spec = first;
      spec.source = SizeMetric{std::to_string(number(0.01, 0.05)) + "+0.1*abs(y-" +
                               std::to_string(number(0, 1)) + ")"};
      ASSERT_TRUE(twins.session->UpdateMetric(spec).ok());
      ASSERT_TRUE(twins.remesher->SetMetric(spec).ok());
    } else {
      std::vector<VertexId> vertices;
      std::vector<Metric> tensors;
      for (const VertexId id : twins.local.Compact().vertex_ids) {
        if (twins.local.positions()[id.index()].x > number(0, 4)) {
          vertices.push_back(id);
          tensors.push_back(Metric::Isotropic(number(0.02, 0.04)));
        }
      }
      const MetricLimits limits{.gradation = {.gradation = number(1.3, 2)}};
      FunctionsSpec beside{.parts = {SizeMetric{"0.03+0.2*abs(x-t)"}}, .time = 0.1 * round};
      ASSERT_TRUE(twins.session->UpdateTensors(vertices, tensors, beside, limits).ok());
      ASSERT_TRUE(twins.remesher->SetTensors(vertices, tensors, limits, beside).ok());
      beside.time *= 2;
      ASSERT_TRUE(twins.session->UpdateFunctions(beside, limits).ok());
      ASSERT_TRUE(twins.remesher->SetFunctions(beside, limits).ok());
      const MetricLimits later{.bounds = {.size_min = number(0.02, 0.03)}};
      ASSERT_TRUE(twins.session->UpdateLimits(later).ok());
      ASSERT_TRUE(twins.remesher->SetLimits(later).ok());
    }
    AdvanceOptions options;
    if (round % 3 == 1) options.visits_max = 777;
    ASSERT_NO_FATAL_FAILURE(twins.Advance(options));
  }
}

TEST_F(LiveServer, AnImportedMeshFollowsTensorsAtItsOwnPoints) {
  const auto session = Create(Plate(), Size("0.1"));
  ASSERT_TRUE(session->Advance().ok());
  const MeshData mesh = session->replica().Compact().mesh;
  std::vector<Metric> tensors;
  for (const Vec2 p : mesh.points) tensors.push_back(Metric::Isotropic(0.03 + 0.1 * p.x));
  MetricSpec spec;
  spec.source = BackgroundMetric{mesh, tensors};
  Twins twins{Create(mesh, spec), Remesher::Create(mesh, spec, {}).value(), {}};
  ASSERT_NO_FATAL_FAILURE(twins.Advance());
  EXPECT_GT(twins.local.summary().vertex_count, static_cast<int>(mesh.points.size()));
}

TEST_F(LiveServer, MetricsComeWithTheMeshIfAskedFor) {
  SessionSettings settings;
  settings.parts = Parts::kMeshAndMetric;
  const auto session = Create(Plate(), Size("0.1+0.1*x"), settings);
  ASSERT_TRUE(session->Advance().ok());
  ASSERT_TRUE(session->UpdateMetric(Size("0.1")).ok());
  ASSERT_TRUE(session->Advance().ok());
  const CompactMesh compact = session->replica().Compact();
  ASSERT_EQ(compact.metrics.size(), compact.mesh.points.size());
  for (const Metric& metric : compact.metrics) {
    EXPECT_NEAR(metric.m11, 100, 100 * 0.06) << "up to Options::metric_tolerance";
  }
  const auto downloaded = client_->GetMesh(session->id(), Parts::kMeshAndMetric);
  ASSERT_TRUE(downloaded.ok());
  EXPECT_EQ(downloaded->Compact().metrics, compact.metrics);
}

// Goal: a refusal says on this side exactly what the core says.
TEST_F(LiveServer, RefusalsKeepTheirCodeFieldAndIndex) {
  Domain crossing = Plate();
  crossing.segments[8] = {8, 2, 6};
  crossing.points[2] = {0.2, 0.2};
  const auto expected = Remesher::Create(crossing, Size("0.1"), {});
  ASSERT_FALSE(expected.ok());
  const auto refused = client_->CreateSession(crossing, Size("0.1"));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, expected.error().code);
  EXPECT_EQ(refused.error().field, expected.error().field);
  EXPECT_EQ(refused.error().index, expected.error().index);
  EXPECT_EQ(refused.error().other_index, expected.error().other_index);

  const auto syntax = client_->CreateSession(Plate(), Size("0.1 +"));
  ASSERT_FALSE(syntax.ok());
  EXPECT_EQ(syntax.error().code, ErrorCode::kExpressionSyntax);
  EXPECT_TRUE(client_->ListSessions()->empty()) << "a refused session leaves nothing behind";
}

TEST_F(LiveServer, ARefusedUpdateLeavesTheMeshAndHalfAStepIsNotCommitted) {
  const auto session = Create(Plate(), Size("0.1"));
  ASSERT_TRUE(session->Advance().ok());
  const MeshReplica before = session->replica();
  std::vector<Metric> tensors(before.Compact().vertex_ids.size(), Metric::Isotropic(0.1));
  tensors[17].m12 = std::numeric_limits<double>::quiet_NaN();
  const Status refused = session->UpdateTensors({}, tensors);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kNotFinite);
  EXPECT_EQ(refused.error().index, 17);

  const auto half = session->Advance();
  ASSERT_FALSE(half.ok());
  EXPECT_EQ(half.error().code, ErrorCode::kUpdateRejected);
  EXPECT_TRUE(SameMesh(session->replica(), before));
  EXPECT_TRUE(session->Advance().ok()) << "the refusal has emptied the stage";

  EXPECT_FALSE(session->UpdateTensors({}, tensors).ok());
  ASSERT_TRUE(session->Discard().ok());
  EXPECT_TRUE(session->Advance().ok()) << "so does Discard";
}

TEST_F(LiveServer, ASessionHasOneEditorAndAnyNumberOfReaders) {
  auto first = Create(Plate(), Size("0.1"));
  ASSERT_TRUE(first->Advance().ok());
  const auto second = client_->OpenSession(first->id());
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kSessionBusy);
  EXPECT_TRUE(SameMesh(*client_->GetMesh(first->id()), first->replica()));

  const MeshReplica last = first->replica();
  const std::string id = first->id();
  first.reset();
  const auto third = client_->OpenSession(id);
  ASSERT_TRUE(third.ok()) << third.error().message;
  EXPECT_TRUE(SameMesh((*third)->replica(), last)) << "it starts with a snapshot";
}

// Goal: who follows a part has what a filter of the whole replica gives, at every revision.
TEST_F(LiveServer, ASubscriptionCanFollowAPart) {
  Domain domain = Plate();  // Cut in two by a line at x = 1; the left part has no seed: region 0.
  domain.points[8] = {1, 0};
  domain.points[9] = {1, 1};
  domain.segments = {{0, 8, 1}, {8, 1, 1}, {1, 2, 2}, {2, 9, 3}, {9, 3, 3}, {3, 0, 4},
                     {4, 5, 5}, {5, 6, 5}, {6, 7, 5}, {7, 4, 5}, {8, 9, 6}};
  const auto session = Create(domain, Size("0.1"));
  const auto right = client_->Subscribe(session->id(), {.region_tags = {9}});
  const auto points = client_->Subscribe(session->id(), {.follow = Follow::kVertices});
  for (const char* size : {"0.1", "0.03 + 0.1*abs(x - 1)", "0.2"}) {
    ASSERT_TRUE(session->UpdateMetric(Size(size)).ok());
    ASSERT_TRUE(session->Advance().ok());
    const MeshReplica& whole = session->replica();
    for (const auto& subscription : {right.get(), points.get()}) {
      while (subscription->replica().revision() < whole.revision()) {
        const Result<MeshDiff> diff = subscription->Next();
        ASSERT_TRUE(diff.ok()) << diff.error().message;
      }
    }
    std::int32_t triangle_count = 0;
    for (std::size_t t = 0; t < whole.triangles().size(); ++t) {
      const TriangleId id = TriangleId::FromIndex(t);
      const bool wanted = whole.IsLive(id) && whole.triangle_regions()[t] == 9;
      ASSERT_EQ(right->replica().IsLive(id), wanted);
      if (!wanted) continue;
      ASSERT_EQ(right->replica().triangles()[t], whole.triangles()[t]);
      ++triangle_count;
    }
    EXPECT_EQ(right->replica().summary().triangle_count, triangle_count);
    EXPECT_LT(triangle_count, whole.summary().triangle_count);
    EXPECT_EQ(points->replica().summary().vertex_count, whole.summary().vertex_count);
    EXPECT_EQ(points->replica().summary().triangle_count, 0);
  }
}

TEST_F(LiveServer, ReopenGoesOnWhereTheReplicaIs) {
  const auto session = Create(Plate(), Size("0.1"));
  ASSERT_TRUE(session->Advance().ok());
  ASSERT_TRUE(session->Reopen().ok());
  ASSERT_TRUE(session->UpdateMetric(Size("0.05")).ok());
  ASSERT_TRUE(session->Advance().ok());
  EXPECT_TRUE(SameMesh(session->replica(), *session->GetMesh()));
  ASSERT_TRUE(session->Resync().ok());
  EXPECT_TRUE(SameMesh(session->replica(), *session->GetMesh()));
}

TEST_F(LiveServer, RevisionsComeBackAndFork) {
  const auto session = Create(Plate(), Size("0.1"));
  ASSERT_TRUE(session->Advance().ok());
  const std::uint64_t first = session->replica().summary().state_hash;
  ASSERT_EQ(*session->SaveRevision(), Revision{1});
  ASSERT_TRUE(session->UpdateMetric(Size("0.05")).ok());
  ASSERT_TRUE(session->Advance().ok());
  const std::uint64_t second = session->replica().summary().state_hash;
  const auto fork_id = session->Fork(Revision{1});
  ASSERT_TRUE(fork_id.ok()) << fork_id.error().message;
  const auto back = session->Rollback(Revision{1});
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->revision, Revision{3});
  EXPECT_EQ(session->replica().summary().state_hash, first);
  auto fork = client_->OpenSession(*fork_id);
  ASSERT_TRUE(fork.ok()) << fork.error().message;
  ASSERT_TRUE((*fork)->UpdateMetric(Size("0.05")).ok());
  ASSERT_TRUE((*fork)->Advance().ok());
  EXPECT_EQ((*fork)->replica().summary().state_hash, second);
  const std::array saved{Revision{1}};
  EXPECT_TRUE(session->Release(saved).ok());
  EXPECT_EQ(session->Release(saved).error().code, ErrorCode::kRevisionNotFound);
  EXPECT_EQ(session->Rollback(Revision{77}).error().code, ErrorCode::kRevisionNotFound);
}

TEST_F(LiveServer, WhatIsFrozenStaysWhileTheBoundaryMoves) {
  const auto session = Create(Plate(), Size("0.1"));
  ASSERT_TRUE(session->Advance().ok());
  const VertexId corner(0);
  const Vec2 place = session->replica().positions()[corner.index()];
  ASSERT_TRUE(session->Freeze({.vertices = {corner}, .permissions = {.swap = false}}).ok());
  MotionRequest motion;
  motion.tags.push_back({{5}, Translation{{0.02, 0}}});
  ASSERT_TRUE(session->MoveBoundary(motion).ok());
  const auto report = session->Advance();
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(session->replica().positions()[corner.index()], place);
  const Vec2 elsewhere{place.x - 0.01, place.y};
  const Status refused = session->MoveNodes({&corner, 1}, {&elsewhere, 1});
  EXPECT_EQ(refused.error().code, ErrorCode::kFrozen);
  EXPECT_EQ(refused.error().field + std::to_string(refused.error().index), "vertices0");
  ASSERT_TRUE(session->Discard().ok());
  ASSERT_TRUE(session->Freeze({}).ok());
  ASSERT_TRUE(session->MoveNodes({&corner, 1}, {&elsewhere, 1}).ok());
  Options options;
  options.metric_tolerance = 0.5;
  ASSERT_TRUE(session->SetOptions(options).ok());
  ASSERT_TRUE(session->Advance().ok());
  EXPECT_EQ(session->replica().positions()[corner.index()], elsewhere);
}

// Goal: the mirror of a client has the bits of the same session in process, whatever domain comes
// next and whatever is displaced.
TEST_F(LiveServer, DomainsAndDisplacementsGiveTheBitsOfTheCore) {
  const auto session = Create(Plate(), Size("0.06"));
  auto local = Remesher::Create(Plate(), Size("0.06"), {});
  ASSERT_TRUE(local.ok());
  const auto advance = [&] {
    const auto report = session->Advance();
    ASSERT_TRUE(report.ok()) << report.error().message;
    ASSERT_TRUE((*local)->Step({}).ok());
    const MeshDiff diff = (*local)->Commit();
    EXPECT_EQ(session->replica().summary(), diff.summary);
  };
  advance();
  Domain domain = Plate();
  const auto first = static_cast<std::int32_t>(domain.points.size());
  const Vec2 corner = domain.points[0];
  for (const Vec2 p : {Vec2{0.1, 0.1}, Vec2{0.2, 0.12}, Vec2{0.12, 0.2}}) {
    domain.points.push_back(corner + p);
  }
  for (std::int32_t i = 0; i < 3; ++i) {
    domain.segments.push_back({first + i, first + (i + 1) % 3, 77});
  }
  domain.holes.push_back(corner + Vec2{0.14, 0.14});
  for (const Domain& next : {domain, Plate()}) {
    ASSERT_TRUE(session->ReplaceDomain(next).ok());
    ASSERT_TRUE(ReplaceDomain(**local, next).ok());
    advance();
  }
  std::vector<VertexId> vertices;
  const Mesh& mesh = (*local)->mesh();
  for (std::int32_t i = 0; i < mesh.vertex_slots(); i += 2) {
    if (mesh.vertex(VertexId(i)).live) vertices.emplace_back(i);
  }
  const std::vector<Vec2> by(vertices.size(), Vec2{0.01, 0.005});
  ASSERT_TRUE(session->Displace(vertices, by).ok());
  DisplaceVertices displacement(vertices, by);
  ASSERT_TRUE((*local)->Apply(displacement).ok());
  EXPECT_GT(displacement.displaced_count(), 0);
  advance();
  Domain crossing = Plate();
  crossing.segments.push_back({0, 2, 1});
  crossing.segments.push_back({1, 3, 1});
  EXPECT_EQ(session->ReplaceDomain(crossing).error().code,
            ReplaceDomain(**local, crossing).error().code);
}

TEST_F(LiveServer, FieldsAndTransferRowsComeWithTheDiff) {
  SessionSettings settings;
  settings.parts = Parts::kEverything;
  const auto session = Create(Plate(), Size("0.1"), settings);
  ASSERT_TRUE(session->Advance().ok());
  const auto count = static_cast<std::size_t>(session->replica().summary().vertex_count);
  FieldUpdate update;
  update.values.push_back({.name = "u", .values = std::vector<double>(count, 2.5)});
  ASSERT_TRUE(session->SetFields(update).ok());
  ASSERT_TRUE(session->UpdateMetric(Size("0.07")).ok());
  ASSERT_TRUE(session->Advance().ok());
  const MeshDiff& change = session->last_change();
  ASSERT_EQ(change.fields.changed.size(), 1U);
  EXPECT_EQ(change.fields.changed[0].name, "u");
  for (const double value : change.fields.changed[0].rows.values) EXPECT_EQ(value, 2.5);
  ASSERT_TRUE(change.transfer.has_value());
  EXPECT_EQ(change.transfer->vertex_ids, change.vertex_ids);
  ASSERT_TRUE(session->SetFields({.dropped_names = {"u"}}).ok());
  ASSERT_TRUE(session->Advance().ok());
  EXPECT_EQ(session->last_change().fields.dropped_names, std::vector<std::string>{"u"});
}

TEST_F(LiveServer, CancelEndsAnAdvanceWithAValidRevision) {
  const auto session = Create(Plate(), Size("0.0015"));
  AdvanceOptions options;
  options.progress_interval = std::chrono::milliseconds(10);
  std::int64_t visits = 0;
  const auto report = session->Advance(options, [&](const AdvanceProgress& progress) {
    visits = progress.visits;
    session->Cancel();
  });
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->stop, AdvanceStop::kCancelled);
  EXPECT_GT(visits, 0);
  EXPECT_GT(report->active_count, 0);
  EXPECT_TRUE(SameMesh(session->replica(), *session->GetMesh()));
}

// Goal: a callback that changes its own session is told so, and the advance goes on as it was.
TEST_F(LiveServer, CallbacksLookAndCancelAndDoNothingElse) {
  const auto session = Create(Plate(), Size("0.002"));
  AdvanceOptions options;
  options.progress_interval = std::chrono::milliseconds(10);
  std::set<ErrorCode> codes;
  int seen_count = 0;
  const auto meddle = [&] {
    for (const Status& status :
         {session->UpdateMetric(Size("0.1")), session->Discard(), session->Reopen(),
          session->Resync(), Status(session->Advance().error())}) {
      codes.insert(status.ok() ? ErrorCode::kInternal : status.error().code);
    }
    ++seen_count;
    session->Cancel();
  };
  const auto report = session->Advance(
      options, [&](const AdvanceProgress&) { meddle(); }, [&](const MeshDiff&) { meddle(); });
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_GE(seen_count, 2);
  EXPECT_EQ(codes, std::set{ErrorCode::kProtocolOrder});
  EXPECT_EQ(report->stop, AdvanceStop::kCancelled);
  ASSERT_TRUE(session->UpdateMetric(Size("0.1")).ok());
  ASSERT_TRUE(session->Advance().ok());
  EXPECT_TRUE(SameMesh(session->replica(), *session->GetMesh()));
}

TEST_F(LiveServer, QualityIsWhatTheCoreMeasuresHere) {
  const auto session = Create(Plate(), Size("0.05+0.1*x"));
  ASSERT_TRUE(session->Advance().ok());
  auto remesher = Remesher::Create(Plate(), Size("0.05+0.1*x"), {}).value();
  ASSERT_TRUE(remesher->Step({}).ok());
  static_cast<void>(remesher->Commit());
  const Quality local = MeasureQuality(remesher->mesh(), remesher->field());
  const Result<Quality> remote = session->GetQuality();
  ASSERT_TRUE(remote.ok()) << remote.error().message;
  EXPECT_EQ(remote->q_mean, local.q_mean);
  EXPECT_EQ(remote->q_min, local.q_min);
  EXPECT_EQ(remote->edge_count, local.edge_count);
  EXPECT_EQ(remote->integrated.mean, local.integrated.mean);
  EXPECT_EQ(remote->averaged.share_sqrt2, local.averaged.share_sqrt2);
  EXPECT_EQ(remote->angles, local.angles);
  EXPECT_EQ(remote->lengths, local.lengths);
  EXPECT_EQ(remote->complexity, local.complexity);
}

TEST_F(LiveServer, SessionsAreListedAndDeleted) {
  SessionSettings settings;
  settings.session_id = "plate";
  settings.labels["case"] = "live";
  const auto session = Create(Plate(), Size("0.1"), settings);
  EXPECT_EQ(client_->CreateSession(Plate(), Size("0.1"), settings).error().code,
            ErrorCode::kSessionExists);
  ASSERT_TRUE(session->Advance().ok());
  const auto sessions = client_->ListSessions();
  ASSERT_TRUE(sessions.ok());
  ASSERT_EQ(sessions->size(), 1U);
  EXPECT_EQ((*sessions)[0].session_id, "plate");
  EXPECT_EQ((*sessions)[0].labels.at("case"), "live");
  EXPECT_EQ((*sessions)[0].summary, session->replica().summary());
  EXPECT_EQ(*client_->DeleteSession("plate"), Revision{1});
  EXPECT_EQ(client_->GetSession("plate").error().code, ErrorCode::kSessionNotFound);
  EXPECT_FALSE(session->Advance().ok());
}

}  // namespace
}  // namespace pliant::client
