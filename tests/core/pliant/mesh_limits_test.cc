#include "core/pliant/mesh_limits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/delaunay/import_mesh.h"
#include "core/mesh/export_mesh.h"
#include "core/metric/function_field.h"
#include "tests/support/mesh_testing.h"

// Random lives draw their seeds from PLIANT_SEED if it is set:
//   PLIANT_SEED=17 core_tests --gtest_filter='MeshLimits*'   replays the run of a failure

namespace pliant {
namespace {

constexpr GradationOptions kAll[] = {{.gradation = 1.5, .rotation = 0.7},
                                     {.gradation = 1.3},
                                     {.rotation = 0.7},
                                     {.gradation = 1.5, .rotation = 0.7, .smoothing_count = 2}};

Metric RandomTensor(Rng& rng) {
  const double major = std::pow(10, rng.Uniform(-1, 1.5));
  const double angle = rng.Uniform(0, std::numbers::pi);
  return MetricFromAxes(
      {major, major * std::pow(10, -rng.Uniform(0, 2)), {std::cos(angle), std::sin(angle)}});
}

/// Long axes that turn, with a jump: something to do for every limit.
Metric Formula(Vec2 p) {
  const double angle = 0.4 * p.x + 0.2 * p.y;
  return MetricFromAxes(
      {p.x + p.y < 9 ? 0.3 : 4, p.x < 5 ? 0.1 : 2.5, {std::cos(angle), std::sin(angle)}});
}

/// A mesh whose vertices have limited tensors, and all that happens to it.
class LimitedMesh {
 public:
  LimitedMesh(std::int32_t n, const GradationOptions& options, std::uint64_t seed)
      : made_(testing::ImportedMesh(testing::GridData(n, n))),
        editor_(*made_, seed),
        options_(options) {
    Load();
    (void)limits_.Update();
    Commit();
  }

  MeshLimits& limits() { return limits_; }
  const Mesh& mesh() const { return made_->mesh; }
  Rng& rng() { return editor_.rng(); }

  void Load() {
    const std::vector<VertexId> live = testing::LiveVertices(mesh());
    std::vector<Metric> raw;
    for (const VertexId v : live) raw.push_back(Formula(mesh().position(v)));
    EXPECT_TRUE(limits_.Load(options_, live, raw).ok());
  }

  /// Edits, and tensors at some vertices. @return what the limits changed
  WantedTensors Update(int edits, std::uint64_t tensors) {
    for (int i = 0; i < edits; ++i) (void)editor_.Step();
    // Tensors that were sent move with the mesh, or come from the formula where it is.
    const std::shared_ptr<const MetricField> sent = limits_.RawField(base_);
    const FunctionField formula(Formula);
    EXPECT_TRUE(limits_.Follow(*base_, rng().Below(2) == 0 ? *sent : formula).ok());
    const std::vector<VertexId> live = testing::LiveVertices(mesh());
    for (std::uint64_t i = 0; i < tensors; ++i) {
      limits_.SetRaw(live[rng().Below(live.size())], RandomTensor(rng()));
    }
    WantedTensors wanted = limits_.Update().value();
    base_ = std::make_shared<FrozenMesh>(made_->edit);
    return wanted;
  }

  RawTensors Commit() {
    revision_ = Revision(static_cast<std::int64_t>(revision_) + 1);
    (void)made_->edit.Commit(revision_);
    base_ = std::make_shared<FrozenMesh>(made_->edit);
    return limits_.Commit();
  }
  void Rollback() {
    made_->edit.Rollback();
    limits_.Rollback();
    base_ = std::make_shared<FrozenMesh>(made_->edit);
  }

