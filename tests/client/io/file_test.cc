#include "client/io/file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/client/io/support.h"

namespace pliant::io {
namespace {

TEST(File, ReadsBackWhatWasWrittenAndLeavesNothingElse) {
  const TemporaryFolder folder;
  const std::string path = folder.File("a.bin");
  std::string bytes(100000, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 7);
  ASSERT_TRUE(WriteFileAtomically(path, "old").ok());
  ASSERT_TRUE(WriteFileAtomically(path, bytes).ok());
  EXPECT_EQ(ReadFile(path).value(), bytes);
  const std::filesystem::directory_iterator files(folder.File(""));
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

TEST(File, NamesTheCauseOfAFailure) {
  const TemporaryFolder folder;
  EXPECT_EQ(ReadFile(folder.File("none")).error().code, ErrorCode::kFileNotFound);
  EXPECT_EQ(ReadFile(folder.File("")).error().code, ErrorCode::kFileUnreadable);
  EXPECT_EQ(WriteFileAtomically(folder.File("none/x"), "a").error().code,
            ErrorCode::kFileUnwritable);
  // A folder cannot be replaced by a file; the temporary file must be gone.
  std::filesystem::create_directory(folder.File("taken"));
  EXPECT_EQ(WriteFileAtomically(folder.File("taken"), "a").error().code,
            ErrorCode::kFileUnwritable);
  const std::filesystem::directory_iterator files(folder.File(""));
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

TEST(File, SplitsNames) {
  EXPECT_EQ(Extension("a.b/c.MESH"), ".mesh");
  EXPECT_EQ(Extension("a.b/c"), "");
  EXPECT_EQ(WithoutExtension("a.b/c.1.poly"), "a.b/c.1");
}

}  // namespace
}  // namespace pliant::io
