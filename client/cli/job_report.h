#pragma once

#include <string>

#include "client/cli/report.h"
#include "client/cpp/job_types.h"
#include "core/base/result.h"

namespace pliant::cli {

/// "queued", "running", "done", "failed" or "cancelled".
[[nodiscard]] std::string JobStateName(client::JobState state);

/// The fields are described in client/cli/README.md.
[[nodiscard]] Json JobJson(const client::JobInfo& job);

/// One line for people, ended.
[[nodiscard]] std::string JobText(const client::JobInfo& job);

/// What a job that has ended without a mesh means for whoever wanted it: its own error, or
/// kJobNotDone for one that was cancelled. Ok for one that is done. @pre it has ended
[[nodiscard]] Status JobStatus(const client::JobInfo& job);

}  // namespace pliant::cli
