#include "server/store/sqlite_connection.h"

#include <sqlite3.h>

#include <array>
#include <utility>

namespace pliant::server {
namespace {

// Marks a file as ours: "PLST".
constexpr int kApplicationId = 0x504c5354;
// Reads wait that long for a writer that replaces the log; nobody else writes.
constexpr int kBusyMs = 10'000;

// What makes a database of version i one of version i + 1.
constexpr std::array<const char*, kStoreVersion> kUpgrades = {R"(
CREATE TABLE documents(
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  kind INTEGER NOT NULL,
  tenant TEXT NOT NULL,
  name TEXT NOT NULL,
  epoch INTEGER NOT NULL,
  last_number INTEGER NOT NULL,
  snapshot_number INTEGER NOT NULL,
  snapshot_size INTEGER NOT NULL,
  journal_size INTEGER NOT NULL,
  form INTEGER NOT NULL,
  size INTEGER NOT NULL,
  checksum INTEGER NOT NULL,
  head BLOB NOT NULL,
  UNIQUE(kind, tenant, name)
) STRICT;
CREATE TABLE rows(
  document INTEGER NOT NULL,
  part INTEGER NOT NULL,
  number INTEGER NOT NULL,
  piece INTEGER NOT NULL,
  piece_count INTEGER NOT NULL,
  form INTEGER NOT NULL,
  size INTEGER NOT NULL,
  checksum INTEGER NOT NULL,
  bytes BLOB NOT NULL,
  PRIMARY KEY(document, part, number, piece)
) STRICT;
)"};

int Pragma(SQLite::Database& database, const char* name) {
  return database.execAndGet(std::string("PRAGMA ") + name).getInt();
}

}  // namespace

Result<std::unique_ptr<SqliteConnection>> SqliteConnection::Open(const std::string& path, Mode mode,
                                                                 const std::string& vfs) {
  try {
    std::unique_ptr<SqliteConnection> connection(new SqliteConnection(path, mode, vfs));
    PLIANT_RETURN_IF_ERROR(connection->Prepare(mode));
    return connection;
  } catch (const SQLite::Exception& exception) {
    return ToError(exception, path);
  }
}

SqliteConnection::SqliteConnection(const std::string& path, Mode mode, const std::string& vfs)
    : path_(path),
      database_(path,
                mode == Mode::kWrite ? SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE
                                     : SQLite::OPEN_READWRITE,
                kBusyMs, vfs) {}

Status SqliteConnection::Prepare(Mode mode) {
  // Finds damage where it is read instead of where it has spread to.
  database_.exec("PRAGMA cell_size_check = ON");
  if (mode == Mode::kRead) {
    database_.exec("PRAGMA query_only = ON");
    return {};
  }
  const int version = Pragma(database_, "user_version");
  const bool is_new = version == 0 && Pragma(database_, "schema_version") == 0;
  if (!is_new && Pragma(database_, "application_id") != kApplicationId) {
    return Error{ErrorCode::kDataCorrupt,
                 path_ + " is no store of Pliant; choose another data directory", "data"};
  }
  if (version > kStoreVersion) {
    return Error{ErrorCode::kDataVersion,
                 path_ + " has format " + std::to_string(version) +
                     ", which a newer pliantd wrote; this one reads up to format " +
                     std::to_string(kStoreVersion) + ": start that newer one",
                 "data"};
  }
  if (database_.execAndGet("PRAGMA journal_mode = WAL").getString() != "wal") {
    return Error{ErrorCode::kFileUnwritable,
                 path_ + " is on a file system that has no shared memory; use a local disk",
                 "data"};
  }
  database_.exec("PRAGMA synchronous = FULL");
  // The log is cut back to that after it was longer.
  database_.exec("PRAGMA journal_size_limit = 67108864");
  sqlite3_wal_hook(
      database_.getHandle(),
      [](void* pages, sqlite3*, const char*, int count) {
        *static_cast<int*>(pages) = count;
        return SQLITE_OK;
      },
      &log_pages_);
  if (version == kStoreVersion) return {};
  SQLite::Transaction transaction(database_, SQLite::TransactionBehavior::IMMEDIATE);
  for (int from = version; from < kStoreVersion; ++from) {
    database_.exec(kUpgrades[static_cast<std::size_t>(from)]);
  }
  database_.exec("PRAGMA application_id = " + std::to_string(kApplicationId));
  database_.exec("PRAGMA user_version = " + std::to_string(kStoreVersion));
  transaction.commit();
  return {};
}

SQLite::Statement& SqliteConnection::Use(const char* sql) {
  const auto found = statements_.find(sql);
  if (found == statements_.end()) {
    return statements_.emplace(sql, SQLite::Statement(database_, sql)).first->second;
  }
  // The result is that of the last use, which has been reported.
  found->second.tryReset();
  found->second.clearBindings();
  return found->second;
}

void SqliteConnection::RollBack() {
  for (auto& [sql, statement] : statements_) statement.tryReset();
  // Some errors have rolled back already.
  if (sqlite3_get_autocommit(database_.getHandle()) == 0) database_.tryExec("ROLLBACK");
}

void SqliteConnection::Checkpoint(int pages_min) {
  if (log_pages_ < pages_min) return;
  for (auto& [sql, statement] : statements_) statement.tryReset();
  int pages = 0;
  int moved = 0;
  const int result = sqlite3_wal_checkpoint_v2(database_.getHandle(), nullptr,
                                               SQLITE_CHECKPOINT_PASSIVE, &pages, &moved);
  // Whatever it left, the next commit reports again.
  if (result == SQLITE_OK && pages == moved) log_pages_ = 0;
}

Error SqliteConnection::ToError(const SQLite::Exception& exception, const std::string& path) {
  const std::string cause = std::string(exception.what()) + " (SQLite " +
                            std::to_string(exception.getExtendedErrorCode()) + ")";
  switch (exception.getErrorCode() & 0xff) {
    case SQLITE_FULL:
    case SQLITE_NOMEM:
      return {ErrorCode::kResourceExhausted,
              "no space is left for " + path + ": " + cause +
                  "; nothing was written; free some and try again",
              "data"};
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
    case SQLITE_AUTH:
      return {ErrorCode::kFileUnwritable,
              "cannot write " + path + ": " + cause +
                  "; the file and its directory must be writable for the server's user",
              "data"};
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return {ErrorCode::kDataCorrupt,
              path + " is damaged: " + cause +
                  "; check it with pliantd --check-data and restore what is lost from a backup",
              "data"};
    case SQLITE_TOOBIG:
      return {ErrorCode::kTooLarge, "a row is too large for " + path + ": " + cause, "data"};
    default:
      return {ErrorCode::kUnavailable,
              "input or output failed at " + path + ": " + cause +
                  "; nothing was written; look at the disk, then try again",
              "data"};
  }
}

}  // namespace pliant::server
