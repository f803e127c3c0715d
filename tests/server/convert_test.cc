#include "server/convert.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "server/limits.h"
#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

using test::Doubles;
using test::Ints;

constexpr RequestLimits kLimits{.vertices_max = 1000};

void ExpectRefused(const v1::CreateSession& create, ErrorCode code, const std::string& field) {
  const Result<SessionInput> input = ConvertCreate(create, kLimits);
  ASSERT_FALSE(input.ok()) << "expected " << ErrorCodeName(code) << " in " << field;
  EXPECT_EQ(ErrorCodeName(input.error().code), ErrorCodeName(code));
  EXPECT_EQ(input.error().field, field);
}

TEST(ConvertCreate, ReadsADomainAMetricAndOptions) {
  v1::CreateSession create = test::UnitSquare("0.1 + x");
  create.set_session_id("flap.3");
  create.mutable_metric()->set_time(2.5);
  create.mutable_metric()->mutable_limits()->set_size_min(0.01);
  create.mutable_metric()->mutable_limits()->set_size_max(1);
  create.mutable_metric()->mutable_limits()->set_anisotropy_max(100);
  create.mutable_metric()->mutable_limits()->set_gradation(1.5);
  create.mutable_metric()->mutable_limits()->set_rotation(0.7);
  create.mutable_metric()->mutable_limits()->set_geometry(1);
  create.mutable_metric()->mutable_limits()->set_gap_element_count(3);
  create.mutable_metric()->mutable_limits()->set_smoothing_count(2);
  v1::SessionOptions& options = *create.mutable_options();
  options.set_seed(-1);
  options.set_variant(v1::VARIANT_PAPER);
  options.set_smoothing(v1::SMOOTHING_BUBBLE);
  options.set_step(0.25);
  options.set_hops_max(4);
  options.set_vertices_max(500);
  options.add_restrictions(v1::RESTRICTION_NO_SWAP);
  options.set_durability(v1::DURABILITY_NONE);
  (*create.mutable_labels())["case"] = "7";
  const Result<SessionInput> input = ConvertCreate(create, kLimits);
  ASSERT_TRUE(input.ok()) << input.error().message;
  EXPECT_EQ(input->session_id, "flap.3");
  EXPECT_EQ(input->labels.at("case"), "7");
  EXPECT_EQ(std::get<Domain>(input->engine.start).points.size(), 4U);
  EXPECT_EQ(std::get<SizeMetric>(input->engine.metric.source).size, "0.1 + x");
  EXPECT_EQ(input->engine.metric.time, 2.5);
  EXPECT_EQ(input->engine.metric.bounds,
            (SizeBounds{.size_min = 0.01, .size_max = 1, .anisotropy_max = 100}));
  EXPECT_EQ(input->engine.metric.gradation.gradation, 1.5);
  EXPECT_EQ(input->engine.metric.gradation.rotation, 0.7);
  EXPECT_EQ(input->engine.metric.gradation.geometry, 1);
  EXPECT_EQ(input->engine.metric.gradation.gap_element_count, 3);
  EXPECT_EQ(input->engine.metric.gradation.smoothing_count, 2);
  EXPECT_EQ(input->durability, Durability::kNone);
  EXPECT_EQ(input->engine.options.seed, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(input->engine.options.variant, Variant::kPaper);
  EXPECT_EQ(input->engine.options.smoothing, Smoothing::kBubble);
  EXPECT_EQ(input->engine.options.step, 0.25);
  EXPECT_EQ(input->engine.options.hops_max, 4);
  EXPECT_EQ(input->engine.options.vertices_max, 500);
  EXPECT_FALSE(input->engine.options.permissions.swap);
  EXPECT_TRUE(input->engine.options.permissions.insert);
}

// Goal: limits come into force by themselves only where nobody has chosen any.
TEST(ConvertCreate, ChosenLimitsAreNotAutomatic) {
  const auto is_automatic = [](auto set) {
    v1::CreateSession create = test::UnitSquare();
    set(*create.mutable_metric()->mutable_limits());
    const Result<SessionInput> input = ConvertCreate(create, kLimits);
    EXPECT_TRUE(input.ok());
    return input->engine.metric.gradation.automatic;
  };
  EXPECT_TRUE(is_automatic([](v1::MetricLimits&) {}));
  EXPECT_TRUE(is_automatic([](v1::MetricLimits& limits) { limits.set_geometry(1); }));
  EXPECT_FALSE(is_automatic([](v1::MetricLimits& limits) { limits.set_gradation(0); }));
  EXPECT_FALSE(is_automatic([](v1::MetricLimits& limits) { limits.set_rotation(0.7); }));
  EXPECT_FALSE(is_automatic([](v1::MetricLimits& limits) { limits.set_automatic(false); }));
  EXPECT_TRUE(is_automatic([](v1::MetricLimits& limits) {
    limits.set_gradation(0);
    limits.set_automatic(true);
  }));
}

TEST(ConvertCreate, KeepsTheEnginesDefaultsWhereNothingIsSaid) {
  const Result<SessionInput> input = ConvertCreate(test::UnitSquare(), kLimits);
  ASSERT_TRUE(input.ok());
  Options expected;
  expected.vertices_max = kLimits.vertices_max;  // The server allows no more.
  EXPECT_EQ(input->engine.options, expected);
}

TEST(ConvertCreate, TakesTensorsOfAMeshAsItsBackground) {
  const Result<SessionInput> input = ConvertCreate(test::TwoTriangles(), kLimits);
  ASSERT_TRUE(input.ok());
  const auto& background = std::get<BackgroundMetric>(input->engine.metric.source);
  EXPECT_EQ(background.mesh, std::get<MeshData>(input->engine.start));
  EXPECT_EQ(background.tensors.size(), 4U);
  EXPECT_EQ(background.tensors[3], (Metric{25, 0, 25}));
}

TEST(ConvertCreate, RefusesWhatIsMissing) {
  v1::CreateSession create = test::UnitSquare();
  create.clear_start();
  ExpectRefused(create, ErrorCode::kEmpty, "domain");
  create = test::UnitSquare();
  create.clear_metric();
  ExpectRefused(create, ErrorCode::kEmpty, "metric.sources");
  create = test::UnitSquare();
  create.mutable_metric()->mutable_sources(0)->clear_source();
  ExpectRefused(create, ErrorCode::kEmpty, "metric.sources");
  ExpectRefused(test::UnitSquare(""), ErrorCode::kEmpty, "metric.size");
}

TEST(ConvertCreate, IntersectsSeveralSources) {
  v1::CreateSession create = test::UnitSquare();
  const std::string size = create.metric().sources(0).size().size();
  create.mutable_metric()->add_sources()->mutable_expression()->set_m11("1");
  create.mutable_metric()->mutable_sources(1)->mutable_expression()->set_m12("0");
  create.mutable_metric()->mutable_sources(1)->mutable_expression()->set_m22("4");
  const auto input = ConvertCreate(create, kLimits);
  ASSERT_TRUE(input.ok());
  EXPECT_EQ(std::get<IntersectedMetric>(input->engine.metric.source),
            (IntersectedMetric{{SizeMetric{size}, ExpressionMetric{"1", "0", "4"}}}));

  create.mutable_metric()->mutable_sources(1)->mutable_size()->set_size("");
  const auto refused = ConvertCreate(create, kLimits);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kEmpty);
  EXPECT_EQ(refused.error().message.find("metric.sources[1]: "), 0U) << refused.error().message;

  create = test::UnitSquare();
  while (create.metric().sources_size() < 17) {
    *create.mutable_metric()->add_sources() = create.metric().sources(0);
  }
  ExpectRefused(create, ErrorCode::kTooLarge, "metric.sources");
}

