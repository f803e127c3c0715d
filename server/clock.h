#pragma once

#include <chrono>

namespace pliant::server {

/// Where the server takes the time from; passed in, so that tests run on a clock of their own.
///
/// *Threads*: all functions may be called from any thread.
class Clock {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = std::chrono::steady_clock::duration;
  using WallTime = std::chrono::system_clock::time_point;

  virtual ~Clock() = default;
  /// For durations and deadlines: never goes back.
  [[nodiscard]] virtual Time Now() const = 0;
  /// For people: time stamps of sessions.
  [[nodiscard]] virtual WallTime WallNow() const = 0;
};

/// The computer's clock.
class SystemClock final : public Clock {
 public:
  [[nodiscard]] Time Now() const override { return std::chrono::steady_clock::now(); }
  [[nodiscard]] WallTime WallNow() const override { return std::chrono::system_clock::now(); }
};

}  // namespace pliant::server
