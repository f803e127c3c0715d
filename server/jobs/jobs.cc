#include "server/jobs/jobs.h"

#include <chrono>
#include <exception>
#include <utility>
#include <vector>

#include "core/mesh/snapshot_bytes.h"
#include "server/errand.h"

namespace pliant::server {
namespace {

std::string StateName(JobState state) {
  switch (state) {
    case JobState::kQueued:
      return "queued";
    case JobState::kRunning:
      return "running";
    case JobState::kDone:
      return "done";
    case JobState::kFailed:
      return "failed";
    case JobState::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

Result<MeshDiff> ReadMesh(JobStore& store, const JobKey& key) {
  try {
    PLIANT_ASSIGN_OR_RETURN(const SharedBytes bytes, store.LoadMesh(key));
    return ReadMeshSnapshot(*bytes);
  } catch (const std::exception& exception) {
    return Error{ErrorCode::kInternal, std::string("reading a mesh failed: ") + exception.what(),
                 key.job_id};
  }
}

}  // namespace

Jobs::Jobs(Environment environment, const JobBoard::Bounds& bounds, std::uint64_t seed)
    : environment_(std::move(environment)), board_(bounds, seed, *environment_.clock) {}

Jobs::~Jobs() {
  // However long a disk takes; its store tells of every write.
  writes_->WaitForNone(std::chrono::hours(1));
}

// A write that this object lives to see the end of.
JobStore::Done Jobs::Counted(JobStore::Done done) {
  writes_->Begin();
  return [writes = writes_, done = std::move(done)](const Status& status) {
    done(status);
    writes->End();
  };
}

Status Jobs::Load() {
  PLIANT_ASSIGN_OR_RETURN(std::vector<JobInfo> jobs, environment_.store->List());
  const std::size_t count = jobs.size();
  for (JobInfo& job : jobs) board_.Restore(std::move(job));
  if (count > 0) environment_.log->Info("jobs_loaded", {{"count", std::to_string(count)}});
  Sweep();
  StartQueued();
  return {};
}

void Jobs::Submit(const JobDraft& draft, Bytes input, const InfoDone& done) {
  Sweep();
  if (environment_.accounts != nullptr) {
    const Status has_time =
        environment_.accounts->Of(draft.key.tenant)->CheckCompute(environment_.clock->Now());
    if (!has_time.ok()) {
      done(has_time.error());
      return;
    }
  }
  const Result<JobInfo> reserved = board_.Reserve(draft);
  if (!reserved.ok()) {
    done(reserved);
    return;
  }
  environment_.store->Create(
      *reserved, std::move(input), Counted([this, info = *reserved, done](const Status& status) {
        if (!status.ok()) {
          board_.Withdraw(info.number);
          done(status.error());
          return;
        }
        board_.Publish(info.number);
        environment_.log->Info("job_submit", {{"job", info.key.job_id},
                                              {"priority", std::to_string(info.priority)},
                                              {"bytes", std::to_string(info.input_size)}});
        done(info);
        StartQueued();
      }));
}

Result<JobInfo> Jobs::Get(const JobKey& key) {
  Sweep();
  return board_.Find(key);
}

JobBoard::Page Jobs::List(const std::string& tenant, std::int64_t before, std::size_t count_max) {
  Sweep();
  return board_.List(tenant, before, count_max);
}

void Jobs::Cancel(const JobKey& key, const InfoDone& done) {
  Sweep();
  const Result<JobBoard::Cancelled> cancelled = board_.Cancel(key);
  if (!cancelled.ok()) {
    done(cancelled.error());
    return;
  }
  const JobInfo& info = cancelled->info;
  if (!cancelled->changed) {
    done(info);
    return;
  }
  environment_.log->Info("job_cancel", {{"job", key.job_id}});
  environment_.store->End(
      info, {}, Counted([info, done](const Status& status) {
        done(status.ok() ? Result<JobInfo>(info) : Result<JobInfo>(status.error()));
      }));
}

void Jobs::Fetch(const JobKey& key, MeshDone done) {
  Sweep();
  const Result<JobInfo> info = board_.Find(key);
  if (!info.ok()) {
    done(info.error());
    return;
  }
  if (info->state != JobState::kDone) {
    done(Error{ErrorCode::kJobNotDone,
               "job " + key.job_id + " is " + StateName(info->state) +
                   "; only a job that is done has a mesh, and GetJob says more",
               "job_id"});
    return;
  }
  environment_.scheduler->Wake(std::make_shared<Errand>(
      [store = environment_.store, key, done = std::move(done)] { done(ReadMesh(*store, key)); }));
}

void Jobs::Stop() {
  const JobBoard::Unfinished unfinished = board_.StopAll();
  if (unfinished.queued + unfinished.running == 0) return;
  const bool durable = environment_.store->durable();
  environment_.log->Warning(durable ? "jobs_interrupted" : "jobs_lost",
                            {{"queued", std::to_string(unfinished.queued)},
                             {"running", std::to_string(unfinished.running)}});
}

void Jobs::Sweep() {
  // Whoever comes next and takes the id of a forgotten job stores his own after the deletion.
  const std::lock_guard lock(sweep_mutex_);
  for (const JobKey& key : board_.TakeExpired()) {
    environment_.store->Delete(key, [log = environment_.log, key](const Status& status) {
      if (status.ok()) return;
      log->Warning("job_delete_failed", {{"job", key.job_id}, {"message", status.error().message}});
    });
  }
}

void Jobs::StartQueued() {
  while (std::optional<JobBoard::Start> start = board_.TakeNext()) {
    environment_.log->Info("job_start", {{"job", start->info.key.job_id}});
    environment_.scheduler->Wake(std::make_shared<JobRun>(
        JobRun::Environment{
            .clock = environment_.clock,
            .log = environment_.log,
            .store = environment_.store,
            .factory = environment_.factory,
            .codec = environment_.codec,
            .visits_per_step = environment_.visits_per_step,
            .account = environment_.accounts == nullptr
                           ? nullptr
                           : environment_.accounts->Of(start->info.key.tenant),
            .on_progress = [this](std::int64_t number,
                                  const JobProgress& progress) { board_.Tell(number, progress); },
            .on_end = [this](std::int64_t number, JobEnd end) { EndRun(number, std::move(end)); },
            .on_stopped =
                [this](std::int64_t number) {
                  board_.GiveBack(number);
                  StartQueued();
                }},
        *std::move(start)));
  }
}

void Jobs::EndRun(std::int64_t number, JobEnd end) {
  Sweep();
  std::optional<JobInfo> ended = board_.BeginEnd(number, end);
  if (!ended) {  // It was cancelled while it ended.
    board_.GiveBack(number);
    StartQueued();
    return;
  }
  environment_.store->End(
      *ended, std::move(end.mesh), Counted([this, info = *ended](const Status& status) mutable {
        if (!status.ok()) {
          // It could not be kept. After a restart the job is done again.
          info.state = JobState::kFailed;
          info.mesh_size = 0;
          info.outcome =
              std::make_shared<const Bytes>(environment_.codec.write_error(status.error()));
        }
        board_.FinishEnd(info);
        environment_.log->Info("job_end",
                               {{"job", info.key.job_id}, {"state", StateName(info.state)}});
        StartQueued();
      }));
}

}  // namespace pliant::server
