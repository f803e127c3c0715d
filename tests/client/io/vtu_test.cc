#include "client/io/vtu.h"

#include <gtest/gtest.h>

#include "client/io/formats.h"
#include "tests/client/io/support.h"

namespace pliant::io {
namespace {

// Goal: ParaView's format holds the mesh, its tags and the fields to the bit.
// Method: meshio reads the file. Sizes 1 to 3 of the grid make base64 end with every padding.
TEST(Vtu, MeshioReadsTheMesh) {
  for (const std::int32_t n : {1, 2, 3}) {
    const TemporaryFolder folder;
    const MeshData mesh = GridMesh(n, /*seed=*/2);
    ASSERT_TRUE(WriteMesh(folder.File("a.vtu"), mesh).ok());
    EXPECT_EQ(MeshioDump(folder.File("a.vtu")), ExpectedDump(mesh));
  }
}

TEST(Vtu, MeshioReadsTheFields) {
  const TemporaryFolder folder;
  MeshData mesh;
  mesh.points = {{0, 0}, {1, 0}, {0, 1}};
  mesh.triangles = {{0, 1, 2}};
  PointField size;
  size.name = "size <\"h\">";
  size.values = {0.1, 0.2, 1e-300};
  const PointField metric = FieldFromMetrics({{1, 2, 3}, {4, 5, 6}, {7, 8, 9}});
  ASSERT_TRUE(WriteMesh(folder.File("a.vtu"), mesh, {size, metric}).ok());
  EXPECT_EQ(MeshioDump(folder.File("a.vtu")),
            ExpectedDump(mesh) +
                "field size <\"h\"> [0.1, 0.2, 1e-300]\n"
                "field metric [1.0, 2.0, 0.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0, "
                "4.0, 5.0, 0.0, 5.0, 6.0, 0.0, 0.0, 0.0, 0.0, "
                "7.0, 8.0, 0.0, 8.0, 9.0, 0.0, 0.0, 0.0, 0.0]\n");
}

}  // namespace
}  // namespace pliant::io
