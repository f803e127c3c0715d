#include "server/record_values.h"

#include <gtest/gtest.h>

#include <span>

namespace pliant::server {
namespace {

// What Put writes and Take reads again; every shorter piece of it must fail and not crash.
template <class Value, class Put, class Take>
Value Again(const Value& value, Put put, Take take) {
  ByteWriter writer;
  put(value, writer);
  const Bytes bytes = std::move(writer).Take();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    ByteReader reader(std::span<const std::byte>(bytes).first(size));
    static_cast<void>(take(reader));
    EXPECT_FALSE(reader.ok()) << "cut at " << size << " of " << bytes.size();
  }
  ByteReader reader(bytes);
  Value again = take(reader);
  EXPECT_TRUE(reader.AtEnd());
  return again;
}

UpdateAnswer AdvancedAnswer() {
  AdvancedEvent advanced;
  advanced.base_revision = Revision(3);
  advanced.summary = {5, 6, 7, 0xfedcba9876543210};
  advanced.progress.stop_reason = StopReason::kVertexLimit;
  advanced.progress.active_count = 8;
  advanced.progress.counts = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  advanced.progress.metric = {true, 9, 1, 2, 3, 4, 5, VertexId(6), 7, 8};
  advanced.troubles = {{.kind = TroubleKind::kSizeJump,
                        .vertex_count = 3,
                        .place_count = 2,
                        .center = {1, 2},
                        .box = {{3, 4}, {5, 6}},
                        .q_min = 7,
                        .length_min = 8,
                        .length_max = 9}};
  advanced.end = AdvanceEnd::kServerClosing;
  advanced.motion_fraction = 0.5;
  advanced.softened_count = 13;
  advanced.compute = std::chrono::microseconds(11);
  advanced.elapsed = std::chrono::microseconds(12);
  return {.event = {.update_id = 41, .revision = Revision(4), .body = advanced},
          .update = {UpdateKind::kAdvance, 0x123456789abcdef0}};
}

TEST(RecordValues, KeepsAdvancedAnswers) {
  const UpdateAnswer answer = Again(AdvancedAnswer(), PutAnswer, TakeAnswer);
  EXPECT_EQ(answer.update, AdvancedAnswer().update);
  const SessionEvent& event = answer.event;
  EXPECT_EQ(event.update_id, 41);
  EXPECT_EQ(event.revision, Revision(4));
  const auto& advanced = std::get<AdvancedEvent>(event.body);
  const AdvancedEvent expected = std::get<AdvancedEvent>(AdvancedAnswer().event.body);
  EXPECT_EQ(advanced.base_revision, Revision(3));
  EXPECT_EQ(advanced.summary, expected.summary);
  EXPECT_EQ(advanced.progress.stop_reason, StopReason::kVertexLimit);
  EXPECT_EQ(advanced.progress.active_count, 8);
  EXPECT_EQ(advanced.progress.counts, expected.progress.counts);
  EXPECT_EQ(advanced.progress.metric, expected.progress.metric);
  ASSERT_EQ(advanced.troubles.size(), 1u);
  const Trouble& trouble = advanced.troubles[0];
  EXPECT_EQ(trouble.kind, TroubleKind::kSizeJump);
  EXPECT_EQ(trouble.vertex_count, 3);
  EXPECT_EQ(trouble.place_count, 2);
  EXPECT_EQ(trouble.center.y, 2);
  EXPECT_EQ(trouble.box.low.x, 3);
  EXPECT_EQ(trouble.box.high.y, 6);
  EXPECT_EQ(trouble.q_min, 7);
  EXPECT_EQ(trouble.length_max, 9);
  EXPECT_EQ(advanced.end, AdvanceEnd::kServerClosing);
  EXPECT_EQ(advanced.motion_fraction, 0.5);
  EXPECT_EQ(advanced.softened_count, 13);
  EXPECT_EQ(advanced.compute.count(), 11);
  EXPECT_EQ(advanced.elapsed.count(), 12);
}

// Goal: one without softened corners is written as it was before there were any.
TEST(RecordValues, KeepsAdvancedAnswersWithoutSoftenedCorners) {
  UpdateAnswer answer = AdvancedAnswer();
  ByteWriter writer;
  PutAnswer(answer, writer);
  const std::size_t bytes = std::move(writer).Take().size();
  std::get<AdvancedEvent>(answer.event.body).softened_count = 0;
  ByteWriter shorter;
  PutAnswer(answer, shorter);
  EXPECT_EQ(std::move(shorter).Take().size(), bytes - sizeof(std::int64_t));
  const UpdateAnswer again = Again(answer, PutAnswer, TakeAnswer);
  EXPECT_EQ(std::get<AdvancedEvent>(again.event.body).softened_count, 0);
  EXPECT_EQ(std::get<AdvancedEvent>(again.event.body).elapsed.count(), 12);
}

TEST(RecordValues, KeepsOtherAnswers) {
  const Fingerprint metric{UpdateKind::kMetric, 3};
  const UpdateAnswer accepted = Again(
      UpdateAnswer{{.update_id = 1, .revision = Revision(2), .body = AcceptedEvent{7}}, metric},
      PutAnswer, TakeAnswer);
  EXPECT_EQ(std::get<AcceptedEvent>(accepted.event.body).staged_count, 7);
  EXPECT_EQ(accepted.update, metric);
  for (int code = 0; code <= static_cast<int>(ErrorCode::kInternal); ++code) {
    const Error error{static_cast<ErrorCode>(code), "message", "field", 5, 6};
    const SessionEvent event =
        Again(UpdateAnswer{{.update_id = 9, .body = RejectedEvent{error}}, metric}, PutAnswer,
              TakeAnswer)
            .event;
    const Error& again = std::get<RejectedEvent>(event.body).error;
    EXPECT_EQ(again.code, error.code) << ErrorCodeName(error.code);
    EXPECT_EQ(again.message + again.field, "messagefield");
    EXPECT_EQ(again.index + again.other_index, 11);
  }
}

// Goal: answers of before there were fingerprints are read: these bytes were written then.
TEST(RecordValues, ReadsAnswersWithoutAFingerprint) {
  ByteWriter writer;
  writer.Put(std::int64_t{5});  // update_id
  writer.Put(std::int64_t{2});  // revision
  writer.Put(std::uint8_t{1});  // accepted
  writer.Put(std::int32_t{3});  // staged_count
  const Bytes old = std::move(writer).Take();
  ByteReader reader(old);
  const UpdateAnswer answer = TakeAnswer(reader);
  EXPECT_TRUE(reader.AtEnd());
  EXPECT_EQ(answer.event.update_id, 5);
  EXPECT_EQ(std::get<AcceptedEvent>(answer.event.body).staged_count, 3);
  EXPECT_EQ(answer.update, Fingerprint{});
  ByteWriter again;
  PutAnswer(answer, again);
  EXPECT_EQ(std::move(again).Take(), old) << "it stays without one";
}

TEST(RecordValues, RefusesAnswersThatTheirUpdateCannotHave) {
  for (const UpdateKind kind :
       {UpdateKind::kAdvance, UpdateKind::kRollback, UpdateKind{3}, UpdateKind{14}}) {
    ByteWriter writer;
    PutAnswer({{.update_id = 5, .body = AcceptedEvent{}}, {kind, 1}}, writer);
    const Bytes bytes = std::move(writer).Take();
    ByteReader reader(bytes);
    static_cast<void>(TakeAnswer(reader));
    EXPECT_FALSE(reader.ok()) << static_cast<int>(kind);
  }
}

TEST(RecordValues, KeepsDiffsWhole) {
  MeshDiff diff;
  diff.base_revision = Revision(1);
  diff.revision = Revision(2);
  diff.removed_vertices = {VertexId(1)};
  diff.removed_triangles = {TriangleId(2), TriangleId(3)};
  diff.removed_edges = {EdgeId(4)};
  diff.vertex_ids = {VertexId(5)};
  diff.vertex_positions = {{1, 2}};
  diff.triangle_ids = {TriangleId(6)};
  diff.triangle_vertices = {{VertexId(1), VertexId(2), VertexId(3)}};
  diff.triangle_regions = {7};
  diff.edge_ids = {EdgeId(8)};
  diff.edge_vertices = {{VertexId(1), VertexId(2)}};
  diff.edge_tags = {9};
  diff.created_vertices = {VertexId(5)};
  diff.created_triangles = {TriangleId(6)};
  diff.created_edges = {EdgeId(8)};
  diff.metric_vertex_ids = {VertexId(5)};
  diff.metrics = {Metric::Isotropic(0.5)};
  diff.transfer = TransferRows{{VertexId(5)}, {{{VertexId(1), VertexId(2)}, {0.5, 0.5, 0}}}};
  diff.fields.changed = {{"u", FieldLocation::kTriangle, 2, {{3}, {1, 2}}}};
  diff.fields.dropped_names = {"v"};
  diff.summary = {1, 2, 3, 4};
  const MeshDiff again = Again(diff, PutDiff, TakeDiff);
  EXPECT_EQ(again.base_revision, diff.base_revision);
  EXPECT_EQ(again.revision, diff.revision);
  EXPECT_EQ(again.removed_vertices, diff.removed_vertices);
  EXPECT_EQ(again.removed_triangles, diff.removed_triangles);
  EXPECT_EQ(again.removed_edges, diff.removed_edges);
  EXPECT_EQ(again.vertex_ids, diff.vertex_ids);
  EXPECT_EQ(again.vertex_positions[0].y, 2);
  EXPECT_EQ(again.triangle_ids, diff.triangle_ids);
  EXPECT_EQ(again.triangle_vertices, diff.triangle_vertices);
  EXPECT_EQ(again.triangle_regions, diff.triangle_regions);
  EXPECT_EQ(again.edge_ids, diff.edge_ids);
  EXPECT_EQ(again.edge_vertices, diff.edge_vertices);
  EXPECT_EQ(again.edge_tags, diff.edge_tags);
  EXPECT_EQ(again.created_vertices, diff.created_vertices);
  EXPECT_EQ(again.created_triangles, diff.created_triangles);
  EXPECT_EQ(again.created_edges, diff.created_edges);
  EXPECT_EQ(again.metric_vertex_ids, diff.metric_vertex_ids);
  EXPECT_EQ(again.metrics.size(), 1u);
  EXPECT_EQ(again.transfer, diff.transfer);
  EXPECT_EQ(again.fields, diff.fields);
  EXPECT_EQ(again.summary, diff.summary);
}

TEST(RecordValues, RefusesColumnsThatDoNotFit) {
  MeshDiff diff;
  diff.vertex_ids = {VertexId(5)};
  ByteWriter writer;
  PutDiff(diff, writer);
  const Bytes bytes = std::move(writer).Take();
  ByteReader reader(bytes);
  static_cast<void>(TakeDiff(reader));
  EXPECT_FALSE(reader.ok()) << "an id without a position";
}

TEST(RecordValues, KeepsTimesAndBytes) {
  const Clock::WallTime time(std::chrono::seconds(1'700'000'000) + std::chrono::nanoseconds(7));
  EXPECT_EQ(Again(time, PutTime, TakeTime), time);
  const Bytes bytes(9, std::byte{3});
  EXPECT_EQ(Again(
                bytes, [](const Bytes& b, ByteWriter& w) { PutBytes(b, w); }, TakeBytes),
            bytes);
}

}  // namespace
}  // namespace pliant::server
