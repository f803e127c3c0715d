#include "client/cpp/mesh_replica.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/client/model_mesh.h"

namespace pliant::client {
namespace {

using testing::HasSubstr;

/// A replica and its model, a few revisions on.
struct Pair {
  ModelMesh model;
  MeshReplica replica;
  ModelChanger changer;

  explicit Pair(std::uint64_t seed) : changer(seed) {
    for (int revision = 1; revision <= 3; ++revision) {
      ModelMesh next = changer.Next(model, /*change_count=*/20);
      EXPECT_TRUE(replica.Apply(DiffOf(model, next)).ok());
      model = std::move(next);
    }
  }
};

// Goal: following diffs gives the mesh that the server has, whatever comes and goes.
// Method: a model of plain maps is changed at random and compared with the replica in full after
// every diff; the diff is found by comparing maps. Replay: --gtest_filter=*FollowsRandomDiffs*
TEST(MeshReplica, FollowsRandomDiffs) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    ModelChanger changer(seed);
    ModelMesh model;
    MeshReplica replica;
    for (int revision = 1; revision <= 30; ++revision) {
      SCOPED_TRACE(testing::Message() << "revision " << revision);
      ModelMesh next = changer.Next(model, revision == 1 ? 40 : revision % 7);
      const Status status = replica.Apply(DiffOf(model, next));
      ASSERT_TRUE(status.ok()) << status.error().message;
      model = std::move(next);
      ASSERT_NO_FATAL_FAILURE(ExpectSame(replica, model));
    }
  }
}

TEST(MeshReplica, AnEmptyDiffOnlyRaisesTheRevision) {
  Pair pair(/*seed=*/7);
  ModelMesh next = pair.model;
  next.revision = Revision{static_cast<std::int64_t>(next.revision) + 1};
  ASSERT_TRUE(pair.replica.Apply(DiffOf(pair.model, next)).ok());
  ExpectSame(pair.replica, next);
}

TEST(MeshReplica, ResetReplacesEverything) {
  Pair pair(/*seed=*/8);
  const ModelMesh other = ModelChanger(/*seed=*/9).Next({}, 15);
  ASSERT_TRUE(pair.replica.Reset(DiffOf({}, other)).ok());
  ExpectSame(pair.replica, other);
}

TEST(MeshReplica, KeepsMetricsOfLiveVerticesOnly) {
  Pair pair(/*seed=*/10);
  const VertexId gone = pair.model.vertices.begin()->first;
  ASSERT_TRUE(pair.replica.HasMetric(gone));
  ModelMesh next = pair.model;
  next.vertices.erase(gone);
  std::erase_if(next.triangles, [&](const auto& t) {
    return std::ranges::find(t.second.first, gone) != t.second.first.end();
  });
  std::erase_if(next.edges, [&](const auto& e) {
    return std::ranges::find(e.second.first, gone) != e.second.first.end();
  });
  next.revision = Revision{4};
  ASSERT_TRUE(pair.replica.Apply(DiffOf(pair.model, next)).ok());
  EXPECT_FALSE(pair.replica.HasMetric(gone));
  const CompactMesh compact = pair.replica.Compact();
  ASSERT_EQ(compact.metrics.size(), compact.mesh.points.size());
  for (std::size_t i = 0; i < compact.metrics.size(); ++i) {
    const double x = compact.mesh.points[i].x;
    EXPECT_EQ(compact.metrics[i], Metric::Isotropic(1 + x * x));
  }
}

// Goal: whatever is wrong with a diff is noticed, named, and leaves the replica as it was.
// Method: a good diff is damaged in one place at a time.
struct Damage {
  std::string name;
  std::string field;
  void (*apply)(MeshDiff&);
};

class DamagedDiff : public testing::TestWithParam<Damage> {};

