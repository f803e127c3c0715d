#include "client/io/gmsh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "client/io/formats.h"
#include "client/io/gmsh_writer.h"
#include "tests/client/io/support.h"

namespace pliant::io {
namespace {

using testing::HasSubstr;

// Node 9 belongs to no element; numbers have gaps and no order.
const char* const kSmall22 = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
1
1 5 "wall of $Nodes"
$EndPhysicalNames
$Nodes
5
30 0 1 2
9 9 9 9
7 0 0 2
4 1 0 2
100 1 1 2
$EndNodes
$Elements
4
1 15 2 0 1 7
2 1 2 5 1 7 4
3 2 3 8 1 0 7 4 100
4 2 2 9 1 7 100 30
$EndElements
)";

const char* const kSmall41 = R"($MeshFormat
4.1 0 8
$EndMeshFormat
$Entities
1 1 2 0
1 0 0 0 0
1 0 0 0 1 0 0 2 5 6 0
1 0 0 0 1 1 0 1 8 1 -1
2 0 0 0 1 1 0 1 9 0
$EndEntities
$Nodes
2 5 4 100
0 1 0 3
30
9
7
0 1 2
9 9 9
0 0 2
2 1 1 2
4
100
1 0 2 0.5 0.5
1 1 2 0.25 0.75
$EndNodes
$Elements
4 4 1 4
0 1 15 1
1 7
1 1 1 1
2 7 4
2 1 2 1
3 7 4 100
2 2 2 1
4 7 100 30
$EndElements
$Periodic
0
$EndPeriodic
)";

Error ErrorInMsh(const std::string& bytes) {
  const Result<GmshGeometry> result = ParseGmsh(bytes);
  return result.ok() ? Error{.message = "no error"} : result.error();
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Gmsh, DropsUnusedNodesAndKeepsNumbersAndPhysicalTags) {
  for (const std::string bytes : {kSmall22, kSmall41}) {
    SCOPED_TRACE(bytes.substr(0, 16));
    const Result<GmshGeometry> result = ParseGmsh(bytes);
    ASSERT_TRUE(result.ok()) << result.error().message;
    EXPECT_EQ(result->node_numbers, (std::vector<std::int64_t>{30, 7, 4, 100}));
    MeshData expected;
    expected.points = {{0, 1}, {0, 0}, {1, 0}, {1, 1}};
    expected.triangles = {{1, 2, 3}, {1, 3, 0}};
    expected.triangle_tags = {8, 9};
    expected.edges = {{1, 2}};
    expected.edge_tags = {5};
    EXPECT_EQ(std::get<MeshData>(result->geometry), expected);
  }
}

TEST(Gmsh, NamesTheError) {
  EXPECT_EQ(ErrorInMsh("").code, ErrorCode::kFileSyntax);
  EXPECT_EQ(ErrorInMsh("$NOD\n3\n").code, ErrorCode::kFileSyntax);
  const Error version = ErrorInMsh(Replaced(kSmall22, "2.2 0", "4 0"));
  EXPECT_EQ(version.code, ErrorCode::kFileUnsupported);
  EXPECT_THAT(version.message, HasSubstr("-format msh41"));
  EXPECT_EQ(ErrorInMsh(Replaced(kSmall22, "0 1 2\n", "0 1 3\n")).code, ErrorCode::kFileUnsupported);
  EXPECT_EQ(ErrorInMsh(Replaced(kSmall22, "\n9 9", "\n7 9")).code, ErrorCode::kDuplicateId);
  const Error index = ErrorInMsh(Replaced(kSmall22, "7 100 30", "7 100 31"));
  EXPECT_EQ(index.code, ErrorCode::kIndexOutOfRange);
  EXPECT_EQ(index.index, 1);
  EXPECT_EQ(ErrorInMsh(Replaced(kSmall22, "4 2 2 9 1", "4 3 2 9 1")).code,
            ErrorCode::kFileUnsupported);
  const Error number = ErrorInMsh(Replaced(kSmall41, "1 1 2 0.25", "1 one 2 0.25"));
  EXPECT_EQ(number.code, ErrorCode::kFileSyntax);
  EXPECT_EQ(number.index, 24);
  EXPECT_EQ(ErrorInMsh(Replaced(kSmall41, "2 1 1 2\n", "2 1 1 999999999\n")).code,
            ErrorCode::kFileSyntax);
  EXPECT_EQ(ErrorInMsh("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n").code, ErrorCode::kEmpty);
  EXPECT_EQ(ErrorInMsh(Replaced(kSmall41, "$Periodic\n", "$PartitionedEntities\n")).code,
            ErrorCode::kFileUnsupported);
}

TEST(Gmsh, SurvivesDamagedFiles) {
  ExpectSurvivesDamage(kSmall22, 5000, ParseGmsh);
  ExpectSurvivesDamage(kSmall41, 5000, ParseGmsh);
}

