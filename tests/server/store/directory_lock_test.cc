#include "server/store/directory_lock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <optional>

#include "tests/support/temporary_folder.h"

namespace pliant::server {
namespace {

using testing::HasSubstr;

TEST(DirectoryLock, IsHeldByOneAtATime) {
  const test::TemporaryFolder folder;
  const std::string directory = (std::filesystem::path(folder.path()) / "made" / "anew").string();
  std::optional<Result<DirectoryLock>> first = DirectoryLock::Take(directory);
  ASSERT_TRUE(first->ok()) << first->error().message;
  const Result<DirectoryLock> second = DirectoryLock::Take(directory);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(second.error().message, HasSubstr(directory));
  EXPECT_THAT(second.error().message, HasSubstr("process " + std::to_string(getpid())));
  first.reset();
  EXPECT_TRUE(DirectoryLock::Take(directory).ok());
}

TEST(DirectoryLock, RefusesWhatIsNoDirectory) {
  const test::TemporaryFolder folder;
  const std::string file = folder.path() + "/file";
  std::ofstream(file) << "x";
  const Result<DirectoryLock> lock = DirectoryLock::Take(file);
  ASSERT_FALSE(lock.ok());
  EXPECT_EQ(lock.error().code, ErrorCode::kFileUnwritable);
  EXPECT_THAT(lock.error().message, HasSubstr(file));
}

}  // namespace
}  // namespace pliant::server
