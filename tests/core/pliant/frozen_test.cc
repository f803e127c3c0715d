#include "core/pliant/frozen.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/motion/move.h"
#include "core/pliant/remesher.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/random_domain.h"
#include "tests/support/seed.h"

namespace pliant {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::int64_t kVisitsMax = 2'000'000;

/// The unit square, halved by an internal line x = 0.5 of tag 9: region 1 left, region 2 right.
Domain TwoHalves() {
  Domain domain;
  domain.points = {{0, 0}, {0.5, 0}, {1, 0}, {1, 1}, {0.5, 1}, {0, 1}};
  domain.segments = {{0, 1, 1}, {1, 2, 1}, {2, 3, 2}, {3, 4, 3}, {4, 5, 3}, {5, 0, 4}, {1, 4, 9}};
  domain.regions = {{{0.25, 0.5}, 1}, {{0.75, 0.5}, 2}};
  return domain;
}

MetricSpec SizeOf(const std::string& size) { return {.source = SizeMetric{size}}; }

std::unique_ptr<Remesher> MeshOfTwoRooms(const std::string& size, const Options& options = {}) {
  auto made = Remesher::Create(TwoHalves(), SizeOf(size), options);
  EXPECT_TRUE(made.ok()) << made.error().message;
  EXPECT_TRUE((*made)->Step({}).ok());
  (void)(*made)->Commit();
  return std::move(*made);
}

void RunToTheEnd(Remesher& remesher) {
  const auto progress = remesher.Step({.visits_max = kVisitsMax});
  ASSERT_TRUE(progress.ok()) << progress.error().message;
  EXPECT_EQ(progress->active_count, 0);
}

/// The bits of what constraints name, found in the mesh by slot and by nothing of frozen.cc.
class Picture {
 public:
  Picture(const Mesh& mesh, const Constraints& constraints) : constraints_(constraints) {
    for (const VertexId id : constraints.vertices) AddVertex(mesh, id);
    for (const EdgeId id : constraints.edges) AddEdge(mesh, id);
    for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
      const TriangleRecord& triangle = mesh.triangle(TriangleId(t));
      if (!triangle.live) continue;
      for (const std::int32_t tag : constraints.regions) {
        if (triangle.region == tag) AddTriangle(mesh, t);
      }
    }
  }

  /// What differs in another mesh; empty if nothing does.
  [[nodiscard]] std::string DifferenceTo(const Mesh& mesh) const {
    for (const VertexId id : constraints_.vertices) {
      if (!mesh.IsLive(id)) return "vertex " + std::to_string(id.value()) + " is gone";
    }
    for (const EdgeId id : constraints_.edges) {
      if (!mesh.edge(id).live) return "edge " + std::to_string(id.value()) + " is gone";
    }
    const Picture other(mesh, constraints_);
    for (const auto& [name, words] : rows_) {
      const auto found = other.rows_.find(name);
      if (found == other.rows_.end()) return name + " is gone";
      if (found->second != words) return name + " has other bits";
    }
    return other.rows_.size() == rows_.size() ? "" : "there is more than before";
  }

 private:
  using Words = std::vector<std::uint64_t>;

  void AddVertex(const Mesh& mesh, VertexId id) {
    const Vec2 p = mesh.position(id);
    rows_["vertex " + std::to_string(id.value())] =
        Words{std::bit_cast<std::uint64_t>(p.x), std::bit_cast<std::uint64_t>(p.y)};
  }
  void AddEdge(const Mesh& mesh, EdgeId id) {
    const EdgeRecord& edge = mesh.edge(id);
    rows_["edge " + std::to_string(id.value())] = Words{
        edge.vertices[0].index(), edge.vertices[1].index(), static_cast<std::uint64_t>(edge.tag)};
    for (const VertexId end : edge.vertices) AddVertex(mesh, end);
  }
  void AddTriangle(const Mesh& mesh, std::int32_t slot) {
    const TriangleRecord& triangle = mesh.triangle(TriangleId(slot));
    Words& words = rows_["triangle " + std::to_string(slot)];
    for (const VertexId corner : triangle.vertices) {
      words.push_back(corner.index());
      AddVertex(mesh, corner);
    }
    words.push_back(static_cast<std::uint64_t>(triangle.region));
  }

