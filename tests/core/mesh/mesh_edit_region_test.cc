// Goal: the operations that let a mesh cover another part of the plane keep it consistent, and are
// undone bit for bit.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/mesh/mesh_diff.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/segment_edges.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/stop_after.h"

namespace pliant {
namespace {

class Region : public ::testing::Test {
 protected:
  Region() : made_(testing::ImportedMesh(testing::GridData(4, 4))) {
    (void)made_->edit.Commit(Revision(1));
  }

  [[nodiscard]] std::vector<TriangleId> CellTriangles(double x, double y) const {
    std::vector<TriangleId> found;
    for (const TriangleId id : testing::LiveTriangles(made_->mesh)) {
      Vec2 center{0, 0};
      for (const VertexId v : made_->mesh.triangle(id).vertices) {
        center = center + (1.0 / 3) * made_->mesh.position(v);
      }
      if (center.x > x && center.x < x + 1 && center.y > y && center.y < y + 1) {
        found.push_back(id);
      }
    }
    return found;
  }

  /// Cuts a cell out of the grid; `sides` are all of its own.
  void CutOut(double x, double y, const std::vector<std::array<std::int32_t, 2>>& sides) {
    std::vector<SegmentRecord> lines;
    for (const auto& [a, b] : sides) lines.push_back({VertexId(a), VertexId(b)});
    const std::vector<std::int32_t> places = made_->edit.ReplaceSegments({}, lines);
    for (std::size_t i = 0; i < sides.size(); ++i) {
      made_->edit.AddEdge({{lines[i].a, lines[i].b}, {0, 1}, 9, places[i]});
      made_->edit.Fix(lines[i].a);
      made_->edit.Fix(lines[i].b);
    }
    ASSERT_TRUE(made_->edit.ReplaceRegion(CellTriangles(x, y), {}));
  }

