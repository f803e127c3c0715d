#include "core/pliant/check_options.h"

#include <array>
#include <limits>
#include <sstream>

namespace pliant {
namespace {

struct RangeRule {
  const char* name;
  double value;
  double low;
  double high;
};

Error OutOfRange(const RangeRule& rule) {
  std::ostringstream message;
  message << "options." << rule.name << " is " << rule.value << "; expected " << rule.low << " to "
          << rule.high;
  return {ErrorCode::kOutOfRange, message.str(), std::string("options.") + rule.name};
}

}  // namespace

Status CheckOptions(const Options& options) {
  const std::array rules{
      RangeRule{"step", options.step, 0, 1},
      RangeRule{"speed_threshold", options.speed_threshold, 0, 1},
      RangeRule{"age_max", static_cast<double>(options.age_max), 2, 250},
      RangeRule{"age_cooling", static_cast<double>(options.age_cooling), 1,
                static_cast<double>(options.age_max) - 1},
      RangeRule{"hops_max", static_cast<double>(options.hops_max), 1, 250},
      RangeRule{"metric_tolerance", options.metric_tolerance, 0, 1},
      RangeRule{"boundary_tolerance", options.boundary_tolerance, 0,
                std::numeric_limits<double>::max()},
      RangeRule{"vertices_max", static_cast<double>(options.vertices_max), 3, 1e8},
      RangeRule{"visits_per_vertex_max", static_cast<double>(options.visits_per_vertex_max), 1,
                1e6},
  };
  for (const RangeRule& rule : rules) {
    if (!(rule.value >= rule.low && rule.value <= rule.high)) return OutOfRange(rule);
  }
  return {};
}

}  // namespace pliant
