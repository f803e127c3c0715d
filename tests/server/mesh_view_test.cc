// Goal: who follows a part of a mesh has, at every revision, what a filter of the whole mesh gives.
// Method: a real engine with two regions changes at random; a mirror that was written from the
// protocol alone follows the whole diffs and is filtered by brute force; others follow the views.
#include "server/mesh_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/mesh/merge_diffs.h"
#include "core/pliant/remesher.h"
#include "server/convert_reply.h"
#include "tests/support/mirror.h"

namespace pliant::server {
namespace {

using test::Mirror;

/// Two squares side by side: regions 1 and 2.
Domain TwoRegions() {
  return {.points = {{0, 0}, {1, 0}, {2, 0}, {2, 1}, {1, 1}, {0, 1}},
          .segments = {{0, 1, 1}, {1, 2, 1}, {2, 3, 2}, {3, 4, 3}, {4, 5, 3}, {5, 0, 4}, {1, 4, 9}},
          .holes = {},
          .regions = {{{0.5, 0.5}, 1}, {{1.5, 0.5}, 2}}};
}

Mirror Filtered(const Mirror& whole, const MeshView::Spec& spec) {
  const auto wants = [&](std::int32_t region) {
    return spec.region_tags.empty() || std::ranges::count(spec.region_tags, region) > 0;
  };
  Mirror part;
  part.revision = whole.revision;
  std::set<std::int32_t> corners;
  for (const auto& [slot, triangle] : whole.triangles) {
    if (!wants(triangle[3])) continue;
    corners.insert(triangle.begin(), triangle.begin() + 3);
    if (!spec.only_vertices) part.triangles[slot] = triangle;
  }
  for (const auto& [slot, position] : whole.vertices) {
    if (corners.contains(slot)) part.vertices[slot] = position;
  }
  for (const auto& [slot, edge] : whole.edges) {
    const bool both = corners.contains(edge[0]) && corners.contains(edge[1]);
    if (both && !spec.only_vertices) part.edges[slot] = edge;
  }
  return part;
}

/// A view with the mirror of somebody who follows it.
struct Watcher {
  explicit Watcher(MeshView::Spec wanted) : spec(wanted), view(wanted) {}

  std::string Follow(const MeshDiff& diff, const MeshDiff& snapshot) {
    const std::optional<MeshDiff> seen = view.Follow(diff);
    if (seen) return mirror.Apply(ToMeshDiff(*seen, {}));
    ++snapshot_count;
    return mirror.Take(ToMeshSnapshot(view.Reset(snapshot), {}));
  }

  MeshView::Spec spec;
  MeshView view;
  Mirror mirror;
  int snapshot_count = 0;
};

std::vector<MeshView::Spec> AllSpecs() {
  return {{.region_tags = {1}},    {.region_tags = {2}, .with_values = true},
          {.region_tags = {1, 2}}, {.region_tags = {99}},
          {.only_vertices = true}, {.region_tags = {2}, .only_vertices = true}};
}

// Replay: --gtest_filter=MeshView.ShowsWhatAFilterOfTheWholeMeshShows
TEST(MeshView, ShowsWhatAFilterOfTheWholeMeshShows) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 rng(seed);
    std::uniform_real_distribution<double> random(0, 1);
    const auto remesher = *Remesher::Create(TwoRegions(), {.source = SizeMetric{"0.2"}}, {});
    std::vector<Watcher> watchers;
    for (const MeshView::Spec& spec : AllSpecs()) watchers.emplace_back(spec);
    Mirror whole;
    MeshDiff waiting;  // Of revisions that readers have not taken: diffs over several are told too.
    for (int revision = 1; revision <= 14; ++revision) {
      SCOPED_TRACE(testing::Message() << "revision " << revision);
      ASSERT_TRUE(remesher->Step({.visits_max = 400}).ok());
      MeshDiff diff = remesher->Commit();
      ASSERT_EQ(whole.Apply(ToMeshDiff(diff, {})), "");
      waiting = waiting.revision == Revision::kNone ? std::move(diff) : MergeDiffs(waiting, diff);
      if (revision % 3 != 2) {
        const MeshDiff snapshot = remesher->Snapshot();
        for (Watcher& watcher : watchers) {
          ASSERT_EQ(watcher.Follow(waiting, snapshot), "");
          ASSERT_TRUE(watcher.mirror == Filtered(whole, watcher.spec));
          ASSERT_EQ(watcher.view.AbsentTags(), watcher.spec.region_tags == std::vector{99}
                                                   ? std::vector{99}
                                                   : std::vector<std::int32_t>{});
        }
        waiting = {};
      }
      const std::string x = std::to_string(2 * random(rng));
      const std::string size = "0.03 + 0.2*abs(x - " + x + ")";
      ASSERT_TRUE(remesher->SetMetric({.source = SizeMetric{size}}).ok());
    }
    EXPECT_FALSE(watchers[0].mirror.triangles.empty());
    EXPECT_FALSE(watchers[0].mirror.edges.empty());
    EXPECT_TRUE(watchers[3].mirror.vertices.empty()) << "nobody has this tag";
    for (const Watcher& watcher : watchers) {
      if (watcher.spec.with_values) continue;
      EXPECT_EQ(watcher.snapshot_count, 0);
    }
  }
}