class GmshProgram : public testing::Test {
 protected:
  /// Two regions, an arc whose centre is no node of the mesh, and a hole.
  void SetUp() override {
    const char* const kGeometry = R"(
      Point(1) = {0, 0, 0, 0.4}; Point(2) = {2, 0, 0, 0.4}; Point(3) = {2, 1, 0, 0.2};
      Point(4) = {0, 1, 0, 0.2}; Point(5) = {1, 0, 0, 0.2}; Point(6) = {1, 1, 0, 0.2};
      Point(7) = {0.5, 0.5, 0, 0.1}; Point(8) = {0.7, 0.5, 0, 0.1}; Point(9) = {0.3, 0.5, 0, 0.1};
      Line(1) = {1, 5}; Line(2) = {5, 2}; Line(3) = {2, 3}; Line(4) = {3, 6}; Line(5) = {6, 4};
      Line(6) = {4, 1}; Line(7) = {5, 6}; Circle(8) = {8, 7, 9}; Circle(9) = {9, 7, 8};
      Curve Loop(1) = {1, 7, 5, 6}; Curve Loop(2) = {8, 9}; Curve Loop(3) = {2, 3, 4, -7};
      Plane Surface(1) = {1, 2}; Plane Surface(2) = {3};
      Physical Curve("outer", 11) = {1, 2, 3, 4, 5, 6}; Physical Curve("between", 12) = {7};
      Physical Curve("hole", 13) = {8, 9}; Physical Surface("left", 21) = {1};
      Physical Surface("right", 22) = {2};)";
    ASSERT_TRUE(WriteFileAtomically(folder_.File("a.geo"), kGeometry).ok());
  }

  std::string Mesh(const std::string& name, const std::string& options) {
    Shell(std::string(PLIANT_GMSH) + " " + folder_.File("a.geo") + " -2 -v 2 " + options + " -o " +
          folder_.File(name));
    return folder_.File(name);
  }

  TemporaryFolder folder_;
};

// Goal: every format that gmsh writes gives the same mesh, with the tags of its model.
// Method: one model meshed four times; in text, 16 digits limit what can agree.
TEST_F(GmshProgram, WritesWhatWeRead) {
  const Result<Geometry> reference = ReadGeometry(Mesh("a.msh", "-format msh41 -bin"));
  ASSERT_TRUE(reference.ok()) << reference.error().message;
  const MeshData& mesh = std::get<MeshData>(*reference);
  EXPECT_GT(mesh.triangles.size(), 50U);
  EXPECT_EQ(std::set<std::int32_t>(mesh.triangle_tags.begin(), mesh.triangle_tags.end()),
            (std::set<std::int32_t>{21, 22}));
  EXPECT_EQ(std::set<std::int32_t>(mesh.edge_tags.begin(), mesh.edge_tags.end()),
            (std::set<std::int32_t>{11, 12, 13}));
  // The model's own area of each region: what is left of the unit square by a polygon in the
  // circle, and the other square.
  double area_left = 0;
  double area_right = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const auto point = [&mesh, &t](std::size_t k) {
      return mesh.points[static_cast<std::size_t>(t[k])];
    };
    const double area = 0.5 * Cross(point(1) - point(0), point(2) - point(0));
    EXPECT_GT(area, 0);
    (mesh.triangle_tags[i] == 21 ? area_left : area_right) += area;
  }
  EXPECT_NEAR(area_right, 1, 1e-12);
  EXPECT_NEAR(area_left, 1 - 0.04 * 3.1416, 0.01);

  for (const std::string options : {"-format msh41", "-format msh22", "-format msh22 -bin"}) {
    SCOPED_TRACE(options);
    const Result<Geometry> other = ReadGeometry(Mesh("b.msh", options));
    ASSERT_TRUE(other.ok()) << other.error().message;
    const MeshData& same = std::get<MeshData>(*other);
    EXPECT_EQ(same.triangles, mesh.triangles);
    EXPECT_EQ(same.triangle_tags, mesh.triangle_tags);
    EXPECT_EQ(same.edges, mesh.edges);
    EXPECT_EQ(same.edge_tags, mesh.edge_tags);
    ASSERT_EQ(same.points.size(), mesh.points.size());
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      EXPECT_NEAR(same.points[i].x, mesh.points[i].x, 1e-15);
      EXPECT_NEAR(same.points[i].y, mesh.points[i].y, 1e-15);
    }
  }
}

TEST_F(GmshProgram, BinaryFilesSurviveDamage) {
  for (const std::string options : {"-format msh41 -bin", "-format msh22 -bin"}) {
    const std::string path = Mesh("c.msh", options + " -clscale 4");
    const Result<std::string> bytes = ReadFile(path);
    ASSERT_TRUE(bytes.ok());
    ASSERT_TRUE(ParseGmsh(*bytes).ok());
    ExpectSurvivesDamage(*bytes, 3000, ParseGmsh);
  }
}

TEST_F(GmshProgram, OneDimensionIsADomain) {
  const std::string path = folder_.File("d.msh");
  Shell(std::string(PLIANT_GMSH) + " " + folder_.File("a.geo") + " -1 -v 2 -o " + path);
  const Result<Geometry> result = ReadGeometry(path);
  ASSERT_TRUE(result.ok()) << result.error().message;
  const Domain& domain = std::get<Domain>(*result);
  EXPECT_GT(domain.segments.size(), 20U);
  // The centre of the circle is no node of a curve.
  for (const Vec2 p : domain.points) EXPECT_FALSE(p == (Vec2{0.5, 0.5}));
}

}  // namespace
}  // namespace pliant::io
