#pragma once

#include <csignal>

namespace pliant::cli {

/// While it lives, the first Ctrl-C (SIGINT) or SIGTERM only sets a flag, so that long work can
/// end cleanly; the second one ends the program at once.
///
/// At most one at a time: signal handlers belong to the whole process.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  [[nodiscard]] bool interrupted() const;

 private:
  struct sigaction old_int_ {};
  struct sigaction old_term_ {};
};

}  // namespace pliant::cli