TEST(ConvertCreate, TakesTensorsOnAGrid) {
  v1::CreateSession create = test::UnitSquare();
  v1::GridMetric& grid = *create.mutable_metric()->mutable_sources(0)->mutable_grid();
  grid.set_origin_x(-1);
  grid.set_step_x(2);
  grid.set_step_y(3);
  grid.set_column_count(2);
  *grid.mutable_tensors() = Doubles({1, 0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4}, 3);
  const auto input = ConvertCreate(create, kLimits);
  ASSERT_TRUE(input.ok());
  const auto& background = std::get<BackgroundMetric>(input->engine.metric.source);
  EXPECT_EQ(background.mesh.points, (std::vector<Vec2>{{-1, 0}, {1, 0}, {-1, 3}, {1, 3}}));
  EXPECT_EQ(background.tensors[2], (Metric{3, 0, 3}));

  grid.set_column_count(3);
  ExpectRefused(create, ErrorCode::kArrayLength, "metric.grid.tensors");
  grid.set_column_count(-1);
  ExpectRefused(create, ErrorCode::kOutOfRange, "metric.grid.column_count");
}

TEST(ConvertCreate, RefusesTensorsWithoutVertices) {
  v1::CreateSession create = test::UnitSquare();
  *create.mutable_metric()->mutable_sources(0) = test::TwoTriangles().metric().sources(0);
  ExpectRefused(create, ErrorCode::kProtocolOrder, "metric.sources");
}

