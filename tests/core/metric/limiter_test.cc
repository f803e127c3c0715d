#include "core/metric/limiter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/mesh/export_mesh.h"
#include "core/mesh/mesh_rings.h"
#include "tests/support/mesh_testing.h"

// Random updates draw their seeds from PLIANT_SEED if it is set:
//   PLIANT_SEED=17 core_tests --gtest_filter='MetricLimiter*'   replays the run of a failure

namespace pliant {
namespace {

constexpr GradationOptions kAll[] = {{.gradation = 1.5, .rotation = 0.7},
                                     {.gradation = 1.3, .rotation = 0.7},
                                     {.gradation = 1.5},
                                     {.rotation = 0.7},
                                     {.gradation = 1, .rotation = 1},
                                     {.gradation = 1.5, .rotation = 0.7, .smoothing_count = 2},
                                     {.rotation = 0.7, .smoothing_count = 1},
                                     {.smoothing_count = 8},
                                     {}};

std::uint64_t FirstSeed() {
  const char* text = std::getenv("PLIANT_SEED");
  return text == nullptr ? 1 : std::strtoull(text, nullptr, 10);
}

Metric RandomTensor(Rng& rng) {
  const double major = std::pow(10, rng.Uniform(-1, 1.5));
  const double angle = rng.Uniform(0, std::numbers::pi);
  return MetricFromAxes(
      {major, major * std::pow(10, -rng.Uniform(0, 2.5)), {std::cos(angle), std::sin(angle)}});
}

/// A mesh under random edits with a limiter that is told of every change.
class FollowedMesh {
 public:
  FollowedMesh(std::int32_t n, const GradationOptions& options, std::uint64_t seed)
      : made_(testing::ImportedMesh(testing::GridData(n, n))),
        editor_(*made_, seed),
        options_(options),
        limiter_(options) {
    MeshRings rings(mesh());
    for (const VertexId v : testing::LiveVertices(mesh())) limiter_.SetRaw(v.value(), RawOf(v));
    (void)limiter_.Update(rings);
    Commit();
  }

  const Mesh& mesh() const { return made_->mesh; }
  MetricLimiter& limiter() { return limiter_; }
  Rng& rng() { return editor_.rng(); }

  void SetRaw(VertexId v, const Metric& raw) {
    made_->edit.SetMetric(v, raw);
    limiter_.SetRaw(v.value(), raw);
  }
  void Edit(int steps) {
    for (int i = 0; i < steps; ++i) (void)editor_.Step();
  }

  /// Tells the limiter what the log of the mesh says, and updates it.
  LimitChanges Update() {
    std::set<VertexId> touched;
    for (const auto& [v, old] : made_->edit.log().vertices) {
      if (!mesh().IsLive(v)) {
        if (old.live) limiter_.Remove(v.value());
        continue;
      }
      limiter_.SetRaw(v.value(), RawOf(v));
      touched.insert(v);
    }
    for (const auto& [t, old] : made_->edit.log().triangles) {
      for (const VertexId v : old.vertices) touched.insert(v);
      for (const VertexId v : mesh().triangle(t).vertices) touched.insert(v);
    }
    for (const VertexId v : touched) {
      if (mesh().IsLive(v)) limiter_.Touch(v.value());
    }
    MeshRings rings(mesh());
    return limiter_.Update(rings);
  }

  void Commit() {
    revision_ = Revision(static_cast<std::int64_t>(revision_) + 1);
    (void)made_->edit.Commit(revision_);
    limiter_.Commit();
  }
  void Rollback() {
    made_->edit.Rollback();
    limiter_.Rollback();
  }

  std::vector<Metric> Limited() const {
    std::vector<Metric> tensors;
    for (const VertexId v : testing::LiveVertices(mesh())) {
      tensors.push_back(limiter_.Limited(v.value()));
    }
    return tensors;
  }

