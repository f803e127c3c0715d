#include "server/store/maintenance.h"

#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "server/store/sqlite_connection.h"
#include "server/store/sqlite_rows.h"

namespace pliant::server {
namespace {

std::string DatabaseIn(const std::string& directory) { return directory + "/" + kDatabaseFile; }

/// A connection of its own, which leaves everything as it is.
Result<std::unique_ptr<SqliteConnection>> OpenToRead(const SqliteStore::Options& options) {
  const std::string path = DatabaseIn(options.directory);
  std::error_code failed;
  if (!std::filesystem::exists(path, failed)) {
    return Error{ErrorCode::kFileNotFound, "there is no store in " + options.directory, "data"};
  }
  return SqliteConnection::Open(path, SqliteConnection::Mode::kRead, options.vfs);
}

}  // namespace

Result<std::vector<std::string>> CheckStore(const SqliteStore::Options& options) {
  PLIANT_ASSIGN_OR_RETURN(const std::unique_ptr<SqliteConnection> connection, OpenToRead(options));
  std::vector<std::string> wrong;
  try {
    connection->Run("BEGIN");
    SQLite::Statement& check = connection->Use("PRAGMA integrity_check");
    while (check.executeStep()) {
      if (const std::string text = check.getColumn(0).getString(); text != "ok") {
        wrong.push_back("the database: " + text);
      }
    }
    for (const DocumentKind kind : {DocumentKind::kSession, DocumentKind::kJob}) {
      for (const DocumentRow& row : AllDocuments(*connection, kind)) {
        const Result<StoredDocument> document = ReadDocument(*connection, row);
        if (!document.ok()) wrong.push_back(document.error().message);
      }
    }
    connection->RollBack();
  } catch (const SQLite::Exception& exception) {
    return SqliteConnection::ToError(exception, DatabaseIn(options.directory));
  }
  return wrong;
}

Status BackUpStore(const SqliteStore::Options& options, const std::string& directory) {
  PLIANT_ASSIGN_OR_RETURN(const std::unique_ptr<SqliteConnection> connection, OpenToRead(options));
  const std::string copy = DatabaseIn(directory);
  std::error_code failed;
  std::filesystem::create_directories(directory, failed);
  if (failed || std::filesystem::exists(copy)) {
    return Error{ErrorCode::kFileUnwritable,
                 failed ? "cannot make " + directory + ": " + failed.message()
                        : directory + " holds a store already; choose another directory",
                 "backup-data"};
  }
  try {
    // The copy alone is written.
    connection->Run("PRAGMA query_only = OFF");
    SQLite::Statement& copy_all = connection->Use("VACUUM INTO ?");
    copy_all.bind(1, copy);
    copy_all.exec();
    return {};
  } catch (const SQLite::Exception& exception) {
    return SqliteConnection::ToError(exception, copy);
  }
}

}  // namespace pliant::server
