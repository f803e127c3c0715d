#include "client/io/gmsh_writer.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "client/io/formats.h"
#include "client/io/gmsh.h"
#include "tests/client/io/support.h"

namespace pliant::io {
namespace {

std::vector<Vec2> Sorted(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(),
            [](Vec2 a, Vec2 b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  return points;
}

TEST(GmshWriter, RoundTripsToTheBit) {
  const MeshData mesh = GridMesh(4, /*seed=*/3);
  for (const std::string& bytes : {FormatGmsh22(mesh, {}), FormatGmsh41(mesh, {})}) {
    const Result<GmshGeometry> read = ParseGmsh(bytes);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(std::get<MeshData>(read->geometry), mesh);
  }
}

TEST(GmshWriter, WritesMeshesWithoutTags) {
  MeshData mesh;
  mesh.points = {{0, 0}, {1, 0}, {0, 1}};
  mesh.triangles = {{0, 1, 2}};
  mesh.edges = {{0, 1}};
  MeshData expected = mesh;
  expected.triangle_tags = {0};
  expected.edge_tags = {0};
  for (const std::string& bytes : {FormatGmsh22(mesh, {}), FormatGmsh41(mesh, {})}) {
    EXPECT_EQ(std::get<MeshData>(ParseGmsh(bytes).value().geometry), expected);
  }
}

// Goal: others read the same mesh, tags and fields included, in what we write.
// Method: meshio prints our files; gmsh reads them and writes the other format.
TEST(GmshWriter, MeshioAndGmshAgree) {
  const TemporaryFolder folder;
  const MeshData mesh = GridMesh(5, /*seed=*/5);
  for (const std::string extension : {".msh", ".msh2"}) {
    SCOPED_TRACE(extension);
    const std::string path = folder.File("a" + extension);
    ASSERT_TRUE(WriteMesh(path, mesh).ok());
    // meshio knows only the extension .msh.
    const std::string copy = folder.File("copy.msh");
    std::filesystem::copy_file(path, copy, std::filesystem::copy_options::overwrite_existing);
    EXPECT_EQ(MeshioDump(copy), ExpectedDump(mesh));
    const std::string converted = folder.File("converted.msh");
    Shell(std::string(PLIANT_GMSH) + " " + copy + " -v 2 -save -bin -format " +
          (extension == ".msh" ? "msh22" : "msh41") + " -o " + converted);
    const Result<Geometry> read = ReadGeometry(converted);
    ASSERT_TRUE(read.ok()) << read.error().message;
    const MeshData& same = std::get<MeshData>(*read);
    // gmsh sorts points and elements by entity; meshio has seen the order.
    EXPECT_EQ(Sorted(same.points), Sorted(mesh.points));
    EXPECT_EQ(same.triangles.size(), mesh.triangles.size());
    EXPECT_EQ(same.edges.size(), mesh.edges.size());
    EXPECT_EQ(std::count(same.edge_tags.begin(), same.edge_tags.end(), 40), 5);
    EXPECT_EQ(std::count(same.triangle_tags.begin(), same.triangle_tags.end(), 7), 30);
  }
}

TEST(GmshWriter, MeshioReadsTheFields) {
  const TemporaryFolder folder;
  MeshData mesh;
  mesh.points = {{0, 0}, {1, 0}, {0, 1}};
  mesh.triangles = {{0, 1, 2}};
  PointField size;
  size.name = "size";
  size.values = {0.1, 0.2, 1e-300};
  const PointField metric = FieldFromMetrics({{1, 2, 3}, {4, 5, 6}, {7, 8, 9}});
  ASSERT_TRUE(WriteMesh(folder.File("a.msh"), mesh, {size, metric}).ok());
  EXPECT_EQ(MeshioDump(folder.File("a.msh")),
            ExpectedDump(mesh) +
                "field size [0.1, 0.2, 1e-300]\n"
                "field metric [1.0, 2.0, 0.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, "
                "4.0, 5.0, 0.0, 5.0, 6.0, 0.0, 0.0, 0.0, 0.0, "
                "7.0, 8.0, 0.0, 8.0, 9.0, 0.0, 0.0, 0.0, 0.0]\n");
}

}  // namespace
}  // namespace pliant::io
