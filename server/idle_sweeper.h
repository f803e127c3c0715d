#pragma once

#include <chrono>
#include <cstddef>

#include "server/clock.h"
#include "server/log.h"
#include "server/session_registry.h"
#include "server/ticker.h"

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
  /// One look. @return how many sessions were ended
  std::size_t Sweep();

 private:
  SessionRegistry& registry_;
  const Clock& clock_;
  const Log& log_;
  const std::chrono::seconds idle_max_;
  Ticker ticker_;  // Last: it works with all of them.
};

}  // namespace pliant::server
