#include "server/convert_metric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

using test::Doubles;
using test::Ints;

void AddSize(v1::MetricUpdate& wire, const std::string& size) {
  wire.add_sources()->mutable_size()->set_size(size);
}

void AddTensors(v1::MetricUpdate& wire) {
  v1::VertexMetric& vertices = *wire.add_sources()->mutable_vertices();
  vertices.set_revision(4);
  *vertices.mutable_vertex_ids() = Ints({9});
  *vertices.mutable_tensors() = Doubles({1, 0, 2}, 3);
}

TEST(ConvertMetricUpdate, ReadsTensorsByVertexAndOfAll) {
  v1::MetricUpdate wire;
  v1::VertexMetric& vertices = *wire.add_sources()->mutable_vertices();
  vertices.set_revision(4);
  *vertices.mutable_vertex_ids() = Ints({9, 3});
  *vertices.mutable_tensors() = Doubles({1, 0, 2, 3, 0, 4}, 3);
  Result<MetricUpdate> update = ConvertMetricUpdate(wire);
  ASSERT_TRUE(update.ok());
  const VertexTensors* tensors = std::get_if<VertexTensors>(&update->source);
  ASSERT_NE(tensors, nullptr);
  EXPECT_EQ(tensors->revision, Revision(4));
  EXPECT_EQ(*tensors->vertices, (std::vector<VertexId>{VertexId(9), VertexId(3)}));
  EXPECT_EQ(tensors->tensors[1], (Metric{3, 0, 4}));

  vertices.clear_vertex_ids();
  update = ConvertMetricUpdate(wire);
  ASSERT_TRUE(update.ok());
  EXPECT_FALSE(std::get<VertexTensors>(update->source).vertices.has_value());

  *vertices.mutable_vertex_ids() = Ints({9});
  update = ConvertMetricUpdate(wire);
  ASSERT_FALSE(update.ok());
  EXPECT_EQ(update.error().code, ErrorCode::kArrayLength);
  EXPECT_EQ(update.error().field, "metric.tensors");
}

TEST(ConvertMetricUpdate, ReadsOnlyWhatChanges) {
  v1::MetricUpdate wire;
  wire.set_time(3);
  wire.mutable_limits()->set_size_max(0.5);
  const Result<MetricUpdate> update = ConvertMetricUpdate(wire);
  ASSERT_TRUE(update.ok());
  EXPECT_TRUE(std::holds_alternative<std::monostate>(update->source));
  EXPECT_EQ(update->time, 3);
  EXPECT_EQ(update->size_max, 0.5);
  EXPECT_FALSE(update->size_min.has_value());
  wire.set_time(NAN);
  EXPECT_EQ(ConvertMetricUpdate(wire).error().code, ErrorCode::kNotFinite);
}

TEST(ConvertMetricUpdate, ReadsFunctionsBesideTensorsInTheirOrder) {
  v1::MetricUpdate wire;
  AddSize(wire, "x");
  AddTensors(wire);
  AddSize(wire, "y");
  const Result<MetricUpdate> update = ConvertMetricUpdate(wire);
  ASSERT_TRUE(update.ok()) << update.error().message;
  EXPECT_EQ(std::get<VertexTensors>(update->source).tensors[0], (Metric{1, 0, 2}));
  ASSERT_TRUE(update->functions.has_value());
  EXPECT_EQ(*update->functions,
            (FunctionsSpec{.parts = {SizeMetric{"x"}, SizeMetric{"y"}}, .before_count = 1}));
}

TEST(ConvertMetricUpdate, ReadsFunctionsBesideASolution) {
  v1::MetricUpdate wire;
  v1::SolutionMetric& solution = *wire.add_sources()->mutable_solution();
  solution.mutable_field()->set_name("u");
  solution.set_complexity(100);
  AddSize(wire, "y");
  const Result<MetricUpdate> update = ConvertMetricUpdate(wire);
  ASSERT_TRUE(update.ok()) << update.error().message;
  EXPECT_EQ(std::get<SolutionRequest>(update->source).name, "u");
  EXPECT_EQ(update->functions->before_count, 0U);
}

TEST(ConvertMetricUpdate, ReadsFunctionsAloneAsAnIntersection) {
  v1::MetricUpdate wire;
  AddSize(wire, "x");
  AddSize(wire, "y");
  const Result<MetricUpdate> update = ConvertMetricUpdate(wire);
  ASSERT_TRUE(update.ok());
  EXPECT_EQ(std::get<IntersectedMetric>(update->source).parts.size(), 2U);
  EXPECT_FALSE(update->functions.has_value());
}

TEST(ConvertMetricUpdate, RefusesValuesAtVerticesTwice) {
  v1::MetricUpdate wire;
  AddTensors(wire);
  AddSize(wire, "x");
  wire.add_sources()->mutable_solution()->mutable_field()->set_name("u");
  const Result<MetricUpdate> update = ConvertMetricUpdate(wire);
  ASSERT_FALSE(update.ok());
  EXPECT_EQ(update.error().code, ErrorCode::kUnimplemented);
  EXPECT_EQ(update.error().field, "metric.sources");
}

TEST(ConvertMetricUpdate, SaysWhichOfSeveralSourcesIsBad) {
  v1::MetricUpdate wire;
  AddTensors(wire);
  AddSize(wire, "");
  const Result<MetricUpdate> update = ConvertMetricUpdate(wire);
  ASSERT_FALSE(update.ok());
  EXPECT_EQ(update.error().message.rfind("metric.sources[1]: ", 0), 0U) << update.error().message;
  while (wire.sources_size() < 17) AddSize(wire, "1");
  EXPECT_EQ(ConvertMetricUpdate(wire).error().code, ErrorCode::kTooLarge);
}

// Goal: tensors of the mesh that a session starts from are one of several sources there.
TEST(ConvertFirstMetric, IntersectsTensorsOfTheMeshWithFunctions) {
  v1::CreateSession create = test::TwoTriangles();
  ASSERT_TRUE(create.metric().sources(0).has_vertices());
  AddSize(*create.mutable_metric(), "x");
  MeshData mesh;
  mesh.points.resize(
      static_cast<std::size_t>(create.metric().sources(0).vertices().tensors().shape(0)));
  const Result<MetricSpec> spec = ConvertFirstMetric(create, mesh);
  ASSERT_TRUE(spec.ok()) << spec.error().message;
  const auto& parts = std::get<IntersectedMetric>(spec->source).parts;
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(std::get<BackgroundMetric>(parts[0]).mesh, mesh);
  const Result<MetricSpec> domain = ConvertFirstMetric(create, Domain{});
  ASSERT_FALSE(domain.ok());
  EXPECT_EQ(domain.error().code, ErrorCode::kProtocolOrder);
}

}  // namespace
}  // namespace pliant::server
