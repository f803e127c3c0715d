#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "client/cli/engine.h"
#include "core/base/result.h"

namespace pliant::cli {

/// How a mesh that nobody waits for is made: the options of a job.
struct DetachOptions {
  std::string job_id;         ///< --job-id; empty: the server makes one.
  std::int32_t priority = 0;  ///< --priority
  double keep_hours = 0;      ///< --keep-h; 0: as long as the server likes to.

  [[nodiscard]] client::JobSettings Settings(const RemeshJob& job) const;
};

void AddDetachOptions(CLI::App& command, DetachOptions& options);

/// Submits the job and prints its id.
[[nodiscard]] Status SubmitDetached(const std::string& address, const RemeshJob& job,
                                    const DetachOptions& options);

}  // namespace pliant::cli
