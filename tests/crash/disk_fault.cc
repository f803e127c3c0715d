// Preloaded into a server: kills it inside the n-th write to, or synchronisation of, a file of its
// store. PLIANT_FAULT_AT says which; a write is torn first: half of it reaches the file.
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

std::atomic<long> changes = 0;

long FaultAt() {
  static const long at = [] {
    const char* text = std::getenv("PLIANT_FAULT_AT");
    return text == nullptr ? 0 : std::atol(text);
  }();
  return at;
}

bool IsOfTheStore(int file) {
  char target[PATH_MAX] = {};
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  if (readlink(link.c_str(), target, sizeof(target) - 1) < 0) return false;
  return std::strstr(target, "pliant.sqlite") != nullptr;
}

bool IsNow(int file) {
  const long at = FaultAt();
  return at > 0 && IsOfTheStore(file) && ++changes == at;
}

template <class Function>
Function Real(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

[[noreturn]] void Die() {
  kill(getpid(), SIGKILL);
  for (;;) pause();
}

}  // namespace

extern "C" {

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t at) {
  static const auto real = Real<ssize_t (*)(int, const void*, size_t, off64_t)>("pwrite64");
  if (IsNow(file)) {
    static_cast<void>(real(file, bytes, size / 2, at));
    Die();
  }
  return real(file, bytes, size, at);
}

int fdatasync(int file) {
  static const auto real = Real<int (*)(int)>("fdatasync");
  if (IsNow(file)) Die();
  return real(file);
}

int fsync(int file) {
  static const auto real = Real<int (*)(int)>("fsync");
  if (IsNow(file)) Die();
  return real(file);
}

}  // extern "C"
