#include "server/convert_reply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

using test::NumbersOf;
using testing::ElementsAre;

MeshDiff SomeDiff() {
  MeshDiff diff;
  diff.base_revision = Revision(3);
  diff.revision = Revision(4);
  diff.removed_vertices = {VertexId(1)};
  diff.removed_triangles = {TriangleId(2), TriangleId(3)};
  diff.removed_edges = {EdgeId(4)};
  diff.vertex_ids = {VertexId(0), VertexId(5), VertexId(7)};
  diff.vertex_positions = {{0, 1}, {2, 3}, {4, 5}};
  diff.triangle_ids = {TriangleId(9)};
  diff.triangle_vertices = {{VertexId(0), VertexId(7), VertexId(5)}};
  diff.triangle_regions = {-6};
  diff.edge_ids = {EdgeId(8)};
  diff.edge_vertices = {{VertexId(7), VertexId(0)}};
  diff.edge_tags = {11};
  diff.metric_vertex_ids = {VertexId(7)};
  diff.metrics = {{1, 2, 5}};
  diff.summary = {
      .vertex_count = 30, .triangle_count = 40, .edge_count = 50, .state_hash = 0xfedcba9876543210};
  return diff;
}

TEST(ConvertReply, WritesEveryColumnOfADiff) {
  const v1::MeshDiff wire = ToMeshDiff(SomeDiff(), {.applied_update_id = 77});
  EXPECT_EQ(wire.base_revision(), 3);
  EXPECT_EQ(wire.revision(), 4);
  EXPECT_EQ(wire.applied_update_id(), 77);
  EXPECT_THAT(NumbersOf<std::int32_t>(wire.removed_vertices()), ElementsAre(1));
  EXPECT_THAT(NumbersOf<std::int32_t>(wire.removed_triangles()), ElementsAre(2, 3));
  EXPECT_THAT(NumbersOf<std::int32_t>(wire.removed_edges()), ElementsAre(4));
  EXPECT_THAT(NumbersOf<std::int32_t>(wire.vertex_ids()), ElementsAre(0, 5, 7));
  EXPECT_THAT(NumbersOf<double>(wire.vertex_positions()), ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_EQ(wire.vertex_positions().shape(0), 3);
  EXPECT_EQ(wire.vertex_positions().shape(1), 2);
  EXPECT_THAT(NumbersOf<std::int32_t>(wire.triangle_ids()), ElementsAre(9));
  EXPECT_THAT(NumbersOf<std::int32_t>(wire.triangle_vertices()), ElementsAre(0, 7, 5));
  EXPECT_THAT(NumbersOf<std::int32_t>(wire.triangle_tags()), ElementsAre(-6));
  EXPECT_THAT(NumbersOf<std::int32_t>(wire.edge_ids()), ElementsAre(8));
  EXPECT_THAT(NumbersOf<std::int32_t>(wire.edge_vertices()), ElementsAre(7, 0));
  EXPECT_THAT(NumbersOf<std::int32_t>(wire.edge_tags()), ElementsAre(11));
  EXPECT_EQ(wire.counts().edge_count(), 50);
  EXPECT_EQ(wire.state_hash(), 0xfedcba9876543210);
  EXPECT_FALSE(wire.has_metric()) << "not asked for";
}

TEST(ConvertReply, WritesTheMetricOnlyWhereItIsWanted) {
  const v1::MeshDiff wire = ToMeshDiff(SomeDiff(), {.parts = {.metric = true}});
  EXPECT_THAT(NumbersOf<std::int32_t>(wire.metric().vertex_ids()), ElementsAre(7));
  EXPECT_THAT(NumbersOf<double>(wire.metric().tensors()), ElementsAre(1, 2, 5));
}

TEST(ConvertReply, NumbersASnapshotBySlotsOrDensely) {
  const v1::MeshSnapshot stable = ToMeshSnapshot(SomeDiff(), {});
  EXPECT_EQ(stable.numbering(), v1::NUMBERING_STABLE);
  EXPECT_THAT(NumbersOf<std::int32_t>(stable.triangle_vertices()), ElementsAre(0, 7, 5));
  const v1::MeshSnapshot dense = ToMeshSnapshot(SomeDiff(), {.numbering = v1::NUMBERING_DENSE});
  EXPECT_THAT(NumbersOf<std::int32_t>(dense.vertex_ids()), ElementsAre(0, 5, 7));
  EXPECT_THAT(NumbersOf<std::int32_t>(dense.triangle_vertices()), ElementsAre(0, 2, 1));
  EXPECT_THAT(NumbersOf<std::int32_t>(dense.edge_vertices()), ElementsAre(2, 0));
  EXPECT_EQ(dense.state_hash(), stable.state_hash());
}

// Goal: no number of an advance's result is swapped with another: each has a value of its own.
TEST(ConvertReply, WritesEveryNumberOfAnAdvance) {
  const SessionEvent event{
      .update_id = 5,
      .revision = Revision(4),
      .body = AdvancedEvent{.base_revision = Revision(3),
                            .summary = SomeDiff().summary,
                            .progress = {.stop_reason = StopReason::kVertexLimit,
                                         .active_count = 10,
                                         .counts = {.visits = 11,
                                                    .moves = 12,
                                                    .insertions = 13,
                                                    .deletions = 14,
                                                    .swaps = 15,
                                                    .cooled = 16}},
                            .troubles = {{.kind = TroubleKind::kCurvature,
                                          .vertex_count = 20,
                                          .place_count = 21,
                                          .center = {22, 23},
                                          .box = {{24, 25}, {26, 27}},
                                          .q_min = 28,
                                          .length_min = 29,
                                          .length_max = 30}},
                            .softened_count = 31,
                            .compute = std::chrono::microseconds(17),
                            .elapsed = std::chrono::microseconds(18)}};
  const v1::EditResponse response = ToEditResponse(event, {});
  EXPECT_EQ(response.update_id(), 5);
  EXPECT_EQ(response.revision(), 4);
  const v1::AdvanceResult& result = response.advanced();
  EXPECT_EQ(result.base_revision(), 3);
  EXPECT_EQ(result.revision(), 4);
  EXPECT_EQ(result.stop_reason(), v1::STOP_REASON_VERTEX_LIMIT);
  EXPECT_EQ(result.counts().triangle_count(), 40);
  EXPECT_EQ(result.state_hash(), 0xfedcba9876543210);
  EXPECT_EQ(result.active_count(), 10);
  EXPECT_EQ(result.visit_count(), 11);
  EXPECT_EQ(result.move_count(), 12);
  EXPECT_EQ(result.insertion_count(), 13);
  EXPECT_EQ(result.deletion_count(), 14);
  EXPECT_EQ(result.swap_count(), 15);
  EXPECT_EQ(result.cooled_count(), 16);
  EXPECT_EQ(result.softened_count(), 31);
  EXPECT_EQ(result.compute_us(), 17);
  EXPECT_EQ(result.elapsed_us(), 18);
  ASSERT_EQ(result.troubles_size(), 1);
  const v1::Trouble& trouble = result.troubles(0);
  EXPECT_EQ(trouble.kind(), v1::TROUBLE_KIND_CURVATURE);
  EXPECT_EQ(trouble.vertex_count(), 20);
  EXPECT_EQ(trouble.place_count(), 21);
  EXPECT_EQ(trouble.center_x(), 22);
  EXPECT_EQ(trouble.center_y(), 23);
  EXPECT_EQ(trouble.box().x_min(), 24);
  EXPECT_EQ(trouble.box().y_min(), 25);
  EXPECT_EQ(trouble.box().x_max(), 26);
  EXPECT_EQ(trouble.box().y_max(), 27);
  EXPECT_EQ(trouble.q_min(), 28);
  EXPECT_EQ(trouble.length_min(), 29);
  EXPECT_EQ(trouble.length_max(), 30);
}

TEST(ConvertReply, WritesTheStagesThatLimitSomething) {
  Progress progress;
  progress.metric = {.limits = true,
                     .smoothing_count = 8,
                     .geometry_count = 1,
                     .rotation_count = 0,
                     .gradation_count = 3,
                     .changed_count = 9,
                     .size_ratio_max = 4,
                     .worst = VertexId(5),
                     .raw_complexity = 6,
                     .limited_complexity = 7};
  AdvancedEvent advanced;
  advanced.progress = progress;
  SessionEvent event;
  event.body = advanced;
  const v1::EditResponse response = ToEditResponse(event, {});
  const auto& limits = response.advanced().limits();
  ASSERT_EQ(limits.size(), 3);
  EXPECT_EQ(limits[0].stage(), v1::LIMIT_STAGE_SMOOTHING);
  EXPECT_EQ(limits[0].vertex_count(), 8);
  EXPECT_EQ(limits[1].stage(), v1::LIMIT_STAGE_GEOMETRY);
  EXPECT_EQ(limits[1].vertex_count(), 1);
  EXPECT_EQ(limits[2].stage(), v1::LIMIT_STAGE_GRADATION);
  EXPECT_EQ(limits[2].vertex_count(), 3);
  EXPECT_EQ(limits[2].ratio_max(), 4);
  EXPECT_EQ(limits[2].worst_vertex_id(), 5);
  EXPECT_EQ(limits[2].complexity_before(), 6);
  EXPECT_EQ(limits[2].complexity_after(), 7);
}

TEST(ConvertReply, NamesEveryKindOfTrouble) {
  const auto kind_of = [](TroubleKind kind) {
    const SessionEvent event{.body = AdvancedEvent{.troubles = {{.kind = kind}}}};
    return ToEditResponse(event, {}).advanced().troubles(0).kind();
  };
  EXPECT_EQ(kind_of(TroubleKind::kGeometry), v1::TROUBLE_KIND_GEOMETRY);
  EXPECT_EQ(kind_of(TroubleKind::kVertexLimit), v1::TROUBLE_KIND_VERTEX_LIMIT);
  EXPECT_EQ(kind_of(TroubleKind::kCrossed), v1::TROUBLE_KIND_CROSSED);
  EXPECT_EQ(kind_of(TroubleKind::kCurvature), v1::TROUBLE_KIND_CURVATURE);
  EXPECT_EQ(kind_of(TroubleKind::kSizeJump), v1::TROUBLE_KIND_SIZE_JUMP);
  EXPECT_EQ(kind_of(TroubleKind::kUnsettled), v1::TROUBLE_KIND_UNSETTLED);
}

TEST(ConvertReply, NamesEveryReasonToStop) {
  const auto reason_of = [](StopReason stop, AdvanceEnd end) {
    const SessionEvent event{
        .body = AdvancedEvent{.progress = {.stop_reason = stop, .counts = {}}, .end = end}};
    return ToEditResponse(event, {}).advanced().stop_reason();
  };
  const AdvanceEnd engine = AdvanceEnd::kEngine;
  EXPECT_EQ(reason_of(StopReason::kConverged, engine), v1::STOP_REASON_CONVERGED);
  EXPECT_EQ(reason_of(StopReason::kVisitBudget, engine), v1::STOP_REASON_VISIT_BUDGET);
  EXPECT_EQ(reason_of(StopReason::kCancelled, engine), v1::STOP_REASON_CANCELLED);
  EXPECT_EQ(reason_of(StopReason::kVertexLimit, engine), v1::STOP_REASON_VERTEX_LIMIT);
  EXPECT_EQ(reason_of(StopReason::kVisitLimit, engine), v1::STOP_REASON_VISIT_LIMIT);
  EXPECT_EQ(reason_of(StopReason::kVisitBudget, AdvanceEnd::kTimeBudget),
            v1::STOP_REASON_TIME_BUDGET);
  EXPECT_EQ(reason_of(StopReason::kCancelled, AdvanceEnd::kServerClosing),
            v1::STOP_REASON_SERVER_CLOSING);
  EXPECT_EQ(reason_of(StopReason::kVisitBudget, AdvanceEnd::kStaging), v1::STOP_REASON_STAGING);
}

TEST(ConvertReply, DescribesASession) {
  SessionInfo info{.session_id = "a", .labels = {{"case", "7"}}};
  v1::Session wire = ToSession(info);
  EXPECT_FALSE(wire.has_counts()) << "before the first commit";
  EXPECT_EQ(wire.state(), v1::SESSION_STATE_IDLE);
  info.revision = Revision(2);
  info.summary = SomeDiff().summary;
  info.running = true;
  info.create_time = std::chrono::system_clock::time_point(std::chrono::milliseconds(1500));
  wire = ToSession(info);
  EXPECT_EQ(wire.revision(), 2);
  EXPECT_EQ(wire.counts().vertex_count(), 30);
  EXPECT_EQ(wire.state(), v1::SESSION_STATE_RUNNING);
  EXPECT_EQ(wire.create_time().seconds(), 1);
  EXPECT_EQ(wire.create_time().nanos(), 500'000'000);
  EXPECT_EQ(wire.labels().at("case"), "7");
}

}  // namespace
}  // namespace pliant::server
