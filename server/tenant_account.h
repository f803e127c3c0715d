#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/result.h"
#include "server/clock.h"
#include "server/limits.h"

namespace pliant::server {

/// What the sessions and running jobs of one tenant may use together; 0: no limit. How many there
/// may be is the registry's to count.
struct TenantLimits {
  std::int64_t vertices_max = 0;
  std::int64_t bytes_max = 0;
  /// Time that workers spend on its sessions, per second of the clock, in percent of one worker,
  /// over the long run.
  int compute_percent = 0;
  /// That much more may be used at once after a rest, and is then saved up again.
  std::chrono::milliseconds compute_burst{kTenantBurstMsDefault};
};

/// What one session, or one running job, uses.
struct SessionUsage {
  std::int64_t vertices = 0;
  std::int64_t bytes = 0;  ///< Of memory, roughly.
};

/// The account of one tenant: what its sessions and jobs use, and whether they may use more.
///
/// Compute time is a bucket that fills while workers run its sessions and drains by the clock: a
/// piece of work is begun while it is not full, and charged when it is done, so that one long piece
/// can overdraw it; the next one then waits until the debt is paid.
///
/// *Threads*: all functions from any thread. `mutex_` is a leaf lock.
class TenantAccount {
 public:
  explicit TenantAccount(const TenantLimits& limits) : limits_(limits) {}

  /// A session uses `now` instead of `before`; {} for one that begins or ends.
  void Change(const SessionUsage& before, const SessionUsage& now);
  /// Charges time that a worker has spent.
  void Charge(std::chrono::nanoseconds time, Clock::Time now);

  /// Refuses work that would need more than there is. Errors: kResourceExhausted, with the time
  /// after which there is compute time again.
  [[nodiscard]] Status CheckCompute(Clock::Time now) const;
  /// Refuses a session that would use `wanted` instead of `before`. Error: kResourceExhausted.
  [[nodiscard]] Status CheckRoom(const SessionUsage& before, const SessionUsage& wanted) const;

  [[nodiscard]] SessionUsage usage() const;

 private:
  [[nodiscard]] std::chrono::nanoseconds DebtAt(Clock::Time now) const;

  const TenantLimits limits_;
  mutable std::mutex mutex_;  // Guards all below.
  SessionUsage usage_;
  std::chrono::nanoseconds debt_{0};  // At charged_.
  Clock::Time charged_{};
};

/// The accounts of all tenants, made when they are first asked for.
///
/// *Threads*: any.
class TenantAccounts {
 public:
  explicit TenantAccounts(const TenantLimits& limits) : limits_(limits) {}

  [[nodiscard]] std::shared_ptr<TenantAccount> Of(const std::string& tenant);

 private:
  const TenantLimits limits_;
  std::mutex mutex_;  // Guards accounts_.
  std::map<std::string, std::shared_ptr<TenantAccount>> accounts_;
};

}  // namespace pliant::server
