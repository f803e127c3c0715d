#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/store/sqlite_store.h"

/// What can be done with a store from outside, also while a server works on it.
namespace pliant::server {

/// Reads everything: SQLite's own check, and every row's checksum and place. What is wrong, a
/// sentence each. @par Cost O(stored bytes)
/// Errors: kFileNotFound where there is no store; those of SqliteConnection::Open.
[[nodiscard]] Result<std::vector<std::string>> CheckStore(const SqliteStore::Options& options);

/// A consistent copy of everything, made while writes go on, as a store in another directory.
/// Errors: as CheckStore; kFileUnwritable if there is a store already.
[[nodiscard]] Status BackUpStore(const SqliteStore::Options& options, const std::string& directory);

}  // namespace pliant::server
