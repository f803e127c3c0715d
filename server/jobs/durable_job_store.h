#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "server/jobs/job_store.h"
#include "server/log.h"
#include "server/store/store.h"

namespace pliant::server {

/// Keeps jobs in a Store: they outlive the server.
///
/// A job is a document: its head, and its input as record 1. Its end replaces that record by a
/// snapshot of how it ended and the mesh; the job has ended if and only if that is there. The new
/// head is written beside it, so that a list need not read meshes. So an input or a mesh is written
/// once, and one takes the other's place in one step.
///
/// *Threads*: all functions from any thread but the one that calls `done`. `claim_mutex_` comes
/// before the store's locks.
class DurableJobStore final : public JobStore {
 public:
  /// Both outlive it.
  DurableJobStore(Store& store, const Log& log) : store_(store), log_(log) {}

  [[nodiscard]] bool durable() const override { return true; }
  void Create(const JobInfo& info, Bytes input, Done done) override;
  void End(const JobInfo& ended, Bytes mesh, Done done) override;
  void Delete(const JobKey& key, Done done) override;
  Result<SharedBytes> LoadInput(const JobKey& key) override;
  Result<SharedBytes> LoadMesh(const JobKey& key) override;
  /// What cannot be read is left out, and logged. What was never acknowledged is deleted.
  Result<std::vector<JobInfo>> List() override;

 private:
  Result<Epoch> EpochOf(const JobKey& key);
  void Forget(const JobKey& key);
  Result<std::optional<JobInfo>> Read(const StoredHead& stored);

  Store& store_;
  const Log& log_;
  std::mutex claim_mutex_;  // Guards epochs_.
  std::map<JobKey, Epoch> epochs_;
};

/// A job's head as it is stored: versioned, with a checksum.
[[nodiscard]] Bytes WriteJobInfo(const JobInfo& info);
/// Errors: kDataCorrupt, kDataVersion.
[[nodiscard]] Result<JobInfo> ReadJobInfo(const JobKey& key, std::span<const std::byte> bytes);

}  // namespace pliant::server
