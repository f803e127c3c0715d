// Goal: what only the engine on disk can do: survive, and fail in part.
#include "server/store/sqlite_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <condition_variable>
#include <fstream>
#include <future>
#include <map>
#include <mutex>
#include <thread>

#include "server/store/maintenance.h"
#include "tests/support/faulty_vfs.h"
#include "tests/support/store_testing.h"
#include "tests/support/temporary_folder.h"

namespace pliant::server {
namespace {

using test::FaultyVfs;
using testing::HasSubstr;
using testing::IsEmpty;

Bytes Filled(std::size_t size, int value) { return Bytes(size, static_cast<std::byte>(value)); }

StoreKey KeyOf(int i) { return {DocumentKind::kSession, "t", "s" + std::to_string(i)}; }

Status Append(Store& store, int session, std::int64_t number, const Bytes& record) {
  return Do([&](auto done) {
    store.Append(KeyOf(session), Epoch::kFirst, {number, {record}, Filled(10, 1)}, done);
  });
}

Status Create(Store& store, int session) {
  return Do([&](auto done) {
    store.Create(KeyOf(session), {Filled(10, 0), Filled(100, session)}, done);
  });
}

TEST(SqliteStore, IsThereAgainAfterItWasClosed) {
  const test::TemporaryFolder folder;
  {
    const auto store = Open(folder.path());
    ASSERT_TRUE(Create(*store, 1).ok());
    store->Append(KeyOf(1), Epoch::kFirst, {1, {Filled(9, 1), Filled(9, 2)}, {}},
                  [](const Status&) {});
    // What is queued is written before the end.
  }
  const auto store = Open(folder.path());
  const auto document = store->Load(KeyOf(1));
  ASSERT_TRUE(document.ok()) << document.error().message;
  EXPECT_EQ(document->records.size(), 2u);
  EXPECT_EQ(store->Load(KeyOf(2)).error().code, ErrorCode::kSessionNotFound);
}

TEST(SqliteStore, IsOpenedOnce) {
  const test::TemporaryFolder folder;
  const auto store = Open(folder.path());
  const auto second = SqliteStore::Open({.directory = folder.path(), .vfs = {}});
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(second.error().message, HasSubstr(folder.path()));
}

// Goal: writes of many threads are all there, in order, each done once.
TEST(SqliteStore, ServesManySessionsAtOnce) {
  constexpr int kThreads = 4;
  constexpr int kRecords = 50;
  const test::TemporaryFolder folder;
  const auto store = Open(folder.path());
  std::mutex mutex;
  std::condition_variable all_done;
  int done_count = 0;
  int bad_count = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    ASSERT_TRUE(Create(*store, t).ok());
    threads.emplace_back([&, t] {
      for (int i = 1; i <= kRecords; ++i) {
        store->Append(KeyOf(t), Epoch::kFirst, {i, {Filled(100, i)}, Filled(4, i)},
                      [&](const Status& status) {
                        const std::lock_guard lock(mutex);
                        ++done_count;
                        bad_count += status.ok() ? 0 : 1;
                        all_done.notify_all();
                      });
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  std::unique_lock lock(mutex);
  all_done.wait(lock, [&] { return done_count == kThreads * kRecords; });
  EXPECT_EQ(bad_count, 0);
  for (int t = 0; t < kThreads; ++t) {
    const auto document = store->Load(KeyOf(t));
    ASSERT_TRUE(document.ok());
    ASSERT_EQ(document->records.size(), static_cast<std::size_t>(kRecords));
    for (int i = 1; i <= kRecords; ++i) {
      EXPECT_EQ(document->records[static_cast<std::size_t>(i) - 1], Filled(100, i));
    }
  }
}

// What a run of writes was told, to be compared with what is there afterwards.
struct Told {
  std::int64_t acknowledged = 0;  // Records that were.
  std::int64_t tried = 0;
  bool is_created = false;
};

// Creates a session, appends records with a snapshot in between, until `writes` are done or one
// fails.
Told RunScript(SqliteStore& store, int session) {
  Told told;
  told.is_created = Create(store, session).ok();
  for (int i = 1; told.is_created && i <= 6; ++i) {
    told.tried = i;
    if (!Append(store, session, i, Filled(3000, i)).ok()) break;
    told.acknowledged = i;
    if (i == 3) {
      static_cast<void>(Do([&](auto done) {
        store.PutSnapshot(KeyOf(session), Epoch::kFirst, {2, Filled(9000, 100)}, done);
      }));
    }
  }
  return told;
}

void ExpectWhatWasTold(Store& store, int session, const Told& told) {
  const auto document = store.Load(KeyOf(session));
  if (!document.ok()) {
    EXPECT_FALSE(told.is_created) << document.error().message;
    EXPECT_EQ(document.error().code, ErrorCode::kSessionNotFound);
    return;
  }
  const std::int64_t last = document->head.last_number;
  EXPECT_GE(last, told.acknowledged) << "an acknowledged record is lost";
  EXPECT_LE(last, told.tried);
  const std::int64_t first = document->head.snapshot_number;
  EXPECT_EQ(document->snapshot, first == 0 ? Filled(100, session) : Filled(9000, 100));
  for (std::int64_t i = first + 1; i <= last; ++i) {
    EXPECT_EQ(document->records[static_cast<std::size_t>(i - first - 1)],
              Filled(3000, static_cast<int>(i)));
  }
}

// Method: the same writes again and again, with a disk that dies at the first, second, third, ...
// change of a file (torn in the middle where it is a write); afterwards the files are opened as the
// crash left them. Ends when a run gets through.
TEST(SqliteStore, LosesNothingAcknowledgedWhereverTheDiskDies) {
  int crashes = 0;
  for (int at = 1;; ++at) {
    SCOPED_TRACE(testing::Message() << "change " << at);
    const test::TemporaryFolder folder;
    Told told;
    {
      FaultyVfs vfs;
      auto opened = SqliteStore::Open({.directory = folder.path(), .vfs = vfs.name()});
      ASSERT_TRUE(opened.ok());
      vfs.FailAt(at, SQLITE_IOERR_WRITE, FaultyVfs::Mode::kFromThenOn);
      told = RunScript(**opened, 1);
      const bool is_through = told.acknowledged == 6 && vfs.changes() < at;
      std::move(opened).value().reset();
      if (is_through) break;
    }
    ++crashes;
    const auto store = Open(folder.path());
    ASSERT_NE(store, nullptr);
    ExpectWhatWasTold(*store, 1, told);
    EXPECT_THAT(*CheckStore({.directory = folder.path(), .vfs = {}}), IsEmpty());
  }
  EXPECT_GT(crashes, 30) << "the script changes files more often than that";
}

// Method: the same with errors that pass: full, a failed write, a failed synchronisation. The write
// that met it says so, others go on, and the store works again at once.
TEST(SqliteStore, GoesOnAfterAnErrorThatPasses) {
  for (const int error : {SQLITE_FULL, SQLITE_IOERR_WRITE, SQLITE_IOERR_FSYNC}) {
    for (int at = 1; at <= 24; ++at) {
      SCOPED_TRACE(testing::Message() << "error " << error << " at change " << at);
      const test::TemporaryFolder folder;
      FaultyVfs vfs;
      const auto store = Open(folder.path(), vfs.name());
      ASSERT_TRUE(Create(*store, 2).ok());
      vfs.FailAt(at, error, FaultyVfs::Mode::kOnce);
      const Told told = RunScript(*store, 1);
      vfs.Heal();
      ExpectWhatWasTold(*store, 1, told);
      EXPECT_TRUE(Append(*store, 2, 1, Filled(50, 5)).ok()) << "the others go on";
      if (told.is_created) {
        const std::int64_t last = store->Load(KeyOf(1))->head.last_number;
        EXPECT_EQ(last, told.acknowledged) << "a write that failed left something";
        EXPECT_TRUE(Append(*store, 1, last + 1, Filled(50, 5)).ok());
      }
      EXPECT_THAT(*CheckStore({.directory = folder.path(), .vfs = {}}), IsEmpty());
    }
  }
}

TEST(SqliteStore, SaysWhatIsWrongWhenTheDiskIsFull) {
  const test::TemporaryFolder folder;
  FaultyVfs vfs;
  const auto store = Open(folder.path(), vfs.name());
  ASSERT_TRUE(Create(*store, 1).ok());
  vfs.FailAt(1, SQLITE_FULL, FaultyVfs::Mode::kFromThenOn);
  const Status full = Append(*store, 1, 1, Filled(3000, 1));
  ASSERT_FALSE(full.ok());
  EXPECT_EQ(full.error().code, ErrorCode::kResourceExhausted);
  EXPECT_THAT(full.error().message, HasSubstr(folder.path()));
  EXPECT_TRUE(store->Load(KeyOf(1)).ok()) << "what is there can be read";
  vfs.Heal();
  EXPECT_TRUE(Append(*store, 1, 1, Filled(3000, 1)).ok());
}

// Writes into the file behind SQLite's back. The database is closed, so that all is in one file.
void Overwrite(const std::string& directory, const std::string& find, std::size_t offset) {
  const std::string path = directory + "/pliant.sqlite";
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(file)), {});
  const std::size_t at = text.find(find);
  ASSERT_NE(at, std::string::npos);
  file.clear();
  file.seekp(static_cast<std::streamoff>(at + offset));
  file.put('\x55');
}

// Goal: a byte of one session's record rots: that session says so, the others are served.
TEST(SqliteStore, ADamagedRecordHarmsItsSessionAlone) {
  const test::TemporaryFolder folder;
  std::string mark = "MARK";
  Bytes record;
  for (int i = 0; i < 40; ++i)
    record.push_back(static_cast<std::byte>(mark[static_cast<std::size_t>(i) % 4]));
  {
    const auto store = Open(folder.path());
    for (int i = 1; i <= 2; ++i) ASSERT_TRUE(Create(*store, i).ok());
    ASSERT_TRUE(Append(*store, 1, 1, record).ok());
    ASSERT_TRUE(Append(*store, 2, 1, Filled(40, 3)).ok());
  }
  Overwrite(folder.path(), "MARKMARK", 10);
  const auto store = Open(folder.path());
  const auto bad = store->Load(KeyOf(1));
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().code, ErrorCode::kDataCorrupt);
  EXPECT_THAT(bad.error().message, HasSubstr("s1"));
  EXPECT_TRUE(store->Load(KeyOf(2)).ok());
  EXPECT_EQ(store->List(DocumentKind::kSession)->size(), 2u);
  EXPECT_EQ(CheckStore({.directory = folder.path(), .vfs = {}})->size(), 1u);
  EXPECT_TRUE(Append(*store, 2, 2, Filled(40, 4)).ok());
  EXPECT_TRUE(Do([&](auto done) { store->Delete(KeyOf(1), Epoch::kFirst, done); }).ok());
  EXPECT_THAT(*CheckStore({.directory = folder.path(), .vfs = {}}), IsEmpty());
}

TEST(SqliteStore, RefusesATruncatedFile) {
  const test::TemporaryFolder folder;
  {
    const auto store = Open(folder.path());
    ASSERT_TRUE(Create(*store, 1).ok());
    for (int i = 1; i <= 20; ++i) ASSERT_TRUE(Append(*store, 1, i, Filled(3000, i)).ok());
  }
  const std::string path = folder.path() + "/pliant.sqlite";
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2 / 4096 * 4096);
  const auto store = SqliteStore::Open({.directory = folder.path(), .vfs = {}});
  // SQLite sees it when it meets the first page that is gone: at once or at the session.
  const ErrorCode code = store.ok() ? (*store)->Load(KeyOf(1)).error().code : store.error().code;
  EXPECT_EQ(code, ErrorCode::kDataCorrupt);
}

TEST(SqliteStore, RefusesAReadOnlyDirectory) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(chmod(folder.path().c_str(), 0555), 0);
  // Nothing is read-only for root: be nobody meanwhile.
  constexpr uid_t kNobody = 65534;
  const uid_t user = geteuid();
  ASSERT_EQ(seteuid(user == 0 ? kNobody : user), 0);
  const auto store = SqliteStore::Open({.directory = folder.path(), .vfs = {}});
  ASSERT_EQ(seteuid(user), 0);
  EXPECT_EQ(store.error().code, ErrorCode::kFileUnwritable);
  chmod(folder.path().c_str(), 0700);
}

}  // namespace
}  // namespace pliant::server