TEST_P(DamagedDiff, IsRefusedAndChangesNothing) {
  Pair pair(/*seed=*/11);
  const ModelMesh next = pair.changer.Next(pair.model, 20);
  const MeshDiff good = DiffOf(pair.model, next);
  ASSERT_FALSE(good.removed_vertices.empty());
  ASSERT_GT(good.triangle_ids.size(), 1U);
  MeshDiff bad = good;
  GetParam().apply(bad);

  const Status status = pair.replica.Apply(bad);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kReplicaMismatch);
  EXPECT_EQ(status.error().field, GetParam().field) << status.error().message;
  EXPECT_THAT(status.error().message, HasSubstr("ask for a snapshot"));
  ExpectSame(pair.replica, pair.model);
  EXPECT_TRUE(pair.replica.Apply(good).ok()) << "the undamaged diff must still fit";
}

INSTANTIATE_TEST_SUITE_P(
    Damages, DamagedDiff,
    testing::Values(
        Damage{"WrongBase", "base_revision", [](MeshDiff& d) { d.base_revision = Revision{1}; }},
        Damage{"BackInTime", "revision", [](MeshDiff& d) { d.revision = Revision{1}; }},
        Damage{"WrongHash", "state_hash", [](MeshDiff& d) { ++d.summary.state_hash; }},
        Damage{"WrongVertexCount", "counts", [](MeshDiff& d) { ++d.summary.vertex_count; }},
        Damage{"WrongTriangleCount", "counts", [](MeshDiff& d) { --d.summary.triangle_count; }},
        Damage{"WrongEdgeCount", "counts", [](MeshDiff& d) { ++d.summary.edge_count; }},
        Damage{"OtherBits", "state_hash",
               [](MeshDiff& d) { d.vertex_positions[0].x = -d.vertex_positions[0].x; }},
        Damage{"OtherRegion", "state_hash", [](MeshDiff& d) { ++d.triangle_regions[0]; }},
        Damage{"OtherTag", "state_hash", [](MeshDiff& d) { ++d.edge_tags[0]; }},
        Damage{"MissingRow", "triangle_vertices",
               [](MeshDiff& d) { d.triangle_vertices.pop_back(); }},
        Damage{"MissingTriangle", "counts", [](MeshDiff& d) { d.removed_triangles.pop_back(); }},
        Damage{"FreeVertexRemoved", "removed_vertices",
               [](MeshDiff& d) { d.removed_vertices.push_back(VertexId(500)); }},
        Damage{"Unsorted", "triangle_ids",
               [](MeshDiff& d) { std::swap(d.triangle_ids[0], d.triangle_ids[1]); }},
        Damage{"NegativeSlot", "vertex_ids", [](MeshDiff& d) { d.vertex_ids[0] = VertexId(-1); }},
        Damage{"HugeSlot", "edge_ids", [](MeshDiff& d) { d.edge_ids.back() = EdgeId(0x7fffffff); }},
        Damage{"CornerIsFree", "triangle_vertices",
               [](MeshDiff& d) { d.triangle_vertices[0][1] = VertexId(500); }},
        Damage{"CornerIsNegative", "edge_vertices",
               [](MeshDiff& d) { d.edge_vertices[0][1] = VertexId(-1); }},
        Damage{"MetricOfNobody", "metric.vertex_ids",
               [](MeshDiff& d) { d.metric_vertex_ids.back() = VertexId(500); }},
        Damage{"MetricMissing", "metric.tensors", [](MeshDiff& d) { d.metrics.pop_back(); }}),
    [](const auto& info) { return info.param.name; });

