#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/motion/replace_domain.h"
#include "tests/bench/workload_step.h"

namespace pliant::bench {
namespace {

constexpr std::int32_t kHoleCorners = 16;
constexpr double kHoleRadius = 5;  // In lengths that the metric wants at its centre.

/// The domain with a hole where case F has its disc or, elsewhere, on no symmetry.
Domain WithHole(const Domain& domain, const MetricField& field) {
  const Vec2 low = domain.points[0];
  const Vec2 high = domain.points[2];
  const Vec2 center{low.x + 0.6 * (high.x - low.x), low.y + 0.62 * (high.y - low.y)};
  std::int32_t hint = MetricField::kNoHint;
  const double radius = kHoleRadius * AxesFromMetric(field.At(center, hint)).minor_radius;
  Domain holed = domain;
  const auto first = static_cast<std::int32_t>(domain.points.size());
  for (std::int32_t i = 0; i < kHoleCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kHoleCorners;
    holed.points.push_back(center + radius * Vec2{std::cos(angle), std::sin(angle)});
    holed.segments.push_back({first + i, first + (i + 1) % kHoleCorners, 1});
  }
  holed.holes.push_back(center);
  return holed;
}

}  // namespace

/// A hole of ten lengths appears and vanishes, `repeat` times.
Result<nlohmann::json> RunDomain(Remesher& remesher, const Request& request) {
  PLIANT_ASSIGN_OR_RETURN(const BenchCase instance, MakeCase(request.instance));
  const Domain holed = WithHole(instance.domain, *instance.field());
  std::vector<Update> opens;
  std::vector<Update> closes;
  Untouched untouched;
  for (int run = 0; run < request.repeat; ++run) {
    for (const auto& [domain, updates] :
         {std::pair(&holed, &opens), std::pair(&instance.domain, &closes)}) {
      untouched.Before(remesher.mesh(), [](const VertexRecord&) { return true; });
      PLIANT_ASSIGN_OR_RETURN(Update update, RunOne(remesher, [&]() -> Status {
                                PLIANT_ASSIGN_OR_RETURN(const DomainReport report,
                                                        ReplaceDomain(remesher, *domain));
                                (void)report;
                                return {};
                              }));
      untouched.After(update.diff, remesher.Snapshot());
      updates->push_back(std::move(update));
    }
  }
  return nlohmann::json{
      {"open", JsonOf(opens)}, {"close", JsonOf(closes)}, {"untouched", untouched.Json()}};
}

}  // namespace pliant::bench
