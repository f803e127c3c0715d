#include "core/motion/domain_cavity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/geometry/predicates.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

/// A grid of 6 x 6 cells with a hole of two cells in it.
std::unique_ptr<testing::EditedMesh> HoledGrid() {
  MeshData data = testing::GridData(6, 6);
  std::erase_if(data.triangles, [&](const auto& corners) {
    double x = 0;
    double y = 0;
    for (const std::int32_t i : corners) {
      x += data.points[static_cast<std::size_t>(i)].x / 3;
      y += data.points[static_cast<std::size_t>(i)].y / 3;
    }
    return x > 2 && x < 4 && y > 3 && y < 4;
  });
  return testing::ImportedMesh(data);
}

bool IsBetween(Vec2 a, Vec2 b, Vec2 p) {
  return Orient2d(a, b, p) == 0 && Dot(p - a, b - a) >= 0 && Dot(p - b, a - b) >= 0;
}

/// What GatherCavity asks of one triangle, in other words: the piece misses it if a line through
/// one of its sides, or the piece's own, has both on different sides.
bool Misses(const DomainPiece& piece, const std::array<Vec2, 3>& corners) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2 a = corners[i];
    const Vec2 b = corners[(i + 1) % 3];
    if (Orient2d(a, b, piece.a) < 0 && Orient2d(a, b, piece.b) < 0) return true;
  }
  if (piece.a == piece.b) return false;
  std::set<int> signs;
  for (const Vec2 p : corners) signs.insert(Orient2d(piece.a, piece.b, p));
  if (signs == std::set{1} || signs == std::set{-1}) return true;
  // A line that touches: the ends decide.
  const auto beyond = [&](Vec2 p) {
    return Dot(p - piece.a, piece.b - piece.a) < 0 || Dot(p - piece.b, piece.a - piece.b) < 0;
  };
  const bool none = std::none_of(corners.begin(), corners.end(),
                                 [&](Vec2 p) { return IsBetween(piece.a, piece.b, p); });
  bool crosses = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2 a = corners[i];
    const Vec2 b = corners[(i + 1) % 3];
    crosses = crosses || IsBetween(a, b, piece.a) || IsBetween(a, b, piece.b) ||
              (Orient2d(a, b, piece.a) * Orient2d(a, b, piece.b) < 0 &&
               Orient2d(piece.a, piece.b, a) * Orient2d(piece.a, piece.b, b) < 0);
  }
  const bool holds = Orient2d(corners[0], corners[1], piece.a) >= 0 &&
                     Orient2d(corners[1], corners[2], piece.a) >= 0 &&
                     Orient2d(corners[2], corners[0], piece.a) >= 0;
  return none && !crosses && !holds && std::all_of(corners.begin(), corners.end(), beyond);
}

// Goal: the cavity is what a look at every triangle finds, for pieces that lie in the mesh, leave
// it, cross a hole, lie in it, run along edges or are points; from no known vertex.
TEST(GatherCavity, FindsEveryTriangleThatPiecesTouch) {
  const auto made = HoledGrid();
  const Mesh& mesh = made->mesh;
  Rng rng(31);
  int found_count = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const auto draw = [&] {
      const Vec2 p{rng.Uniform(-1, 7), rng.Uniform(-1, 7)};
      return rng.Below(2) == 0 ? p : Vec2{std::floor(2 * p.x) / 2, std::floor(2 * p.y) / 2};
    };
    DomainPiece piece{draw(), draw(), 0};
    if (rng.Below(5) == 0) piece.b = piece.a;
    const TriangleSet found =
        GatherCavity(mesh, {.pieces = {piece}, .stars = {}, .anchored = {false}});
    std::set<TriangleId> wanted;
    for (const TriangleId id : testing::LiveTriangles(mesh)) {
      const auto& v = mesh.triangle(id).vertices;
      if (!Misses(piece, {mesh.position(v[0]), mesh.position(v[1]), mesh.position(v[2])})) {
        wanted.insert(id);
      }
    }
    EXPECT_EQ(std::set(found.triangles.begin(), found.triangles.end()), wanted)
        << "trial " << trial << " from " << piece.a.x << " " << piece.a.y << " to " << piece.b.x
        << " " << piece.b.y;
    found_count += static_cast<int>(!wanted.empty());
  }
  EXPECT_GT(found_count, 200);
}

TEST(GatherCavity, TakesStarsAndLeavesFrozenTrianglesOut) {
  const auto made = HoledGrid();
  const VertexId center(2 * 7 + 1);
  const TriangleSet all =
      GatherCavity(made->mesh, {.pieces = {}, .stars = {center}, .anchored = {}});
  EXPECT_EQ(all.triangles.size(), 6U);
  EXPECT_FALSE(all.met_frozen);
  made->edit.SetHold(all.triangles.front(), MeshEdit::Hold::kFrozen);
  const TriangleSet rest =
      GatherCavity(made->mesh, {.pieces = {}, .stars = {center}, .anchored = {}});
  EXPECT_EQ(rest.triangles.size(), 5U);
  EXPECT_FALSE(rest.Has(all.triangles.front()));
  EXPECT_TRUE(rest.met_frozen);
}

}  // namespace
}  // namespace pliant
