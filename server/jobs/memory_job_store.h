#pragma once

#include <map>
#include <mutex>
#include <vector>

#include "server/jobs/job_store.h"

namespace pliant::server {

/// Keeps jobs in memory: they end with the server.
///
/// *Threads*: all functions from any thread. `mutex_` is a leaf lock.
class MemoryJobStore final : public JobStore {
 public:
  [[nodiscard]] bool durable() const override { return false; }
  void Create(const JobInfo& info, Bytes input, Done done) override;
  void End(const JobInfo& ended, Bytes mesh, Done done) override;
  void Delete(const JobKey& key, Done done) override;
  Result<SharedBytes> LoadInput(const JobKey& key) override;
  Result<SharedBytes> LoadMesh(const JobKey& key) override;
  Result<std::vector<JobInfo>> List() override;

 private:
  struct Entry {
    JobInfo info;
    SharedBytes input;
    SharedBytes mesh;
  };
  SharedBytes Part(const JobKey& key, SharedBytes Entry::*part);

  std::mutex mutex_;  // Guards entries_.
  std::map<JobKey, Entry> entries_;
};

}  // namespace pliant::server
