#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/store/directory_lock.h"
#include "server/store/store.h"
#include "server/store/write_queue.h"

namespace pliant::server {

class SqliteConnection;

/// The database, in the data directory.
inline constexpr char kDatabaseFile[] = "pliant.sqlite";

/// The store of one server: a SQLite database in a directory of its own, with a write-ahead log
/// that is synchronised at every commit.
///
/// One thread writes. What has gathered while it wrote goes into its next transaction, so that many
/// sessions share one wait for the disk. Where a transaction fails, its writes are tried one by
/// one. After an input or output error the database is opened anew.
class SqliteStore final : public Store {
 public:
  struct Options {
    std::string directory = {};
    std::string vfs = {};  ///< SQLite's name of the file system; empty: the usual one.
  };

  /// Errors: those of DirectoryLock::Take and SqliteConnection::Open.
  static Result<std::unique_ptr<SqliteStore>> Open(const Options& options);
  /// Writes what is queued first.
  ~SqliteStore() override;

  void Create(const StoreKey& key, Draft draft, Done done) override;
  Result<Epoch> Claim(const StoreKey& key) override;
  Status Renew(const StoreKey& key, Epoch epoch) override;
  Status Release(const StoreKey& key, Epoch epoch) override;
  void Append(const StoreKey& key, Epoch epoch, StoreBatch batch, Done done) override;
  void PutSnapshot(const StoreKey& key, Epoch epoch, StoreSnapshot snapshot, Done done) override;
  void Delete(const StoreKey& key, Epoch epoch, Done done) override;
  Result<StoredDocument> Load(const StoreKey& key) override;
  Result<std::vector<StoredHead>> List(DocumentKind kind) override;

 private:
  // A write: throws SQLite::Exception, or returns an error before it has written anything.
  using Work = std::function<Status(SqliteConnection&)>;
  struct Write {
    Work work;
    Done done;
  };

  SqliteStore(const Options& options, DirectoryLock lock);
  [[nodiscard]] std::string path() const;
  void Queue(Work work, std::size_t bytes, Done done);
  Status Wait(Work work);
  void RunWriter();
  void Run(std::vector<Write> writes);
  std::vector<Status> Try(const std::vector<Write>& writes);
  template <class Value>
  Result<Value> Read(const std::function<Result<Value>(SqliteConnection&)>& work);

  const Options options_;
  const DirectoryLock lock_;
  std::unique_ptr<SqliteConnection> writer_;  // Of the thread that writes; null after an error.
  Error last_error_;                          // Of the thread that writes.
  std::mutex read_mutex_;                     // Guards reader_; a leaf lock.
  std::unique_ptr<SqliteConnection> reader_;
  WriteQueue<Write> queue_;
  std::thread thread_;
};

}  // namespace pliant::server
