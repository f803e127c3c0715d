#include "core/motion/domain_fill.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

constexpr WallSide kOut{WallSide::Kind::kOutside, 0};
constexpr WallSide kCovered{WallSide::Kind::kCovered, 0};
constexpr WallSide kCavity{WallSide::Kind::kCavity, 0};

WallSide Region(std::int32_t tag) { return {WallSide::Kind::kRegion, tag}; }

/// Walls around a cell of a grid of unit cells, seen counter-clockwise.
void AddLoop(std::vector<VertexId> loop, WallSide inside, WallSide outside, FillRequest& request) {
  for (std::size_t i = 0; i < loop.size(); ++i) {
    request.walls.push_back({loop[i], loop[(i + 1) % loop.size()], inside, outside});
  }
}

class FillWallsTest : public ::testing::Test {
 protected:
  FillWallsTest() : made_(testing::ImportedMesh(testing::GridData(3, 3))) {
    for (std::int32_t i = 0; i < 16; ++i) request_.points.emplace_back(i);
    request_.state_at = [](VertexId) { return StateAround{}; };
  }

  [[nodiscard]] double AreaOf(const Filling& filling, std::int32_t region) const {
    double area = 0;
    for (const NewTriangle& triangle : filling.triangles) {
      const auto at = [&](std::size_t i) { return made_->mesh.position(triangle.vertices[i]); };
      if (triangle.region == region) area += 0.5 * Cross(at(1) - at(0), at(2) - at(0));
    }
    return area;
  }

  static std::vector<VertexId> Rim() {
    std::vector<VertexId> rim;
    for (const int i : {0, 1, 2, 3, 7, 11, 15, 14, 13, 12, 8, 4}) rim.emplace_back(i);
    return rim;
  }
  static std::vector<VertexId> Middle() {
    return {VertexId(5), VertexId(6), VertexId(10), VertexId(9)};
  }

  std::unique_ptr<testing::EditedMesh> made_;
  FillRequest request_;
};

TEST_F(FillWallsTest, GivesEveryPartTheRegionOfItsWalls) {
  AddLoop(Rim(), Region(4), kOut, request_);
  AddLoop(Middle(), Region(2), Region(4), request_);
  const auto filling = FillWalls(made_->mesh, request_);
  ASSERT_TRUE(filling.has_value());
  EXPECT_DOUBLE_EQ(AreaOf(*filling, 4), 8);
  EXPECT_DOUBLE_EQ(AreaOf(*filling, 2), 1);
}

TEST_F(FillWallsTest, LeavesWhatIsCoveredOrOutsideEmpty) {
  AddLoop(Rim(), kCavity, kCovered, request_);
  AddLoop(Middle(), kOut, Region(3), request_);
  const auto filling = FillWalls(made_->mesh, request_);
  ASSERT_TRUE(filling.has_value());
  EXPECT_DOUBLE_EQ(AreaOf(*filling, 3), 8);
  EXPECT_EQ(filling->triangles.size(), 16U);
  EXPECT_EQ(filling->cavities.front().left, 3);
  EXPECT_FALSE(filling->cavities.front().right.has_value());
}

TEST_F(FillWallsTest, AsksAVertexWhereNoWallKnows) {
  AddLoop(Rim(), kCavity, kCovered, request_);
  EXPECT_FALSE(FillWalls(made_->mesh, request_).has_value()) << "nobody knows";
  request_.state_at = [](VertexId vertex) {
    return vertex == VertexId(9) ? StateAround{true, 6} : StateAround{};
  };
  const auto filling = FillWalls(made_->mesh, request_);
  ASSERT_TRUE(filling.has_value());
  EXPECT_DOUBLE_EQ(AreaOf(*filling, 6), 9);
}

TEST_F(FillWallsTest, RefusesWallsThatCrossOrDisagree) {
  FillRequest crossing = request_;
  crossing.walls = {{VertexId(0), VertexId(10), kOut, kOut}};  // Over point 5.
  EXPECT_FALSE(FillWalls(made_->mesh, crossing).has_value());
  FillRequest open = request_;
  open.walls = {{VertexId(0), VertexId(1), Region(0), kOut}};
  EXPECT_FALSE(FillWalls(made_->mesh, open).has_value()) << "no loop holds the region";
  FillRequest differing = request_;
  AddLoop(Rim(), Region(4), kOut, differing);
  AddLoop(Middle(), Region(2), Region(5), differing);
  EXPECT_FALSE(FillWalls(made_->mesh, differing).has_value());
}

}  // namespace
}  // namespace pliant
