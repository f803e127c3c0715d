#include "client/cli/detach.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace pliant::cli {
namespace {

struct Parsed {
  bool detach = false;
  DetachOptions options;
  int code = 0;

  explicit Parsed(const std::string& line) {
    CLI::App app;
    app.add_flag("--detach", detach);
    AddDetachOptions(app, options);
    try {
      app.parse(line);
    } catch (const CLI::ParseError& error) {
      code = error.get_exit_code();
    }
  }
};

TEST(Detach, HandsItsOptionsToTheJob) {
  const Parsed parsed("--detach --job-id plate --priority -3 --keep-h 0.5");
  ASSERT_EQ(parsed.code, 0);
  RemeshJob job;
  job.options.seed = 9;
  job.advance.visits_max = 4;
  const client::JobSettings settings = parsed.options.Settings(job);
  EXPECT_EQ(settings.job_id, "plate");
  EXPECT_EQ(settings.priority, -3);
  EXPECT_EQ(settings.keep, std::chrono::minutes(30));
  EXPECT_EQ(settings.options.seed, 9U);
  EXPECT_EQ(settings.advance.visits_max, 4);
}

TEST(Detach, HasNoOptionsWithoutItsFlag) {
  EXPECT_EQ(Parsed("--detach").code, 0);
  EXPECT_NE(Parsed("--job-id plate").code, 0);
  EXPECT_NE(Parsed("--priority 3").code, 0);
  EXPECT_NE(Parsed("--detach --keep-h -1").code, 0);
}

}  // namespace
}  // namespace pliant::cli