  Constraints constraints_;
  std::map<std::string, Words> rows_;
};

// --- Refusals -----------------------------------------------------------------------------------

TEST(Frozen, RefusesNamesOfNothingAndNamesTwice) {
  const auto remesher = MeshOfTwoRooms("0.3");
  const auto refused = [&](const Constraints& constraints) {
    const Status status = remesher->SetConstraints(constraints);
    EXPECT_FALSE(status.ok());
    return status.ok() ? Error{} : status.error();
  };
  Error error = refused({.vertices = {VertexId(1), VertexId(1 << 20)}});
  EXPECT_EQ(error.code, ErrorCode::kIndexOutOfRange);
  EXPECT_EQ(error.field, "constraints.frozen_vertices");
  EXPECT_EQ(error.index, 1);
  error = refused({.vertices = {VertexId(4), VertexId(2), VertexId(4)}});
  EXPECT_EQ(error.code, ErrorCode::kDuplicateId);
  EXPECT_EQ(error.index, 2);
  EXPECT_EQ(error.other_index, 0);
  error = refused({.edges = {EdgeId(-1)}});
  EXPECT_EQ(error.code, ErrorCode::kIndexOutOfRange);
  EXPECT_EQ(error.field, "constraints.frozen_edges");
  error = refused({.regions = {1, 7}});
  EXPECT_EQ(error.field, "constraints.frozen_regions");
  EXPECT_EQ(error.index, 1);
  EXPECT_TRUE(FrozenOf(remesher->mesh()).empty());
}

TEST(Frozen, NamesNothingBeforeTheFirstRevision) {
  auto made = Remesher::Create(TwoHalves(), SizeOf("0.3"), {});
  ASSERT_TRUE(made.ok());
  const Status status = (*made)->SetConstraints({.vertices = {VertexId(0)}});
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kRevisionNotFound);
  EXPECT_TRUE((*made)->SetConstraints({.permissions = {.swap = false}}).ok());
  RunToTheEnd(**made);
}

TEST(Frozen, OptionsKeepSeedAndVariant) {
  const auto remesher = MeshOfTwoRooms("0.3");
  Options options = remesher->options();
  options.seed = 77;
  ASSERT_FALSE(remesher->SetOptions(options).ok());
  EXPECT_EQ(remesher->SetOptions(options).error().field, "options.seed");
  options = remesher->options();
  options.variant = Variant::kPaper;
  EXPECT_EQ(remesher->SetOptions(options).error().code, ErrorCode::kProtocolOrder);
  options = remesher->options();
  options.age_max = 900;
  EXPECT_EQ(remesher->SetOptions(options).error().code, ErrorCode::kOutOfRange);
}

// --- What freezes what --------------------------------------------------------------------------

TEST(Frozen, ARegionFreezesItsTrianglesTheirCornersAndTheirConstrainedEdges) {
  const auto remesher = MeshOfTwoRooms("0.25");
  const Mesh& mesh = remesher->mesh();
  ASSERT_TRUE(remesher->SetConstraints({.regions = {2}}).ok());
  for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
    if (!mesh.IsLive(VertexId(v))) continue;
    EXPECT_EQ(mesh.vertex(VertexId(v)).frozen, mesh.position(VertexId(v)).x >= 0.5) << v;
  }
  for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
    const EdgeRecord& edge = mesh.edge(EdgeId(e));
    if (!edge.live) continue;
    const double x = 0.5 * (mesh.position(edge.vertices[0]).x + mesh.position(edge.vertices[1]).x);
    EXPECT_EQ(edge.frozen, x >= 0.5) << e;
  }
}

