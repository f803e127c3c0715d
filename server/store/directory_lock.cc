#include "server/store/directory_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace pliant::server {
namespace {

constexpr char kLockFile[] = "lock";

std::string ReadOwner(int file) {
  std::array<char, 32> text{};
  const ssize_t size = pread(file, text.data(), text.size() - 1, 0);
  return size > 0 ? std::string(text.data(), static_cast<std::size_t>(size)) : "unknown";
}

}  // namespace

Result<DirectoryLock> DirectoryLock::Take(const std::string& directory) {
  std::error_code failed;
  std::filesystem::create_directories(directory, failed);
  if (failed) {
    return Error{ErrorCode::kFileUnwritable,
                 "cannot make the data directory " + directory + ": " + failed.message(), "data"};
  }
  const std::string path = directory + "/" + kLockFile;
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0) {
    return Error{ErrorCode::kFileUnwritable,
                 "cannot write " + path + ": " + std::strerror(errno) +
                     "; the data directory must be writable for the server's user",
                 "data"};
  }
  DirectoryLock lock(file);
  if (flock(file, LOCK_EX | LOCK_NB) != 0) {
    return Error{ErrorCode::kUnavailable,
                 "process " + ReadOwner(file) + " has the data directory " + directory +
                     "; give each server a directory of its own, or stop the other one",
                 "data"};
  }
  const std::string owner = std::to_string(getpid());
  // Only for the message above, so a failure does no harm.
  if (ftruncate(file, 0) == 0 && pwrite(file, owner.data(), owner.size(), 0) < 0) errno = 0;
  return lock;
}

DirectoryLock::~DirectoryLock() {
  if (file_ >= 0) close(file_);
}

}  // namespace pliant::server