TEST(ConvertCreate, RefusesTensorsThatAreNotOneForEachPoint) {
  v1::CreateSession create = test::TwoTriangles();
  v1::VertexMetric& vertices = *create.mutable_metric()->mutable_sources(0)->mutable_vertices();
  *vertices.mutable_tensors() = Doubles({1, 0, 1}, 3);
  ExpectRefused(create, ErrorCode::kArrayLength, "metric.tensors");
  create = test::TwoTriangles();
  *create.mutable_metric()->mutable_sources(0)->mutable_vertices()->mutable_vertex_ids() =
      Ints({0, 1, 2, 3});
  ExpectRefused(create, ErrorCode::kOutOfRange, "metric.vertex_ids");
}

TEST(ConvertCreate, RefusesEnumsThatAreUnspecifiedOrUnknown) {
  v1::CreateSession create = test::UnitSquare();
  create.mutable_options()->set_variant(v1::VARIANT_UNSPECIFIED);
  ExpectRefused(create, ErrorCode::kOutOfRange, "options.variant");
  create = test::UnitSquare();
  create.mutable_options()->set_smoothing(static_cast<v1::Smoothing>(99));
  ExpectRefused(create, ErrorCode::kOutOfRange, "options.smoothing");
  create = test::UnitSquare();
  create.mutable_options()->add_restrictions(v1::RESTRICTION_UNSPECIFIED);
  ExpectRefused(create, ErrorCode::kOutOfRange, "options.restrictions");
}

TEST(ConvertCreate, TakesHowMuchHistoryIsKept) {
  v1::CreateSession create = test::UnitSquare();
  EXPECT_EQ(ConvertCreate(create, kLimits)->history_bytes_max, std::nullopt);
  for (const std::int64_t bytes : {std::int64_t{0}, kKeptBytesMax}) {
    create.mutable_options()->set_history_bytes_max(bytes);
    EXPECT_EQ(ConvertCreate(create, kLimits)->history_bytes_max, bytes);
  }
  for (const std::int64_t bytes : {std::int64_t{-1}, kKeptBytesMax + 1}) {
    create.mutable_options()->set_history_bytes_max(bytes);
    ExpectRefused(create, ErrorCode::kOutOfRange, "options.history_bytes_max");
  }
  v1::EditRequest later;
  later.set_update_id(1);
  later.mutable_options()->set_history_bytes_max(0);
  const UpdateCommand command = ConvertUpdate(later, kLimits);
  const auto* bad = std::get_if<BadUpdate>(&command.body);
  ASSERT_NE(bad, nullptr);
  EXPECT_EQ(bad->error.code, ErrorCode::kOutOfRange);
  EXPECT_EQ(bad->error.field, "options.history_bytes_max");
}

