// Goal: what Store promises, by the engine that ships and by the one that tests use.
#include "server/store/store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <memory>

#include "server/store/sqlite_store.h"
#include "tests/support/memory_store.h"
#include "tests/support/temporary_folder.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Bytes Text(const std::string& text) {
  Bytes bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

enum class Kind { kMemory, kSqlite };

class StoreTest : public testing::TestWithParam<Kind> {
 protected:
  StoreTest() {
    if (GetParam() == Kind::kMemory) {
      store_ = std::make_unique<MemoryStore>();
    } else {
      store_ = SqliteStore::Open({.directory = folder_.path(), .vfs = {}}).value();
    }
  }
  // Calls a write and waits for it.
  template <class Write>
  Status Do(Write write) {
    std::promise<Status> promise;
    write([&](const Status& status) { promise.set_value(status); });
    return promise.get_future().get();
  }
  Status Create(const StoreKey& key) {
    return Do([&](auto done) { store_->Create(key, {Text("head"), Text("start")}, done); });
  }
  Status Append(const StoreKey& key, Epoch epoch, std::int64_t first, std::vector<Bytes> records,
                const std::string& head = "h") {
    return Do([&](auto done) {
      store_->Append(key, epoch, {first, std::move(records), Text(head)}, done);
    });
  }
  static ErrorCode CodeOf(const Status& status) {
    return status.ok() ? ErrorCode{-1} : status.error().code;
  }

  const test::TemporaryFolder folder_;
  const StoreKey key_{DocumentKind::kSession, "tenant", "s-1"};
  std::unique_ptr<Store> store_;
};

TEST_P(StoreTest, KeepsHeadSnapshotAndRecords) {
  ASSERT_TRUE(Create(key_).ok());
  EXPECT_EQ(CodeOf(Create(key_)), ErrorCode::kSessionExists);
  ASSERT_TRUE(Append(key_, Epoch::kFirst, 1, {Text("a"), Text("b")}).ok());
  ASSERT_TRUE(Append(key_, Epoch::kFirst, 3, {}, "head alone").ok());
  ASSERT_TRUE(Append(key_, Epoch::kFirst, 3, {Bytes{}}, "last").ok());
  const Result<StoredDocument> document = store_->Load(key_);
  ASSERT_TRUE(document.ok()) << document.error().message;
  EXPECT_EQ(document->snapshot, Text("start"));
  EXPECT_THAT(document->records, ElementsAre(Text("a"), Text("b"), Bytes{}));
  EXPECT_EQ(document->head.head, Text("last"));
  EXPECT_EQ(document->head.last_number, 3);
  EXPECT_EQ(document->head.journal_size, 2u);
  EXPECT_EQ(document->head.snapshot_size, 5u);
}

TEST_P(StoreTest, RefusesAGapInTheNumbers) {
  ASSERT_TRUE(Create(key_).ok());
  EXPECT_EQ(CodeOf(Append(key_, Epoch::kFirst, 2, {Text("a")})), ErrorCode::kInternal);
  ASSERT_TRUE(Append(key_, Epoch::kFirst, 1, {Text("a")}).ok());
  EXPECT_EQ(CodeOf(Append(key_, Epoch::kFirst, 1, {Text("b")})), ErrorCode::kInternal);
  EXPECT_THAT(store_->Load(key_)->records, ElementsAre(Text("a")));
}

