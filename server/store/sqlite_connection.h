#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <map>
#include <memory>
#include <string>

#include "core/base/result.h"

namespace pliant::server {

/// The version of the tables; server/store/README.md tells what changed in each.
inline constexpr int kStoreVersion = 1;

/// One connection to a store's database, with the statements that it has prepared.
///
/// Calls throw SQLite::Exception, as SQLiteCpp does; ToError makes errors of them.
///
/// *Threads*: one caller at a time.
class SqliteConnection {
 public:
  /// What a connection is for.
  enum class Mode { kWrite, kRead };

  /// Opens a database; the writer makes it if it is not there, and brings an older one up to date.
  /// @param vfs  SQLite's name of the file system; empty: the usual one.
  /// Errors: those of ToError; kDataVersion for one that a newer program wrote; kDataCorrupt for
  /// one that is not a store.
  static Result<std::unique_ptr<SqliteConnection>> Open(const std::string& path, Mode mode,
                                                        const std::string& vfs);

  /// A statement, reset, prepared at most once. @param sql  a constant.
  SQLite::Statement& Use(const char* sql);
  void Run(const char* sql) { Use(sql).exec(); }
  /// Ends what a failed statement left open. Never throws.
  void RollBack();
  /// Moves what is committed from the log into the database if enough has gathered: `pages_min`
  /// pages. An error is left to the next write, which meets it too.
  void Checkpoint(int pages_min);

  [[nodiscard]] SQLite::Database& database() { return database_; }

  /// What an exception means for the store in `path`.
  [[nodiscard]] static Error ToError(const SQLite::Exception& exception, const std::string& path);

 private:
  SqliteConnection(const std::string& path, Mode mode, const std::string& vfs);
  Status Prepare(Mode mode);

  const std::string path_;
  int log_pages_ = 0;  // Written by SQLite's hook, before the statements die.
  SQLite::Database database_;
  std::map<const char*, SQLite::Statement> statements_;
};

}  // namespace pliant::server
