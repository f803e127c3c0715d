#include "client/cli/metric_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/io/formats.h"
#include "tests/client/cli/support.h"

namespace pliant::cli {
namespace {

using testing::HasSubstr;

MetricOptions Parsed(const std::string& text, MetricNeed need = MetricNeed::kRequired) {
  CLI::App app;
  MetricOptions options;
  AddMetricOptions(app, options, need);
  app.parse(text);
  return options;
}

MeshData TwoByOne() {
  MeshData mesh;
  mesh.points = {{0, 0}, {2, 0}, {0, 1}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

TEST(MetricOptions, ASourceIsNeeded) {
  EXPECT_THROW(Parsed(""), CLI::ParseError);
  EXPECT_FALSE(Parsed("", MetricNeed::kOptional).given());
  EXPECT_THROW(Parsed("--size 1 --background a.mesh"), CLI::ParseError);
  EXPECT_THROW(Parsed("--size 1 --tensor-smoothing 9"), CLI::ParseError);
  EXPECT_TRUE(Parsed("--size 1").given());
}

TEST(MetricOptions, FormulasTimeAndBoundsReachTheSpecification) {
  const MetricOptions options = Parsed(
      "--metric-expr \" 1+x ;0; 4*y\" --time 2.5 --hmin 0.1 --hmax 3 --anisotropy-max 100 "
      "--hgrad 1.5 --rotation 0.7 --gap-elements 3 --tensor-smoothing 2");
  const Result<MetricSpec> spec = MakeMetricSpec(options, UnitSquare(), "in.poly");
  ASSERT_TRUE(spec.ok());
  EXPECT_EQ(std::get<ExpressionMetric>(spec->source), (ExpressionMetric{"1+x", "0", "4*y"}));
  EXPECT_EQ(spec->time, 2.5);
  EXPECT_EQ(spec->bounds.size_min, 0.1);
  EXPECT_EQ(spec->bounds.size_max, 3);
  EXPECT_EQ(spec->bounds.anisotropy_max, 100);
  EXPECT_EQ(spec->gradation.gradation, 1.5);
  EXPECT_EQ(spec->gradation.rotation, 0.7);
  EXPECT_EQ(spec->gradation.gap_element_count, 3);
  EXPECT_EQ(spec->gradation.smoothing_count, 2);
  EXPECT_FALSE(spec->gradation.automatic);

  const auto size = MakeMetricSpec(Parsed("--size 0.1+x"), UnitSquare(), "in.poly");
  ASSERT_TRUE(size.ok());
  EXPECT_EQ(std::get<SizeMetric>(size->source), SizeMetric{"0.1+x"});
  EXPECT_TRUE(size->gradation.awaits_need());
  EXPECT_FALSE(Parsed("--size 1 --hgrad 0").gradation.automatic) << "0 is a choice, too";
  EXPECT_FALSE(Parsed("--size 1 --rotation 0").gradation.automatic);
}

TEST(MetricOptions, SeveralSourcesAreIntersected) {
  const auto spec = MakeMetricSpec(Parsed("--size 0.1+x --metric-expr 1;0;4"), UnitSquare(), "");
  ASSERT_TRUE(spec.ok());
  EXPECT_EQ(std::get<IntersectedMetric>(spec->source),
            (IntersectedMetric{{SizeMetric{"0.1+x"}, ExpressionMetric{"1", "0", "4"}}}));
}

TEST(MetricOptions, OtherThanThreeFormulasAreRefused) {
  for (const char* text : {"1;0", "1;0;1;0", "1;;1", "1"}) {
    MetricOptions options;
    options.expression = text;
    const Result<MetricSpec> spec = MakeMetricSpec(options, UnitSquare(), "in.poly");
    ASSERT_FALSE(spec.ok()) << text;
    EXPECT_EQ(spec.error().code, ErrorCode::kExpressionSyntax);
    EXPECT_THAT(spec.error().message, HasSubstr("M11; M12; M22"));
  }
}

TEST(MetricOptions, TensorsBelongToTheInputOrToTheBackground) {
  const TestFolder folder;
  const std::vector<Metric> tensors = {{1, 0, 1}, {2, 0.5, 3}, {4, -1, 5}};
  ASSERT_TRUE(io::WriteField(folder.Path("m.sol"), io::FieldFromMetrics(tensors)).ok());
  ASSERT_TRUE(io::WriteMesh(folder.Path("m.mesh"), TwoByOne()).ok());

  MetricOptions options;
  options.metric_file = folder.Path("m.sol");
  const Result<MetricSpec> own = MakeMetricSpec(options, TwoByOne(), "in.mesh");
  ASSERT_TRUE(own.ok()) << own.error().message;
  EXPECT_EQ(std::get<BackgroundMetric>(own->source).tensors, tensors);

  options.background_file = folder.Path("m.mesh");
  const Result<MetricSpec> other = MakeMetricSpec(options, UnitSquare(), "in.poly");
  ASSERT_TRUE(other.ok()) << other.error().message;
  EXPECT_EQ(std::get<BackgroundMetric>(other->source).mesh.points, TwoByOne().points);
}

TEST(MetricOptions, TensorsWithoutAMeshOrOfAnotherNumberAreRefused) {
  const TestFolder folder;
  const std::vector<Metric> tensors(4);
  ASSERT_TRUE(io::WriteField(folder.Path("m.sol"), io::FieldFromMetrics(tensors)).ok());
  MetricOptions options;
  options.metric_file = folder.Path("m.sol");
  const Result<MetricSpec> domain = MakeMetricSpec(options, UnitSquare(), "in.poly");
  ASSERT_FALSE(domain.ok());
  EXPECT_EQ(domain.error().code, ErrorCode::kFileUnsupported);
  EXPECT_THAT(domain.error().message, HasSubstr("--background"));

  const Result<MetricSpec> count = MakeMetricSpec(options, TwoByOne(), "in.mesh");
  ASSERT_FALSE(count.ok());
  EXPECT_EQ(count.error().code, ErrorCode::kArrayLength);
  EXPECT_THAT(count.error().message, HasSubstr("4 values"));
  EXPECT_THAT(count.error().message, HasSubstr("in.mesh has 3 points"));
}

TEST(MetricOptions, MetricsAtPointsFollowTheFormula) {
  MetricSpec spec;
  spec.source = SizeMetric{"1+x"};
  const auto metrics = MetricsAtPoints(spec, TwoByOne());
  ASSERT_TRUE(metrics.ok());
  EXPECT_EQ((*metrics)[0], Metric::Isotropic(1));
  EXPECT_NEAR((*metrics)[1].m11, 1.0 / 9, 1e-15);
  spec.source = SizeMetric{"1-x"};
  EXPECT_FALSE(MetricsAtPoints(spec, TwoByOne()).ok()) << "negative at x = 2";
}

}  // namespace
}  // namespace pliant::cli
