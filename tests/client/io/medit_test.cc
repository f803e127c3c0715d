#include "client/io/medit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/io/formats.h"
#include "tests/client/io/support.h"

namespace pliant::io {
namespace {

using testing::HasSubstr;

const char* const kBamgStyle = R"(MeshVersionFormatted 0
Dimension
2
Identifier
"Mesh of Vertices and Edges"

MaximalAngleOfCorner 46
# a square
Vertices
4
0 0 1
1 0 2
1 1 3
0 1 4
Edges 4
1 2 10
2 3 11
3 4 12
4 1 13
Corners
2
1
3
RequiredVertices 1 2
End
)";

Error ErrorInMedit(const std::string& bytes) {
  const Result<Geometry> result = ParseMedit(bytes);
  return result.ok() ? Error{.message = "no error"} : result.error();
}

TEST(Medit, TextAndBinaryRoundTripToTheBit) {
  const MeshData mesh = GridMesh(6, /*seed=*/3);
  EXPECT_EQ(std::get<MeshData>(ParseMedit(FormatMedit(mesh)).value()), mesh);
  EXPECT_EQ(std::get<MeshData>(ParseMedit(FormatMeditBinary(mesh)).value()), mesh);
}

TEST(Medit, ReadsAGeometryWithSectionsItDoesNotKnow) {
  const Result<Geometry> result = ParseMedit(kBamgStyle);
  ASSERT_TRUE(result.ok()) << result.error().message;
  const Domain& domain = std::get<Domain>(*result);
  EXPECT_EQ(domain.points, (std::vector<Vec2>{{0, 0}, {1, 0}, {1, 1}, {0, 1}}));
  EXPECT_EQ(domain.segments,
            (std::vector<Segment>{{0, 1, 10}, {1, 2, 11}, {2, 3, 12}, {3, 0, 13}}));
}

TEST(Medit, ReadsAPlaneInSpaceAndRefusesASurface) {
  const std::string head = "MeshVersionFormatted 2 Dimension 3 Vertices 3 0 0 5 0 1 0 5 0 1 1 ";
  const std::string tail = " 0 Triangles 1 1 2 3 9 End";
  const Result<Geometry> plane = ParseMedit(head + "5" + tail);
  ASSERT_TRUE(plane.ok()) << plane.error().message;
  EXPECT_EQ(std::get<MeshData>(*plane).triangle_tags, std::vector<std::int32_t>{9});
  EXPECT_EQ(ErrorInMedit(head + "6" + tail).code, ErrorCode::kFileUnsupported);
}

TEST(Medit, NamesTheErrorAndItsLine) {
  const std::string start = "MeshVersionFormatted 2\nDimension 2\nVertices\n3\n0 0 0\n1 0 0\n";
  EXPECT_EQ(ErrorInMedit("solid x").code, ErrorCode::kFileSyntax);
  EXPECT_EQ(ErrorInMedit("MeshVersionFormatted 2 Dimension 2 End").code, ErrorCode::kEmpty);
  EXPECT_EQ(ErrorInMedit("MeshVersionFormatted 2 Dimension 4").code, ErrorCode::kFileSyntax);
  const Error bad_number = ErrorInMedit(start + "0 one 0\n");
  EXPECT_EQ(bad_number.code, ErrorCode::kFileSyntax);
  EXPECT_EQ(bad_number.index, 7);
  EXPECT_THAT(bad_number.message, HasSubstr("line 7: expected a number, found 'one'"));
  EXPECT_EQ(ErrorInMedit(start + "0 nan 0\n").code, ErrorCode::kNotFinite);
  const Error bad_index = ErrorInMedit(start + "0 1 0\nTriangles 1\n1 2 4 0\n");
  EXPECT_EQ(bad_index.code, ErrorCode::kIndexOutOfRange);
  EXPECT_EQ(bad_index.index, 0);
  EXPECT_EQ(ErrorInMedit(start + "0 1 0\nTriangles 1\n1 2 0 0\n").code,
            ErrorCode::kIndexOutOfRange);
  EXPECT_EQ(ErrorInMedit(start + "0 1 0\nQuadrilaterals 1\n1 2 3 1 0\n").code,
            ErrorCode::kFileUnsupported);
  EXPECT_EQ(ErrorInMedit(start + "0 1 0\nVertices 1\n1 2 3\n").code, ErrorCode::kFileSyntax);
  EXPECT_EQ(ErrorInMedit("MeshVersionFormatted 2 Dimension 2 Vertices 2000000000 0 0 0").code,
            ErrorCode::kFileSyntax);
  EXPECT_EQ(ErrorInMedit("MeshVersionFormatted 2 Dimension 2 Vertices 3000000000 0 0 0").code,
            ErrorCode::kTooLarge);
}

TEST(Medit, SurvivesDamagedFiles) {
  const MeshData mesh = GridMesh(2, /*seed=*/4);
  ExpectSurvivesDamage(FormatMedit(mesh), 3000, ParseMedit);
  ExpectSurvivesDamage(FormatMeditBinary(mesh), 3000, ParseMedit);
  ExpectSurvivesDamage(kBamgStyle, 3000, ParseMedit);
}

// Goal: others read the same mesh, to the bit, in what we write, and we in what they write.
// Method: meshio prints our files; meshio converts our text to its binary and back to text.
TEST(Medit, MeshioAgrees) {
  const TemporaryFolder folder;
  const MeshData mesh = GridMesh(5, /*seed=*/5);
  ASSERT_TRUE(WriteMesh(folder.File("a.mesh"), mesh).ok());
  ASSERT_TRUE(WriteMesh(folder.File("b.meshb"), mesh).ok());
  EXPECT_EQ(MeshioDump(folder.File("a.mesh")), ExpectedDump(mesh));
  EXPECT_EQ(MeshioDump(folder.File("b.meshb")), ExpectedDump(mesh));
  for (const std::string name : {"c.mesh", "d.meshb"}) {
    SCOPED_TRACE(name);
    Shell(std::string(PLIANT_PYTHON) + " -c \"import meshio; meshio.read('" +
          folder.File("a.mesh") + "').write('" + folder.File(name) + "')\"");
    const Result<Geometry> read = ReadGeometry(folder.File(name));
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(std::get<MeshData>(*read), mesh);
  }
}

}  // namespace
}  // namespace pliant::io
