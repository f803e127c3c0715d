#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "server/clock.h"
#include "server/engine.h"
#include "server/jobs/job_board.h"
#include "server/jobs/job_codec.h"
#include "server/jobs/job_store.h"
#include "server/limits.h"
#include "server/log.h"
#include "server/scheduler.h"
#include "server/tenant_account.h"

namespace pliant::server {

/// The work of one job, in slices: builds the engine from the stored input, runs the loop, commits
/// one revision, measures and writes the mesh. What it uses meanwhile enters its tenant's account,
/// as that of a session does; a mesh that has no room there fails the job.
///
/// Ends exactly once: with on_end, or with on_stopped if it was told to stop. It looks at that
/// between two steps and the engine within them, so a loop that runs stops within milliseconds, and
/// so does the measurement; building the input's triangulation and the commit are not interrupted.
///
/// *Threads*: RunSlice runs on one worker at a time and owns everything.
class JobRun final : public Task {
 public:
  /// What it uses of its server; all outlive it.
  struct Environment {
    const Clock* clock = nullptr;
    const Log* log = nullptr;
    JobStore* store = nullptr;
    EngineFactory factory = {};
    JobCodec codec = {};
    std::int64_t visits_per_step = kVisitsPerStep;
    /// Of the job's tenant; null: nobody counts.
    std::shared_ptr<TenantAccount> account = nullptr;
    std::function<void(std::int64_t number, const JobProgress&)> on_progress = {};
    std::function<void(std::int64_t number, JobEnd)> on_end = {};
    std::function<void(std::int64_t number)> on_stopped = {};
  };

  JobRun(Environment environment, JobBoard::Start start)
      : environment_(std::move(environment)), start_(std::move(start)) {}

  /// Never throws: a bug of the engine fails this job alone, with kInternal and a reference.
  Outcome RunSlice(Clock::Time slice_end) override;

 private:
  Outcome RunUnguarded(Clock::Time slice_end);
  Status Build();
  Status Continue(Clock::Time slice_end);
  Status Account();
  void Commit();
  bool Measure(Clock::Time slice_end);
  void Finish();
  void LeaveMemory();
  void End(JobEnd end);
  void Fail(const Error& error);
  void HandleBug(const std::string& what);

  const Environment environment_;
  const JobBoard::Start start_;
  std::unique_ptr<Engine> engine_;
  SessionUsage reported_;  // What the tenant's account knows.
  AdvanceSpec spec_;
  Clock::Time begin_;
  std::chrono::nanoseconds compute_{0};
  Progress progress_;
  bool loop_over_ = false;
  AdvanceEnd advance_end_ = AdvanceEnd::kEngine;
  std::optional<JobResult> result_;           // Since the commit.
  std::unique_ptr<Measurement> measurement_;  // Of the result.
  bool over_ = false;
};

}  // namespace pliant::server
