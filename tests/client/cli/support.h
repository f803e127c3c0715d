#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "client/cpp/types.h"
#include "core/geometry/domain.h"

namespace pliant::cli {

/// A folder of the running test's own, empty at first and gone afterwards.
class TestFolder {
 public:
  TestFolder() : path_(Name()) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~TestFolder() { std::filesystem::remove_all(path_); }
  [[nodiscard]] std::string Path(const std::string& name) const { return (path_ / name).string(); }

 private:
  static std::filesystem::path Name() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    return std::filesystem::path(testing::TempDir()) /
           (std::string("pliant_cli_") + info->test_suite_name() + "_" + info->name());
  }
  std::filesystem::path path_;
};

/// The unit square with tags 1 to 4.
inline Domain UnitSquare() {
  return {.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
          .segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}},
          .holes = {},
          .regions = {}};
}

}  // namespace pliant::cli