TEST(Frozen, AnEdgeFreezesItsEndsAndOtherConstraintsThawThem) {
  const auto remesher = MeshOfTwoRooms("0.25");
  const Mesh& mesh = remesher->mesh();
  ASSERT_TRUE(remesher->SetConstraints({.edges = {EdgeId(3)}}).ok());
  const auto ends = mesh.edge(EdgeId(3)).vertices;
  EXPECT_TRUE(mesh.vertex(ends[0]).frozen && mesh.vertex(ends[1]).frozen);
  ASSERT_TRUE(remesher->SetConstraints({.vertices = {VertexId(0)}}).ok());
  EXPECT_FALSE(mesh.edge(EdgeId(3)).frozen);
  EXPECT_THAT(FrozenOf(mesh).vertices, ElementsAre(VertexId(0)));
  ASSERT_TRUE(remesher->SetConstraints({}).ok());
  EXPECT_TRUE(FrozenOf(mesh).empty());
}

// Goal: a frozen region stays while the rest is refined, what that costs is reported as such, and
//       with the constraint lifted the mesh follows there too.
TEST(Frozen, ARegionStaysCoarseIsReportedAndFollowsOnceThawed) {
  const auto remesher = MeshOfTwoRooms("0.25");
  const Mesh& mesh = remesher->mesh();
  const Constraints constraints{.regions = {2}};
  ASSERT_TRUE(remesher->SetConstraints(constraints).ok());
  const Picture before(mesh, constraints);
  ASSERT_TRUE(remesher->SetMetric(SizeOf("0.04")).ok());
  RunToTheEnd(*remesher);
  EXPECT_EQ(before.DifferenceTo(mesh), "");
  const std::vector<Trouble> troubles = remesher->FindTroubles();
  ASSERT_FALSE(troubles.empty());
  EXPECT_EQ(troubles[0].kind, TroubleKind::kFrozen);
  EXPECT_GT(troubles[0].length_max, 4);
  EXPECT_GE(troubles[0].box.low.x, 0.25);
  (void)remesher->Commit();
  EXPECT_GT(mesh.vertex_count(), 300);

  ASSERT_TRUE(remesher->SetConstraints({}).ok());
  RunToTheEnd(*remesher);
  EXPECT_TRUE(remesher->FindTroubles().empty());
  EXPECT_EQ(testing::Faults(mesh), "");
  (void)remesher->Commit();
  const Quality quality = MeasureQuality(mesh, remesher->field());
  EXPECT_GT(quality.integrated.share_sqrt2, 0.95);
}

// --- Modes --------------------------------------------------------------------------------------

// Each restriction lets nothing of its kind happen, whatever the metric asks for.
TEST(Frozen, RestrictionsHoldEach) {
  const auto counts_with = [](const Permissions& permissions) {
    const auto remesher = MeshOfTwoRooms("0.2");
    EXPECT_TRUE(remesher->SetConstraints({.permissions = permissions}).ok());
    EXPECT_TRUE(remesher->SetMetric(SizeOf("0.05+0.3*x")).ok());
    const auto progress = remesher->Step({.visits_max = kVisitsMax});
    EXPECT_TRUE(progress.ok());
    EXPECT_EQ(testing::Faults(remesher->mesh()), "");
    return progress->counts;
  };
  EXPECT_GT(counts_with({}).insertions, 50);
  LoopCounts counts = counts_with({.insert = false});
  EXPECT_EQ(counts.insertions + counts.deletions, 0);
  EXPECT_GT(counts.moves, 0);
  counts = counts_with({.move = false});
  EXPECT_EQ(counts.moves, 0);
  EXPECT_GT(counts.insertions, 0);
  counts = counts_with({.swap = false});
  EXPECT_EQ(counts.swaps, 0);
  EXPECT_GT(counts.deletions, 0);
  counts = counts_with({.insert = false, .swap = false});
  EXPECT_EQ(counts.insertions + counts.deletions + counts.swaps, 0);
  EXPECT_GT(counts.moves, 0);
}

TEST(Frozen, NoSurfaceKeepsEveryConstrainedEdgeAndStillRefinesInside) {
  const auto remesher = MeshOfTwoRooms("0.2");
  const Mesh& mesh = remesher->mesh();
  Constraints edges;
  for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
    if (mesh.edge(EdgeId(e)).live) edges.edges.emplace_back(e);
  }
  const Picture before(mesh, edges);
  ASSERT_TRUE(remesher->SetConstraints({.permissions = {.surface = false}}).ok());
  ASSERT_TRUE(remesher->SetMetric(SizeOf("0.05")).ok());
  RunToTheEnd(*remesher);
  EXPECT_EQ(before.DifferenceTo(mesh), "");
  EXPECT_EQ(mesh.edge_count(), std::ssize(edges.edges));
  EXPECT_GT(mesh.vertex_count(), 150);
  ASSERT_FALSE(remesher->FindTroubles().empty());
  EXPECT_EQ(remesher->FindTroubles()[0].kind, TroubleKind::kFrozen);
}

