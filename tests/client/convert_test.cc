#include "client/cpp/convert.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/fake_server.h"
#include "tests/client/model_mesh.h"

namespace pliant::client {
namespace {

using testing::ElementsAre;

// Small arrays travel inside their messages: no chunk may come.
struct Wire {
  wire::ColumnWriter writer{[](const v1::BlobChunk&) { ADD_FAILURE() << "a chunk"; }};
  wire::ColumnReader reader{1024};

  template <class Scalar, std::size_t kColumns, class Row>
  std::vector<Row> Read(const v1::Array& array) {
    Result<std::vector<Row>> rows = reader.Read<Scalar, kColumns, Row>(array, "array");
    EXPECT_TRUE(rows.ok());
    return std::move(rows).value();
  }
};

MeshData Triangles(std::vector<Vec2> points, std::vector<std::array<std::int32_t, 3>> triangles) {
  MeshData mesh;
  mesh.points = std::move(points);
  mesh.triangles = std::move(triangles);
  return mesh;
}

MetricSpec Spec(decltype(MetricSpec::source) source, double time = 0) {
  MetricSpec spec;
  spec.source = std::move(source);
  spec.time = time;
  return spec;
}

TEST(Convert, ADomainArrivesWhole) {
  const Domain domain{.points = {{0, 0}, {1, 0}, {0.1, 1e-300}},
                      .segments = {{0, 1, -7}, {1, 2, 0}, {2, 0, 9}},
                      .holes = {{0.25, 0.125}},
                      .regions = {{{0.5, 0.5}, 3}}};
  Wire wire;
  const v1::Domain message = ToWire(domain, wire.writer);
  EXPECT_EQ((wire.Read<double, 2, Vec2>(message.points())), domain.points);
  using Pair = std::array<std::int32_t, 2>;
  EXPECT_THAT((wire.Read<std::int32_t, 2, Pair>(message.segments())),
              ElementsAre(Pair{0, 1}, Pair{1, 2}, Pair{2, 0}));
  EXPECT_THAT((wire.Read<std::int32_t, 1, std::int32_t>(message.segment_tags())),
              ElementsAre(-7, 0, 9));
  EXPECT_EQ((wire.Read<double, 2, Vec2>(message.holes())), domain.holes);
  EXPECT_THAT((wire.Read<double, 2, Vec2>(message.region_points())), ElementsAre(Vec2{0.5, 0.5}));
  EXPECT_THAT((wire.Read<std::int32_t, 1, std::int32_t>(message.region_tags())), ElementsAre(3));
}

TEST(Convert, AMeshArrivesWholeAndLeavesOutWhatIsNotThere) {
  const MeshData mesh{.points = {{0, 0}, {1, 0}, {0, 1}},
                      .triangles = {{0, 1, 2}},
                      .triangle_tags = {4},
                      .edges = {{1, 2}},
                      .edge_tags = {5}};
  Wire wire;
  const v1::MeshInput message = ToWire(mesh, wire.writer);
  EXPECT_EQ((wire.Read<double, 2, Vec2>(message.points())), mesh.points);
  EXPECT_EQ((wire.Read<std::int32_t, 3, std::array<std::int32_t, 3>>(message.triangles())),
            mesh.triangles);
  EXPECT_EQ((wire.Read<std::int32_t, 1, std::int32_t>(message.triangle_tags())),
            mesh.triangle_tags);
  EXPECT_EQ((wire.Read<std::int32_t, 2, std::array<std::int32_t, 2>>(message.edges())), mesh.edges);
  EXPECT_EQ((wire.Read<std::int32_t, 1, std::int32_t>(message.edge_tags())), mesh.edge_tags);

  const v1::MeshInput bare = ToWire(Triangles(mesh.points, mesh.triangles), wire.writer);
  EXPECT_FALSE(bare.has_edges());
  EXPECT_FALSE(bare.has_edge_tags());
  EXPECT_FALSE(bare.has_triangle_tags());
}

// Goal: nothing of an earlier specification is left on the server when another one is sent.
TEST(Convert, AMetricSaysEverythingAboutItself) {
  Wire wire;
  const v1::MetricUpdate message = ToWire(Spec(SizeMetric{"x"}), wire.writer);
  ASSERT_EQ(message.sources_size(), 1);
  EXPECT_EQ(message.sources(0).size().size(), "x");
  EXPECT_TRUE(message.has_time());
  EXPECT_TRUE(message.limits().has_size_min());
  EXPECT_TRUE(message.limits().has_size_max());
  EXPECT_TRUE(message.limits().has_anisotropy_max());
  EXPECT_TRUE(message.limits().has_gradation());
  EXPECT_TRUE(message.limits().has_rotation());
  EXPECT_TRUE(message.limits().has_geometry());
  EXPECT_TRUE(message.limits().has_gap_element_count());
  EXPECT_TRUE(message.limits().has_smoothing_count());
  EXPECT_TRUE(message.limits().automatic());
}

TEST(Convert, AnIntersectionIsSeveralSources) {
  Wire wire;
  const IntersectedMetric both{{SizeMetric{"x"}, ExpressionMetric{"1", "0", "2"}}};
  const v1::MetricUpdate message = ToWire(Spec(both, 2.5), wire.writer);
  ASSERT_EQ(message.sources_size(), 2);
  EXPECT_EQ(message.sources(0).size().size(), "x");
  EXPECT_EQ(message.sources(1).expression().m22(), "2");
  EXPECT_EQ(message.time(), 2.5);
}

TEST(Convert, ABackgroundMetricCarriesItsMesh) {
  const MeshData mesh = Triangles({{0, 0}, {1, 0}, {0, 1}}, {{0, 1, 2}});
  const std::vector<Metric> tensors = {{1, 0, 1}, {2, 0.5, 3}, {4, -1, 5}};
  Wire wire;
  const v1::MetricUpdate message = ToWire(Spec(BackgroundMetric{mesh, tensors}, 2.5), wire.writer);
  const v1::BackgroundMetric& background = message.sources(0).background();
  EXPECT_EQ((wire.Read<double, 2, Vec2>(background.mesh().points())), mesh.points);
  EXPECT_EQ((wire.Read<double, 3, Metric>(background.tensors())), tensors);
  EXPECT_EQ(message.time(), 2.5);
}

TEST(Convert, TensorsWithoutIdsAreThoseOfAllVertices) {
  const std::vector<Metric> tensors = {{1, 0, 1}};
  const std::vector<VertexId> ids = {VertexId(12)};
  Wire wire;
  const v1::MetricUpdate some = ToWire(VertexTensors{Revision{3}, ids, tensors}, wire.writer);
  EXPECT_EQ(some.sources(0).vertices().revision(), 3);
  EXPECT_EQ((wire.Read<std::int32_t, 1, VertexId>(some.sources(0).vertices().vertex_ids())), ids);
  const v1::MetricUpdate all = ToWire(VertexTensors{Revision{3}, {}, tensors}, wire.writer);
  EXPECT_FALSE(all.sources(0).vertices().has_vertex_ids());
}

TEST(Convert, OnlyOptionsThatDifferFromTheDefaultsAreSent) {
  EXPECT_EQ(ToWire(Options()).ByteSizeLong(), 0U);
  Options options;
  options.variant = Variant::kPaper;
  options.smoothing = Smoothing::kBubble;
  options.permissions = {.insert = false, .swap = true, .move = false};
  options.seed = 1ULL << 63;
  options.step = 0.2;
  options.speed_threshold = 0.02;
  options.age_cooling = 31;
  options.age_max = 81;
  options.hops_max = 9;
  options.metric_tolerance = 0;
  options.boundary_tolerance = 0.25;
  options.vertices_max = 100;
  options.visits_per_vertex_max = 7;
  const v1::SessionOptions message = ToWire(options);
  EXPECT_EQ(message.variant(), v1::VARIANT_PAPER);
  EXPECT_EQ(message.smoothing(), v1::SMOOTHING_BUBBLE);
  EXPECT_THAT(message.restrictions(),
              ElementsAre(v1::RESTRICTION_NO_INSERT, v1::RESTRICTION_NO_MOVE));
  EXPECT_EQ(message.seed(), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(message.step(), 0.2);
  EXPECT_EQ(message.speed_threshold(), 0.02);
  EXPECT_EQ(message.age_cooling(), 31);
  EXPECT_EQ(message.age_max(), 81);
  EXPECT_EQ(message.hops_max(), 9);
  EXPECT_TRUE(message.has_metric_tolerance());
  EXPECT_EQ(message.metric_tolerance(), 0);
  EXPECT_EQ(message.boundary_tolerance(), 0.25);
  EXPECT_EQ(message.vertices_max(), 100);
  EXPECT_EQ(message.visits_per_vertex_max(), 7);
}

TEST(Convert, EveryVariantHasItsName) {
  const auto variant = [](Variant value) {
    Options options;
    options.variant = value;
    return ToWire(options).variant();
  };
  EXPECT_EQ(variant(Options().variant), v1::VARIANT_UNSPECIFIED) << "the default is left out";
  EXPECT_EQ(variant(Variant::kCooled), v1::VARIANT_COOLED);
  EXPECT_EQ(variant(Variant::kPaper), v1::VARIANT_PAPER);
}

TEST(Convert, DiffsAndSnapshotsComeBackAsTheyWere) {
  ModelChanger changer(/*seed=*/5);
  const ModelMesh first = changer.Next({}, 30);
  const ModelMesh second = changer.Next(first, 10);
  const MeshDiff diff = DiffOf(first, second);
  Wire wire;
  v1::MeshDiff message;
  WriteElements(diff, wire.writer, message);
  const Result<MeshDiff> back = FromWire(message, wire.reader);
  ASSERT_TRUE(back.ok()) << back.error().message;
  EXPECT_EQ(back->base_revision, diff.base_revision);
  EXPECT_EQ(back->revision, diff.revision);
  EXPECT_EQ(back->removed_vertices, diff.removed_vertices);
  EXPECT_EQ(back->removed_triangles, diff.removed_triangles);
  EXPECT_EQ(back->removed_edges, diff.removed_edges);
  EXPECT_EQ(back->vertex_ids, diff.vertex_ids);
  EXPECT_EQ(back->vertex_positions, diff.vertex_positions);
  EXPECT_EQ(back->triangle_ids, diff.triangle_ids);
  EXPECT_EQ(back->triangle_vertices, diff.triangle_vertices);
  EXPECT_EQ(back->triangle_regions, diff.triangle_regions);
  EXPECT_EQ(back->edge_ids, diff.edge_ids);
  EXPECT_EQ(back->edge_vertices, diff.edge_vertices);
  EXPECT_EQ(back->edge_tags, diff.edge_tags);
  EXPECT_EQ(back->metric_vertex_ids, diff.metric_vertex_ids);
  EXPECT_EQ(back->metrics, diff.metrics);
  EXPECT_EQ(back->summary, diff.summary);

  v1::MeshSnapshot snapshot;
  WriteElements(DiffOf({}, second), wire.writer, snapshot);
  snapshot.mutable_metric()->clear_vertex_ids();
  const Result<MeshDiff> whole = FromWire(snapshot, wire.reader);
  ASSERT_TRUE(whole.ok());
  EXPECT_EQ(whole->base_revision, Revision::kNone);
  EXPECT_EQ(whole->metric_vertex_ids, whole->vertex_ids) << "absent means all live vertices";
}

TEST(Convert, AColumnOfAnotherTypeIsNamed) {
  Wire wire;
  v1::MeshDiff message;
  *message.mutable_removed_edges() = wire.writer.Write<double, 1, double>(std::vector<double>{1});
  const Result<MeshDiff> diff = FromWire(message, wire.reader);
  ASSERT_FALSE(diff.ok());
  EXPECT_EQ(diff.error().code, ErrorCode::kArrayType);
  EXPECT_EQ(diff.error().field, "removed_edges");
}

TEST(Convert, QualityNeedsTheHistogramsOfThisVersion) {
  v1::QualityReport report;
  report.mutable_counts()->set_vertex_count(4);
  report.mutable_counts()->set_triangle_count(2);
  report.set_edge_count(5);
  report.set_q_min(0.5);
  report.mutable_integrated()->set_share_125(0.75);
  report.mutable_angle_deg()->set_high(180);
  report.mutable_averaged()->mutable_histogram()->set_high(2);
  for (int i = 0; i < 60; ++i) {
    report.mutable_angle_deg()->add_counts(i);
    report.mutable_averaged()->mutable_histogram()->add_counts(2 * i);
  }
  const Result<Quality> quality = FromWire(report);
  ASSERT_TRUE(quality.ok());
  EXPECT_EQ(quality->vertex_count, 4);
  EXPECT_EQ(quality->edge_count, 5);
  EXPECT_EQ(quality->q_min, 0.5);
  EXPECT_EQ(quality->integrated.share_125, 0.75);
  EXPECT_EQ(quality->angles.counts[59], 59);
  EXPECT_EQ(quality->lengths.counts[59], 118);
  EXPECT_EQ(quality->lengths.upper, 2);

  report.mutable_angle_deg()->add_counts(1);
  EXPECT_EQ(FromWire(report).error().code, ErrorCode::kArrayLength);
}

TEST(Convert, ReadsTroubles) {
  v1::AdvanceResult result;
  v1::Trouble& wire = *result.add_troubles();
  wire.set_kind(v1::TROUBLE_KIND_CROSSED);
  wire.set_vertex_count(1);
  wire.set_place_count(2);
  wire.set_center_x(3);
  wire.set_center_y(4);
  wire.mutable_box()->set_x_min(5);
  wire.mutable_box()->set_y_min(6);
  wire.mutable_box()->set_x_max(7);
  wire.mutable_box()->set_y_max(8);
  wire.set_q_min(9);
  wire.set_length_min(10);
  wire.set_length_max(11);
  const Trouble trouble = FromWire(result).troubles.at(0);
  EXPECT_EQ(trouble.kind, TroubleKind::kCrossed);
  EXPECT_EQ(trouble.vertex_count, 1);
  EXPECT_EQ(trouble.place_count, 2);
  EXPECT_EQ(trouble.center, (Vec2{3, 4}));
  EXPECT_EQ(trouble.box.low, (Vec2{5, 6}));
  EXPECT_EQ(trouble.box.high, (Vec2{7, 8}));
  EXPECT_EQ(trouble.q_min, 9);
  EXPECT_EQ(trouble.length_min, 10);
  EXPECT_EQ(trouble.length_max, 11);

  const auto kind = [&](v1::TroubleKind named) {
    wire.set_kind(named);
    return FromWire(result).troubles.at(0).kind;
  };
  EXPECT_EQ(kind(v1::TROUBLE_KIND_SIZE_JUMP), TroubleKind::kSizeJump);
  EXPECT_EQ(kind(v1::TROUBLE_KIND_GEOMETRY), TroubleKind::kGeometry);
  EXPECT_EQ(kind(v1::TROUBLE_KIND_CURVATURE), TroubleKind::kCurvature);
  EXPECT_EQ(kind(v1::TROUBLE_KIND_VERTEX_LIMIT), TroubleKind::kVertexLimit);
  EXPECT_EQ(kind(v1::TROUBLE_KIND_UNSETTLED), TroubleKind::kUnsettled);
}

TEST(Convert, ReadsWhatOnlySomeAdvancesTell) {
  v1::AdvanceResult result;
  EXPECT_EQ(FromWire(result).motion_fraction, std::nullopt);
  EXPECT_EQ(FromWire(result).durable_revision, std::nullopt);
  result.set_motion_fraction(0.5);
  result.set_durable_revision(0);
  result.set_softened_count(3);
  const AdvanceReport report = FromWire(result);
  EXPECT_EQ(report.motion_fraction, 0.5);
  EXPECT_EQ(report.durable_revision, Revision::kNone);
  EXPECT_EQ(report.softened_count, 3);
}

TEST(Convert, StopReasonsKeepTheirMeaning) {
  const auto stop = [](v1::StopReason reason) {
    v1::AdvanceResult result;
    result.set_stop_reason(reason);
    return FromWire(result).stop;
  };
  EXPECT_EQ(stop(v1::STOP_REASON_CONVERGED), AdvanceStop::kConverged);
  EXPECT_EQ(stop(v1::STOP_REASON_VISIT_BUDGET), AdvanceStop::kVisitBudget);
  EXPECT_EQ(stop(v1::STOP_REASON_TIME_BUDGET), AdvanceStop::kTimeBudget);
  EXPECT_EQ(stop(v1::STOP_REASON_CANCELLED), AdvanceStop::kCancelled);
  EXPECT_EQ(stop(v1::STOP_REASON_VERTEX_LIMIT), AdvanceStop::kVertexLimit);
  EXPECT_EQ(stop(v1::STOP_REASON_VISIT_LIMIT), AdvanceStop::kVisitLimit);
  EXPECT_EQ(stop(v1::STOP_REASON_SERVER_CLOSING), AdvanceStop::kServerClosing);
  EXPECT_EQ(stop(v1::STOP_REASON_STAGING), AdvanceStop::kStaging);
}

TEST(Convert, PutsTheStagesOfTheLimitsTogether) {
  v1::AdvanceResult result;
  EXPECT_EQ(FromWire(result).metric, MetricReport{});
  const auto add = [&](v1::LimitStage stage, std::int64_t vertex_count) {
    v1::LimitReport& limit = *result.add_limits();
    limit.set_stage(stage);
    limit.set_vertex_count(vertex_count);
    limit.set_ratio_max(4);
    limit.set_worst_vertex_id(5);
    limit.set_complexity_before(6);
    limit.set_complexity_after(7);
  };
  add(v1::LIMIT_STAGE_SMOOTHING, 8);
  add(v1::LIMIT_STAGE_GEOMETRY, 1);
  add(v1::LIMIT_STAGE_ROTATION, 2);
  add(v1::LIMIT_STAGE_GRADATION, 3);
  EXPECT_EQ(FromWire(result).metric, (MetricReport{.limits = true,
                                                   .smoothing_count = 8,
                                                   .geometry_count = 1,
                                                   .rotation_count = 2,
                                                   .gradation_count = 3,
                                                   .size_ratio_max = 4,
                                                   .worst = VertexId(5),
                                                   .raw_complexity = 6,
                                                   .limited_complexity = 7}));
}

}  // namespace
}  // namespace pliant::client
