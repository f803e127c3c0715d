#include "client/cli/progress_bar.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace pliant::cli {
namespace {

using testing::HasSubstr;

client::AdvanceProgress At(std::int64_t visits, std::int64_t active) {
  return {.active_count = active,
          .visits = visits,
          .vertex_count = 1234567,
          .elapsed = std::chrono::milliseconds(3456)};
}

TEST(ProgressBar, ShowsCountsAndClearsItsLine) {
  std::ostringstream out;
  {
    ProgressBar bar(out, ProgressBar::Target::kTerminal);
    bar.Show(At(1000, 2345));
    EXPECT_THAT(out.str(), HasSubstr("1,234,567 vertices, 2,345 active, 3.4 s"));
    EXPECT_EQ(out.str().find('\n'), std::string::npos);
  }
  EXPECT_EQ(out.str().back(), '\r');
}

TEST(ProgressBar, NeverGoesBack) {
  std::ostringstream out;
  ProgressBar bar(out, ProgressBar::Target::kTerminal);
  const auto filled = [&](const client::AdvanceProgress& progress) {
    out.str("");
    bar.Show(progress);
    return std::ranges::count(out.str(), '#');
  };
  const auto first = filled(At(10'000, 100));
  EXPECT_GT(first, 10);
  EXPECT_EQ(filled(At(11'000, 50'000)), first) << "more work turned up";
  EXPECT_GT(filled(At(1'000'000, 1)), first);
}

TEST(ProgressBar, WritesNothingWhereThereIsNoTerminal) {
  std::ostringstream out;
  {
    ProgressBar bar(out, ProgressBar::Target::kNothing);
    bar.Show(At(1, 1));
  }
  EXPECT_EQ(out.str(), "");
}

TEST(ProgressBar, GroupsDigits) {
  EXPECT_EQ(Grouped(0), "0");
  EXPECT_EQ(Grouped(999), "999");
  EXPECT_EQ(Grouped(1000), "1,000");
  EXPECT_EQ(Grouped(-1234567), "-1,234,567");
}

}  // namespace
}  // namespace pliant::cli
