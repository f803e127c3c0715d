#include "client/io/geometry.h"

#include <gtest/gtest.h>

namespace pliant::io {
namespace {

TEST(Geometry, ReadsSizesAndTensorsAsMetrics) {
  PointField sizes;
  sizes.values = {0.5, 2};
  const auto isotropic = MetricsFromField(sizes);
  EXPECT_EQ(isotropic.value(), (std::vector<Metric>{{4, 0, 4}, {0.25, 0, 0.25}}));
  const PointField tensors = FieldFromMetrics({{1, 2, 3}, {4, 5, 6}});
  EXPECT_EQ(tensors.values, (std::vector<double>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(MetricsFromField(tensors).value(), (std::vector<Metric>{{1, 2, 3}, {4, 5, 6}}));
}

TEST(Geometry, RefusesSizesThatAreNotPositive) {
  PointField sizes;
  sizes.values = {0.5, 1, 0};
  const auto metrics = MetricsFromField(sizes);
  ASSERT_FALSE(metrics.ok());
  EXPECT_EQ(metrics.error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(metrics.error().index, 2);
}

TEST(Geometry, FindsTheFirstElementThatNamesNoPoint) {
  MeshData mesh;
  mesh.points = {{0, 0}, {1, 0}, {0, 1}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_TRUE(CheckIndices(mesh).ok());
  mesh.edges = {{0, 1}, {1, 3}};
  const Status status = CheckIndices(mesh);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kIndexOutOfRange);
  EXPECT_EQ(status.error().field, "edges");
  EXPECT_EQ(status.error().index, 1);
}

TEST(Geometry, IsADomainWithoutTriangles) {
  MeshData mesh;
  mesh.points = {{0, 0}, {1, 0}, {0, 1}};
  mesh.edges = {{0, 1}, {1, 2}};
  mesh.edge_tags = {5, 6};
  const Geometry geometry = GeometryFromMesh(mesh);
  ASSERT_TRUE(std::holds_alternative<Domain>(geometry));
  EXPECT_EQ(std::get<Domain>(geometry).segments, (std::vector<Segment>{{0, 1, 5}, {1, 2, 6}}));
}

}  // namespace
}  // namespace pliant::io