// Goal: whoever lost a document can never write to it.
TEST_P(StoreTest, OnlyTheLastClaimWrites) {
  EXPECT_EQ(store_->Claim(key_).error().code, ErrorCode::kSessionNotFound);
  ASSERT_TRUE(Create(key_).ok());
  const Result<Epoch> second = store_->Claim(key_);
  ASSERT_TRUE(second.ok());
  EXPECT_GT(*second, Epoch::kFirst);
  EXPECT_EQ(CodeOf(Append(key_, Epoch::kFirst, 1, {Text("old")})), ErrorCode::kSessionBusy);
  EXPECT_EQ(CodeOf(Do([&](auto done) {
              store_->PutSnapshot(key_, Epoch::kFirst, {1, Text("old")}, done);
            })),
            ErrorCode::kSessionBusy);
  EXPECT_EQ(CodeOf(Do([&](auto done) { store_->Delete(key_, Epoch::kFirst, done); })),
            ErrorCode::kSessionBusy);
  EXPECT_EQ(CodeOf(store_->Renew(key_, Epoch::kFirst)), ErrorCode::kSessionBusy);
  EXPECT_EQ(CodeOf(store_->Release(key_, Epoch::kFirst)), ErrorCode::kSessionBusy);
  EXPECT_TRUE(store_->Renew(key_, *second).ok());
  EXPECT_TRUE(Append(key_, *second, 1, {Text("new")}).ok());
  EXPECT_TRUE(store_->Release(key_, *second).ok());
  EXPECT_EQ(CodeOf(Append(key_, *second, 2, {Text("late")})), ErrorCode::kSessionBusy);
  EXPECT_THAT(store_->Load(key_)->records, ElementsAre(Text("new")));
  EXPECT_EQ(store_->Load(key_)->snapshot, Text("start"));
}

TEST_P(StoreTest, ASnapshotReplacesWhatItCovers) {
  ASSERT_TRUE(Create(key_).ok());
  ASSERT_TRUE(Append(key_, Epoch::kFirst, 1, {Text("a"), Text("b"), Text("c")}).ok());
  const auto put = [&](std::int64_t number, const Bytes& bytes) {
    return Do([&](auto done) { store_->PutSnapshot(key_, Epoch::kFirst, {number, bytes}, done); });
  };
  const Bytes large(5 << 20, std::byte{9});
  ASSERT_TRUE(put(2, large).ok());
  Result<StoredDocument> document = store_->Load(key_);
  ASSERT_TRUE(document.ok()) << document.error().message;
  EXPECT_EQ(document->snapshot, large);
  EXPECT_THAT(document->records, ElementsAre(Text("c")));
  EXPECT_EQ(document->head.journal_size, 1u);
  EXPECT_EQ(document->head.snapshot_number, 2);
  ASSERT_TRUE(put(1, Text("older")).ok());
  ASSERT_TRUE(put(9, Text("of what is not there yet")).ok());
  EXPECT_EQ(store_->Load(key_)->snapshot, large);
  ASSERT_TRUE(Append(key_, Epoch::kFirst, 4, {Text("d")}).ok());
  ASSERT_TRUE(put(4, Text("all")).ok());
  document = store_->Load(key_);
  ASSERT_TRUE(document.ok()) << document.error().message;
  EXPECT_EQ(document->snapshot, Text("all"));
  EXPECT_THAT(document->records, IsEmpty());
}

TEST_P(StoreTest, ListsByAgeAndForgetsWhatIsDeleted) {
  for (const char* name : {"b", "a", "c"}) {
    ASSERT_TRUE(Create({DocumentKind::kSession, "t", name}).ok());
  }
  ASSERT_TRUE(Create({DocumentKind::kJob, "t", "j"}).ok());
  ASSERT_TRUE(Do([&](auto done) {
                store_->Delete({DocumentKind::kSession, "t", "a"}, Epoch::kFirst, done);
              }).ok());
  const auto names = [&](DocumentKind kind) {
    std::vector<std::string> found;
    const Result<std::vector<StoredHead>> heads = store_->List(kind);
    for (const StoredHead& head : *heads) {
      EXPECT_EQ(head.head, Text("head"));
      found.push_back(head.key.name);
    }
    return found;
  };
  EXPECT_THAT(names(DocumentKind::kSession), ElementsAre("b", "c"));
  EXPECT_THAT(names(DocumentKind::kJob), ElementsAre("j"));
  EXPECT_EQ(store_->Load({DocumentKind::kSession, "t", "a"}).error().code,
            ErrorCode::kSessionNotFound);
  EXPECT_TRUE(Create({DocumentKind::kSession, "t", "a"}).ok()) << "the name is free again";
}

INSTANTIATE_TEST_SUITE_P(Engines, StoreTest, testing::Values(Kind::kMemory, Kind::kSqlite),
                         [](const auto& parameter) {
                           return parameter.param == Kind::kMemory ? "Memory" : "Sqlite";
                         });

}  // namespace
}  // namespace pliant::server
