// Goal: vertices that were put anywhere inside get a mesh, whatever lies in between, and what does
// not touch it stays. Method: a grid of which vertices are put elsewhere; the checks are those of
// the mesh.

#include "core/delaunay/clash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/delaunay/cavity.h"
#include "core/mesh/star.h"
#include "tests/support/board.h"
#include "tests/support/seed.h"
#include "tests/support/stop_after.h"

namespace pliant {
namespace {

using testing::Board;
using testing::Faults;

/// Vertex at a place of the grid.
VertexId At(std::int32_t x, std::int32_t y) { return VertexId(9 * y + x); }

bool KeepsAll(VertexId) { return true; }

std::vector<TriangleId> CavityOf(const Board& board) {
  return WithClashes(board.grid->mesh, board.Inverted(), KeepsAll);
}

TEST(WithClashes, AFarJumpTouchesItsTwoEndsOnly) {
  Board board;
  board.Put(At(1, 1), {6.3, 6.6});
  const Mesh& mesh = board.grid->mesh;
  Star star;
  star.Gather(mesh, At(1, 1));
  const std::vector<TriangleId> cavity =
      WithClashes(mesh, {star.triangles().begin(), star.triangles().end()}, KeepsAll);
  EXPECT_TRUE(std::is_sorted(cavity.begin(), cavity.end()));
  for (const TriangleId id : cavity) {
    const auto& v = mesh.triangle(id).vertices;
    const bool at_start = std::find(v.begin(), v.end(), At(1, 1)) != v.end();
    const auto is_near = [&](VertexId vertex) {
      return vertex.value() % 9 >= 5 && vertex.value() / 9 >= 5;
    };
    EXPECT_TRUE(at_start || std::all_of(v.begin(), v.end(), is_near)) << id;
  }
  const auto filled = RetriangulateCavity(board.grid->edit, cavity, KeepsAll);
  ASSERT_TRUE(filled.ok());
  EXPECT_TRUE(filled->removed.empty());
  EXPECT_EQ(Faults(mesh), "");
  EXPECT_EQ(mesh.position(At(1, 1)), (Vec2{6.3, 6.6}));
}

TEST(WithClashes, NothingIsAddedWhereNothingOverlaps) {
  Board board;
  board.Put(At(4, 4), {4.4, 4.3});
  const std::vector<TriangleId> star = {board.grid->mesh.vertex(At(4, 4)).triangle};
  EXPECT_EQ(WithClashes(board.grid->mesh, star, KeepsAll), star);
}

constexpr test::Seeds kSeeds{.count = 200, .long_count = 20000};

/// Vertices change places, or go anywhere inside; some of them share lines.
void JumpAtRandom(std::uint64_t seed) {
  Rng rng(seed);
  Board board;
  std::vector<Vec2> places;
  std::vector<VertexId> chosen;
  for (std::int32_t y = 1; y < 8; ++y) {
    for (std::int32_t x = 1; x < 8; ++x) {
      if (rng.Below(3) != 0) continue;
      chosen.push_back(At(x, y));
      places.push_back(board.grid->mesh.position(At(x, y)));
    }
  }
  for (std::size_t i = chosen.size(); i > 1; --i) std::swap(places[i - 1], places[rng.Below(i)]);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const Vec2 anywhere{rng.Uniform(0.01, 7.99), rng.Uniform(0.01, 7.99)};
    board.Put(chosen[i], rng.Below(2) == 0 ? anywhere : places[i]);
  }
  const auto filled = RetriangulateCavity(board.grid->edit, CavityOf(board), KeepsAll);
  ASSERT_TRUE(filled.ok()) << filled.error().message;
  EXPECT_TRUE(filled->removed.empty());
  EXPECT_EQ(Faults(board.grid->mesh), "");
}

TEST(WithClashes, RandomJumpsAllHaveAMesh) {
  for (const std::uint64_t seed : kSeeds.OfPart(0)) {
    SCOPED_TRACE(test::Replay(seed, "core_tests", "WithClashes.RandomJumps*"));
    ASSERT_NO_FATAL_FAILURE(JumpAtRandom(seed));
    if (::testing::Test::HasFailure()) return;
  }
}

// Goal: what no mesh can have is named by the mesh's ids.
TEST(WithClashes, WhoCannotStayIsNamed) {
  const std::array cases = {std::pair(Vec2{12, 4}, ErrorCode::kPointOutsideDomain),
                            std::pair(Vec2{8, 4.5}, ErrorCode::kPointOnSegment),
                            std::pair(Vec2{6, 6}, ErrorCode::kDuplicatePoint)};
  for (const auto& [place, code] : cases) {
    Board board;
    board.Put(At(3, 3), place);
    const auto filled = RetriangulateCavity(board.grid->edit, CavityOf(board), KeepsAll);
    ASSERT_FALSE(filled.ok());
    EXPECT_EQ(filled.error().code, code) << filled.error().message;
    EXPECT_EQ(filled.error().index, At(3, 3).value());
    const bool clashes = code == ErrorCode::kDuplicatePoint;
    EXPECT_EQ(filled.error().other_index, clashes ? At(6, 6).value() : -1);
  }
}

// Goal: somebody who wants the motion to end is asked, and the mesh is as it was.
TEST(WithClashes, CanBeStopped) {
  Board board;
  board.Put(At(1, 1), {6.3, 6.6});
  const testing::StopAfter stop(1);
  const std::vector<TriangleId> inverted = board.Inverted();
  EXPECT_EQ(WithClashes(board.grid->mesh, inverted, KeepsAll, &stop), inverted);
  for (std::int64_t after = 1; after < 3; ++after) {
    const testing::StopAfter later(after);
    const auto filled =
        RetriangulateCavity(board.grid->edit, CavityOf(board), KeepsAll, {}, &later);
    ASSERT_FALSE(filled.ok());
    EXPECT_EQ(filled.error().code, ErrorCode::kCancelled);
  }
  EXPECT_EQ(board.Inverted(), inverted);
}

}  // namespace
}  // namespace pliant
