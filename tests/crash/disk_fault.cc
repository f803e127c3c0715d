// Preloaded into a server: what goes wrong with the files of its store. PLIANT_FAULT says what:
//   kill  (default) it dies inside the n-th write or synchronisation, PLIANT_FAULT_AT; a write is
//         torn first: half of it reaches the file;
//   drop  from the n-th on, nothing is written, and the disk says that it was;
//   slow  a synchronisation takes PLIANT_FAULT_AT ms.
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>

namespace {

std::atomic<long> changes = 0;

enum class Fault { kKill, kDrop, kSlow };

Fault Kind() {
  static const Fault kind = [] {
    const char* text = std::getenv("PLIANT_FAULT");
    if (text == nullptr) return Fault::kKill;
    return std::strcmp(text, "drop") == 0   ? Fault::kDrop
           : std::strcmp(text, "slow") == 0 ? Fault::kSlow
                                            : Fault::kKill;
  }();
  return kind;
}

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

// The moment has come in which it should die.
bool IsNow(int file) {
  const long at = FaultAt();
  return Kind() == Fault::kKill && at > 0 && IsOfTheStore(file) && ++changes == at;
}

// The moment is past from which nothing reaches the disk.
bool IsDropped(int file) {
  return Kind() == Fault::kDrop && IsOfTheStore(file) && ++changes >= FaultAt();
}

void TakeTime(int file) {
  if (Kind() != Fault::kSlow || !IsOfTheStore(file)) return;
  const timespec time{.tv_sec = FaultAt() / 1000, .tv_nsec = FaultAt() % 1000 * 1'000'000};
  nanosleep(&time, nullptr);
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
  if (IsDropped(file)) return static_cast<ssize_t>(size);
  return real(file, bytes, size, at);
}

int fdatasync(int file) {
  static const auto real = Real<int (*)(int)>("fdatasync");
  if (IsNow(file)) Die();
  if (IsDropped(file)) return 0;
  TakeTime(file);
  return real(file);
}

int fsync(int file) {
  static const auto real = Real<int (*)(int)>("fsync");
  if (IsNow(file)) Die();
  if (IsDropped(file)) return 0;
  TakeTime(file);
  return real(file);
}

}  // extern "C"
