#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/result.h"
#include "core/mesh/mesh_diff.h"
#include "server/call_counter.h"
#include "server/jobs/job_board.h"
#include "server/jobs/job_run.h"

namespace pliant::server {

/// The jobs of a server: what its calls use. Puts the board, the store and the runs together.
///
/// A submission and a cancellation are answered when they are stored, and an end is seen when it
/// is. What was not ended when the server died is taken up again from its input by Load, which
/// gives the same bits.
///
/// *Threads*: Load first; all else from any thread. `sweep_mutex_` comes before the locks of the
/// board and the store.
class Jobs {
 public:
  /// All outlive it; the scheduler has stopped before it goes.
  struct Environment {
    const Clock* clock = nullptr;
    const Log* log = nullptr;
    Scheduler* scheduler = nullptr;
    JobStore* store = nullptr;
    /// Null: nobody counts.
    TenantAccounts* accounts = nullptr;
    EngineFactory factory = {};
    JobCodec codec = {};
    std::int64_t visits_per_step = kVisitsPerStep;
  };
  using InfoDone = std::function<void(const Result<JobInfo>&)>;
  using MeshDone = std::function<void(const Result<MeshDiff>&)>;

  /// @param seed  of the ids that it makes up.
  Jobs(Environment environment, const JobBoard::Bounds& bounds, std::uint64_t seed);
  /// Waits until the store has told of every write. @pre no calls any more
  ~Jobs();
  Jobs(const Jobs&) = delete;
  Jobs& operator=(const Jobs&) = delete;

  /// Takes up what the store has. Errors: those of reading its list.
  Status Load();

  /// Errors: kJobExists, kUnavailable; kResourceExhausted, also for a tenant without compute time
  /// left; those of the store.
  void Submit(const JobDraft& draft, Bytes input, const InfoDone& done);
  /// Error: kJobNotFound.
  Result<JobInfo> Get(const JobKey& key);
  [[nodiscard]] JobBoard::Page List(const std::string& tenant, std::int64_t before,
                                    std::size_t count_max);
  /// Errors: kJobNotFound; those of the store.
  void Cancel(const JobKey& key, const InfoDone& done);
  /// The mesh of a job that is done, as a diff from nothing; `done` runs on a worker, or here
  /// where there is no mesh. Errors: kJobNotFound, kJobNotDone; those of the store.
  void Fetch(const JobKey& key, MeshDone done);

  /// Forgets what has expired. Every call does, so that no result is seen after its time; somebody
  /// else should now and then, so that it is freed where no call comes.
  void Sweep();

  /// Running jobs stop; none is started or taken any more.
  void Stop();

 private:
  JobStore::Done Counted(JobStore::Done done);
  void StartQueued();
  void EndRun(std::int64_t number, JobEnd end);

  const Environment environment_;
  JobBoard board_;
  const std::shared_ptr<CallCounter> writes_ = std::make_shared<CallCounter>();  // Not told of yet.
  std::mutex sweep_mutex_;  // Guards nothing but the order of deletions.
};

}  // namespace pliant::server
