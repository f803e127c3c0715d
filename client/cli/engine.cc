#include "client/cli/engine.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "core/pliant/remesher.h"
#include "core/threads/thread_pool.h"

namespace pliant::cli {
namespace {

using Clock = std::chrono::steady_clock;
using client::AdvanceReport;
using client::AdvanceStop;
using std::chrono::microseconds;
using std::chrono::milliseconds;

/// Visits between two looks at the clock and at Ctrl-C: some tens of milliseconds.
constexpr std::int64_t kVisitsPerStep = 20'000;
constexpr milliseconds kProgressInterval{100};

Error Cancelled() {
  return {.code = ErrorCode::kCancelled, .message = "interrupted; nothing was written"};
}

AdvanceStop StopOf(StopReason reason) {
  switch (reason) {
    case StopReason::kConverged:
      return AdvanceStop::kConverged;
    case StopReason::kVisitBudget:
      return AdvanceStop::kVisitBudget;
    case StopReason::kCancelled:
      return AdvanceStop::kCancelled;
    case StopReason::kVertexLimit:
      return AdvanceStop::kVertexLimit;
    case StopReason::kVisitLimit:
      return AdvanceStop::kVisitLimit;
  }
  return AdvanceStop::kConverged;
}

Result<std::unique_ptr<Remesher>> Create(const RemeshJob& job) {
  return std::visit(
      [&](const auto& start) { return Remesher::Create(start, job.metric, job.options); },
      job.start);
}

/// The loop in small steps until it ends, runs into a limit or is cancelled.
struct LocalRun {
  Progress progress;
  AdvanceStop stop = AdvanceStop::kConverged;
  Clock::duration time{0};
};

Result<LocalRun> RunLoop(Remesher& remesher, const client::AdvanceOptions& limits,
                         const OnProgress& on_progress) {
  const auto start = Clock::now();
  const std::int64_t visits_max =
      limits.visits_max.value_or(std::numeric_limits<std::int64_t>::max());
  auto shown = start;
  LocalRun run;
  while (true) {
    const Budget budget{.visits_max =
                            std::min(kVisitsPerStep, visits_max - run.progress.counts.visits)};
    PLIANT_ASSIGN_OR_RETURN(run.progress, remesher.Step(budget));
    const auto now = Clock::now();
    run.time = now - start;
    run.stop = StopOf(run.progress.stop_reason);
    if (run.progress.stop_reason != StopReason::kVisitBudget) return run;
    if (run.progress.counts.visits >= visits_max) return run;
    if (limits.time_max && run.time >= *limits.time_max) {
      run.stop = AdvanceStop::kTimeBudget;
      return run;
    }
    if (!on_progress || now - shown < kProgressInterval) continue;
    shown = now;
    const client::AdvanceProgress progress{
        .active_count = run.progress.active_count,
        .visits = run.progress.counts.visits,
        .vertex_count = remesher.mesh().vertex_count(),
        .elapsed = std::chrono::duration_cast<milliseconds>(run.time)};
    if (on_progress(progress) == Proceed::kCancel) return Cancelled();
  }
}

AdvanceReport ReportOf(const LocalRun& run, const MeshDiff& diff, std::vector<Trouble> troubles) {
  const auto time = std::chrono::duration_cast<microseconds>(run.time);
  return {.base_revision = diff.base_revision,
          .revision = diff.revision,
          .stop = run.stop,
          .active_count = run.progress.active_count,
          .summary = diff.summary,
          .visits = run.progress.counts.visits,
          .moves = run.progress.counts.moves,
          .insertions = run.progress.counts.insertions,
          .deletions = run.progress.counts.deletions,
          .swaps = run.progress.counts.swaps,
          .cooled_count = run.progress.counts.cooled,
          .troubles = std::move(troubles),
          .metric = run.progress.metric,
          .compute_time = time,
          .elapsed_time = time};
}

/// What a session on the server brings home.
Result<RemeshResult> RunSession(client::Session& session, const RemeshJob& job,
                                const OnProgress& on_progress) {
  RemeshResult result;
  PLIANT_ASSIGN_OR_RETURN(result.report, AdvanceWithProgress(session, job.advance, on_progress));
  PLIANT_ASSIGN_OR_RETURN(result.quality, session.GetQuality());
  result.mesh = session.replica().Compact();
  return result;
}

}  // namespace

Result<RemeshResult> RemeshLocally(const RemeshJob& job, const OnProgress& on_progress) {
  ThreadPool threads(job.thread_count > 0
                         ? job.thread_count
                         : std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  PLIANT_ASSIGN_OR_RETURN(const std::unique_ptr<Remesher> remesher, Create(job));
  remesher->UseHelpers(Helpers(&threads));
  PLIANT_ASSIGN_OR_RETURN(const LocalRun run, RunLoop(*remesher, job.advance, on_progress));
  const TroubleSearch search = remesher->WhereTroublesMayBe();
  const MeshDiff diff = remesher->Commit();
  std::vector<Trouble> troubles;
  if (run.progress.active_count == 0) troubles = remesher->FindTroubles(search);
  client::MeshReplica replica;
  PLIANT_RETURN_IF_ERROR(replica.Apply(diff));
  RemeshResult result;
  result.report = ReportOf(run, diff, std::move(troubles));
  result.quality = MeasureQuality(remesher->mesh(), remesher->field());
  result.mesh = replica.Compact();
  return result;
}

Result<RemeshResult> RemeshOnServer(const std::string& address, const RemeshJob& job,
                                    const OnProgress& on_progress) {
  PLIANT_ASSIGN_OR_RETURN(client::Client server, client::Client::Connect(address));
  client::SessionSettings settings;
  settings.options = job.options;
  settings.labels["client"] = "pliant remesh";
  settings.parts = client::Parts::kMeshAndMetric;
  PLIANT_ASSIGN_OR_RETURN(const std::unique_ptr<client::Session> session,
                          server.CreateSession(job.start, job.metric, settings));
  Result<RemeshResult> result = RunSession(*session, job, on_progress);
  const Result<Revision> deleted = server.DeleteSession(session->id());
  if (result.ok() && !deleted.ok()) return deleted.error();
  return result;
}

Result<AdvanceReport> AdvanceWithProgress(client::Session& session,
                                          const client::AdvanceOptions& options,
                                          const OnProgress& on_progress) {
  bool cancelled = false;
  const auto show = [&](const client::AdvanceProgress& progress) {
    if (cancelled || on_progress(progress) == Proceed::kGoOn) return;
    cancelled = true;
    session.Cancel();
  };
  client::AdvanceOptions with_progress = options;
  with_progress.progress_interval = kProgressInterval;
  Result<AdvanceReport> report =
      on_progress ? session.Advance(with_progress, show) : session.Advance(with_progress);
  if (report.ok() && cancelled) return Cancelled();
  return report;
}

}  // namespace pliant::cli
