#include "core/transfer/field_set.h"

#include <gtest/gtest.h>

#include "tests/support/field_testing.h"

namespace pliant {
namespace {

using testing::ValuesOf;

/// A committed grid with random edits at hand.
struct Session {
  Session() : edited(testing::ImportedMesh(testing::GridData(6, 6))), editor(*edited, 17) {
    (void)edited->edit.Commit(Revision(1));
  }

  Status Stage(FieldValues values, std::optional<TransferKind> kind = std::nullopt) {
    return fields.Stage(edited->mesh, {.values = {std::move(values)}, .transfer = kind});
  }
  FieldChanges Commit() {
    FieldChanges changes = fields.Commit(MeshTransfer(edited->mesh, edited->edit.log()));
    (void)edited->edit.Commit(Revision(++revision));
    return changes;
  }

  std::unique_ptr<testing::EditedMesh> edited;
  testing::RandomEditor editor;
  FieldSet fields;
  int revision = 1;
};

double Plane(Vec2 p) { return 1 + p.x - 2 * p.y; }

// Goal: a client that keeps a copy and writes what the changes list has the server's values.
TEST(FieldSet, TellsEveryChangedValue) {
  Session session;
  for (const auto& [name, location] :
       {std::pair("a", FieldLocation::kVertex), std::pair("b", FieldLocation::kTriangle)}) {
    for (const auto& [suffix, kind] : {std::pair("_linear", TransferKind::kLinear),
                                       std::pair("_bounded", TransferKind::kBounded),
                                       std::pair("_mass", TransferKind::kConservative)}) {
      ASSERT_TRUE(session
                      .Stage(ValuesOf(session.edited->mesh, std::string(name) + suffix, location,
                                      [](Vec2 p) { return p.x * p.y; }),
                             kind)
                      .ok());
    }
  }
  std::map<std::string, std::map<std::int32_t, double>> copy;
  for (int step = 0; step < 10; ++step) {
    const FieldChanges changes = session.Commit();
    for (const FieldChange& change : changes.changed) {
      for (std::size_t i = 0; i < change.rows.slots.size(); ++i) {
        copy[change.name][change.rows.slots[i]] = change.rows.values[i];
      }
    }
    ASSERT_EQ(session.fields.fields().size(), 6U);
    for (const Field& field : session.fields.fields()) {
      const auto check = [&](std::int32_t slot) {
        EXPECT_EQ(copy[field.name][slot], field.values[static_cast<std::size_t>(slot)])
            << field.name << " at " << slot;
      };
      if (field.location == FieldLocation::kVertex) {
        for (const VertexId id : testing::LiveVertices(session.edited->mesh)) check(id.value());
      } else {
        for (const TriangleId id : testing::LiveTriangles(session.edited->mesh)) check(id.value());
      }
    }
    for (int i = 0; i < 10; ++i) session.editor.Step();
  }
}

// Goal: the server's linear transfer is what a client gets from the rows, to the bit.
TEST(FieldSet, TransfersLinearlyAsTheRowsSay) {
  Session session;
  FieldValues vectors = ValuesOf(session.edited->mesh, "v", FieldLocation::kVertex,
                                 [](Vec2 p) { return p.x * p.x + 0.1 * p.y; });
  std::vector<double> doubled;
  for (const double value : vectors.values) doubled.insert(doubled.end(), {value, -3 * value});
  vectors.column_count = 2;
  vectors.values = doubled;
  ASSERT_TRUE(session.Stage(vectors).ok());
  (void)session.Commit();
  for (int step = 0; step < 10; ++step) {
    for (int i = 0; i < 20; ++i) session.editor.Step();
    const TransferRows rows = MeshTransfer(session.edited->mesh, session.edited->edit.log()).rows();
    const Field before = *session.fields.Find("v");
    Field client = before;
    client.values.resize(2 * static_cast<std::size_t>(session.edited->mesh.vertex_slots()));
    for (std::size_t i = 0; i < rows.rows.size(); ++i) {
      for (std::size_t column = 0; column < 2; ++column) {
        client.values[2 * rows.vertex_ids[i].index() + column] = ApplyRow(
            rows.rows[i], [&](VertexId source) { return before.row(source.index())[column]; });
      }
    }
    (void)session.Commit();
    for (const VertexId id : testing::LiveVertices(session.edited->mesh)) {
      for (std::size_t column = 0; column < 2; ++column) {
        EXPECT_EQ(session.fields.Find("v")->row(id.index())[column],
                  client.row(id.index())[column]);
      }
    }
  }
}

TEST(FieldSet, WritesStagedValuesBeforeItCarriesThem) {
  Session session;
  ASSERT_TRUE(
      session.Stage(ValuesOf(session.edited->mesh, "p", FieldLocation::kVertex, Plane)).ok());
  for (int i = 0; i < 60; ++i) session.editor.Step();
  (void)session.Commit();
  const Field& field = *session.fields.Find("p");
  for (const VertexId id : testing::LiveVertices(session.edited->mesh)) {
    EXPECT_NEAR(field.values[id.index()], Plane(session.edited->mesh.position(id)), 1e-12);
  }
}

TEST(FieldSet, WritesSomeValuesAndTellsOnlyThose) {
  Session session;
  ASSERT_TRUE(
      session.Stage(ValuesOf(session.edited->mesh, "p", FieldLocation::kVertex, Plane)).ok());
  (void)session.Commit();
  ASSERT_TRUE(session.Stage({.name = "p", .ids = {{3, 8}}, .values = {-7, -8}}).ok());
  const FieldChanges changes = session.Commit();
  ASSERT_EQ(changes.changed.size(), 1U);
  EXPECT_EQ(changes.changed[0].rows.slots, (std::vector<std::int32_t>{3, 8}));
  EXPECT_EQ(changes.changed[0].rows.values, (std::vector<double>{-7, -8}));
}

TEST(FieldSet, GivesAllValuesForASnapshot) {
  Session session;
  const Mesh& mesh = session.edited->mesh;
  ASSERT_TRUE(session.Stage(ValuesOf(mesh, "v", FieldLocation::kVertex, Plane)).ok());
  ASSERT_TRUE(session.Stage(ValuesOf(mesh, "t", FieldLocation::kTriangle, Plane)).ok());
  for (int i = 0; i < 30; ++i) session.editor.Step();
  (void)session.Commit();
  const auto all = session.fields.At(testing::LiveVertices(mesh), testing::LiveTriangles(mesh));
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].name, "t");
  EXPECT_EQ(all[0].rows.slots.size(), static_cast<std::size_t>(mesh.triangle_count()));
  ASSERT_EQ(all[1].rows.slots.size(), static_cast<std::size_t>(mesh.vertex_count()));
  for (std::size_t i = 0; i < all[1].rows.slots.size(); ++i) {
    EXPECT_NEAR(all[1].rows.values[i], Plane(mesh.position(VertexId(all[1].rows.slots[i]))), 1e-12);
  }
}

TEST(FieldSet, DropsFieldsAndForgetsWhatIsDiscarded) {
  Session session;
  const Mesh& mesh = session.edited->mesh;
  ASSERT_TRUE(session.Stage(ValuesOf(mesh, "p", FieldLocation::kVertex, Plane)).ok());
  session.fields.Discard();
  (void)session.Commit();
  EXPECT_EQ(session.fields.Find("p"), nullptr);
  ASSERT_TRUE(session.Stage(ValuesOf(mesh, "p", FieldLocation::kVertex, Plane)).ok());
  (void)session.Commit();
  ASSERT_TRUE(session.fields.Stage(mesh, {.dropped_names = {"p"}}).ok());
  EXPECT_FALSE(session.Stage({.name = "p", .ids = {{3}}, .values = {1}}).ok())
      << "values at some vertices of a field that is to go";
  EXPECT_EQ(session.Commit().dropped_names, std::vector<std::string>{"p"});
  EXPECT_EQ(session.fields.Find("p"), nullptr);
}

}  // namespace
}  // namespace pliant
