#pragma once

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/result.h"
#include "server/convert_job.h"
#include "server/jobs/job_board.h"
#include "server/limits.h"

namespace YAML {
class Node;
}

namespace pliant::server {

/// How jobs are kept and run: the part of Config that is theirs. Each field is a flag and a key.
struct JobConfig {
  std::size_t jobs_max = kJobsMaxDefault;  ///< --jobs-max; in all states together.
  std::size_t jobs_per_tenant_max = kJobsMaxDefault;
  /// --jobs-bytes-max: inputs and results; reaching it stops new submissions.
  std::size_t bytes_max = kJobsBytesMaxDefault;
  std::size_t bytes_per_tenant_max = kJobsBytesMaxDefault;
  /// --jobs-running-max: jobs that compute at once; 0: half of the workers, at least one.
  std::size_t running_max = 0;
  std::int64_t keep_h = kJobKeepHDefault;  ///< --job-keep-h: of a job that does not say.
};

/// Adds the flags.
void AddJobFlags(CLI::App& app, JobConfig& config);

/// Sets the field of a key from YAML; false if there is no such key. Throws YAML's exceptions.
bool SetJobKey(const std::string& key, const YAML::Node& value, JobConfig& config);

/// Error: kOutOfRange.
[[nodiscard]] Status CheckJobConfig(const JobConfig& config);

/// The board's bounds on a server with so many workers.
[[nodiscard]] JobBoard::Bounds JobBoundsOf(const JobConfig& config, int worker_count);

[[nodiscard]] JobKeep JobKeepOf(const JobConfig& config);

}  // namespace pliant::server
