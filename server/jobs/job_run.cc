#include "server/jobs/job_run.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "core/mesh/snapshot_bytes.h"

namespace pliant::server {

Task::Outcome JobRun::RunSlice(Clock::Time slice_end) {
  if (over_) return Outcome::kIdle;
  const Clock::Time begin = environment_.clock->Now();
  Outcome outcome = Outcome::kIdle;
  // The edge of the job: what goes wrong inside must not leave it.
  try {
    outcome = RunUnguarded(slice_end);
  } catch (const std::exception& exception) {
    HandleBug(exception.what());
  }
  if (environment_.account != nullptr) {
    const Clock::Time now = environment_.clock->Now();
    environment_.account->Charge(now - begin, now);
  }
  return outcome;
}

// One stage a slice, or as much of the loop as fits into it.
Task::Outcome JobRun::RunUnguarded(Clock::Time slice_end) {
  if (start_.stop->asked()) {
    over_ = true;
    LeaveMemory();
    environment_.on_stopped(start_.info.number);
    return Outcome::kIdle;
  }
  if (result_) {
    if (!Measure(slice_end)) return Outcome::kMore;
    Finish();
    return Outcome::kIdle;
  }
  if (loop_over_) {
    Commit();
    return Outcome::kMore;
  }
  const Status status = engine_ == nullptr ? Build() : Continue(slice_end);
  if (status.ok()) return Outcome::kMore;
  Fail(status.error());
  return Outcome::kIdle;
}

Status JobRun::Build() {
  PLIANT_ASSIGN_OR_RETURN(const SharedBytes bytes, environment_.store->LoadInput(start_.info.key));
  PLIANT_ASSIGN_OR_RETURN(const JobInput input, environment_.codec.read_input(*bytes));
  PLIANT_ASSIGN_OR_RETURN(engine_, environment_.factory(input.engine));
  PLIANT_RETURN_IF_ERROR(Account());
  spec_ = input.advance;
  begin_ = environment_.clock->Now();
  return {};
}

// Runs the loop until it ends or the slice does.
Status JobRun::Continue(Clock::Time slice_end) {
  const Clock& clock = *environment_.clock;
  for (;;) {
    const Clock::Time step_begin = clock.Now();
    PLIANT_ASSIGN_OR_RETURN(
        progress_, engine_->Step({.visits_max = std::min(spec_.visits_max - progress_.counts.visits,
                                                         environment_.visits_per_step),
                                  .stop = start_.stop.get()}));
    PLIANT_RETURN_IF_ERROR(Account());
    const Clock::Time now = clock.Now();
    compute_ += now - step_begin;
    environment_.on_progress(
        start_.info.number,
        {.progress = progress_,
         .vertex_count = engine_->vertex_count(),
         .elapsed = std::chrono::duration_cast<std::chrono::milliseconds>(now - begin_)});
    if (progress_.stop_reason == StopReason::kCancelled) return {};
    if (progress_.stop_reason != StopReason::kVisitBudget ||
        progress_.counts.visits >= spec_.visits_max) {
      loop_over_ = true;
      return {};
    }
    if (spec_.time_max && now - begin_ >= *spec_.time_max) {
      advance_end_ = AdvanceEnd::kTimeBudget;
      loop_over_ = true;
      return {};
    }
    if (now >= slice_end) return {};
  }
}

// Enters what the job uses now into its tenant's account. Error: kResourceExhausted.
Status JobRun::Account() {
  if (environment_.account == nullptr) return {};
  const std::int64_t vertices = engine_->vertex_count();
  const SessionUsage now{.vertices = vertices, .bytes = vertices * kBytesPerVertex};
  PLIANT_RETURN_IF_ERROR(environment_.account->CheckRoom(reported_, now));
  environment_.account->Change(reported_, now);
  reported_ = now;
  return {};
}

void JobRun::LeaveMemory() {
  measurement_.reset();
  engine_.reset();
  if (environment_.account != nullptr) environment_.account->Change(reported_, {});
  reported_ = {};
}

void JobRun::Commit() {
  const Clock::Time commit_begin = environment_.clock->Now();
  JobResult result;
  result.advanced.progress = progress_;
  result.advanced.end = advance_end_;
  const TroubleSearch search = engine_->WhereTroublesMayBe();
  result.advanced.summary = engine_->Commit().summary;
  if (progress_.active_count == 0) result.advanced.troubles = engine_->FindTroubles(search);
  result.revision = engine_->revision();
  const Clock::Time now = environment_.clock->Now();
  using std::chrono::duration_cast;
  using std::chrono::microseconds;
  result.advanced.compute = duration_cast<microseconds>(compute_ + (now - commit_begin));
  result.advanced.elapsed = duration_cast<microseconds>(now - begin_);
  result_ = std::move(result);
}

// Measures the result until that is done (true) or the slice ends (false).
bool JobRun::Measure(Clock::Time slice_end) {
  if (measurement_ == nullptr) measurement_ = engine_->Measure(MetricBasis::kLimited);
  while (measurement_->Continue()) {
    if (start_.stop->asked() || environment_.clock->Now() >= slice_end) return false;
  }
  result_->quality = measurement_->Take();
  return true;
}

void JobRun::Finish() {
  End({.state = JobState::kDone,
       .outcome = environment_.codec.write_result(*result_),
       .mesh = WriteMeshSnapshot(engine_->Snapshot())});
}

void JobRun::End(JobEnd end) {
  over_ = true;
  LeaveMemory();
  environment_.on_end(start_.info.number, std::move(end));
}

void JobRun::Fail(const Error& error) {
  End({.state = JobState::kFailed, .outcome = environment_.codec.write_error(error)});
}

// A check failed inside the engine, or memory ran out: nothing of this job is used any more.
void JobRun::HandleBug(const std::string& what) {
  const std::string& id = start_.info.key.job_id;
  const std::string reference =
      id + "-" + std::to_string(environment_.clock->WallNow().time_since_epoch().count());
  environment_.log->Error("bug", {{"job", id}, {"reference", reference}, {"what", what}});
  Fail({ErrorCode::kInternal,
        "a bug of the server was met, so the job has failed; please report it with reference " +
            reference,
        reference});
}

}  // namespace pliant::server
