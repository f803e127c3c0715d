#include "client/io/triangle.h"

#include <gtest/gtest.h>

#include "client/io/formats.h"
#include "tests/client/io/support.h"

namespace pliant::io {
namespace {

// In the manner of the examples in Triangle's own manual.
const char* const kBox = R"(# A box with eight points in two dimensions, one attribute, markers.
8 2 1 1
 1   0 0   -0.5  5   # Outer box has these points:
 2   0 3   0.25  5
 3   3 0   11    5
 4   3 3.0 90.77 5
 5   1 1   -7    0   # Inner square has these points:
 6   1 2   1e2   0
 7   2 1   3.125 0
 8   2 2   0     0
# Five segments without boundary markers.
5 1
 1   1 2 7
 2   5 7 8   # Segments 2 through 5 enclose the hole.
 3   7 8 9
 4   8 6 10
 5   6 5 11
# One hole in the middle of the inner square.
1
 1   1.5 1.5
# Two regions.
2
 1   0.1 0.2  3 0.1
 2   2.5 2.5  -4.0
)";

Error ErrorInPoly(const std::string& poly) {
  const Result<Domain> result = ParsePoly(poly);
  return result.ok() ? Error{.message = "no error"} : result.error();
}

TEST(Triangle, ReadsAPolyWithCommentsAttributesAndMarkers) {
  const Result<Domain> result = ParsePoly(kBox);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->points.size(), 8U);
  EXPECT_EQ(result->points[3], (Vec2{3, 3}));
  EXPECT_EQ(result->segments,
            (std::vector<Segment>{{0, 1, 7}, {4, 6, 8}, {6, 7, 9}, {7, 5, 10}, {5, 4, 11}}));
  EXPECT_EQ(result->holes, (std::vector<Vec2>{{1.5, 1.5}}));
  EXPECT_EQ(result->regions, (std::vector<RegionSeed>{{{0.1, 0.2}, 3}, {{2.5, 2.5}, -4}}));
}

TEST(Triangle, CountsFromZeroOrOneAndNeedsNoTail) {
  const Result<Domain> zero = ParsePoly("3 2 0 0\n0 0 0\n1 1 0\n2 0 1\n1 0\n0 2 0\n0\n");
  ASSERT_TRUE(zero.ok()) << zero.error().message;
  EXPECT_EQ(zero->segments, (std::vector<Segment>{{2, 0, 0}}));
  const Result<Domain> no_holes = ParsePoly("2\n1 0 0\n2 1 0\n1\n1 1 2");
  ASSERT_TRUE(no_holes.ok()) << no_holes.error().message;
  EXPECT_EQ(no_holes->segments, (std::vector<Segment>{{0, 1, 0}}));
}

TEST(Triangle, FindsPointsInTheNodeFileBeside) {
  const TemporaryFolder folder;
  const std::string poly = "0 2 0 0\n1 1\n1 1 2 6\n0\n";
  ASSERT_TRUE(WriteFileAtomically(folder.File("a.1.poly"), poly).ok());
  EXPECT_EQ(ReadGeometry(folder.File("a.1.poly")).error().code, ErrorCode::kFileNotFound);
  ASSERT_TRUE(WriteFileAtomically(folder.File("a.1.node"), "2 2 0 1\n1 0 0 1\n2 4 5 1\n").ok());
  const Result<Geometry> result = ReadGeometry(folder.File("a.1.poly"));
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(std::get<Domain>(*result).points, (std::vector<Vec2>{{0, 0}, {4, 5}}));
  EXPECT_EQ(std::get<Domain>(*result).segments, (std::vector<Segment>{{0, 1, 6}}));
}

