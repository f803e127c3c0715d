#include "core/pliant/check_options.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

namespace pliant {
namespace {

struct Bound {
  const char* name;
  std::function<void(Options&)> at;      ///< Sets the option to the end of its range.
  std::function<void(Options&)> beyond;  ///< Sets it one past.
};

// Goal: every stated range is checked at its bound and one past it, and the error names the option.
TEST(CheckOptions, AcceptsEveryBoundAndRefusesOnePast) {
  const Bound bounds[] = {
      {"step", [](Options& o) { o.step = 1; }, [](Options& o) { o.step = 1.0001; }},
      {"step", [](Options& o) { o.step = 0; }, [](Options& o) { o.step = -1e-9; }},
      {"speed_threshold", [](Options& o) { o.speed_threshold = 0; },
       [](Options& o) { o.speed_threshold = -0.1; }},
      {"speed_threshold", [](Options& o) { o.speed_threshold = 0.99; },
       [](Options& o) { o.speed_threshold = 1.01; }},
      {"age_max", [](Options& o) { o.age_max = 250; }, [](Options& o) { o.age_max = 251; }},
      {"age_max", [](Options& o) { o.age_max = 2, o.age_cooling = 1; },
       [](Options& o) { o.age_max = 1, o.age_cooling = 1; }},
      {"age_cooling", [](Options& o) { o.age_cooling = 1; }, [](Options& o) { o.age_cooling = 0; }},
      {"age_cooling", [](Options& o) { o.age_cooling = 79; },
       [](Options& o) { o.age_cooling = 80; }},
      {"hops_max", [](Options& o) { o.hops_max = 1; }, [](Options& o) { o.hops_max = 0; }},
      {"hops_max", [](Options& o) { o.hops_max = 250; }, [](Options& o) { o.hops_max = 251; }},
      {"metric_tolerance", [](Options& o) { o.metric_tolerance = 0; },
       [](Options& o) { o.metric_tolerance = -0.01; }},
      {"metric_tolerance", [](Options& o) { o.metric_tolerance = 1; },
       [](Options& o) { o.metric_tolerance = 1.01; }},
      {"boundary_tolerance", [](Options& o) { o.boundary_tolerance = 1e300; },
       [](Options& o) { o.boundary_tolerance = std::numeric_limits<double>::infinity(); }},
      {"boundary_tolerance", [](Options& o) { o.boundary_tolerance = 0; },
       [](Options& o) { o.boundary_tolerance = -1e-300; }},
      {"vertices_max", [](Options& o) { o.vertices_max = 3; },
       [](Options& o) { o.vertices_max = 2; }},
      {"vertices_max", [](Options& o) { o.vertices_max = 100'000'000; },
       [](Options& o) { o.vertices_max = 100'000'001; }},
      {"visits_per_vertex_max", [](Options& o) { o.visits_per_vertex_max = 1; },
       [](Options& o) { o.visits_per_vertex_max = 0; }},
  };
  for (const Bound& bound : bounds) {
    Options good;
    bound.at(good);
    EXPECT_TRUE(CheckOptions(good).ok()) << bound.name;
    Options bad;
    bound.beyond(bad);
    const Status status = CheckOptions(bad);
    ASSERT_FALSE(status.ok()) << bound.name;
    EXPECT_EQ(status.error().code, ErrorCode::kOutOfRange);
    EXPECT_EQ(status.error().field, std::string("options.") + bound.name);
    EXPECT_NE(status.error().message.find(bound.name), std::string::npos);
  }
}

TEST(CheckOptions, AcceptsTheDefaultsAndRefusesNan) {
  EXPECT_TRUE(CheckOptions({}).ok());
  Options options;
  options.metric_tolerance = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(CheckOptions(options).ok());
}

}  // namespace
}  // namespace pliant
