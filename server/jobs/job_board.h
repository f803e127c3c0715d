#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/base/rng.h"
#include "core/base/stop_signal.h"
#include "server/clock.h"
#include "server/jobs/job.h"

namespace pliant::server {

/// All jobs of a server: who waits, who runs, who has ended and until when it is kept. It decides
/// and remembers; it neither computes nor stores.
///
/// Of the tenants that have a job waiting, the one with the fewest running goes next, then the one
/// that went longest ago; of its jobs the one with the greatest priority, then the oldest. So a
/// priority orders a tenant's own jobs and holds up nobody else's.
///
/// *Invariants*: at most running_max jobs hold a place; one that is cancelled while it runs gives
/// its place back only when its work has really stopped. A job that has ended never changes again.
/// *Threads*: all functions from any thread. `mutex_` is a leaf lock.
class JobBoard {
 public:
  struct Bounds {
    std::size_t jobs_max = 0;  ///< In all states together.
    std::size_t jobs_per_tenant_max = 0;
    /// Inputs and meshes. Reaching it stops new submissions; a result always finds its place.
    std::size_t bytes_max = 0;
    std::size_t bytes_per_tenant_max = 0;
    std::size_t running_max = 1;
  };
  /// A job that is to run now.
  struct Start {
    JobInfo info;
    std::shared_ptr<const StopFlag> stop;  ///< Set when it should.
  };
  /// Some of a tenant's jobs, newest first.
  struct Page {
    std::vector<JobInfo> jobs;
    std::int64_t next = 0;  ///< Number to go on before; 0 if that was the last page.
  };

  /// @param seed   of the ids that it makes up.
  /// @param clock  outlives it.
  JobBoard(const Bounds& bounds, std::uint64_t seed, const Clock& clock);

  /// Takes an id and room; nobody sees the job yet. Errors: kJobExists, kResourceExhausted.
  Result<JobInfo> Reserve(const JobDraft& draft);
  /// The reserved job waits for its turn from now on.
  void Publish(std::int64_t number);
  /// Frees what a reserved job took.
  void Withdraw(std::int64_t number);
  /// Puts a stored job back: one that had ended as it was, any other at its place in the queue.
  void Restore(JobInfo info);

  /// The next job to run, which holds a place from now on; nothing while no place is free.
  std::optional<Start> TakeNext();
  void Tell(std::int64_t number, const JobProgress& progress);
  /// A running job is about to end as `end` says: it cannot be cancelled any more, and looks as it
  /// did until Finish. Nothing if it was cancelled before.
  std::optional<JobInfo> BeginEnd(std::int64_t number, const JobEnd& end);
  /// That end holds, as the job says, and everybody may see it. Gives its place back.
  void FinishEnd(const JobInfo& ended);
  /// The work of a cancelled job has stopped: gives its place back.
  void GiveBack(std::int64_t number);

  /// Error: kJobNotFound, also for a job of another tenant and for one that has expired.
  [[nodiscard]] Result<JobInfo> Find(const JobKey& key) const;
  [[nodiscard]] Page List(const std::string& tenant, std::int64_t before,
                          std::size_t count_max) const;

  /// A job that waits or runs is cancelled at once. `changed` says whether this call did it.
  struct Cancelled {
    JobInfo info;
    bool changed = false;
  };
  /// Error: kJobNotFound.
  Result<Cancelled> Cancel(const JobKey& key);

  /// Forgets the jobs whose time is over; the keys of what was forgotten.
  std::vector<JobKey> TakeExpired();

  /// Tells all running jobs to stop, and starts no more; how many were waiting or running.
  struct Unfinished {
    std::size_t queued = 0;
    std::size_t running = 0;
  };
  Unfinished StopAll();

 private:
  struct Entry {
    JobInfo info;
    bool reserved = true;  // Not seen yet.
    bool ending = false;
    std::shared_ptr<StopFlag> stop;  // Not null while the job holds a place.
  };
  struct Tenant {
    std::set<std::pair<std::int64_t, std::int64_t>> queue;  // (-priority, number): first goes next.
    std::set<std::int64_t> seen;                            // Numbers, to list.
    std::size_t count = 0;
    std::size_t bytes = 0;
    std::size_t running = 0;
    std::int64_t last_start = 0;
  };

  [[nodiscard]] Status CheckRoom(const JobDraft& draft) const;
  [[nodiscard]] const Entry* FindSeen(const JobKey& key) const;
  void Enqueue(const JobInfo& info);
  void Settle(Entry& entry);
  void Erase(std::int64_t number);
  void FreePlace(std::int64_t number, const std::string& tenant);

  const Bounds bounds_;
  const Clock& clock_;
  mutable std::mutex mutex_;  // Guards all below.
  Rng rng_;
  std::int64_t last_number_ = 0;
  std::int64_t start_count_ = 0;
  bool stopped_ = false;
  std::map<std::int64_t, Entry> entries_;
  std::map<JobKey, std::int64_t> numbers_;
  std::map<std::string, Tenant> tenants_;
  std::map<std::int64_t, std::string> places_;  // Tenants of the jobs that hold one, by number.
  std::set<std::pair<Clock::WallTime, std::int64_t>> expiry_;
  std::size_t bytes_ = 0;
};

}  // namespace pliant::server