// --- Revisions ----------------------------------------------------------------------------------

// Goal: constraints and options go back with a rollback, an undo and a fork, bit for bit, and the
//       sessions then go on alike.
TEST(Frozen, ConstraintsAndOptionsBelongToTheRevision) {
  const auto remesher = MeshOfTwoRooms("0.2");
  ASSERT_TRUE(remesher->SetConstraints({.regions = {2}, .permissions = {.swap = false}}).ok());
  Options options = remesher->options();
  options.metric_tolerance = 0.5;
  ASSERT_TRUE(remesher->SetOptions(options).ok());
  remesher->Rollback();
  EXPECT_TRUE(FrozenOf(remesher->mesh()).empty());
  EXPECT_EQ(remesher->options(), Options{});

  ASSERT_TRUE(remesher->SetConstraints({.regions = {2}, .permissions = {.swap = false}}).ok());
  options.permissions.swap = false;
  ASSERT_TRUE(remesher->SetOptions(options).ok());
  (void)remesher->Commit();
  EXPECT_EQ(remesher->options(), options);
  const std::optional<RevisionDelta> undo = remesher->TakeUndo();
  ASSERT_TRUE(undo.has_value());
  const RevisionDelta redo = remesher->InverseOf(*undo);

  const auto saved = remesher->Save();
  ASSERT_TRUE(saved.ok());
  auto fork = Remesher::Load(*saved);
  ASSERT_TRUE(fork.ok()) << fork.error().message;
  EXPECT_EQ((*fork)->options(), options);
  EXPECT_EQ(FrozenOf((*fork)->mesh()).triangles, FrozenOf(remesher->mesh()).triangles);

  ASSERT_TRUE(remesher->Apply(*undo, Revision(3)).ok());
  EXPECT_TRUE(FrozenOf(remesher->mesh()).empty());
  EXPECT_EQ(remesher->options(), Options{});
  const auto bytes = WriteDelta(redo);
  ASSERT_TRUE(bytes.ok());
  RevisionDelta again = redo;
  again.base = Revision(3);
  ASSERT_TRUE(remesher->Apply(again, Revision(4)).ok());
  EXPECT_EQ(remesher->options(), options);
  for (Remesher* one : {remesher.get(), fork->get()}) {
    ASSERT_TRUE(one->SetMetric(SizeOf("0.06")).ok());
    RunToTheEnd(*one);
    (void)one->Commit();
  }
  EXPECT_EQ(testing::DifferenceOf(remesher->mesh(), (*fork)->mesh()), "");
}

// A motion that would take a frozen vertex along is refused, and nothing has changed.
TEST(Frozen, AMotionOfWhatIsFrozenIsRefused) {
  const auto remesher = MeshOfTwoRooms("0.2");
  ASSERT_TRUE(remesher->SetConstraints({.regions = {2}}).ok());
  (void)remesher->Commit();
  const Mesh before = remesher->mesh();
  MotionRequest request;
  request.tags.push_back({{9}, Translation{{-0.1, 0}}});
  const auto refused = MoveVertices(*remesher, request);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kFrozen);
  EXPECT_THAT(refused.error().message, HasSubstr("frozen"));
  EXPECT_EQ(refused.error().field, "vertices");
  EXPECT_THAT(refused.error().message,
              HasSubstr("vertex " + std::to_string(refused.error().index) + " "));
  EXPECT_EQ(testing::DifferenceOf(remesher->mesh(), before), "");
  request.tags = {{{4}, Translation{{-0.1, 0}}}};
  EXPECT_TRUE(MoveVertices(*remesher, request).ok());
}

// --- At random ----------------------------------------------------------------------------------