TEST(ConvertCreate, SaysWhatIsNotImplementedInsteadOfIgnoringIt) {
  const auto with = [](auto change) {
    v1::CreateSession create = test::UnitSquare();
    change(create);
    return create;
  };
  ExpectRefused(with([](auto& c) { c.mutable_metric()->mutable_displacement(); }),
                ErrorCode::kUnimplemented, "metric.displacement");
  ExpectRefused(with([](auto& c) { c.mutable_metric()->mutable_sources(0)->mutable_distance(); }),
                ErrorCode::kUnimplemented, "metric.sources");
  ExpectRefused(with([](auto& c) { c.mutable_metric()->add_sources()->mutable_vertices(); }),
                ErrorCode::kProtocolOrder, "metric.sources");
  ExpectRefused(
      with([](auto& c) { c.mutable_options()->set_durability(v1::DURABILITY_UNSPECIFIED); }),
      ErrorCode::kOutOfRange, "options.durability");
}

TEST(ConvertCreate, TakesSizesAtTheirBoundAndNotOneMore) {
  EXPECT_TRUE(
      ConvertCreate(test::UnitSquare(std::string(kExpressionLengthMax, '1')), kLimits).ok());
  ExpectRefused(test::UnitSquare(std::string(kExpressionLengthMax + 1, '1')), ErrorCode::kTooLarge,
                "metric.size");

  v1::CreateSession create = test::UnitSquare();
  create.set_session_id(std::string(kSessionIdLengthMax, 'a'));
  EXPECT_TRUE(ConvertCreate(create, kLimits).ok());
  create.set_session_id(std::string(kSessionIdLengthMax + 1, 'a'));
  ExpectRefused(create, ErrorCode::kOutOfRange, "session_id");
  create.set_session_id("a/b");
  ExpectRefused(create, ErrorCode::kOutOfRange, "session_id");

  create = test::UnitSquare();
  for (std::size_t i = 0; i < kLabelsMax; ++i) (*create.mutable_labels())[std::to_string(i)] = "";
  EXPECT_TRUE(ConvertCreate(create, kLimits).ok());
  (*create.mutable_labels())["one more"] = "";
  ExpectRefused(create, ErrorCode::kTooLarge, "labels");
  create = test::UnitSquare();
  (*create.mutable_labels())["k"] = std::string(kLabelLengthMax, 'v');
  EXPECT_TRUE(ConvertCreate(create, kLimits).ok());
  (*create.mutable_labels())["k"] = std::string(kLabelLengthMax + 1, 'v');
  ExpectRefused(create, ErrorCode::kTooLarge, "labels");

  create = test::UnitSquare();
  create.mutable_options()->set_vertices_max(1000);
  EXPECT_TRUE(ConvertCreate(create, kLimits).ok());
  create.mutable_options()->set_vertices_max(1001);
  ExpectRefused(create, ErrorCode::kOutOfRange, "options.vertices_max");
  create.mutable_options()->set_vertices_max(4);
  EXPECT_TRUE(ConvertCreate(create, kLimits).ok());
  create.mutable_options()->set_vertices_max(3);
  ExpectRefused(create, ErrorCode::kTooLarge, "domain.points");
}

TEST(ConvertAdvance, ReadsBudgetsAndRefusesThoseOutOfRange) {
  v1::Advance wire;
  EXPECT_EQ(ConvertAdvance(wire)->visits_max, INT64_MAX);
  wire.set_budget_visits(5);
  wire.set_budget_ms(7);
  wire.set_progress_interval_ms(kProgressIntervalMsMin);
  const Result<AdvanceSpec> spec = ConvertAdvance(wire);
  ASSERT_TRUE(spec.ok());
  EXPECT_EQ(spec->visits_max, 5);
  EXPECT_EQ(*spec->time_max, std::chrono::milliseconds(7));
  EXPECT_EQ(*spec->progress_interval, std::chrono::milliseconds(kProgressIntervalMsMin));

  const auto field_of = [](const v1::Advance& advance) {
    const auto result = ConvertAdvance(advance);
    return result.ok() ? std::string("accepted") : result.error().field;
  };
  v1::Advance bad = wire;
  bad.set_budget_visits(0);
  EXPECT_EQ(field_of(bad), "advance.budget_visits");
  bad = wire;
  bad.set_budget_ms(-1);
  EXPECT_EQ(field_of(bad), "advance.budget_ms");
  bad.set_budget_ms(INT64_MAX);
  EXPECT_EQ(field_of(bad), "advance.budget_ms");
  bad = wire;
  bad.set_progress_interval_ms(kProgressIntervalMsMin - 1);
  EXPECT_EQ(field_of(bad), "advance.progress_interval_ms");
  bad = wire;
  bad.set_commit_interval_ms(9);
  EXPECT_EQ(field_of(bad), "advance.commit_interval_ms");
  bad = {};
  bad.set_progress_interval_ms(INT64_MAX);
  EXPECT_NE(ConvertAdvance(bad).error().message.find("it must be from 10 to 31622400000 (a year)"),
            std::string::npos)
      << ConvertAdvance(bad).error().message;
}