  std::unique_ptr<testing::EditedMesh> made_;
};

TEST_F(Region, OpensAHoleAndFillsItAgain) {
  CutOut(1, 1, {{6, 7}, {7, 12}, {12, 11}, {11, 6}});
  EXPECT_EQ(testing::Faults(made_->mesh), "");
  EXPECT_EQ(made_->mesh.triangle_count(), 30);
  (void)made_->edit.Commit(Revision(2));
  ASSERT_TRUE(made_->edit.ReplaceRegion(
      {}, std::vector<NewTriangle>{{{VertexId(6), VertexId(7), VertexId(11)}, 0},
                                   {{VertexId(7), VertexId(12), VertexId(11)}, 0}}));
  EXPECT_EQ(testing::Faults(made_->mesh), "");
  EXPECT_EQ(made_->mesh.triangle_count(), 32);
  made_->edit.Rollback();
  EXPECT_EQ(testing::Faults(made_->mesh), "");
  EXPECT_EQ(made_->mesh.triangle_count(), 30);
}

// Two holes that touch in a point pinch it; when one is filled it is a vertex like others.
TEST_F(Region, KnowsWhichVerticesArePinched) {
  CutOut(1, 1, {{6, 7}, {7, 12}, {12, 11}, {11, 6}});
  EXPECT_FALSE(made_->mesh.vertex(VertexId(12)).pinched);
  (void)made_->edit.Commit(Revision(2));
  CutOut(2, 2, {{12, 13}, {13, 18}, {18, 17}, {17, 12}});
  EXPECT_EQ(testing::Faults(made_->mesh), "");
  EXPECT_TRUE(made_->mesh.vertex(VertexId(12)).pinched);
  ASSERT_TRUE(made_->edit.ReplaceRegion(
      {}, std::vector<NewTriangle>{{{VertexId(6), VertexId(7), VertexId(11)}, 0},
                                   {{VertexId(7), VertexId(12), VertexId(11)}, 0}}));
  EXPECT_EQ(testing::Faults(made_->mesh), "");
  EXPECT_FALSE(made_->mesh.vertex(VertexId(12)).pinched);
}

TEST_F(Region, GivesPlacesOfSegmentsAway) {
  const std::size_t count = made_->mesh.segments().size();
  const SegmentRecord old = made_->mesh.segments()[1];
  const auto first = made_->edit.ReplaceSegments(std::vector<std::int32_t>{1}, {});
  EXPECT_TRUE(first.empty());
  EXPECT_FALSE(made_->mesh.segments()[1].a.valid());
  const std::vector<SegmentRecord> added{{VertexId(5), VertexId(6)}, {VertexId(6), VertexId()}};
  const auto places = made_->edit.ReplaceSegments({}, added);
  EXPECT_EQ(places, (std::vector<std::int32_t>{1, static_cast<std::int32_t>(count)}));
  made_->edit.Rollback();
  ASSERT_EQ(made_->mesh.segments().size(), count);
  EXPECT_EQ(made_->mesh.segments()[1].a, old.a);
  EXPECT_EQ(made_->mesh.segments()[1].b, old.b);
}

// Goal: it can be stopped at every look, and undone then. Method: a hole that takes so many
// triangles that there are several looks.
TEST(LargeRegion, IsReplacedWholeOrUndone) {
  constexpr int kCells = 60;
  const auto made = testing::ImportedMesh(testing::GridData(kCells, kCells));
  (void)made->edit.Commit(Revision(1));
  const MeshSummary before = SnapshotOf(made->mesh, Revision(1)).summary;
  // All but the outermost cells.
  const auto is_inner = [&](VertexId v) {
    const Vec2 p = made->mesh.position(v);
    return p.x > 0 && p.x < kCells && p.y > 0 && p.y < kCells;
  };
  std::vector<TriangleId> gone;
  for (const TriangleId id : testing::LiveTriangles(made->mesh)) {
    if (std::ranges::all_of(made->mesh.triangle(id).vertices, is_inner)) gone.push_back(id);
  }
  std::vector<std::array<VertexId, 2>> sides;
  for (const TriangleId id : gone) {
    const TriangleRecord& triangle = made->mesh.triangle(id);
    for (std::size_t side = 0; side < 3; ++side) {
      const TriangleId beyond = triangle.neighbors[side];
      if (std::ranges::binary_search(gone, beyond)) continue;
      sides.push_back({triangle.vertices[(side + 1) % 3], triangle.vertices[(side + 2) % 3]});
    }
  }
  const auto replace = [&](const StopSignal* stop) {
    std::vector<SegmentRecord> lines;
    for (const auto& [a, b] : sides) lines.push_back({a, b});
    const std::vector<std::int32_t> places = made->edit.ReplaceSegments({}, lines);
    for (std::size_t i = 0; i < sides.size(); ++i) {
      made->edit.AddEdge({sides[i], {0, 1}, 9, places[i]});
    }
    return made->edit.ReplaceRegion(gone, {}, stop);
  };
  int stops = 0;
  for (;; ++stops) {
    const testing::StopAfter stop(stops + 1);
    MeshEdit::Trial trial = made->edit.BeginTrial();
    const bool replaced = replace(&stop);
    made->edit.Undo(std::move(trial));
    EXPECT_EQ(testing::Faults(made->mesh), "");
    EXPECT_EQ(SnapshotOf(made->mesh, Revision(1)).summary, before);
    if (replaced) break;
  }
  EXPECT_GE(stops, 5);
}

TEST_F(Region, TurnsAnEdgeRound) {
  EdgeId edge;
  ForEachPiece(made_->mesh, 0, [&](EdgeId id) { edge = id; });
  const EdgeRecord before = made_->mesh.edge(edge);
  made_->edit.SetEdge(edge, {{before.vertices[1], before.vertices[0]}, {0.25, 0.5}, 8, 0});
  const EdgeRecord& now = made_->mesh.edge(edge);
  EXPECT_EQ(now.vertices[0], before.vertices[1]);
  EXPECT_EQ(now.tag, 8);
  EXPECT_EQ(made_->mesh.FindEdge(before.vertices[0], before.vertices[1]), edge);
  int seen = 0;
  for (const VertexId end : before.vertices) {
    ForEachEdgeAt(made_->mesh, end, [&](EdgeId id) { seen += id == edge ? 1 : 0; });
  }
  EXPECT_EQ(seen, 2);
}

}  // namespace
}  // namespace pliant