/// One session with random constraints, metrics, budgets, commits and rollbacks.
class FrozenCampaign {
 public:
  explicit FrozenCampaign(std::uint64_t seed)
      : seed_(seed), rng_(seed), random_(testing::MakeRandomCase(seed)) {}

  void Run() {
    Options options;
    options.vertices_max = 3'000;
    if (rng_.Below(8) == 0) options.variant = Variant::kPaper;
    options.visits_per_vertex_max = 40;
    auto made =
        Remesher::Create(random_.domain, testing::RandomMetric(random_, 150, seed_), options);
    ASSERT_TRUE(made.ok()) << made.error().message;
    remesher_ = std::move(*made);
    ASSERT_TRUE(remesher_->Step({.visits_max = kVisitsMax}).ok());
    (void)remesher_->Commit();
    Constraints committed;
    for (int round = 0; round < 6 && !::testing::Test::HasFailure(); ++round) {
      SCOPED_TRACE(::testing::Message() << "round " << round);
      if (rng_.Below(2) == 0) Constrain();
      const Picture picture(remesher_->mesh(), WhatStays());
      const double wanted = rng_.Uniform(50, 450);
      ASSERT_TRUE(remesher_->SetField(testing::RandomMetric(random_, wanted, rng_.Next())).ok());
      const std::int64_t budget = rng_.Below(2) == 0 ? kVisitsMax : 1 + rng_.Below(500);
      ASSERT_TRUE(remesher_->Step({.visits_max = budget}).ok());
      EXPECT_EQ(picture.DifferenceTo(remesher_->mesh()), "");
      EXPECT_EQ(testing::FaultsAgainst(random_, remesher_->mesh()), "");
      if (rng_.Below(4) == 0) {
        remesher_->Rollback();
        constraints_ = committed;
        EXPECT_EQ(remesher_->options().permissions, committed.permissions);
      } else {
        (void)remesher_->Commit();
        committed = constraints_;
      }
    }
  }

 private:
  /// What is frozen, and with no_surface every constrained edge.
  [[nodiscard]] Constraints WhatStays() const {
    Constraints stays = constraints_;
    if (constraints_.permissions.surface) return stays;
    stays.edges.clear();
    const Mesh& mesh = remesher_->mesh();
    for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
      if (mesh.edge(EdgeId(e)).live) stays.edges.emplace_back(e);
    }
    return stays;
  }

  void Constrain() {
    const Mesh& mesh = remesher_->mesh();
    constraints_ = {};
    for (const VertexId id : testing::LiveVertices(mesh)) {
      if (rng_.Below(10) == 0) constraints_.vertices.push_back(id);
    }
    for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
      if (mesh.edge(EdgeId(e)).live && rng_.Below(5) == 0) constraints_.edges.emplace_back(e);
    }
    if (rng_.Below(3) == 0) {
      const auto at =
          static_cast<std::int32_t>(rng_.Below(static_cast<std::uint64_t>(mesh.triangle_slots())));
      if (mesh.triangle(TriangleId(at)).live) {
        constraints_.regions.push_back(mesh.triangle(TriangleId(at)).region);
      }
    }
    Permissions& may = constraints_.permissions;
    for (bool* permission : {&may.insert, &may.swap, &may.move, &may.surface}) {
      *permission = rng_.Below(5) != 0;
    }
    const Status status = remesher_->SetConstraints(constraints_);
    ASSERT_TRUE(status.ok()) << status.error().message;
  }

  std::uint64_t seed_;
  Rng rng_;
  testing::RandomCase random_;
  std::unique_ptr<Remesher> remesher_;
  Constraints constraints_;
};

// Goal: nothing frozen ever changes a bit, in any mode, on any domain, by any update, and the mesh
//       stays a triangulation of its domain.
// Replay: PLIANT_SEED=17 core_tests --gtest_filter='FrozenAtRandom.*'
TEST(FrozenAtRandom, NothingFrozenEverChanges) {
  for (const std::uint64_t seed : test::Seeds{.count = 60, .long_count = 1000}.OfPart(0)) {
    SCOPED_TRACE(test::Replay(seed, "core_tests", "FrozenAtRandom.*"));
    FrozenCampaign(seed).Run();
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace pliant