TEST(ConvertUpdate, TurnsEveryKindThatIsNotImplementedIntoItsRefusal) {
  const auto code_of = [](const v1::EditRequest& request) {
    const UpdateCommand command = ConvertUpdate(request, kLimits);
    EXPECT_EQ(command.update_id, 6);
    const BadUpdate* bad = std::get_if<BadUpdate>(&command.body);
    return bad == nullptr ? ErrorCode::kUnavailable : bad->error.code;
  };
  v1::EditRequest request;
  request.set_update_id(6);
  request.mutable_metric()->add_sources()->mutable_solution()->mutable_field()->set_name("u");
  request.mutable_metric()->mutable_displacement();
  EXPECT_EQ(code_of(request), ErrorCode::kUnimplemented) << "values of vertices where they were";
}

TEST(ConvertUpdate, TakesMotions) {
  v1::EditRequest request;
  request.mutable_boundary();
  EXPECT_TRUE(std::holds_alternative<BadUpdate>(ConvertUpdate(request, kLimits).body))
      << "moves nothing";
  v1::TagMotion& motion = *request.mutable_boundary()->add_tags();
  motion.add_tags(3);
  motion.mutable_translation()->set_x(1);
  EXPECT_TRUE(std::holds_alternative<MotionUpdate>(ConvertUpdate(request, kLimits).body));
  request.mutable_nodes();
  EXPECT_TRUE(std::holds_alternative<BadUpdate>(ConvertUpdate(request, kLimits).body))
      << "moves nothing";
  request.mutable_nodes()->mutable_vertices()->set_revision(1);
  EXPECT_TRUE(std::holds_alternative<MotionUpdate>(ConvertUpdate(request, kLimits).body));
}

TEST(ConvertUpdate, TakesDomainsAndDisplacements) {
  v1::EditRequest request;
  request.mutable_domain();
  EXPECT_TRUE(std::holds_alternative<BadUpdate>(ConvertUpdate(request, kLimits).body)) << "empty";
  *request.mutable_domain()->mutable_domain() = test::UnitSquare().domain();
  const UpdateCommand domain = ConvertUpdate(request, kLimits);
  ASSERT_TRUE(std::holds_alternative<DomainUpdate>(domain.body));
  EXPECT_EQ(std::get<DomainUpdate>(domain.body).domain.points.size(), 4U);
  v1::MetricDisplacement& moved = *request.mutable_metric()->mutable_displacement();
  moved.set_revision(3);
  *moved.mutable_vertex_ids() = test::Ints({5, 2});
  *moved.mutable_displacements() = test::Doubles({0.5, 1, 2, 3}, 2);
  const UpdateCommand metric = ConvertUpdate(request, kLimits);
  ASSERT_TRUE(std::holds_alternative<MetricUpdate>(metric.body));
  const auto& update = std::get<MetricUpdate>(metric.body).displacement;
  ASSERT_TRUE(update.has_value());
  EXPECT_EQ(update->revision, Revision(3));
  EXPECT_EQ(update->vertices, (std::vector{VertexId(5), VertexId(2)}));
  EXPECT_EQ(update->by[1], (Vec2{2, 3}));
  v1::VertexMetric& vertices = *request.mutable_metric()->add_sources()->mutable_vertices();
  vertices.set_revision(3);
  *vertices.mutable_tensors() = test::Doubles({1, 0, 1}, 3);
  const UpdateCommand with_tensors = ConvertUpdate(request, kLimits);
  ASSERT_TRUE(std::holds_alternative<MetricUpdate>(with_tensors.body));
  const auto& both = std::get<MetricUpdate>(with_tensors.body);
  EXPECT_TRUE(std::holds_alternative<VertexTensors>(both.source));
  EXPECT_TRUE(both.displacement.has_value());
  request.mutable_metric()->clear_sources();
  *moved.mutable_vertex_ids() = test::Ints({5});
  const UpdateCommand uneven = ConvertUpdate(request, kLimits);
  ASSERT_TRUE(std::holds_alternative<BadUpdate>(uneven.body));
  EXPECT_EQ(std::get<BadUpdate>(uneven.body).error.code, ErrorCode::kArrayLength);
}

