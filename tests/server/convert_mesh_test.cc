#include "server/convert_mesh.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

using test::Doubles;
using test::Ints;

TEST(ConvertMesh, ReadsADomainWithAllItsParts) {
  v1::Domain wire = test::UnitSquare().domain();
  *wire.mutable_holes() = Doubles({0.5, 0.5}, 2);
  *wire.mutable_region_points() = Doubles({0.1, 0.2}, 2);
  *wire.mutable_region_tags() = Ints({-9});
  const Result<Domain> domain = ConvertDomain(wire);
  ASSERT_TRUE(domain.ok());
  EXPECT_EQ(domain->points[2], (Vec2{1, 1}));
  EXPECT_EQ(domain->segments[3], (Segment{3, 0, 4}));
  EXPECT_EQ(domain->holes[0], (Vec2{0.5, 0.5}));
  EXPECT_EQ(domain->regions[0], (RegionSeed{{0.1, 0.2}, -9}));
}

TEST(ConvertMesh, TagsSegmentsWithoutTagsZero) {
  v1::Domain wire = test::UnitSquare().domain();
  wire.clear_segment_tags();
  EXPECT_EQ(ConvertDomain(wire)->segments[3], (Segment{3, 0, 0}));
}

TEST(ConvertMesh, ReadsAMeshWithAllItsParts) {
  const Result<MeshData> mesh = ConvertMesh(test::TwoTriangles().mesh(), "mesh");
  ASSERT_TRUE(mesh.ok());
  EXPECT_EQ(mesh->triangles[1], (std::array<std::int32_t, 3>{0, 2, 3}));
  EXPECT_EQ(mesh->triangle_tags, (std::vector<std::int32_t>{7, 8}));
  EXPECT_EQ(mesh->edges[0], (std::array<std::int32_t, 2>{0, 1}));
  EXPECT_EQ(mesh->edge_tags, (std::vector<std::int32_t>{5, 6}));
}

struct Refusal {
  ErrorCode code;
  std::string field;
  std::int64_t index;
};

void ExpectRefused(const Result<Domain>& domain, const Refusal& refusal) {
  ASSERT_FALSE(domain.ok());
  EXPECT_EQ(domain.error().code, refusal.code);
  EXPECT_EQ(domain.error().field, refusal.field);
  EXPECT_EQ(domain.error().index, refusal.index);
}

// Goal: each array that is wrong alone is named with its first bad row.
TEST(ConvertMesh, NamesTheFirstBadRowOfADomain) {
  v1::Domain wire = test::UnitSquare().domain();
  *wire.mutable_points() = Doubles({0, 0, 1, 0, NAN, 1, 0, INFINITY}, 2);
  ExpectRefused(ConvertDomain(wire), {ErrorCode::kNotFinite, "domain.points", 2});
  wire = test::UnitSquare().domain();
  *wire.mutable_segments() = Ints({0, 1, 1, 4, 2, -1, 3, 0}, 2);
  ExpectRefused(ConvertDomain(wire), {ErrorCode::kIndexOutOfRange, "domain.segments", 1});
  *wire.mutable_segments() = Ints({0, 1, 1, 2, 2, -1, 3, 0}, 2);
  ExpectRefused(ConvertDomain(wire), {ErrorCode::kIndexOutOfRange, "domain.segments", 2});
  wire = test::UnitSquare().domain();
  *wire.mutable_segment_tags() = Ints({1, 2, 3});
  ExpectRefused(ConvertDomain(wire), {ErrorCode::kArrayLength, "domain.segment_tags", -1});
  wire = test::UnitSquare().domain();
  *wire.mutable_holes() = Doubles({0.5, NAN}, 2);
  ExpectRefused(ConvertDomain(wire), {ErrorCode::kNotFinite, "domain.holes", 0});
  wire = test::UnitSquare().domain();
  *wire.mutable_region_points() = Doubles({0.5, 0.5}, 2);
  ExpectRefused(ConvertDomain(wire), {ErrorCode::kArrayLength, "domain.region_tags", -1});
  ExpectRefused(ConvertDomain(v1::Domain()), {ErrorCode::kEmpty, "domain.points", -1});
  wire = test::UnitSquare().domain();
  wire.clear_segments();
  ExpectRefused(ConvertDomain(wire), {ErrorCode::kEmpty, "domain.segments", -1});
}

TEST(ConvertMesh, NamesTheFirstBadRowOfAMesh) {
  v1::MeshInput wire = test::TwoTriangles().mesh();
  *wire.mutable_triangles() = Ints({0, 1, 2, 0, 2, 4}, 3);
  Result<MeshData> mesh = ConvertMesh(wire, "mesh");
  ASSERT_FALSE(mesh.ok());
  EXPECT_EQ(mesh.error().field, "mesh.triangles");
  EXPECT_EQ(mesh.error().index, 1);
  wire = test::TwoTriangles().mesh();
  *wire.mutable_edge_tags() = Ints({1, 2, 3});
  mesh = ConvertMesh(wire, "metric.background.mesh");
  ASSERT_FALSE(mesh.ok());
  EXPECT_EQ(mesh.error().field, "metric.background.mesh.edge_tags");
  EXPECT_EQ(mesh.error().code, ErrorCode::kArrayLength);
  wire.clear_triangles();
  mesh = ConvertMesh(wire, "mesh");
  ASSERT_FALSE(mesh.ok());
  EXPECT_EQ(mesh.error().code, ErrorCode::kEmpty);
}

}  // namespace
}  // namespace pliant::server
