#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "server/jobs/job.h"

namespace pliant::server {

/// Bytes that several may read.
using SharedBytes = std::shared_ptr<const Bytes>;

/// Why a store has no input or mesh of a job.
[[nodiscard]] inline Error NotStored(const JobKey& key, const std::string& what) {
  return {ErrorCode::kJobNotFound, "job '" + key.job_id + "' has no " + what + " any more",
          "job_id"};
}

/// Where jobs are kept: what they compute from and what came out.
///
/// A stored job has either its input or, once it has ended, its end; that one drops the input.
/// Writes end with `done`, called once, on any thread, also from within the call; when it says ok,
/// the write survives a crash if the store is durable at all. Writes to one job take effect in the
/// order of their calls.
///
/// *Threads*: all functions from any thread.
class JobStore {
 public:
  using Done = std::function<void(const Status&)>;

  virtual ~JobStore() = default;
  /// Whether jobs outlive the process.
  [[nodiscard]] virtual bool durable() const = 0;
  /// Keeps a new job.
  virtual void Create(const JobInfo& info, Bytes input, Done done) = 0;
  /// Keeps how a job ended; `mesh` is empty unless it is done.
  virtual void End(const JobInfo& ended, Bytes mesh, Done done) = 0;
  /// Forgets a job; one that is not there is forgotten already.
  virtual void Delete(const JobKey& key, Done done) = 0;

  /// Error: kJobNotFound; those of reading.
  virtual Result<SharedBytes> LoadInput(const JobKey& key) = 0;
  virtual Result<SharedBytes> LoadMesh(const JobKey& key) = 0;
  /// All jobs, without inputs and meshes; those that have not ended are kQueued.
  virtual Result<std::vector<JobInfo>> List() = 0;
};

}  // namespace pliant::server
