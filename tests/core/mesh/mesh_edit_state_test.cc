// MeshEdit, the part that goes from one committed state to another.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/mesh_delta.h"
#include "core/mesh/mesh_edit.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::DifferenceOf;
using testing::EditedMesh;
using testing::Faults;
using testing::GridData;
using testing::ImportedMesh;
using testing::RandomEditor;
using testing::Replica;

Bytes StateBytes(const Mesh& mesh) {
  ByteWriter writer;
  WriteMesh(mesh, writer);
  return std::move(writer).Take();
}

std::unique_ptr<EditedMesh> Restored(const Bytes& bytes, Revision revision) {
  auto edited = std::make_unique<EditedMesh>();
  ByteReader reader(bytes);
  MeshState state = ReadMesh(reader);
  EXPECT_TRUE(reader.AtEnd());
  edited->edit.Restore(std::move(state), revision);
  return edited;
}

// Goal: back and forth between any revisions every record, the free slots, the summary and the
//       diffs are those of the first time.
// Method: 12 revisions of random edits; then a random walk over them by undo and redo. Bytes of the
//         whole mesh are compared with those of the first time, a replica follows by the diffs, and
//         at each end of the walk the same edits give the same mesh as in a mesh that was restored
//         from bytes.
TEST(MeshEditState, GoesBackAndForthBitForBit) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const auto edited = ImportedMesh(GridData(5, 5));
    Replica replica;
    EXPECT_EQ(replica.Apply(edited->edit.Commit(Revision(1))), "");
    RandomEditor editor(*edited, seed);
    std::vector<Bytes> states{StateBytes(edited->mesh)};
    std::vector<MeshSummary> summaries{edited->edit.summary()};
    std::vector<MeshDelta> undo;
    std::vector<MeshDelta> redo;
    std::int64_t number = 1;
    for (int revision = 1; revision < 12; ++revision) {
      const int edits = static_cast<int>(editor.rng().Below(60));
      for (int i = 0; i < edits; ++i) editor.Step();
      EXPECT_EQ(replica.Apply(edited->edit.Commit(Revision(++number))), "");
      undo.push_back(*edited->edit.TakeUndo());
      EXPECT_FALSE(edited->edit.TakeUndo().has_value()) << "it can be taken once";
      redo.push_back(edited->edit.InverseOf(undo.back()));
      states.push_back(StateBytes(edited->mesh));
      summaries.push_back(edited->edit.summary());
    }
    std::size_t at = states.size() - 1;
    for (int walk = 0; walk < 60; ++walk) {
      const bool back = at > 0 && (at + 1 == states.size() || editor.rng().Below(2) == 0);
      const MeshDelta& delta = back ? undo[at - 1] : redo[at];
      ASSERT_TRUE(edited->edit.Fits(delta));
      const MeshDiff diff = edited->edit.Apply(delta, Revision(++number));
      at = back ? at - 1 : at + 1;
      ASSERT_EQ(StateBytes(edited->mesh), states[at]);
      ASSERT_EQ(Faults(edited->mesh), "");
      ASSERT_EQ(edited->edit.summary(), summaries[at]);
      ASSERT_EQ(replica.Apply(diff), "");
      ASSERT_EQ(replica.DifferenceTo(edited->mesh), "");
    }
    const auto other = Restored(states[at], Revision(number));
    EXPECT_EQ(other->edit.summary(), summaries[at]);
    EXPECT_EQ(DifferenceOf(edited->mesh, other->mesh), "");
    RandomEditor one(*edited, seed + 1000);
    RandomEditor two(*other, seed + 1000);
    for (int i = 0; i < 200; ++i) {
      one.Step();
      two.Step();
    }
    EXPECT_EQ(DifferenceOf(edited->mesh, other->mesh), "") << "after the same edits";
    EXPECT_EQ(edited->edit.Commit(Revision(99)).summary, other->edit.Commit(Revision(99)).summary);
  }
}

TEST(MeshEditState, RefusesADeltaOfAnotherState) {
  const auto edited = ImportedMesh(GridData(5, 5));
  (void)edited->edit.Commit(Revision(1));
  RandomEditor editor(*edited, 3);
  for (int i = 0; i < 50; ++i) editor.Step();
  (void)edited->edit.Commit(Revision(2));
  const MeshDelta undo = *edited->edit.TakeUndo();
  ASSERT_TRUE(edited->edit.Fits(undo));
  for (int i = 0; i < 50; ++i) editor.Step();
  (void)edited->edit.Commit(Revision(3));
  EXPECT_FALSE(edited->edit.Fits(undo));
}

TEST(MeshEditState, TheFirstCommitHasNoUndo) {
  const auto edited = ImportedMesh(GridData(2, 2));
  EXPECT_FALSE(edited->edit.TakeUndo().has_value());
  (void)edited->edit.Commit(Revision(1));
  EXPECT_FALSE(edited->edit.TakeUndo().has_value());
}

}  // namespace
}  // namespace pliant