  /// The first difference to limiting everything from the start; empty if there is none.
  std::string DifferenceToFullRun() const {
    const ExportedMesh exported = ExportMesh(mesh());
    std::vector<Metric> raw;
    for (const VertexId v : exported.vertex_ids) raw.push_back(RawOf(v));
    const auto count = static_cast<std::int32_t>(raw.size());
    const LimitedMetrics full = LimitMetrics(GraphOfTriangles(exported.data.triangles, count),
                                             exported.data.points, raw, options_);
    for (std::size_t i = 0; i < raw.size(); ++i) {
      const std::int32_t v = exported.vertex_ids[i].value();
      if (limiter_.Limited(v) != full.tensors[i]) return "vertex " + std::to_string(v);
      if (limiter_.Raw(v) != raw[i]) return "raw tensor of vertex " + std::to_string(v);
    }
    if (limiter_.totals().smoothing_count != full.smoothing_count) return "smoothing_count";
    if (limiter_.totals().rotation_count != full.rotation_count) return "rotation_count";
    if (limiter_.totals().gradation_count != full.gradation_count) return "gradation_count";
    MetricLimiter fresh(options_);
    MeshRings rings(mesh());
    for (const VertexId v : exported.vertex_ids) fresh.SetRaw(v.value(), RawOf(v));
    (void)fresh.Update(rings);
    return limiter_.totals() == fresh.totals() ? "" : "totals";
  }

 private:
  Metric RawOf(VertexId v) const { return mesh().metric(v); }

