#pragma once

#include <string>
#include <utility>

#include "core/base/result.h"

namespace pliant::server {

/// One server at a time has a directory: a lock on a file in it, which ends with the process
/// however that ends.
///
/// *Threads*: one caller at a time.
class DirectoryLock {
 public:
  /// Makes the directory if it is not there. Errors: kFileUnwritable, kUnavailable where another
  /// process has it; the message names that process.
  static Result<DirectoryLock> Take(const std::string& directory);

  DirectoryLock(DirectoryLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  DirectoryLock& operator=(DirectoryLock&& other) noexcept {
    std::swap(file_, other.file_);
    return *this;
  }
  ~DirectoryLock();

 private:
  explicit DirectoryLock(int file) : file_(file) {}
  int file_ = -1;
};

}  // namespace pliant::server