/// Two triangles that share the side 1-2, in region `left` and in region 2.
MeshDiff TwoTriangles(std::int32_t left) {
  MeshDiff diff;
  diff.revision = Revision(1);
  for (int i = 0; i < 4; ++i) diff.vertex_ids.emplace_back(i);
  diff.vertex_positions = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  diff.triangle_ids = {TriangleId(0), TriangleId(1)};
  diff.triangle_vertices = {{VertexId(0), VertexId(1), VertexId(2)},
                            {VertexId(1), VertexId(3), VertexId(2)}};
  diff.triangle_regions = {left, 2};
  diff.edge_ids = {EdgeId(0), EdgeId(1)};
  diff.edge_vertices = {{VertexId(1), VertexId(2)}, {VertexId(0), VertexId(1)}};
  diff.edge_tags = {7, 8};
  return diff;
}

/// The left triangle becomes one of another region; its corner is not named.
MeshDiff Repainted(std::int32_t left) {
  MeshDiff diff;
  diff.base_revision = Revision(1);
  diff.revision = Revision(2);
  diff.triangle_ids = {TriangleId(0)};
  diff.triangle_vertices = {{VertexId(0), VertexId(1), VertexId(2)}};
  diff.triangle_regions = {left};
  return diff;
}

TEST(MeshView, AsksForASnapshotWhereTheDiffDoesNotTellAll) {
  Watcher watcher({.region_tags = {2}});
  ASSERT_EQ(watcher.Follow(TwoTriangles(1), {}), "");
  EXPECT_EQ(watcher.mirror.vertices.size(), 3U);
  EXPECT_EQ(watcher.mirror.edges.size(), 1U);
  MeshDiff later = TwoTriangles(2);
  later.revision = Revision(2);
  EXPECT_EQ(watcher.Follow(Repainted(2), later), "");
  EXPECT_EQ(watcher.snapshot_count, 1) << "nobody said where vertex 0 is";
  EXPECT_TRUE(watcher.view.AbsentTags().empty());
  EXPECT_EQ(watcher.mirror.vertices.size(), 4U);
  EXPECT_EQ(watcher.mirror.edges.size(), 2U);

  MeshDiff moved = Repainted(2);  // The same, but vertex 0 moves: then all is told...
  moved.vertex_ids = {VertexId(0)};
  moved.vertex_positions = {{-1, 0}};
  Watcher other({.region_tags = {2}});
  ASSERT_EQ(other.Follow(TwoTriangles(1), {}), "");
  EXPECT_EQ(other.Follow(moved, {}), "");
  EXPECT_EQ(other.snapshot_count, 0);
  EXPECT_EQ(other.mirror.edges.size(), 2U) << "its edge comes with it, though nobody named it";
  Watcher keen({.region_tags = {2}, .with_values = true});  // ...but not what values it has.
  ASSERT_EQ(keen.Follow(TwoTriangles(1), {}), "");
  EXPECT_EQ(keen.Follow(moved, later), "");
  EXPECT_EQ(keen.snapshot_count, 1);
}

TEST(MeshView, TellsWhatLeavesIt) {
  Watcher watcher({.region_tags = {1, 4}});
  ASSERT_EQ(watcher.Follow(TwoTriangles(1), {}), "");
  ASSERT_EQ(watcher.mirror.triangles.size(), 1U);
  EXPECT_EQ(watcher.view.AbsentTags(), std::vector{4});
  EXPECT_EQ(watcher.Follow(Repainted(3), {}), "");
  EXPECT_EQ(watcher.view.AbsentTags(), (std::vector{1, 4}));
  EXPECT_TRUE(watcher.mirror.triangles.empty());
  EXPECT_TRUE(watcher.mirror.vertices.empty());
  EXPECT_TRUE(watcher.mirror.edges.empty());
}

TEST(MeshView, TellsValuesOfWhatIsInView) {
  MeshDiff diff = TwoTriangles(1);
  for (int i = 0; i < 4; ++i) {
    diff.metric_vertex_ids.emplace_back(i);
    diff.metrics.push_back(Metric::Isotropic(1 + i));
  }
  diff.fields.changed = {
      {"p", FieldLocation::kTriangle, 1, {{0, 1}, {10, 11}}},
      {"u", FieldLocation::kVertex, 2, {{0, 1, 2, 3}, {0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5}}}};
  diff.fields.dropped_names = {"old"};
  MeshView view({.region_tags = {2}, .with_values = true});
  const MeshDiff seen = *view.Follow(diff);
  EXPECT_EQ(seen.metric_vertex_ids, (std::vector{VertexId(1), VertexId(2), VertexId(3)}));
  EXPECT_EQ(seen.metrics[2], Metric::Isotropic(4));
  EXPECT_EQ(seen.fields.changed[0].rows, (FieldRows{{1}, {11}}));
  EXPECT_EQ(seen.fields.changed[1].rows, (FieldRows{{1, 2, 3}, {1, 1.5, 2, 2.5, 3, 3.5}}));
  EXPECT_EQ(seen.fields.dropped_names, diff.fields.dropped_names);
  MeshView vertices({.only_vertices = true, .with_values = true});
  EXPECT_EQ(vertices.Follow(diff)->fields.changed.size(), 1U) << "no triangles, no values at them";
}

}  // namespace
}  // namespace pliant::server
