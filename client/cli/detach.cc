#include "client/cli/detach.h"

#include <chrono>
#include <iostream>

namespace pliant::cli {

client::JobSettings DetachOptions::Settings(const RemeshJob& job) const {
  return {.options = job.options,
          .advance = job.advance,
          .job_id = job_id,
          .priority = priority,
          .keep = std::chrono::milliseconds(static_cast<std::int64_t>(keep_hours * 3'600'000))};
}

void AddDetachOptions(CLI::App& command, DetachOptions& options) {
  command.add_option("--job-id", options.job_id, "With --detach: wished id of the job")
      ->type_name("ID")
      ->needs("--detach");
  command
      .add_option("--priority", options.priority,
                  "With --detach: greater goes first among one's own jobs")
      ->needs("--detach")
      ->capture_default_str();
  command
      .add_option("--keep-h", options.keep_hours,
                  "With --detach: hours for which the result is kept; 0: the server's choice")
      ->check(CLI::Range(0.0, 1e6))
      ->needs("--detach")
      ->capture_default_str();
}

Status SubmitDetached(const std::string& address, const RemeshJob& job,
                      const DetachOptions& options) {
  PLIANT_ASSIGN_OR_RETURN(client::Client server, client::Client::Connect(address));
  PLIANT_ASSIGN_OR_RETURN(const client::JobInfo submitted,
                          server.SubmitJob(job.start, job.metric, options.Settings(job)));
  std::cout << submitted.job_id << "\n";
  return {};
}

}  // namespace pliant::cli