// Goal: a server that lies, hash and counts included, cannot take a vertex from under a triangle or
// an edge; the same diff is taken once nothing uses the vertex.
// Method: a model in which the vertex is gone and all else stays, so that its summary is the
// diff's.
TEST(MeshReplica, NoVertexGoesWhileSomethingUsesIt) {
  for (const bool by_edge : {false, true}) {
    SCOPED_TRACE(by_edge ? "an edge" : "a triangle");
    Pair pair(/*seed=*/21);
    ModelMesh next = pair.model;
    next.revision = Revision{static_cast<std::int64_t>(next.revision) + 1};
    const VertexId corner =
        by_edge ? next.edges.begin()->second.first[1] : next.triangles.begin()->second.first[2];
    const auto has_corner = [&](const auto& element) {
      return std::ranges::count(element.second.first, corner) > 0;
    };
    // Of both kinds only one uses it.
    if (by_edge) {
      std::erase_if(next.triangles, has_corner);
    } else {
      std::erase_if(next.edges, has_corner);
    }
    next.vertices.erase(corner);
    const Status status = pair.replica.Apply(DiffOf(pair.model, next));
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().code, ErrorCode::kReplicaMismatch);
    EXPECT_EQ(status.error().field, "removed_vertices");
    EXPECT_EQ(status.error().index, 0);
    ExpectSame(pair.replica, pair.model);

    std::erase_if(next.triangles, has_corner);
    std::erase_if(next.edges, has_corner);
    ASSERT_TRUE(pair.replica.Apply(DiffOf(pair.model, next)).ok());
    ExpectSame(pair.replica, next);
  }
}

// Goal: a diff that names a slot far out, as no server does, is refused before memory is spent on
// it; one whose vertex is there by right is taken.
TEST(MeshReplica, ASlotFarOutCostsNothingBeforeItIsKnownToBeRight) {
  Pair pair(/*seed=*/12);
  const VertexId far(500'000'000);
  MeshDiff diff = DiffOf(pair.model, pair.changer.Next(pair.model, 5));
  diff.vertex_ids.push_back(far);
  diff.vertex_positions.push_back({1, 1});
  const std::size_t slots = pair.replica.positions().size();
  EXPECT_EQ(pair.replica.Apply(diff).error().field, "counts");
  EXPECT_EQ(pair.replica.positions().size(), slots);
  EXPECT_FALSE(pair.replica.IsLive(far));
  ExpectSame(pair.replica, pair.model);

  const VertexId further(2'000);  // More than four times what there is.
  ModelMesh next = pair.model;
  next.revision = Revision{static_cast<std::int64_t>(next.revision) + 1};
  next.vertices[further] = next.vertices.begin()->second;
  auto& corners = next.triangles.begin()->second.first;
  corners[2] = further;  // The greatest slot may stand last.
  ASSERT_TRUE(pair.replica.Apply(DiffOf(pair.model, next)).ok());
  ExpectSame(pair.replica, next);
}

TEST(MeshReplica, ADiffThatComesTwiceIsRefused) {
  Pair pair(/*seed=*/12);
  const ModelMesh next = pair.changer.Next(pair.model, 5);
  const MeshDiff diff = DiffOf(pair.model, next);
  ASSERT_TRUE(pair.replica.Apply(diff).ok());
  const Status again = pair.replica.Apply(diff);
  ASSERT_FALSE(again.ok());
  EXPECT_EQ(again.error().field, "base_revision");
  ExpectSame(pair.replica, next);
}

TEST(MeshReplica, SameMeshSeesEveryDifference) {
  const Pair pair(/*seed=*/13);
  const auto with = [&](auto change) {
    ModelMesh other = pair.model;
    change(other);
    MeshReplica replica;
    EXPECT_TRUE(replica.Apply(DiffOf({}, other)).ok());
    return SameMesh(pair.replica, replica);
  };
  EXPECT_TRUE(with([](ModelMesh&) {}));
  EXPECT_FALSE(with([](ModelMesh& m) { m.revision = Revision{9}; }));
  EXPECT_FALSE(with([](ModelMesh& m) { m.vertices.begin()->second.y += 1; }));
  EXPECT_FALSE(with([](ModelMesh& m) { m.triangles.erase(m.triangles.begin()); }));
  EXPECT_FALSE(with([](ModelMesh& m) { ++m.edges.begin()->second.second; }));
}

}  // namespace
}  // namespace pliant::client
