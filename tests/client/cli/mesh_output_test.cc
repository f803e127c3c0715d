#include "client/cli/mesh_output.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "client/io/file.h"
#include "client/io/formats.h"
#include "tests/client/cli/support.h"

namespace pliant::cli {
namespace {

using testing::HasSubstr;

client::CompactMesh OneTriangle() {
  client::CompactMesh mesh;
  mesh.mesh.points = {{0, 0}, {1, 0}, {0, 1}};
  mesh.mesh.triangles = {{0, 1, 2}};
  mesh.metrics.resize(3);
  return mesh;
}

// Goal: the check before the work and the writer after it agree on every extension.
TEST(MeshOutput, TheCheckAgreesWithTheWriter) {
  const TestFolder folder;
  for (const char* name : {"a.mesh", "a.meshb", "a.msh", "a.msh2", "a.msh22", "a.msh4", "a.msh41",
                           "a.vtu", "a.node", "a.ele", "a.poly", "a.sol", "a.stl", "a"}) {
    const std::string path = folder.Path(name);
    EXPECT_EQ(CheckMeshOutput(path).ok(), io::WriteMesh(path, OneTriangle().mesh).ok()) << name;
  }
}

TEST(MeshOutput, AFolderThatIsMissingIsNamed) {
  const TestFolder folder;
  const Status status = CheckMeshOutput(folder.Path("nowhere/a.vtu"));
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kFileUnwritable);
  EXPECT_THAT(status.error().message, HasSubstr("nowhere"));
}

TEST(MeshOutput, VtuFilesCarryTheMetricIfItIsKnown) {
  const TestFolder folder;
  const auto text = [&](const client::CompactMesh& mesh) {
    EXPECT_TRUE(WriteCompactMesh(folder.Path("a.vtu"), mesh).ok());
    return io::ReadFile(folder.Path("a.vtu")).value();
  };
  client::CompactMesh mesh = OneTriangle();
  EXPECT_THAT(text(mesh), HasSubstr("\"metric\""));
  mesh.metrics.clear();
  EXPECT_THAT(text(mesh), testing::Not(HasSubstr("\"metric\"")));
}

}  // namespace
}  // namespace pliant::cli
