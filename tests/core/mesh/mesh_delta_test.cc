#include "core/mesh/mesh_delta.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::EditedMesh;
using testing::GridData;
using testing::ImportedMesh;
using testing::RandomEditor;

Bytes Written(const MeshDelta& delta) {
  ByteWriter writer;
  WriteMeshDelta(delta, writer);
  return std::move(writer).Take();
}

Bytes Written(const Mesh& mesh) {
  ByteWriter writer;
  WriteMesh(mesh, writer);
  return std::move(writer).Take();
}

MeshDelta UndoOfEdits(EditedMesh& edited, RandomEditor& editor, int steps, Revision revision) {
  for (int step = 0; step < steps; ++step) editor.Step();
  (void)edited.edit.Commit(revision);
  return *edited.edit.TakeUndo();
}

TEST(MeshDelta, ReadsWhatItWrote) {
  const auto edited = ImportedMesh(GridData(6, 6));
  (void)edited->edit.Commit(Revision(1));
  RandomEditor editor(*edited, 17);
  const MeshDelta undo = UndoOfEdits(*edited, editor, 100, Revision(2));
  EXPECT_FALSE(undo.vertices.ids.empty());
  EXPECT_FALSE(undo.edges.ids.empty());
  const Bytes bytes = Written(undo);
  ByteReader reader(bytes);
  const MeshDelta back = ReadMeshDelta(reader);
  EXPECT_TRUE(reader.AtEnd());
  EXPECT_EQ(Written(back), bytes);
  EXPECT_TRUE(edited->edit.Fits(back));
}

// Goal: a delta costs what it changes. Method: the same edit on meshes of 200 and 20,000 triangles.
TEST(MeshDelta, DoesNotGrowWithTheMesh) {
  std::vector<std::size_t> sizes;
  for (const std::int32_t n : {10, 100}) {
    const auto edited = ImportedMesh(GridData(n, n));
    (void)edited->edit.Commit(Revision(1));
    edited->edit.MoveVertex(VertexId(n + 2), {1.1, 1.1});
    (void)edited->edit.Commit(Revision(2));
    const std::optional<MeshDelta> undo = edited->edit.TakeUndo();
    sizes.push_back(undo->bytes());
    EXPECT_EQ(undo->vertices.ids.size(), 1U);
  }
  EXPECT_EQ(sizes[0], sizes[1]);
}

// Goal: bytes that are cut off or do not fit together are refused, and never lead out of a mesh.
TEST(MeshDelta, RefusesWhatCannotBe) {
  const auto edited = ImportedMesh(GridData(4, 4));
  (void)edited->edit.Commit(Revision(1));
  RandomEditor editor(*edited, 5);
  const Bytes bytes = Written(UndoOfEdits(*edited, editor, 60, Revision(2)));
  const Bytes mesh = Written(edited->mesh);
  for (std::size_t size = 0; size < bytes.size(); size += 3) {
    ByteReader reader(std::span<const std::byte>(bytes).first(size));
    (void)ReadMeshDelta(reader);
    EXPECT_FALSE(reader.ok()) << "the first " << size << " of " << bytes.size() << " bytes";
  }
  for (std::size_t size = 0; size < mesh.size(); size += 7) {
    ByteReader reader(std::span<const std::byte>(mesh).first(size));
    (void)ReadMesh(reader);
    EXPECT_FALSE(reader.ok()) << "the first " << size << " of " << mesh.size() << " bytes";
  }
  MeshDelta out_of_range;
  out_of_range.vertices.slots = 3;
  out_of_range.vertices.ids = {VertexId(1)};
  out_of_range.vertices.records.resize(1);
  out_of_range.vertices.records[0].triangle = TriangleId(7);
  const Bytes bad = Written(out_of_range);
  ByteReader reader(bad);
  (void)ReadMeshDelta(reader);
  EXPECT_FALSE(reader.ok());
}

TEST(MeshDelta, MergedLeadsWhereTheTwoLead) {
  const auto edited = ImportedMesh(GridData(6, 6));
  (void)edited->edit.Commit(Revision(1));
  const Bytes first = Written(edited->mesh);
  RandomEditor editor(*edited, 23);
  const MeshDelta to_first = UndoOfEdits(*edited, editor, 80, Revision(2));
  const MeshDelta to_second = UndoOfEdits(*edited, editor, 80, Revision(3));
  const MeshDelta merged = Merge(to_second, to_first);
  EXPECT_LT(merged.bytes(), to_first.bytes() + to_second.bytes());
  ASSERT_TRUE(edited->edit.Fits(merged));
  (void)edited->edit.Apply(merged, Revision(4));
  EXPECT_EQ(Written(edited->mesh), first);
}

}  // namespace
}  // namespace pliant
