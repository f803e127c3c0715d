#include "core/metric/fixed_point.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "core/base/rng.h"

namespace pliant {
namespace {

/// Distances from the nearest source in a graph whose edge lengths change.
struct Distances {
  using Value = double;
  struct Edge {
    std::int32_t to;
    double length;
  };

  std::vector<std::vector<std::int32_t>> rings;
  std::vector<std::vector<double>> lengths;  ///< lengths[p][q]
  std::vector<double> source;
  std::vector<double> value;

  static double Key(double v) { return v; }
  static bool IsBetter(double a, double b) { return a < b; }
  static double None() { return std::numeric_limits<double>::infinity(); }
  double& At(std::int32_t v) { return value[static_cast<std::size_t>(v)]; }
  double Own(std::int32_t v) const { return source[static_cast<std::size_t>(v)]; }
  std::optional<double> Offer(double v, std::int32_t p, std::int32_t q) const {
    return v + lengths[static_cast<std::size_t>(p)][static_cast<std::size_t>(q)];
  }
  std::span<const std::int32_t> Neighbors(std::int32_t v) const {
    return rings[static_cast<std::size_t>(v)];
  }

  /// The same by sweeps over all edges. [Bellman1958]
  std::vector<double> Solved() const {
    std::vector<double> best = source;
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t p = 0; p < rings.size(); ++p) {
        for (const std::int32_t q : rings[p]) {
          const auto to = static_cast<std::size_t>(q);
          if (best[p] + lengths[p][to] >= best[to]) continue;
          best[to] = best[p] + lengths[p][to];
          changed = true;
        }
      }
    }
    return best;
  }
};

Distances RandomGraph(Rng& rng, std::size_t count) {
  Distances graph;
  graph.rings.resize(count);
  graph.lengths.assign(count, std::vector<double>(count, 0));
  graph.source.assign(count, Distances::None());
  graph.value.assign(count, Distances::None());
  for (std::size_t p = 0; p < count; ++p) {
    for (int k = 0; k < 3; ++k) {
      const std::size_t q = rng.Below(count);
      if (q == p || graph.lengths[p][q] > 0) continue;
      graph.rings[p].push_back(static_cast<std::int32_t>(q));
      graph.rings[q].push_back(static_cast<std::int32_t>(p));
      graph.lengths[p][q] = graph.lengths[q][p] = rng.Uniform(0.1, 1);
    }
  }
  return graph;
}

// Goal: sources that come, go, and lengths that change leave the distances that sweeps find.
TEST(FixedPoint, FollowsChangingSourcesAndLengths) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Rng rng(seed);
    Distances graph = RandomGraph(rng, 60);
    FixedPoint<Distances> solver;
    for (int update = 0; update < 40; ++update) {
      for (int i = 0; i < 3; ++i) {
        const std::size_t v = rng.Below(60);
        graph.source[v] = rng.Below(2) == 0 ? rng.Uniform(0, 2) : Distances::None();
        solver.Recheck(graph, static_cast<std::int32_t>(v));
        const std::size_t p = rng.Below(60);
        if (graph.rings[p].empty()) continue;
        const auto q = graph.rings[p][rng.Below(graph.rings[p].size())];
        const auto to = static_cast<std::size_t>(q);
        graph.lengths[p][to] = graph.lengths[to][p] = rng.Uniform(0.1, 1);
        solver.Recheck(graph, static_cast<std::int32_t>(p));
        solver.Recheck(graph, q);
      }
      std::vector<int> settled(60, 0);
      solver.Settle(graph, [&](std::int32_t v) { ++settled[static_cast<std::size_t>(v)]; });
      ASSERT_EQ(graph.value, graph.Solved()) << "seed " << seed << " update " << update;
      for (const int times : settled) EXPECT_LE(times, 2);
    }
  }
}

TEST(FixedPoint, DoesNothingWhereNothingChanged) {
  Rng rng(1);
  Distances graph = RandomGraph(rng, 60);
  graph.source[7] = 0;
  FixedPoint<Distances> solver;
  solver.Recheck(graph, 7);
  solver.Settle(graph, [](std::int32_t) {});
  const std::int64_t settled = solver.settled_count();
  EXPECT_GT(settled, 30);
  for (std::int32_t v = 0; v < 60; ++v) solver.Recheck(graph, v);
  solver.Settle(graph, [](std::int32_t) {});
  EXPECT_EQ(solver.settled_count(), settled);
}

}  // namespace
}  // namespace pliant
