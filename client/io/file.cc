#include "client/io/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <system_error>

namespace pliant::io {
namespace {

constexpr std::uint64_t kFileSizeMax = std::uint64_t{16} << 30;

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

Error FileError(ErrorCode code, const std::string& path, const std::string& action, int cause) {
  return {.code = code,
          .message = path + ": cannot " + action + ": " + std::generic_category().message(cause),
          .field = path};
}

Status WriteAll(int fd, std::string_view bytes, const std::string& path) {
  while (!bytes.empty()) {
    const ssize_t written = write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return FileError(ErrorCode::kFileUnwritable, path, "write", errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return {};
}

std::string TemporaryName(const std::string& path) {
  static std::atomic<std::uint64_t> count = 0;
  return path + ".partial-" + std::to_string(getpid()) + "-" + std::to_string(count++);
}

}  // namespace

Result<std::string> ReadFile(const std::string& path) {
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) {
    const ErrorCode code =
        errno == ENOENT || errno == ENOTDIR ? ErrorCode::kFileNotFound : ErrorCode::kFileUnreadable;
    return FileError(code, path, "open", errno);
  }
  struct stat info {};
  if (fstat(file.get(), &info) != 0) {
    return FileError(ErrorCode::kFileUnreadable, path, "read", errno);
  }
  if (static_cast<std::uint64_t>(info.st_size) > kFileSizeMax) {
    return FileError(ErrorCode::kTooLarge, path, "read a file of more than 16 GiB", EFBIG);
  }
  // One byte more than the file has, so that its end is seen without another turn; pipes, which
  // have no size, grow as they go.
  std::string bytes(static_cast<std::size_t>(info.st_size) + 1, '\0');
  std::size_t filled = 0;
  for (;;) {
    if (filled == bytes.size()) {
      if (filled > kFileSizeMax) {
        return FileError(ErrorCode::kTooLarge, path, "read more than 16 GiB", EFBIG);
      }
      bytes.resize(2 * bytes.size());
    }
    const ssize_t got = read(file.get(), bytes.data() + filled, bytes.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return FileError(ErrorCode::kFileUnreadable, path, "read", errno);
    if (got == 0) break;
    filled += static_cast<std::size_t>(got);
  }
  bytes.resize(filled);
  return bytes;
}

Status WriteFileAtomically(const std::string& path, std::string_view bytes) {
  const std::string temporary = TemporaryName(path);
  {
    const Descriptor file(open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (file.get() < 0) return FileError(ErrorCode::kFileUnwritable, path, "create", errno);
    Status status = WriteAll(file.get(), bytes, path);
    if (status.ok() && fsync(file.get()) != 0 && errno != EINVAL) {
      status = FileError(ErrorCode::kFileUnwritable, path, "write", errno);
    }
    if (!status.ok()) {
      unlink(temporary.c_str());
      return status;
    }
  }
  if (rename(temporary.c_str(), path.c_str()) != 0) {
    const int cause = errno;
    unlink(temporary.c_str());
    return FileError(ErrorCode::kFileUnwritable, path, "replace", cause);
  }
  return {};
}

bool FileExists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

std::string Extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return extension;
}

std::string WithoutExtension(const std::string& path) {
  return path.substr(0, path.size() - Extension(path).size());
}

}  // namespace pliant::io
