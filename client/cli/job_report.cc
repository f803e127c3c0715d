#include "client/cli/job_report.h"

#include "client/cli/error_text.h"
#include "client/cli/progress_bar.h"

namespace pliant::cli {
namespace {

Json ErrorJson(const Error& error) {
  return {{"code", ErrorCodeName(error.code)},
          {"message", error.message},
          {"field", error.field},
          {"index", error.index},
          {"other_index", error.other_index}};
}

}  // namespace

std::string JobStateName(client::JobState state) {
  switch (state) {
    case client::JobState::kQueued:
      return "queued";
    case client::JobState::kRunning:
      return "running";
    case client::JobState::kDone:
      return "done";
    case client::JobState::kFailed:
      return "failed";
    case client::JobState::kCancelled:
      return "cancelled";
  }
  return "queued";
}

Json JobJson(const client::JobInfo& job) {
  Json json = {{"job_id", job.job_id},
               {"state", JobStateName(job.state)},
               {"priority", job.priority},
               {"create_time", UtcTime(job.create_time)}};
  if (job.end_time) json["end_time"] = UtcTime(*job.end_time);
  if (job.expire_time) json["expire_time"] = UtcTime(*job.expire_time);
  if (job.progress) {
    json["progress"] = {{"visits", job.progress->visits},
                        {"active_count", job.progress->active_count},
                        {"vertex_count", job.progress->vertex_count},
                        {"seconds", static_cast<double>(job.progress->elapsed.count()) / 1000}};
  }
  if (job.error) json["error"] = ErrorJson(*job.error);
  if (job.report) json.update(AdvanceJson(*job.report));
  if (job.quality) json["quality"] = QualityJson(*job.quality);
  return json;
}

std::string JobText(const client::JobInfo& job) {
  std::string text = job.job_id + "  " + JobStateName(job.state);
  if (job.progress) text += "  " + Grouped(job.progress->vertex_count) + " vertices so far";
  if (job.report) {
    text += "  " + Grouped(job.report->summary.vertex_count) + " vertices  " +
            Grouped(job.report->summary.triangle_count) + " triangles";
  }
  text += "  submitted " + UtcTime(job.create_time);
  if (job.expire_time) text += "  kept until " + UtcTime(*job.expire_time);
  if (job.error) text += "  " + ErrorText(*job.error);
  return text + "\n";
}

Status JobStatus(const client::JobInfo& job) {
  if (job.state == client::JobState::kDone) return {};
  if (job.error) return *job.error;
  return Error{ErrorCode::kJobNotDone, "job " + job.job_id + " is " + JobStateName(job.state), {}};
}

}  // namespace pliant::cli
