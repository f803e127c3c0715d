#include "client/cli/error_text.h"

#include <gtest/gtest.h>

namespace pliant::cli {
namespace {

TEST(ErrorText, SaysWhatAndWhere) {
  EXPECT_EQ(ErrorText({.code = ErrorCode::kCrossingSegments,
                       .message = "they cross at (1, 2)",
                       .field = "domain.segments",
                       .index = 7,
                       .other_index = 12}),
            "CROSSING_SEGMENTS at domain.segments[7] and [12]: they cross at (1, 2)");
  EXPECT_EQ(ErrorText({.code = ErrorCode::kInternal, .message = "m"}), "INTERNAL: m");
}

TEST(ErrorText, DoesNotNameAFileTwice) {
  EXPECT_EQ(
      ErrorText(
          {.code = ErrorCode::kFileNotFound, .message = "a.poly: no such file", .field = "a.poly"}),
      "FILE_NOT_FOUND: a.poly: no such file");
}

TEST(ErrorText, ExitCodesTellConnectionsAndInterruptionsApart) {
  const auto code = [](ErrorCode cause) { return ExitCodeOf({.code = cause, .message = ""}); };
  EXPECT_EQ(code(ErrorCode::kUnavailable), ExitCode::kUnreachable);
  EXPECT_EQ(code(ErrorCode::kCancelled), ExitCode::kInterrupted);
  EXPECT_EQ(code(ErrorCode::kNotFinite), ExitCode::kRefused);
  EXPECT_EQ(code(ErrorCode::kInternal), ExitCode::kRefused);
}

}  // namespace
}  // namespace pliant::cli
