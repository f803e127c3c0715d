#pragma once

#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <string>
#include <utility>

#include "server/store/sqlite_store.h"

namespace pliant::server {

inline std::unique_ptr<SqliteStore> Open(const std::string& directory,
                                         const std::string& vfs = {}) {
  auto store = SqliteStore::Open({.directory = directory, .vfs = vfs});
  EXPECT_TRUE(store.ok()) << (store.ok() ? "" : store.error().message);
  return store.ok() ? std::move(store).value() : nullptr;
}

/// Calls `write` with a callback and waits for what it is told.
template <class Write>
Status Do(Write write) {
  std::promise<Status> promise;
  write([&](const Status& status) { promise.set_value(status); });
  return promise.get_future().get();
}

}  // namespace pliant::server
