// Prints one line for each of a few small sessions: counts and hash of the mesh after the first
// build and after an update of its metric. The cases together use both loops, expressions with
// elementary functions, gradation, constraints, holes and sliding boundaries.
#include <cstdint>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/domain.h"
#include "core/mesh/mesh_diff.h"
#include "core/metric/metric_spec.h"
#include "core/pliant/remesher.h"

namespace {

using pliant::Domain;
using pliant::ExpressionMetric;
using pliant::MetricSpec;
using pliant::Options;
using pliant::Remesher;
using pliant::SizeMetric;

struct Case {
  std::string name;
  Domain domain;
  MetricSpec metric;
  Options options;
};

// A square of side 2 around the origin, with a diamond in it: a hole, or a constraint.
enum class Diamond { kHole, kConstraint };
Domain SquareWithDiamond(Diamond diamond) {
  Domain domain;
  domain.points = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {0.3, 0}, {0, 0.4}, {-0.5, 0}, {0, -0.6}};
  for (std::int32_t i = 0; i < 4; ++i) {
    domain.segments.push_back({.a = i, .b = (i + 1) % 4, .tag = i});
    domain.segments.push_back({.a = 4 + i, .b = 4 + (i + 1) % 4, .tag = 10 + i});
  }
  if (diamond == Diamond::kHole) domain.holes = {{0, 0}};
  return domain;
}

std::vector<Case> Cases() {
  const ExpressionMetric front{.m11 = "25 + 2000*exp(-(6*(x-t)+sin(3*y))^2)",
                               .m12 = "40*cos(x*y)*exp(-x^2)",
                               .m22 = "25 + 300*exp(-(y-t)^2)"};
  const SizeMetric rings{"0.03 + 0.1*abs(sin(4*sqrt(x^2+y^2)+t))^1.5"};
  return {
      {"front cooled", SquareWithDiamond(Diamond::kConstraint), {.source = front}, {}},
      {"rings graded",
       SquareWithDiamond(Diamond::kHole),
       {.source = rings, .gradation = {.gradation = 1.3, .rotation = 0.7}},
       {}},
      {"front paper",
       SquareWithDiamond(Diamond::kHole),
       {.source = front},
       {.variant = pliant::Variant::kPaper, .seed = 7}},
  };
}

// Steps in small budgets, so that where a step ends matters too.
bool Run(Remesher& remesher, const std::string& name) {
  for (;;) {
    const auto progress = remesher.Step({.visits_max = 1000});
    if (!progress.ok()) {
      std::printf("%s: %s\n", name.c_str(), progress.error().message.c_str());
      return false;
    }
    if (progress->stop_reason != pliant::StopReason::kVisitBudget) break;
  }
  const pliant::MeshSummary summary = remesher.Commit().summary;
  std::printf("%s: %d vertices, %d triangles, %d edges, %016llx\n", name.c_str(),
              summary.vertex_count, summary.triangle_count, summary.edge_count,
              static_cast<unsigned long long>(summary.state_hash));
  return true;
}

bool RunCase(const Case& instance) {
  auto remesher = Remesher::Create(instance.domain, instance.metric, instance.options);
  if (!remesher.ok()) {
    std::printf("%s: %s\n", instance.name.c_str(), remesher.error().message.c_str());
    return false;
  }
  MetricSpec moved = instance.metric;
  moved.time = 0.05;
  return Run(**remesher, instance.name) && (*remesher)->SetMetric(moved).ok() &&
         Run(**remesher, instance.name + ", moved");
}

}  // namespace

int main() {
  bool ok = true;
  for (const Case& instance : Cases()) ok = RunCase(instance) && ok;
  return ok ? 0 : 1;
}