TEST(Triangle, PolyRoundTripsToTheBit) {
  Domain domain;
  domain.points = {{0.1, 1.0 / 3}, {-5e-324, 1e300}, {7, 8}};
  domain.segments = {{0, 1, -3}, {1, 2, 0}};
  domain.holes = {{0.7, 0.1}};
  domain.regions = {{{1e-9, 2}, 2147483647}};
  const Result<Domain> read = ParsePoly(FormatPoly(domain));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->points, domain.points);
  EXPECT_EQ(read->segments, domain.segments);
  EXPECT_EQ(read->holes, domain.holes);
  EXPECT_EQ(read->regions, domain.regions);
}

TEST(Triangle, MeshRoundTripsToTheBit) {
  const TemporaryFolder folder;
  const MeshData mesh = GridMesh(4, /*seed=*/6);
  ASSERT_TRUE(WriteMesh(folder.File("m.ele"), mesh).ok());
  const Result<Geometry> read = ReadGeometry(folder.File("m.node"));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(std::get<MeshData>(*read), mesh);
}

TEST(Triangle, TakesOnlyMarkedEdgesFromAListOfAllEdges) {
  const TriangleFiles files{.node = "4 2 0 0\n0 0 0\n1 1 0\n2 1 1\n3 0 1\n",
                            .ele = "2 3 0\n0 0 1 2\n1 0 2 3\n",
                            .edge = "5 1\n0 0 1 1\n1 1 2 1\n2 2 3 1\n3 3 0 1\n4 0 2 0\n"};
  const Result<MeshData> mesh = ParseTriangleMesh(files);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh->edges.size(), 4U);
  EXPECT_EQ(mesh->edge_tags, (std::vector<std::int32_t>{1, 1, 1, 1}));
}

TEST(Triangle, NamesTheErrorAndItsLine) {
  const std::string points = "2 2 0 0\n1 0 0\n2 1 0\n";
  EXPECT_EQ(ErrorInPoly("2 3 0 0\n1 0 0 0\n2 1 0 0\n").code, ErrorCode::kFileUnsupported);
  const Error wrong_number = ErrorInPoly("2 2 0 0\n1 0 0\n3 1 0\n");
  EXPECT_EQ(wrong_number.code, ErrorCode::kFileSyntax);
  EXPECT_EQ(wrong_number.index, 3);
  const Error dangling = ErrorInPoly(points + "2 0\n1 1 2\n2 1 3\n0\n");
  EXPECT_EQ(dangling.code, ErrorCode::kIndexOutOfRange);
  EXPECT_EQ(dangling.index, 1);
  EXPECT_EQ(ErrorInPoly(points + "1 0\n1 1 2\n0\n1\n1 0 0 1.5\n").code, ErrorCode::kOutOfRange);
  EXPECT_EQ(ErrorInPoly("1999999999 2\n1 0 0\n").code, ErrorCode::kFileSyntax);
  EXPECT_EQ(ErrorInPoly("").code, ErrorCode::kFileSyntax);
  const Result<MeshData> quadratic = ParseTriangleMesh(
      {.node = "1 2\n1 0 0\n", .ele = "1 6 0\n1 1 1 1 1 1 1\n", .edge = std::nullopt});
  EXPECT_EQ(quadratic.error().code, ErrorCode::kFileUnsupported);
}

TEST(Triangle, SurvivesDamagedFiles) {
  ExpectSurvivesDamage(kBox, 5000, [](const std::string& poly) { return ParsePoly(poly); });
  const TriangleFiles files = FormatTriangleMesh(GridMesh(2, /*seed=*/4));
  ExpectSurvivesDamage(files.node, 1000, [&files](const std::string& node) {
    return ParseTriangleMesh({.node = node, .ele = files.ele, .edge = files.edge});
  });
  ExpectSurvivesDamage(files.ele, 1000, [&files](const std::string& ele) {
    return ParseTriangleMesh({.node = files.node, .ele = ele, .edge = files.edge});
  });
  ExpectSurvivesDamage(*files.edge, 1000, [&files](const std::string& edge) {
    return ParseTriangleMesh({.node = files.node, .ele = files.ele, .edge = edge});
  });
}

}  // namespace
}  // namespace pliant::io