  /// To the commit before the last one, and what leads back.
  void Undo(const MeshDelta& mesh, const RawTensors& raw) {
    std::vector<VertexId> touched = mesh.vertices.ids;
    const auto add_corners = [&] {
      for (const TriangleId id : mesh.triangles.ids) {
        if (id.value() >= this->mesh().triangle_slots()) continue;
        const TriangleRecord& record = this->mesh().triangle(id);
        if (record.live)
          touched.insert(touched.end(), record.vertices.begin(), record.vertices.end());
      }
    };
    add_corners();
    revision_ = Revision(static_cast<std::int64_t>(revision_) + 1);
    (void)made_->edit.Apply(mesh, revision_);
    add_corners();
    limits_.Apply(raw, touched);
    (void)limits_.Update();
    (void)limits_.Commit();
    base_ = std::make_shared<FrozenMesh>(made_->edit);
  }
  std::optional<MeshDelta> TakeUndo() { return made_->edit.TakeUndo(); }

  std::vector<Metric> Limited() const {
    std::vector<Metric> tensors;
    for (const VertexId v : testing::LiveVertices(mesh())) tensors.push_back(limits_.Limited(v));
    return tensors;
  }

  /// The first difference to limiting everything from the start; empty if there is none.
  std::string DifferenceToFullRun() const {
    const ExportedMesh exported = ExportMesh(mesh());
    std::vector<Metric> raw;
    for (const VertexId v : exported.vertex_ids) {
      if (!limits_.Has(v)) return "no raw tensor at vertex " + std::to_string(v.value());
      raw.push_back(limits_.Raw(v));
    }
    const auto count = static_cast<std::int32_t>(raw.size());
    const LimitedMetrics full = LimitMetrics(GraphOfTriangles(exported.data.triangles, count),
                                             exported.data.points, raw, options_);
    for (std::size_t i = 0; i < raw.size(); ++i) {
      if (limits_.Limited(exported.vertex_ids[i]) != full.tensors[i]) {
        return "vertex " + std::to_string(exported.vertex_ids[i].value());
      }
    }
    if (limits_.report().gradation_count != full.gradation_count) return "gradation_count";
    if (limits_.report().rotation_count != full.rotation_count) return "rotation_count";
    return limits_.All().vertices == exported.vertex_ids ? "" : "raw tensors of dead vertices";
  }

