#include "server/store/maintenance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <string>
#include <utility>

#include "tests/support/store_testing.h"
#include "tests/support/temporary_folder.h"

namespace pliant::server {
namespace {

using testing::IsEmpty;

const StoreKey kKey{DocumentKind::kSession, "t", "s"};

Status AppendRecord(Store& store, std::int64_t number) {
  const Bytes record(3000, static_cast<std::byte>(number));
  return Do([&](auto done) {
    store.Append(kKey, Epoch::kFirst, {.first = number, .records = {record}, .head = {}}, done);
  });
}

// Goal: a copy is what was there at one moment, whatever the server does to the original meanwhile.
TEST(BackUpStore, CopiesAStoreThatIsInUse) {
  const test::TemporaryFolder folder;
  const SqliteStore::Options options{.directory = folder.path() + "/store", .vfs = {}};
  const std::string copy = folder.path() + "/copy";
  const auto store = Open(options.directory);
  ASSERT_TRUE(Do([&](auto done) { store->Create(kKey, {}, done); }).ok());
  ASSERT_TRUE(AppendRecord(*store, 1).ok());
  const Status done = BackUpStore(options, copy);
  ASSERT_TRUE(done.ok()) << done.error().message;
  ASSERT_TRUE(AppendRecord(*store, 2).ok());
  EXPECT_EQ(BackUpStore(options, copy).error().code, ErrorCode::kFileUnwritable)
      << "a copy must not be overwritten";
  EXPECT_THAT(*CheckStore({.directory = copy, .vfs = {}}), IsEmpty());
  const auto other = Open(copy);
  EXPECT_EQ(other->Load(kKey)->records.size(), 1u);
  EXPECT_TRUE(AppendRecord(*other, 2).ok()) << "the copy is a store like any other";
  EXPECT_THAT(*CheckStore(options), IsEmpty()) << "also while it is in use";
}

TEST(CheckStore, SaysThatThereIsNone) {
  const test::TemporaryFolder folder;
  const SqliteStore::Options options{.directory = folder.path(), .vfs = {}};
  EXPECT_EQ(CheckStore(options).error().code, ErrorCode::kFileNotFound);
  EXPECT_EQ(BackUpStore(options, folder.path() + "/copy").error().code, ErrorCode::kFileNotFound);
}

}  // namespace
}  // namespace pliant::server
