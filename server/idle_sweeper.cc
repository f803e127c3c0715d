#include "server/idle_sweeper.h"

#include <string>

#include "server/limits.h"

namespace pliant::server {

IdleSweeper::IdleSweeper(SessionRegistry& registry, const Clock& clock, const Log& log,
                         std::chrono::seconds idle_max)
    : registry_(registry),
      clock_(clock),
      log_(log),
      idle_max_(idle_max),
      ticker_(std::chrono::milliseconds(kIdleCheckMs), [this] { Sweep(); }) {}

std::size_t IdleSweeper::Sweep() {
  const std::size_t count = registry_.CloseIdle(
      clock_.Now() - idle_max_, {ErrorCode::kSessionNotFound,
                                 "the session was closed because nobody had used it for " +
                                     std::to_string(idle_max_.count()) + " s",
                                 {}});
  if (count > 0) log_.Info("idle_close", {{"sessions", std::to_string(count)}});
  return count;
}

}  // namespace pliant::server
