#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "server/clock.h"
#include "server/memory_budget.h"
#include "server/session.h"
#include "server/session_registry.h"

namespace pliant::server {

/// Sends sessions to sleep: those that nobody has used for a while, and, where the server holds
/// more memory than it may, those that were used longest ago. Only sessions that are stored can
/// sleep, and only while they have nothing to do.
///
/// What sessions say that they hold is an estimate, known at once; what the process holds, with all
/// that is not a session's and all that the allocator cannot give back, is measured once a second
/// and added to it; ten times a second where it is near the limit.
///
/// *Threads*: one of its own, which looks at these times, and when the budget is exceeded.
class Sleeper {
 public:
  struct Policy {
    /// Time without use after which a session sleeps; 0: never.
    std::chrono::seconds idle_max{0};
    /// Of the whole process where `resident` tells that, else of all sessions; in bytes, 0: no
    /// limit.
    std::int64_t memory_bytes_max = 0;
    /// Memory that the process holds now, in bytes, 0 if that is not known; may be absent.
    std::function<std::int64_t()> resident = {};
  };

  /// @param registry, clock  outlive it.
  Sleeper(const Policy& policy, const SessionRegistry& registry, const Clock& clock);
  ~Sleeper();
  /// Begins to look; once.
  void Start();

  [[nodiscard]] MemoryBudget& budget() { return budget_; }

  /// Who should sleep now: idle ones first, then, where the limit is exceeded, the least recently
  /// used until there is some room again.
  [[nodiscard]] std::vector<std::shared_ptr<Session>> Choose() const;

  /// Measures what the process holds; Choose and the budget go by that until the next time.
  void Measure();

 private:
  [[nodiscard]] bool IsNearLimit() const;
  void Look();
  void SendToSleep();
  void Work();

  const Policy policy_;
  const SessionRegistry& registry_;
  const Clock& clock_;
  MemoryBudget budget_;
  bool has_freed_ = false;  // The thread's own: sessions went to sleep since memory was returned.

  std::mutex mutex_;  // Guards all below; a leaf lock.
  std::condition_variable wake_;
  bool is_over_ = false;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace pliant::server