 private:
  std::unique_ptr<testing::EditedMesh> made_;
  testing::RandomEditor editor_;
  GradationOptions options_;
  MeshLimits limits_{made_->edit};
  std::shared_ptr<FrozenMesh> base_;
  Revision revision_ = Revision::kNone;
};

// Goal: whatever happens to mesh and tensors, the limits are those of a full run, to the bit.
// Method: lives of edits, tensors, new beginnings, commits, rollbacks and undos; LimitMetrics,
// which
//         is another program, limits everything each time.
TEST(MeshLimits, EqualAFullRunThroughRandomLives) {
  const char* text = std::getenv("PLIANT_SEED");
  std::uint64_t seed = text == nullptr ? 1 : std::strtoull(text, nullptr, 10);
  for (const GradationOptions& options : kAll) {
    SCOPED_TRACE("replay: PLIANT_SEED=" + std::to_string(seed) +
                 " core_tests --gtest_filter='MeshLimits*'");
    LimitedMesh limited(12, options, seed);
    ASSERT_EQ(limited.DifferenceToFullRun(), "");
    Rng rng(seed);
    for (int step = 0; step < 120; ++step) {
      SCOPED_TRACE(step);
      switch (rng.Below(6)) {
        case 0:
          limited.Rollback();
          break;
        case 1: {
          const std::vector<Metric> before = limited.Limited();
          limited.Rollback();
          const std::vector<Metric> committed = limited.Limited();
          (void)limited.Update(static_cast<int>(rng.Below(30)), rng.Below(4));
          const RawTensors raw = limited.Commit();
          limited.Undo(*limited.TakeUndo(), raw);
          ASSERT_EQ(limited.Limited(), committed);
          break;
        }
        case 2:
          (void)limited.Commit();
          break;
        case 3:
          if (rng.Below(4) == 0) limited.Load();
          (void)limited.limits().Update();
          break;
        default:
          (void)limited.Update(static_cast<int>(rng.Below(40)), rng.Below(6));
      }
      ASSERT_EQ(limited.DifferenceToFullRun(), "");
    }
    ++seed;
  }
}

// Goal: an update names every vertex whose tensor it changed.
TEST(MeshLimits, NameWhatTheyChanged) {
  LimitedMesh limited(14, kAll[0], 3);
  const std::vector<Metric> before = limited.Limited();
  const WantedTensors wanted = limited.Update(0, 2);
  const std::vector<Metric> after = limited.Limited();
  const std::vector<VertexId> live = testing::LiveVertices(limited.mesh());
  EXPECT_NE(before, after);
  for (std::size_t i = 0; i < live.size(); ++i) {
    if (before[i] == after[i]) continue;
    const auto at = std::ranges::find(wanted.vertices, live[i]);
    ASSERT_NE(at, wanted.vertices.end());
    EXPECT_EQ(wanted.tensors[static_cast<std::size_t>(at - wanted.vertices.begin())], after[i]);
  }
  EXPECT_TRUE(limited.Update(0, 0).vertices.empty()) << "nothing changed since";
}

// Goal: a short input segment makes the points at its ends fine, growth leads on from there, and a
// segment that another given point stretches lets go again.
TEST(MeshLimits, LimitTheSizeAtShortSegments) {
  Domain domain;
  domain.points = {{0, 0}, {1, 0}, {1, 0.05}, {1, 1}, {0, 1}};
  for (std::int32_t i = 0; i < 5; ++i) domain.segments.push_back({i, (i + 1) % 5, 1});
  const auto made = testing::DomainMesh(domain);
  const std::vector<VertexId> live = testing::LiveVertices(made->mesh);
  ASSERT_EQ(live.size(), 5U);
  MeshLimits limits(made->edit);
  ASSERT_TRUE(limits
                  .Load({.gradation = 1.5, .geometry = 1}, live,
                        std::vector<Metric>(5, Metric::Isotropic(0.5)))
                  .ok());
  const WantedTensors wanted = limits.Update().value();
  EXPECT_NEAR(wanted.tensors[1].m11, 400, 1e-9);
  EXPECT_NEAR(wanted.tensors[2].m11, 400, 1e-9);
  EXPECT_NEAR(wanted.tensors[0].m11, std::pow(0.05 + 0.4054651081, -2), 1e-6);
  EXPECT_EQ(limits.report().geometry_count, 2);
  EXPECT_GT(limits.report().gradation_count, 0);
  EXPECT_NEAR(limits.report().raw_complexity, 4, 1e-3);
  EXPECT_GT(limits.report().limited_complexity, 4);
  EXPECT_NEAR(limits.report().size_ratio_max, 10, 1e-9);

  (void)made->edit.Commit(Revision(1));
  (void)limits.Commit();
  FrozenMesh base(made->edit);
  made->edit.MoveVertex(VertexId(2), {1, 0.5});
  EXPECT_TRUE(limits.Follow(base, FunctionField([](Vec2) { return Metric::Isotropic(0.5); })).ok());
  (void)limits.Update();
  EXPECT_EQ(limits.report().geometry_count, 0);
  EXPECT_EQ(limits.Limited(VertexId(1)), Metric::Isotropic(0.5)) << "the far end of the segment";
}

// Goal: a point that is given no more has the size that it wants again, though neither it nor any
// triangle has moved.
TEST(MeshLimits, ForgetShortSegmentsAtVerticesThatAreGivenNoMore) {
  Domain domain;
  domain.points = {{0, 0}, {1, 0}, {1, 0.05}, {1, 1}, {0, 1}};
  for (std::int32_t i = 0; i < 5; ++i) domain.segments.push_back({i, (i + 1) % 5, 1});
  const auto made = testing::DomainMesh(domain);
  MeshLimits limits(made->edit);
  ASSERT_TRUE(limits
                  .Load({.gradation = 1.5, .geometry = 1}, testing::LiveVertices(made->mesh),
                        std::vector<Metric>(5, Metric::Isotropic(0.5)))
                  .ok());
  (void)limits.Update();
  (void)made->edit.Commit(Revision(1));
  (void)limits.Commit();
  ASSERT_EQ(limits.report().geometry_count, 2);
  const FunctionField wanted([](Vec2) { return Metric::Isotropic(0.5); });
  for (const std::int32_t v : {1, 2}) {
    FrozenMesh base(made->edit);
    made->edit.Unfix(VertexId(v));
    EXPECT_TRUE(limits.Follow(base, wanted).ok());
    (void)limits.Update();
    EXPECT_EQ(limits.report().geometry_count, 2 - v);
  }
  EXPECT_EQ(limits.Limited(VertexId(1)), Metric::Isotropic(0.5));
}

// Goal: sizes at a gap leave room for as many elements as asked, growth leads on from there, and
// when the far side goes away they let go again, at vertices that have not moved.
TEST(MeshLimits, LimitTheSizeInGaps) {
  Domain domain;
  domain.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.2, 0.1}, {0.8, 0.1}, {0.5, 0.4}};
  for (std::int32_t i = 0; i < 4; ++i) domain.segments.push_back({i, (i + 1) % 4, 1});
  for (std::int32_t i = 0; i < 3; ++i) domain.segments.push_back({4 + i, 4 + (i + 1) % 3, 2});
  domain.holes = {{0.5, 0.2}};
  const auto made = testing::DomainMesh(domain);
  const std::vector<VertexId> live = testing::LiveVertices(made->mesh);
  ASSERT_EQ(live.size(), 7U);
  MeshLimits limits(made->edit);
  ASSERT_TRUE(limits
                  .Load({.gradation = 1.1, .gap_element_count = 2}, live,
                        std::vector<Metric>(7, Metric::Isotropic(0.1)))
                  .ok());
  const WantedTensors wanted = limits.Update().value();
  // Down from the hole's flat side it is 0.1 to the wall: two elements of 0.05.
  EXPECT_NEAR(wanted.tensors[4].m11, 400, 1e-9);
  EXPECT_NEAR(wanted.tensors[5].m11, 400, 1e-9);
  EXPECT_EQ(limits.report().geometry_count, 2);
  EXPECT_GT(limits.report().gradation_count, 0);

