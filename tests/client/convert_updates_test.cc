#include "client/cpp/convert_updates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace pliant::client {
namespace {

using testing::ElementsAre;

class ConvertUpdates : public testing::Test {
 protected:
  wire::ColumnWriter writer_{[](v1::BlobChunk) { ADD_FAILURE() << "small arrays travel inside"; }};
  wire::ColumnReader reader_{1 << 20};
};

TEST_F(ConvertUpdates, WritesEveryShapeOfAMotion) {
  MotionRequest motion;
  motion.vertices = {VertexId(4)};
  motion.positions = {{1, 2}};
  motion.tags = {{{1}, Translation{{0.5, -1}}},
                 {{2}, Rotation{{3, 4}, 0.25}},
                 {{3}, AffineMap{1, 2, 3, 4, {5, 6}}},
                 {{4, 5}, PolynomialPath{{{7, 8}, {9, 10}}}}};
  motion.on_impossible = ImpossibleMotion::kStop;
  motion.follow_length = 2;
  const v1::BoundaryUpdate wire = ToWire(motion, Revision{6}, writer_);
  EXPECT_EQ(wire.vertices().revision(), 6);
  EXPECT_EQ(wire.vertices().positions().shape(1), 2);
  ASSERT_EQ(wire.tags_size(), 4);
  EXPECT_EQ(wire.tags(0).translation().y(), -1);
  EXPECT_EQ(wire.tags(1).rotation().angle_rad(), 0.25);
  EXPECT_EQ(wire.tags(1).rotation().center_y(), 4);
  EXPECT_EQ(wire.tags(2).affine().a21(), 3);
  EXPECT_EQ(wire.tags(2).affine().b2(), 6);
  EXPECT_THAT(wire.tags(3).path().y(), ElementsAre(8, 10));
  EXPECT_THAT(wire.tags(3).tags(), ElementsAre(4, 5));
  EXPECT_EQ(wire.on_impossible(), v1::IMPOSSIBLE_MOTION_STOP);
  EXPECT_EQ(wire.metric_follow_length(), 2);
}

TEST_F(ConvertUpdates, NamesNoVerticesWhereAllAreMeant) {
  const std::vector<Vec2> positions{{0, 0}, {1, 1}};
  const v1::NodeUpdate wire =
      ToWire({.revision = Revision{2}, .vertices = {}, .positions = positions}, writer_);
  EXPECT_FALSE(wire.vertices().has_vertex_ids());
  EXPECT_EQ(wire.vertices().positions().shape(0), 2);
  EXPECT_EQ(wire.on_impossible(), v1::IMPOSSIBLE_MOTION_REFUSE);
}

TEST_F(ConvertUpdates, WritesDisplacements) {
  const std::vector<VertexId> vertices{VertexId(7), VertexId(3)};
  const std::vector<Vec2> by{{0.5, 1}, {2, -3}};
  const v1::MetricDisplacement wire = DisplacementToWire(vertices, by, Revision{4}, writer_);
  EXPECT_EQ(wire.revision(), 4);
  EXPECT_EQ(wire.vertex_ids().shape(0), 2);
  EXPECT_EQ(wire.displacements().shape(1), 2);
}

TEST_F(ConvertUpdates, WritesConstraints) {
  const Constraints constraints{.vertices = {VertexId(1)},
                                .edges = {EdgeId(2), EdgeId(3)},
                                .regions = {-4},
                                .permissions = {false, false, false, false}};
  const v1::ConstraintUpdate wire = ToWire(constraints, Revision{9}, writer_);
  EXPECT_EQ(wire.revision(), 9);
  EXPECT_EQ(wire.frozen_vertices().shape(0), 1);
  EXPECT_EQ(wire.frozen_edges().shape(0), 2);
  EXPECT_THAT(wire.frozen_regions(), ElementsAre(-4));
  EXPECT_THAT(wire.restrictions(),
              ElementsAre(v1::RESTRICTION_NO_INSERT, v1::RESTRICTION_NO_SWAP,
                          v1::RESTRICTION_NO_MOVE, v1::RESTRICTION_NO_SURFACE));
}

// Defaults too: an update must be able to go back to them. Seed and variant are not said at all.
TEST_F(ConvertUpdates, SaysAllOptionsThatMayChange) {
  const v1::SessionOptions wire = AllToWire(Options{.seed = 5, .hops_max = 3});
  EXPECT_FALSE(wire.has_seed() || wire.has_variant() || wire.has_vertices_max());
  EXPECT_EQ(wire.hops_max(), 3);
  EXPECT_EQ(wire.metric_tolerance(), Options().metric_tolerance);
  EXPECT_TRUE(wire.has_boundary_tolerance());
  EXPECT_EQ(wire.boundary_tolerance(), 0);
  EXPECT_EQ(wire.age_max(), Options().age_max);
  EXPECT_EQ(wire.smoothing(), v1::SMOOTHING_PLIANT);
  EXPECT_EQ(AllToWire(Options{.vertices_max = 77}).vertices_max(), 77);
}

TEST_F(ConvertUpdates, FieldsComeBackAsTheyWent) {
  FieldUpdate update;
  update.values.push_back({.name = "v", .column_count = 2, .values = {1, 2, 3, 4}});
  update.values[0].ids = std::vector<std::int32_t>{5, 8};
  update.transfer = TransferKind::kConservative;
  update.dropped_names = {"old"};
  v1::FieldUpdate wire = ToWire(update, Revision{3}, writer_);
  EXPECT_EQ(wire.transfer(), v1::TRANSFER_CONSERVATIVE);
  EXPECT_EQ(wire.revision(), 3);
  wire.add_values()->set_name("gone");  // Without location: dropped, in a diff.
  const Result<FieldChanges> changes = FieldsFromWire(wire.values(), reader_);
  ASSERT_TRUE(changes.ok()) << changes.error().message;
  ASSERT_EQ(changes->changed.size(), 1U);
  EXPECT_EQ(changes->changed[0].column_count, 2U);
  EXPECT_THAT(changes->changed[0].rows.slots, ElementsAre(5, 8));
  EXPECT_THAT(changes->changed[0].rows.values, ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(changes->dropped_names, ElementsAre("gone"));
  wire.mutable_values(0)->clear_ids();
  EXPECT_EQ(FieldsFromWire(wire.values(), reader_).error().code, ErrorCode::kArrayLength);
}

TEST_F(ConvertUpdates, RefusesTransferRowsOfDifferentLengths) {
  const std::vector<VertexId> ids{VertexId(1), VertexId(2)};
  const std::vector<std::array<VertexId, 3>> sources{{VertexId(0), VertexId(-1), VertexId(-1)}};
  const std::vector<std::array<double, 3>> weights{{1, 0, 0}};
  v1::TransferRows wire;
  *wire.mutable_vertex_ids() =
      writer_.Write<std::int32_t, 1>(std::span<const VertexId>(ids).first(1));
  *wire.mutable_sources() = writer_.Write<std::int32_t, 3>(std::span(sources));
  *wire.mutable_weights() = writer_.Write<double, 3>(std::span(weights));
  const Result<TransferRows> rows = FromWire(wire, reader_);
  ASSERT_TRUE(rows.ok());
  EXPECT_EQ(rows->rows[0].sources[0], VertexId(0));
  *wire.mutable_vertex_ids() = writer_.Write<std::int32_t, 1>(std::span<const VertexId>(ids));
  EXPECT_EQ(FromWire(wire, reader_).error().code, ErrorCode::kArrayLength);
}

}  // namespace
}  // namespace pliant::client
