#include "client/io/formats.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/io/support.h"

namespace pliant::io {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(Formats, RefusesUnknownExtensions) {
  EXPECT_EQ(ReadGeometry("a.stl").error().code, ErrorCode::kFileUnsupported);
  EXPECT_EQ(ReadGeometry("a").error().code, ErrorCode::kFileUnsupported);
  EXPECT_EQ(ReadField("a.mesh").error().code, ErrorCode::kFileUnsupported);
  EXPECT_EQ(WriteMesh("a.poly", {}).error().code, ErrorCode::kFileUnsupported);
  EXPECT_EQ(WriteDomain("a.vtu", {}).error().code, ErrorCode::kFileUnsupported);
  EXPECT_EQ(WriteField("a.mtr", {}).error().code, ErrorCode::kFileUnsupported);
}

TEST(Formats, ErrorsStartWithThePath) {
  const TemporaryFolder folder;
  EXPECT_EQ(ReadGeometry(folder.File("none.mesh")).error().code, ErrorCode::kFileNotFound);
  const std::string path = folder.File("bad.mesh");
  ASSERT_TRUE(WriteFileAtomically(path, "MeshVersionFormatted 2\nDimension x").ok());
  const Error error = ReadGeometry(path).error();
  EXPECT_EQ(error.code, ErrorCode::kFileSyntax);
  EXPECT_EQ(error.index, 2);
  EXPECT_THAT(error.message, StartsWith(path + ": line 2: "));
}

TEST(Formats, ChecksLengthsBeforeItWrites) {
  const TemporaryFolder folder;
  MeshData mesh = GridMesh(1, /*seed=*/1);
  PointField field;
  field.values = {1, 2};
  EXPECT_EQ(WriteMesh(folder.File("a.vtu"), mesh, {field}).error().code, ErrorCode::kArrayLength);
  field.component_count = 2;
  EXPECT_EQ(WriteMesh(folder.File("a.vtu"), mesh, {field}).error().code, ErrorCode::kOutOfRange);
  mesh.edge_tags.pop_back();
  EXPECT_EQ(WriteMesh(folder.File("a.mesh"), mesh).error().code, ErrorCode::kArrayLength);
  mesh.edge_tags.clear();
  mesh.triangles[0][0] = 99;
  EXPECT_EQ(WriteMesh(folder.File("a.mesh"), mesh).error().code, ErrorCode::kIndexOutOfRange);
}

TEST(Formats, DropsNothingSilently) {
  const TemporaryFolder folder;
  PointField field;
  field.values = {1, 2, 3, 4};
  const Status status = WriteMesh(folder.File("a.mesh"), GridMesh(1, /*seed=*/1), {field});
  EXPECT_EQ(status.error().code, ErrorCode::kFileUnsupported);
  Domain domain;
  domain.points = {{0, 0}, {1, 0}, {0, 1}};
  domain.segments = {{0, 1, 1}, {1, 2, 2}, {2, 0, 3}};
  ASSERT_TRUE(WriteDomain(folder.File("a.mesh"), domain).ok());
  const Result<Geometry> read = ReadGeometry(folder.File("a.mesh"));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(std::get<Domain>(*read).segments, domain.segments);
  domain.holes = {{5, 5}};
  EXPECT_EQ(WriteDomain(folder.File("a.mesh"), domain).error().code, ErrorCode::kFileUnsupported);
  EXPECT_TRUE(WriteDomain(folder.File("a.poly"), domain).ok());
}

}  // namespace
}  // namespace pliant::io
