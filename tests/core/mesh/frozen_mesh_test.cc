#include "core/mesh/frozen_mesh.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/mesh/export_mesh.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

/// What a mesh was, copied whole.
struct Copy {
  explicit Copy(const Mesh& mesh) : exported(ExportMesh(mesh)) {
    locator = std::make_unique<TriangleLocator>(exported.data.points, exported.data.triangles);
    for (const VertexId v : exported.vertex_ids) metrics.push_back(mesh.metric(v));
  }
  ExportedMesh exported;
  std::unique_ptr<TriangleLocator> locator;
  std::vector<Metric> metrics;
};

/// The first way in which a frozen mesh differs from the copy; empty if there is none.
std::string DifferenceOf(FrozenMesh& frozen, const Copy& copy, Rng& rng) {
  frozen.CatchUp();
  for (std::size_t i = 0; i < copy.exported.vertex_ids.size(); ++i) {
    const VertexId v = copy.exported.vertex_ids[i];
    if (frozen.position(v) != copy.exported.data.points[i]) return "position";
    if (frozen.Log(v) != Log(copy.metrics[i])) return "metric";
  }
  for (int i = 0; i < 60; ++i) {
    // Inside, in the hole, outside; on edges and on vertices.
    Vec2 p = {rng.Uniform(-1, 13), rng.Uniform(-1, 13)};
    if (i % 4 == 0) p = {0, rng.Uniform(0, 12)};
    if (i % 10 == 0) p = copy.exported.data.points[rng.Below(copy.exported.data.points.size())];
    const Location expected = copy.locator->Locate(p, -1);
    Vec2 there{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& corners =
          copy.exported.data.triangles[static_cast<std::size_t>(expected.triangle)];
      there +=
          expected.weights[k] * copy.exported.data.points[static_cast<std::size_t>(corners[k])];
    }
    std::vector<Location> found;
    for (const std::int32_t hint : {-1, 7, 1 << 20}) {
      const Location location = frozen.Locate(p, hint);
      const auto triangle = frozen.triangle(TriangleId(location.triangle));
      if (!triangle.live) return "a dead triangle";
      Vec2 at{};
      for (std::size_t k = 0; k < 3; ++k) {
        at += location.weights[k] * frozen.position(triangle.vertices[k]);
      }
      if (location.inside != expected.inside) return "inside";
      if (Length(p - at) > Length(p - there) + 1e-12) return "a point that is not the nearest";
      found.push_back(location);
      const bool corner =
          location.weights[0] == 1 || location.weights[1] == 1 || location.weights[2] == 1;
      if (!corner &&
          (found[0].triangle != location.triangle || found[0].weights != location.weights)) {
        return "an answer that depends on the hint";
      }
    }
  }
  return "";
}

class FrozenMeshTest : public ::testing::Test {
 protected:
  /// A square with a square hole.
  void SetUp() override {
    MeshData data = testing::GridData(12, 12);
    MeshData with_hole;
    std::vector<std::int32_t> row(data.points.size(), -1);
    for (const auto& corners : data.triangles) {
      Vec2 center{};
      for (const std::int32_t v : corners) center += data.points[static_cast<std::size_t>(v)];
      center = (1.0 / 3) * center;
      if (center.x > 4 && center.x < 8 && center.y > 4 && center.y < 8) continue;
      with_hole.triangles.push_back(corners);
      for (std::int32_t& v : with_hole.triangles.back()) {
        std::int32_t& number = row[static_cast<std::size_t>(v)];
        if (number < 0) {
          number = static_cast<std::int32_t>(with_hole.points.size());
          with_hole.points.push_back(data.points[static_cast<std::size_t>(v)]);
        }
        v = number;
      }
    }
    made_ = testing::ImportedMesh(with_hole);
    Commit();
  }

  void Edit(testing::RandomEditor& editor, int steps) {
    for (int i = 0; i < steps; ++i) (void)editor.Step();
  }
  void Commit() {
    revision_ = Revision(static_cast<std::int64_t>(revision_) + 1);
    (void)made_->edit.Commit(revision_);
  }

  std::unique_ptr<testing::EditedMesh> made_;
  Revision revision_ = Revision::kNone;
};

// Goal: the frozen mesh stays what it was through edits, commits and rollbacks.
// Method: a whole copy, and a locator over it.
TEST_F(FrozenMeshTest, StaysWhatItWas) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    testing::RandomEditor editor(*made_, seed);
    Rng rng(seed);
    const Copy at_commit(made_->mesh);
    FrozenMesh frozen(made_->edit);
    ASSERT_EQ(DifferenceOf(frozen, at_commit, rng), "");
    Edit(editor, 40);
    ASSERT_EQ(DifferenceOf(frozen, at_commit, rng), "");

    // Another one in the middle of a revision, that outlives its commit.
    const Copy in_between(made_->mesh);
    FrozenMesh second(made_->edit);
    Edit(editor, 40);
    ASSERT_EQ(DifferenceOf(frozen, at_commit, rng), "");
    ASSERT_EQ(DifferenceOf(second, in_between, rng), "");
    second.CatchUp();
    Commit();
    second.LogWasEmptied();
    ASSERT_EQ(DifferenceOf(second, in_between, rng), "");
    Edit(editor, 40);
    ASSERT_EQ(DifferenceOf(second, in_between, rng), "");
    made_->edit.Rollback();
    second.LogWasEmptied();
    ASSERT_EQ(DifferenceOf(second, in_between, rng), "");
    Edit(editor, 40);
    ASSERT_EQ(DifferenceOf(second, in_between, rng), "");
    Commit();
  }
}

TEST_F(FrozenMeshTest, TakesOtherTensors) {
  FrozenMesh frozen(made_->edit);
  frozen.SetMetric(VertexId(5), Metric::Isotropic(3));
  made_->edit.SetMetric(VertexId(5), Metric::Isotropic(7));
  made_->edit.SetMetric(VertexId(6), Metric::Isotropic(7));
  EXPECT_EQ(frozen.Log(VertexId(5)), Log(Metric::Isotropic(3)));
  EXPECT_EQ(frozen.Log(VertexId(6)), Log(Metric::Isotropic(1)));
}

TEST_F(FrozenMeshTest, HasRowsOnlyForWhatChanged) {
  FrozenMesh frozen(made_->edit);
  testing::RandomEditor editor(*made_, 3);
  Edit(editor, 5);
  frozen.CatchUp();
  EXPECT_EQ(frozen.vertices().size(), made_->edit.log().vertices.size());
  EXPECT_EQ(frozen.triangles().size(), made_->edit.log().triangles.size());
}

}  // namespace
}  // namespace pliant
