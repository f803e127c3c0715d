#include "server/convert_motion.h"

#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

#include "server/limits.h"
#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

using test::Doubles;
using test::Ints;

TEST(ConvertMotion, ReadsEveryShape) {
  v1::BoundaryUpdate wire;
  v1::TagMotion* motion = wire.add_tags();
  motion->add_tags(3);
  motion->add_tags(-4);
  motion->mutable_translation()->set_x(1.5);
  motion->mutable_translation()->set_y(-2);
  motion = wire.add_tags();
  motion->mutable_rotation()->set_center_x(1);
  motion->mutable_rotation()->set_center_y(2);
  motion->mutable_rotation()->set_angle_rad(3);
  v1::Affine& affine = *wire.add_tags()->mutable_affine();
  affine.set_a11(1);
  affine.set_a12(2);
  affine.set_a21(3);
  affine.set_a22(4);
  affine.set_b1(5);
  affine.set_b2(6);
  v1::PolynomialPath& path = *wire.add_tags()->mutable_path();
  path.add_x(1);
  path.add_x(2);
  path.add_y(3);
  path.add_y(4);
  wire.set_on_impossible(v1::IMPOSSIBLE_MOTION_STOP);
  wire.set_metric_follow_length(2.5);

  const Result<MotionUpdate> update = ConvertBoundaryUpdate(wire);
  ASSERT_TRUE(update.ok());
  EXPECT_EQ(update->field, "boundary");
  EXPECT_FALSE(update->revision.has_value());
  EXPECT_EQ(update->request.on_impossible, ImpossibleMotion::kStop);
  EXPECT_EQ(update->request.follow_length, 2.5);
  const std::vector<TagMotion>& tags = update->request.tags;
  ASSERT_EQ(tags.size(), 4U);
  EXPECT_EQ(tags[0].tags, (std::vector<std::int32_t>{3, -4}));
  EXPECT_EQ(std::get<Translation>(tags[0].shape).by, (Vec2{1.5, -2}));
  EXPECT_EQ(std::get<Rotation>(tags[1].shape).center, (Vec2{1, 2}));
  EXPECT_EQ(std::get<Rotation>(tags[1].shape).angle_rad, 3);
  const AffineMap& map = std::get<AffineMap>(tags[2].shape);
  EXPECT_EQ((std::vector<double>{map.a11, map.a12, map.a21, map.a22, map.b.x, map.b.y}),
            (std::vector<double>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(std::get<PolynomialPath>(tags[3].shape).coefficients,
            (std::vector<Vec2>{{1, 3}, {2, 4}}));
}

TEST(ConvertMotion, ReadsPositionsOfSomeAndOfAll) {
  v1::NodeUpdate wire;
  wire.mutable_vertices()->set_revision(7);
  *wire.mutable_vertices()->mutable_positions() = Doubles({1, 2, 3, 4}, 2);
  Result<MotionUpdate> update = ConvertNodeUpdate(wire);
  ASSERT_TRUE(update.ok());
  EXPECT_EQ(update->field, "nodes");
  EXPECT_EQ(update->revision, Revision(7));
  EXPECT_TRUE(update->names_all);
  EXPECT_EQ(update->request.positions[1], (Vec2{3, 4}));
  EXPECT_EQ(update->request.on_impossible, ImpossibleMotion::kRefuse);

  *wire.mutable_vertices()->mutable_vertex_ids() = Ints({5, 6});
  wire.set_on_impossible(v1::IMPOSSIBLE_MOTION_STOP);
  update = ConvertNodeUpdate(wire);
  ASSERT_TRUE(update.ok());
  EXPECT_FALSE(update->names_all);
  EXPECT_EQ(update->request.vertices[0], VertexId(5));
  EXPECT_EQ(update->request.on_impossible, ImpossibleMotion::kStop);
}

struct Complaint {
  ErrorCode code;
  std::string field;
  bool operator==(const Complaint&) const = default;
};

template <class Update>
Complaint RefusalOf(const Result<Update>& update) {
  return update.ok() ? Complaint{ErrorCode::kUnavailable, "none"}
                     : Complaint{update.error().code, update.error().field};
}

TEST(ConvertMotion, RefusesWhatItCannotRead) {
  v1::BoundaryUpdate wire;
  EXPECT_EQ(RefusalOf(ConvertBoundaryUpdate(wire)), (Complaint{ErrorCode::kEmpty, "boundary"}));
  wire.add_tags();
  EXPECT_EQ(RefusalOf(ConvertBoundaryUpdate(wire)),
            (Complaint{ErrorCode::kEmpty, "boundary.tags"}));
  wire.mutable_tags(0)->mutable_path()->add_x(1);
  EXPECT_EQ(RefusalOf(ConvertBoundaryUpdate(wire)),
            (Complaint{ErrorCode::kArrayLength, "boundary.tags"}));
  wire.mutable_tags(0)->mutable_translation();
  wire.set_on_impossible(v1::IMPOSSIBLE_MOTION_UNSPECIFIED);
  EXPECT_EQ(RefusalOf(ConvertBoundaryUpdate(wire)),
            (Complaint{ErrorCode::kOutOfRange, "boundary.on_impossible"}));
  wire.clear_on_impossible();
  *wire.mutable_vertices()->mutable_positions() = Doubles({1, 2, 3}, 3);
  EXPECT_EQ(RefusalOf(ConvertBoundaryUpdate(wire)),
            (Complaint{ErrorCode::kArrayLength, "boundary.vertices.positions"}));
  *wire.mutable_vertices()->mutable_positions() = Doubles({1, 2, 3, 4}, 2);
  *wire.mutable_vertices()->mutable_vertex_ids() = Ints({1});
  EXPECT_EQ(RefusalOf(ConvertBoundaryUpdate(wire)),
            (Complaint{ErrorCode::kArrayLength, "boundary.vertices.positions"}));
  v1::NodeUpdate nodes;
  EXPECT_EQ(RefusalOf(ConvertNodeUpdate(nodes)), (Complaint{ErrorCode::kEmpty, "nodes.vertices"}));
}

TEST(ConvertMotion, TakesAsManyMotionsByTagAsTheLimitSays) {
  v1::BoundaryUpdate wire;
  for (std::size_t i = 0; i < kTagMotionsMax; ++i) wire.add_tags()->mutable_translation();
  EXPECT_TRUE(ConvertBoundaryUpdate(wire).ok());
  wire.add_tags()->mutable_translation();
  EXPECT_EQ(RefusalOf(ConvertBoundaryUpdate(wire)),
            (Complaint{ErrorCode::kTooLarge, "boundary.tags"}));
}

}  // namespace
}  // namespace pliant::server
