#include "core/mesh/snapshot_bytes.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/pliant/remesher.h"

namespace pliant {
namespace {

// A mesh with holes in its slots, made by a real loop, and two fields.
MeshDiff RealSnapshot() {
  const Domain square{.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                      .segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}},
                      .holes = {},
                      .regions = {}};
  auto remesher = Remesher::Create(square, {.source = SizeMetric{"0.1"}}, {}).value();
  EXPECT_TRUE(remesher->Step({}).ok());
  (void)remesher->Commit();
  EXPECT_TRUE(remesher->SetMetric({.source = SizeMetric{"0.05 + 0.2*x"}}).ok());
  EXPECT_TRUE(remesher->Step({}).ok());
  (void)remesher->Commit();
  MeshDiff snapshot = remesher->Snapshot();
  FieldChange at_vertices;
  at_vertices.name = "u";
  at_vertices.column_count = 2;
  for (const VertexId id : snapshot.vertex_ids) {
    at_vertices.rows.slots.push_back(id.value());
    at_vertices.rows.values.insert(at_vertices.rows.values.end(), {0.5 * id.value(), -1});
  }
  FieldChange at_triangles;
  at_triangles.name = "w";
  at_triangles.location = FieldLocation::kTriangle;
  at_triangles.rows = {{snapshot.triangle_ids.back().value()}, {3.25}};
  snapshot.fields.changed = {at_vertices, at_triangles};
  return snapshot;
}

TEST(SnapshotBytes, ComeBackAsTheyWere) {
  const MeshDiff snapshot = RealSnapshot();
  const MeshDiff read = ReadMeshSnapshot(WriteMeshSnapshot(snapshot)).value();
  EXPECT_EQ(read.base_revision, Revision::kNone);
  EXPECT_EQ(read.revision, Revision(2));
  EXPECT_EQ(read.summary, snapshot.summary);
  EXPECT_EQ(read.vertex_ids, snapshot.vertex_ids);
  EXPECT_EQ(read.vertex_positions, snapshot.vertex_positions);
  EXPECT_EQ(read.triangle_ids, snapshot.triangle_ids);
  EXPECT_EQ(read.triangle_vertices, snapshot.triangle_vertices);
  EXPECT_EQ(read.triangle_regions, snapshot.triangle_regions);
  EXPECT_EQ(read.edge_ids, snapshot.edge_ids);
  EXPECT_EQ(read.edge_vertices, snapshot.edge_vertices);
  EXPECT_EQ(read.edge_tags, snapshot.edge_tags);
  EXPECT_EQ(read.metric_vertex_ids, snapshot.metric_vertex_ids);
  EXPECT_EQ(read.metrics, snapshot.metrics);
  EXPECT_EQ(read.fields, snapshot.fields);
  EXPECT_FALSE(snapshot.metrics.empty());
}

// Goal: bytes whose checksum is right and whose contents are not never reach whoever indexes by
// them. Method: a good snapshot, spoiled in one way each.
TEST(SnapshotBytes, RefuseIdsThatNameNothingAndColumnsThatDoNotFit) {
  const std::vector<std::pair<std::string, std::function<void(MeshDiff&)>>> spoilers = {
      {"corner beyond", [](MeshDiff& m) { m.triangle_vertices[0][1] = VertexId(1 << 20); }},
      {"corner negative", [](MeshDiff& m) { m.triangle_vertices[0][1] = VertexId(-1); }},
      {"end beyond", [](MeshDiff& m) { m.edge_vertices[0][0] = VertexId(1 << 20); }},
      {"metric elsewhere", [](MeshDiff& m) { m.metric_vertex_ids.back() = VertexId(1 << 20); }},
      {"field elsewhere", [](MeshDiff& m) { m.fields.changed[1].rows.slots[0] = 1 << 20; }},
      {"ids twice", [](MeshDiff& m) { m.vertex_ids[1] = m.vertex_ids[0]; }},
      {"negative id", [](MeshDiff& m) { m.edge_ids[0] = EdgeId(-1); }},
      {"positions missing", [](MeshDiff& m) { m.vertex_positions.pop_back(); }},
      {"regions missing", [](MeshDiff& m) { m.triangle_regions.pop_back(); }},
      {"tags missing", [](MeshDiff& m) { m.edge_tags.pop_back(); }},
      {"metrics missing", [](MeshDiff& m) { m.metrics.pop_back(); }},
      {"values missing", [](MeshDiff& m) { m.fields.changed[0].rows.values.pop_back(); }},
  };
  const MeshDiff good = RealSnapshot();
  for (const auto& [name, spoil] : spoilers) {
    MeshDiff bad = good;
    spoil(bad);
    const Result<MeshDiff> read = ReadMeshSnapshot(WriteMeshSnapshot(bad));
    ASSERT_FALSE(read.ok()) << name;
    EXPECT_EQ(read.error().code, ErrorCode::kDataCorrupt) << name;
  }
}

TEST(SnapshotBytes, RefuseBytesThatWereCutOrChanged) {
  const Bytes good = WriteMeshSnapshot(RealSnapshot());
  for (std::size_t cut = 0; cut < good.size(); cut += 97) {
    EXPECT_EQ(ReadMeshSnapshot(std::span(good).first(cut)).error().code, ErrorCode::kDataCorrupt)
        << cut;
  }
  Bytes bad = good;
  bad[bad.size() / 2] ^= std::byte{1};
  EXPECT_EQ(ReadMeshSnapshot(bad).error().code, ErrorCode::kDataCorrupt);
}

}  // namespace
}  // namespace pliant
