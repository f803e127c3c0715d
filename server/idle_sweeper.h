#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <thread>

#include "server/clock.h"
#include "server/log.h"
#include "server/session_registry.h"

namespace pliant::server {

/// Ends sessions that nobody has used for a time, so that programs that forget theirs do not fill
/// the server. Looks every kIdleCheckMs, on a thread of its own.
///
/// *Threads*: made and destroyed by one; Sweep from any.
class IdleSweeper {
 public:
  /// @param registry, clock, log  outlive this.
  IdleSweeper(SessionRegistry& registry, const Clock& clock, const Log& log,
              std::chrono::seconds idle_max);
  ~IdleSweeper();
  IdleSweeper(const IdleSweeper&) = delete;
  IdleSweeper& operator=(const IdleSweeper&) = delete;

  /// One look. @return how many sessions were ended
  std::size_t Sweep();

 private:
  void Run();

  SessionRegistry& registry_;
  const Clock& clock_;
  const Log& log_;
  const std::chrono::seconds idle_max_;
  std::mutex mutex_;  // Guards stopping_.
  std::condition_variable stop_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace pliant::server