  std::unique_ptr<testing::EditedMesh> made_;
  testing::RandomEditor editor_;
  GradationOptions options_;
  MetricLimiter limiter_;
  Revision revision_ = Revision::kNone;
};

// Goal: what changes step by step is what comes out when everything is limited anew, to the bit.
// Method: random edits of mesh and tensors, finer and coarser; LimitMetrics, which is another
// program, limits the whole mesh each time.
TEST(MetricLimiter, EqualsTheFullRunAfterRandomUpdates) {
  std::uint64_t seed = FirstSeed();
  for (const GradationOptions& options : kAll) {
    SCOPED_TRACE(::testing::Message() << "gradation " << options.gradation << " rotation "
                                      << options.rotation << " smoothing_count "
                                      << options.smoothing_count << "; replay: PLIANT_SEED=" << seed
                                      << " core_tests --gtest_filter='MetricLimiter*'");
    FollowedMesh followed(14, options, seed);
    ASSERT_EQ(followed.DifferenceToFullRun(), "");
    Rng& rng = followed.rng();
    for (int update = 0; update < 60; ++update) {
      const std::vector<VertexId> live = testing::LiveVertices(followed.mesh());
      const bool back = update % 3 == 2;  // Coarse again: what spread has to be withdrawn.
      for (std::uint64_t i = rng.Below(update % 10 == 0 ? 200 : 8); i > 0; --i) {
        followed.SetRaw(live[rng.Below(live.size())],
                        back ? Metric::Isotropic(30) : RandomTensor(rng));
      }
      if (update % 2 == 1) followed.Edit(static_cast<int>(rng.Below(20)));
      (void)followed.Update();
      ASSERT_EQ(followed.DifferenceToFullRun(), "") << "update " << update;
      followed.Commit();
    }
    ++seed;
  }
}

// Goal: an update reports every vertex whose limited tensor it changed, and only neighbourhoods of
// such.
TEST(MetricLimiter, ReportsWhatChanged) {
  FollowedMesh followed(20, kAll[0], 3);
  std::vector<Metric> before = followed.Limited();
  for (int update = 0; update < 20; ++update) {
    const std::vector<VertexId> live = testing::LiveVertices(followed.mesh());
    followed.SetRaw(live[followed.rng().Below(live.size())], RandomTensor(followed.rng()));
    const LimitChanges changes = followed.Update();
    const std::set<std::int32_t> reported(changes.vertices.begin(), changes.vertices.end());
    const std::vector<Metric> after = followed.Limited();
    for (std::size_t i = 0; i < after.size(); ++i) {
      if (after[i] != before[i]) {
        EXPECT_EQ(reported.count(live[i].value()), 1U);
      }
    }
    EXPECT_EQ(changes.worst >= 0, changes.size_ratio_max > 1);
    before = after;
    followed.Commit();
  }
}

// Goal: the work is that of the change, whatever the mesh weighs. Method: operations, not time.
TEST(MetricLimiter, LooksAtNoMoreInALargerMesh) {
  std::vector<std::int64_t> fine;
  std::vector<std::int64_t> coarse;
  for (const std::int32_t n : {40, 160}) {
    FollowedMesh followed(n, kAll[0], 1);
    for (const VertexId v : testing::LiveVertices(followed.mesh())) {
      followed.SetRaw(v, Metric::Isotropic(3));
    }
    (void)followed.Update();
    followed.Commit();
    const VertexId middle((n + 1) * (n / 2) + n / 2);
    followed.SetRaw(middle, Metric::Isotropic(0.1));
    const LimitChanges finer = followed.Update();
    EXPECT_GT(followed.limiter().totals().gradation_count, 50);
    EXPECT_LT(finer.looked_count, 12 * std::ssize(finer.vertices));
    fine.push_back(finer.looked_count);
    followed.Commit();
    followed.SetRaw(middle, Metric::Isotropic(3));
    const LimitChanges coarser = followed.Update();
    EXPECT_EQ(followed.limiter().totals().gradation_count, 0);
    coarse.push_back(coarser.looked_count);
  }
  EXPECT_EQ(fine[0], fine[1]);
  EXPECT_EQ(coarse[0], coarse[1]);
  EXPECT_LT(coarse[0], 6 * fine[0]);
}

// Goal: a cap holds where it is set and growth carries it on; without it the metric is as before.
TEST(MetricLimiter, CarriesCapsIntoTheMesh) {
  FollowedMesh followed(20, {.gradation = 1.5}, 1);
  for (const VertexId v : testing::LiveVertices(followed.mesh())) {
    followed.SetRaw(v, Metric::Isotropic(4));
  }
  (void)followed.Update();
  followed.Commit();
  followed.limiter().SetRaw(0, Metric::Isotropic(4), 0.25);
  (void)followed.Update();
  EXPECT_EQ(followed.limiter().totals().geometry_count, 1);
  EXPECT_NEAR(followed.limiter().Limited(0).m11, 16, 1e-9);
  EXPECT_NEAR(followed.limiter().Limited(1).m11, std::pow(0.25 + std::log(1.5), -2), 1e-9);
  EXPECT_EQ(followed.limiter().Raw(0), Metric::Isotropic(4));
  const LimitTotals totals = followed.limiter().totals();
  EXPECT_NEAR(static_cast<double>(totals.raw_complexity) * 0x1p-20, 400.0 / 16, 1e-3);
  EXPECT_GT(totals.limited_complexity, totals.raw_complexity);
  followed.limiter().SetRaw(0, Metric::Isotropic(4), 100);
  (void)followed.Update();
  EXPECT_EQ(followed.DifferenceToFullRun(), "");
  EXPECT_EQ(followed.limiter().totals().gradation_count, 0);
}

class RollingBack : public ::testing::TestWithParam<GradationOptions> {};

TEST_P(RollingBack, LeadsToTheLastCommit) {
  FollowedMesh followed(14, GetParam(), 5);
  for (int update = 0; update < 10; ++update) {
    const std::vector<Metric> before = followed.Limited();
    const LimitTotals totals = followed.limiter().totals();
    const std::vector<VertexId> live = testing::LiveVertices(followed.mesh());
    for (int i = 0; i < 5; ++i) {
      followed.SetRaw(live[followed.rng().Below(live.size())], RandomTensor(followed.rng()));
    }
    followed.Edit(20);
    (void)followed.Update();
    EXPECT_NE(followed.Limited(), before);
    followed.Rollback();
    ASSERT_EQ(followed.Limited(), before);
    ASSERT_EQ(followed.limiter().totals(), totals);
    // And what follows is as if nothing had been.
    followed.SetRaw(live[0], RandomTensor(followed.rng()));
    (void)followed.Update();
    ASSERT_EQ(followed.DifferenceToFullRun(), "");
    followed.Commit();
  }
}

INSTANTIATE_TEST_SUITE_P(MetricLimiter, RollingBack, ::testing::ValuesIn(kAll));

}  // namespace
}  // namespace pliant