  (void)made->edit.Commit(Revision(1));
  (void)limits.Commit();
  FrozenMesh base(made->edit);
  made->edit.MoveVertex(VertexId(0), {0, -5});
  made->edit.MoveVertex(VertexId(1), {1, -5});
  EXPECT_TRUE(limits.Follow(base, FunctionField([](Vec2) { return Metric::Isotropic(0.1); })).ok());
  (void)limits.Update();
  EXPECT_EQ(limits.report().geometry_count, 0);
  EXPECT_EQ(limits.Limited(VertexId(4)), Metric::Isotropic(0.1));
  limits.Rollback();
  EXPECT_EQ(limits.report().geometry_count, 2);
}

TEST(MeshLimits, MergeRawTensorsOfTwoDeltas) {
  const auto tensors = [](std::initializer_list<std::pair<int, double>> sizes) {
    RawTensors raw;
    for (const auto& [v, size] : sizes) {
      raw.vertices.emplace_back(v);
      raw.tensors.push_back(Metric::Isotropic(size));
    }
    return raw;
  };
  const RawTensors first = tensors({{1, 1}, {4, 2}, {9, 3}});
  RawTensors second = tensors({{0, 5}, {4, 6}, {12, 7}});
  const RawTensors merged = Merge(first, second);
  const RawTensors expected = tensors({{0, 5}, {1, 1}, {4, 6}, {9, 3}, {12, 7}});
  EXPECT_FALSE(merged.all);
  EXPECT_EQ(merged.vertices, expected.vertices);
  EXPECT_EQ(merged.tensors, expected.tensors);
  second.all = true;
  EXPECT_EQ(Merge(first, second).vertices, second.vertices) << "all others are gone";
  EXPECT_TRUE(Merge(second, first).all);
}

}  // namespace
}  // namespace pliant
