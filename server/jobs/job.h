#pragma once

#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "server/clock.h"
#include "server/engine.h"
#include "server/session_messages.h"

/// What a job is: a remeshing that nobody waits for. In core types; server/convert_job.h knows the
/// wire.
namespace pliant::server {

/// Names a job: ids are a tenant's own.
struct JobKey {
  std::string tenant = {};
  std::string job_id = {};

  friend auto operator<=>(const JobKey&, const JobKey&) = default;
};

/// Numbered as they are stored: add, never renumber.
enum class JobState : std::uint8_t {
  kQueued = 1,
  kRunning = 2,
  kDone = 3,
  kFailed = 4,
  kCancelled = 5,
};

[[nodiscard]] constexpr bool HasEnded(JobState state) { return state >= JobState::kDone; }

/// A job to come.
struct JobDraft {
  JobKey key = {};  ///< The id may be empty.
  std::int32_t priority = 0;
  std::chrono::milliseconds keep{0};  ///< From its end until it is dropped.
  std::size_t input_size = 0;         ///< In bytes.
};

/// What a job computes from.
struct JobInput {
  EngineInput engine = {};
  AdvanceSpec advance = {};
};

/// What it has computed, beside the mesh.
struct JobResult {
  Revision revision = Revision::kNone;
  AdvancedEvent advanced = {};
  Quality quality = {};
};

/// How far a running one is.
struct JobProgress {
  Progress progress = {};
  std::int32_t vertex_count = 0;
  std::chrono::milliseconds elapsed{0};
};

/// How it ended.
struct JobEnd {
  JobState state = JobState::kFailed;
  Bytes outcome = {};  ///< A JobResult or an Error, written by the codec.
  Bytes mesh = {};     ///< WriteMeshSnapshot's; empty unless it is done.
};

/// A job as it is seen and stored; its input and its mesh are kept apart (JobStore).
struct JobInfo {
  JobKey key = {};
  std::int64_t number = 0;  ///< Grows with each submission, over all tenants.
  JobState state = JobState::kQueued;
  std::int32_t priority = 0;
  std::chrono::milliseconds keep{0};
  std::size_t input_size = 0;  ///< In bytes.
  std::size_t mesh_size = 0;   ///< In bytes; 0 unless it is done.
  Clock::WallTime create_time = {};
  std::optional<Clock::WallTime> end_time = {};
  std::shared_ptr<const Bytes> outcome = {};  ///< Null until it ends, and if it was cancelled.
  std::optional<JobProgress> progress = {};   ///< While it runs.

  [[nodiscard]] std::optional<Clock::WallTime> expire_time() const {
    if (!end_time) return std::nullopt;
    return *end_time + keep;
  }
  /// What it holds, in bytes.
  [[nodiscard]] std::size_t size() const { return input_size + mesh_size; }
};

}  // namespace pliant::server
