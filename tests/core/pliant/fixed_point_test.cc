#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "core/base/rng.h"
#include "core/delaunay/import_mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/pliant/loop.h"
#include "core/pliant/nested_build.h"
#include "tests/support/cases.h"

namespace pliant {
namespace {

/// A finished mesh whose nodes can be disturbed one at a time.
class FinishedMesh {
 public:
  explicit FinishedMesh(testing::Case test_case)
      : field_(std::move(test_case.field)), edit_(mesh_), loop_(edit_, Options{}) {
    const auto plan = PlanDomain(test_case.domain);
    BuildFromPlan(*plan, edit_);
    NestedBuild build(edit_, loop_, field_, Options{});
    const Helpers helpers;
    while (build.Run(Budget{}, helpers) == StopReason::kConverged && build.levels_left() > 0) {
      EXPECT_TRUE(build.NextLevel(helpers, nullptr));
    }
    Mend();
    edit_.Compact();
    edit_.Commit(Revision{1});
  }

  /// Visits that follow when these nodes are visited again with an unchanged metric; the mesh is
  /// put back afterwards.
  std::int64_t VisitsAfterRevisiting(std::span<const VertexId> nodes) {
    loop_.ResetCounts();
    loop_.BeginUpdate(SettingsOf(Options{}));
    for (const VertexId node : nodes) loop_.Revisit(node);
    EXPECT_EQ(loop_.Run(*field_, Budget{}), StopReason::kConverged);
    Mend();
    edit_.Rollback();
    return loop_.counts().visits;
  }

  [[nodiscard]] std::int32_t vertex_count() const { return mesh_.vertex_count(); }

 private:
  void Mend() {
    InlineExecutor alone;
    while (loop_.Mend(alone)) EXPECT_EQ(loop_.Run(*field_, Budget{}), StopReason::kConverged);
  }

  std::shared_ptr<const MetricField> field_;
  Mesh mesh_;
  MeshEdit edit_;
  PliantLoop loop_;
};

struct Calm {
  const char* name;
  testing::Case (*make)(double);
  double node_count;
  std::int64_t visits_max;
};

testing::Case Shock(double node_count) { return testing::ShockCase(node_count); }

class FixedPoint : public ::testing::TestWithParam<Calm> {};

// Goal: a finished mesh is at rest. Whichever single node is visited again, nearly nothing follows:
// no avalanche, and the maximum counts, not the median.
TEST_P(FixedPoint, NoNodeStartsAnAvalanche) {
  FinishedMesh mesh(GetParam().make(GetParam().node_count));
  std::int64_t worst = 0;
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    const VertexId node(v);
    worst = std::max(worst, mesh.VisitsAfterRevisiting({&node, 1}));
  }
  RecordProperty("worst_visits", static_cast<int>(worst));
  EXPECT_LE(worst, GetParam().visits_max);
}

TEST_P(FixedPoint, OnePercentOfTheNodesStayAmongThemselves) {
  FinishedMesh mesh(GetParam().make(GetParam().node_count));
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed);
    std::vector<VertexId> nodes;
    for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
      if (rng.Unit() < 0.01) nodes.emplace_back(v);
    }
    EXPECT_LE(mesh.VisitsAfterRevisiting(nodes), static_cast<std::int64_t>(nodes.size() * 11 / 10))
        << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, FixedPoint,
                         ::testing::Values(Calm{"A", &testing::GaussianCase, 10000, 25},
                                           Calm{"C100", &Shock, 10000, 25},
                                           Calm{"C1000", &testing::SharpShockCase, 10000, 25}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace pliant