// Goal: a bad advance does not count as a bad update: it leaves the stage as it is.
TEST(ConvertUpdate, TellsBadUpdatesFromBadAdvances) {
  v1::EditRequest request;
  request.mutable_advance()->set_budget_visits(-3);
  EXPECT_TRUE(std::holds_alternative<BadAdvance>(ConvertUpdate(request, kLimits).body));
  request.mutable_metric()->set_time(NAN);
  EXPECT_TRUE(std::holds_alternative<BadUpdate>(ConvertUpdate(request, kLimits).body));
  request.mutable_discard();
  EXPECT_TRUE(std::holds_alternative<DiscardUpdate>(ConvertUpdate(request, kLimits).body));
  request.mutable_fields()->set_transfer(v1::TRANSFER_BOUNDED);
  EXPECT_TRUE(std::holds_alternative<FieldsUpdate>(ConvertUpdate(request, kLimits).body));
  request.mutable_fields()->set_transfer(v1::TRANSFER_UNSPECIFIED);
  EXPECT_TRUE(std::holds_alternative<BadUpdate>(ConvertUpdate(request, kLimits).body));
}

TEST(ConvertParts, KnowsItsPartsAndRefusesTheRest) {
  v1::GetMeshRequest request;
  EXPECT_FALSE(ConvertParts(request.parts())->metric);
  request.add_parts(v1::MESH_PART_METRIC);
  EXPECT_TRUE(ConvertParts(request.parts())->metric);
  EXPECT_FALSE(ConvertParts(request.parts())->transfer);
  request.add_parts(v1::MESH_PART_TRANSFER);
  EXPECT_TRUE(ConvertParts(request.parts())->transfer);
  EXPECT_FALSE(ConvertParts(request.parts())->fields);
  request.set_parts(1, v1::MESH_PART_FIELDS);
  EXPECT_TRUE(ConvertParts(request.parts())->fields);
  request.set_parts(1, v1::MESH_PART_RAW_METRIC);
  EXPECT_EQ(ConvertParts(request.parts()).error().code, ErrorCode::kUnimplemented);
  request.set_parts(1, v1::MESH_PART_UNSPECIFIED);
  EXPECT_EQ(ConvertParts(request.parts()).error().code, ErrorCode::kOutOfRange);
}

TEST(ConvertOpen, ReadsTheMirrorAndRefusesWhatIsOutOfRange) {
  v1::OpenEdit open;
  EXPECT_EQ(ConvertOpen(open).error().field, "session_id");
  open.set_session_id("a");
  open.set_mirror_revision(3);
  open.set_mirror_mode(v1::MIRROR_MODE_NONE);
  EXPECT_EQ(ConvertOpen(open)->mirror_revision, Revision(3));
  EXPECT_EQ(ConvertOpen(open)->mirror, Mirror::kNone);
  open.set_mirror_mode(v1::MIRROR_MODE_UNSPECIFIED);
  EXPECT_EQ(ConvertOpen(open).error().code, ErrorCode::kOutOfRange);
  open.set_mirror_mode(v1::MIRROR_MODE_POSITIONS);
  EXPECT_EQ(ConvertOpen(open).error().code, ErrorCode::kUnimplemented);
  open.set_mirror_mode(v1::MIRROR_MODE_FULL);
  open.set_mirror_revision(-1);
  EXPECT_EQ(ConvertOpen(open).error().field, "open.mirror_revision");
}

}  // namespace
}  // namespace pliant::server
