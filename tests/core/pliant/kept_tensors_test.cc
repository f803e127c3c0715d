#include "core/pliant/kept_tensors.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <map>

#include "core/base/rng.h"

namespace pliant {
namespace {

constexpr std::uint64_t kSlots = 40;

using Model = std::map<VertexId, Metric>;

void ExpectSame(const KeptTensors& kept, const Model& model) {
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(kSlots); ++v) {
    const auto found = model.find(VertexId(v));
    ASSERT_EQ(kept.Has(VertexId(v)), found != model.end()) << v;
    if (found == model.end()) continue;
    EXPECT_EQ(kept.At(VertexId(v)), found->second);
    const LogMetric log = Log(found->second);
    EXPECT_EQ(LogDistance(kept.LogAt(VertexId(v)), log), 0);
  }
}

// Goal: a rollback brings back the last commit, and Changed leads there. Method: random changes
// beside a map.
TEST(KeptTensors, GoBackToTheLastCommit) {
  Rng rng(11);
  KeptTensors kept;
  Model model;
  Model committed;
  for (int step = 0; step < 3000; ++step) {
    const VertexId vertex(static_cast<std::int32_t>(rng.Below(kSlots)));
    const std::uint64_t kind = rng.Below(20);
    if (kind < 12) {
      model[vertex] = Metric::Isotropic(rng.Uniform(0.1, 1));
      kept.Set(vertex, model[vertex]);
    } else if (kind < 18) {
      if (model.erase(vertex) > 0) kept.Remove(vertex);
    } else if (kind == 18) {
      Model back = model;
      for (const auto& [v, tensor] : kept.Changed()) back[v] = tensor;
      for (const auto& [v, tensor] : committed) EXPECT_EQ(back.at(v), tensor) << step;
      kept.Commit();
      committed = model;
      EXPECT_TRUE(kept.as_committed());
      EXPECT_TRUE(kept.Changed().empty());
    } else {
      kept.Rollback();
      model = committed;
      EXPECT_TRUE(kept.as_committed());
    }
    ExpectSame(kept, model);
  }
}

}  // namespace
}  // namespace pliant
