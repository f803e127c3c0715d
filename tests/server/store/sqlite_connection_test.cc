#include "server/store/sqlite_connection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace pliant::server {
namespace {

using testing::HasSubstr;
using Mode = SqliteConnection::Mode;

class SqliteConnectionTest : public testing::Test {
 protected:
  const test::TemporaryFolder folder_;
  const std::string path_ = folder_.path() + "/store.sqlite";
};

TEST_F(SqliteConnectionTest, MakesAndOpensADatabaseInTheLogMode) {
  auto writer = SqliteConnection::Open(path_, Mode::kWrite, "");
  ASSERT_TRUE(writer.ok()) << writer.error().message;
  EXPECT_EQ((*writer)->database().execAndGet("PRAGMA journal_mode").getString(), "wal");
  EXPECT_EQ((*writer)->database().execAndGet("PRAGMA synchronous").getInt(), 2) << "FULL";
  EXPECT_EQ((*writer)->database().execAndGet("PRAGMA user_version").getInt(), kStoreVersion);
  (*writer)->Run("BEGIN IMMEDIATE");
  (*writer)->Run("INSERT INTO rows VALUES(1, 1, 1, 0, 1, 0, 0, 0, x'')");
  (*writer)->RollBack();
  EXPECT_EQ((*writer)->database().execAndGet("SELECT COUNT(*) FROM rows").getInt(), 0);
  EXPECT_TRUE(SqliteConnection::Open(path_, Mode::kWrite, "").ok());
  auto reader = SqliteConnection::Open(path_, Mode::kRead, "");
  ASSERT_TRUE(reader.ok());
  EXPECT_THROW((*reader)->Run("DELETE FROM rows"), SQLite::Exception);
}

TEST_F(SqliteConnectionTest, RefusesWhatANewerProgramWrote) {
  {
    auto writer = SqliteConnection::Open(path_, Mode::kWrite, "");
    ASSERT_TRUE(writer.ok());
    (*writer)->database().exec("PRAGMA user_version = 2");
  }
  const auto again = SqliteConnection::Open(path_, Mode::kWrite, "");
  ASSERT_FALSE(again.ok());
  EXPECT_EQ(again.error().code, ErrorCode::kDataVersion);
  EXPECT_THAT(again.error().message, HasSubstr("format 2"));
}

TEST_F(SqliteConnectionTest, RefusesWhatIsNoStore) {
  std::ofstream(path_) << std::string(5000, 'x');
  EXPECT_EQ(SqliteConnection::Open(path_, Mode::kWrite, "").error().code, ErrorCode::kDataCorrupt);
  const std::string other = folder_.path() + "/other.sqlite";
  SQLite::Database(other, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE).exec("CREATE TABLE t(a)");
  const auto foreign = SqliteConnection::Open(other, Mode::kWrite, "");
  EXPECT_EQ(foreign.error().code, ErrorCode::kDataCorrupt);
  EXPECT_THAT(foreign.error().message, HasSubstr(other));
}

TEST_F(SqliteConnectionTest, NamesWhatIsWrong) {
  const auto missing =
      SqliteConnection::Open(folder_.path() + "-is-missing/file", Mode::kWrite, "");
  EXPECT_EQ(missing.error().code, ErrorCode::kFileUnwritable);
  const auto code_of = [](int code) {
    return SqliteConnection::ToError(SQLite::Exception("x", code), "p").code;
  };
  EXPECT_EQ(code_of(13), ErrorCode::kResourceExhausted) << "SQLITE_FULL";
  EXPECT_EQ(code_of(8), ErrorCode::kFileUnwritable) << "SQLITE_READONLY";
  EXPECT_EQ(code_of(11), ErrorCode::kDataCorrupt) << "SQLITE_CORRUPT";
  EXPECT_EQ(code_of(18), ErrorCode::kTooLarge) << "SQLITE_TOOBIG";
  EXPECT_EQ(code_of(10), ErrorCode::kUnavailable) << "SQLITE_IOERR";
}

TEST_F(SqliteConnectionTest, MovesTheLogIntoTheDatabase) {
  auto writer = SqliteConnection::Open(path_, Mode::kWrite, "");
  ASSERT_TRUE(writer.ok());
  const auto size = [&] { return std::filesystem::file_size(path_); };
  const auto before = size();
  (*writer)->Run("INSERT INTO rows VALUES(1, 1, 1, 0, 1, 0, 0, 0, zeroblob(100000))");
  (*writer)->Checkpoint(1000);
  EXPECT_EQ(size(), before) << "too little to be worth it";
  (*writer)->Checkpoint(10);
  EXPECT_GT(size(), before + 100000);
}

}  // namespace
}  // namespace pliant::server
