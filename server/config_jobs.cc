#include "server/config_jobs.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <chrono>

namespace pliant::server {

void AddJobFlags(CLI::App& app, JobConfig& config) {
  app.add_option("--jobs-max", config.jobs_max, "Jobs at once, those that are kept included")
      ->capture_default_str();
  app.add_option("--jobs-per-tenant-max", config.jobs_per_tenant_max, "Jobs of one tenant at once")
      ->capture_default_str();
  app.add_option("--jobs-bytes-max", config.bytes_max,
                 "Bytes of inputs and results at which new jobs are refused")
      ->capture_default_str();
  app.add_option("--jobs-per-tenant-bytes-max", config.bytes_per_tenant_max,
                 "The same for the jobs of one tenant")
      ->capture_default_str();
  app.add_option("--jobs-running-max", config.running_max,
                 "Jobs that compute at once; 0: half of the workers, at least one")
      ->capture_default_str();
  app.add_option("--job-keep-h", config.keep_h,
                 "Time for which the result of a job is kept that does not say, in h")
      ->capture_default_str();
}

bool SetJobKey(const std::string& key, const YAML::Node& value, JobConfig& config) {
  if (key == "jobs-max") {
    config.jobs_max = value.as<std::size_t>();
  } else if (key == "jobs-per-tenant-max") {
    config.jobs_per_tenant_max = value.as<std::size_t>();
  } else if (key == "jobs-bytes-max") {
    config.bytes_max = value.as<std::size_t>();
  } else if (key == "jobs-per-tenant-bytes-max") {
    config.bytes_per_tenant_max = value.as<std::size_t>();
  } else if (key == "jobs-running-max") {
    config.running_max = value.as<std::size_t>();
  } else if (key == "job-keep-h") {
    config.keep_h = value.as<std::int64_t>();
  } else {
    return false;
  }
  return true;
}

Status CheckJobConfig(const JobConfig& config) {
  const auto at_least_one = [](std::size_t value, const std::string& key) -> Status {
    if (value >= 1) return {};
    return Error{ErrorCode::kOutOfRange, "--" + key + " must be >= 1", key};
  };
  PLIANT_RETURN_IF_ERROR(at_least_one(config.jobs_max, "jobs-max"));
  PLIANT_RETURN_IF_ERROR(at_least_one(config.jobs_per_tenant_max, "jobs-per-tenant-max"));
  PLIANT_RETURN_IF_ERROR(at_least_one(config.bytes_max, "jobs-bytes-max"));
  PLIANT_RETURN_IF_ERROR(at_least_one(config.bytes_per_tenant_max, "jobs-per-tenant-bytes-max"));
  if (config.keep_h < 1 || config.keep_h > kJobKeepHMax) {
    return Error{ErrorCode::kOutOfRange,
                 "--job-keep-h is " + std::to_string(config.keep_h) + "; allowed are 1 to " +
                     std::to_string(kJobKeepHMax),
                 "job-keep-h"};
  }
  return {};
}

JobBoard::Bounds JobBoundsOf(const JobConfig& config, int worker_count) {
  const auto half = static_cast<std::size_t>(std::max(1, worker_count / 2));
  return {.jobs_max = config.jobs_max,
          .jobs_per_tenant_max = config.jobs_per_tenant_max,
          .bytes_max = config.bytes_max,
          .bytes_per_tenant_max = config.bytes_per_tenant_max,
          .running_max = config.running_max > 0 ? config.running_max : half};
}

JobKeep JobKeepOf(const JobConfig& config) {
  return {.usual = std::chrono::hours(config.keep_h),
          .max = std::chrono::milliseconds(kJobKeepMsMax)};
}

}  // namespace pliant::server
