#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "client/cpp/types.h"
#include "core/base/result.h"
#include "core/pliant/options.h"
#include "core/pliant/quality.h"

namespace pliant::client {

/// How a job is submitted.
struct JobSettings {
  Options options = {};
  AdvanceOptions advance = {};  ///< How far it may go.
  std::string job_id = {};      ///< Wished id; empty: the server makes one.
  std::int32_t priority = 0;    ///< Greater goes first among one's own jobs.
  /// How long it is kept after its end; 0: as long as the server likes to.
  std::chrono::milliseconds keep{0};
};

enum class JobState { kQueued, kRunning, kDone, kFailed, kCancelled };

[[nodiscard]] constexpr bool HasEnded(JobState state) { return state >= JobState::kDone; }

/// A job in short.
struct JobInfo {
  std::string job_id;
  JobState state = JobState::kQueued;
  std::int32_t priority = 0;
  std::optional<AdvanceProgress> progress;  ///< While it runs.
  std::optional<AdvanceReport> report;      ///< When it is done, as `quality`.
  std::optional<Quality> quality;
  std::optional<Error> error;  ///< If it failed.
  std::chrono::system_clock::time_point create_time;
  std::optional<std::chrono::system_clock::time_point> end_time;
  std::optional<std::chrono::system_clock::time_point> expire_time;  ///< When it is dropped.
};

/// How to wait for a job.
struct JobWait {
  std::optional<std::chrono::milliseconds> time_max = {};  ///< Absent: for as long as it takes.
  /// How long a server may be out of reach, say for a restart.
  std::chrono::milliseconds reconnect_max{60'000};
  /// Called with what is known after each look at the job, from every 20 ms at first to every 2 s.
  /// False: waits no longer. The job goes on.
  std::function<bool(const JobInfo&)> on_look = {};
};

}  // namespace pliant::client
