#include "server/jobs/memory_job_store.h"

#include <string>
#include <utility>

namespace pliant::server {

void MemoryJobStore::Create(const JobInfo& info, Bytes input, Done done) {
  {
    const std::lock_guard lock(mutex_);
    entries_[info.key] = {
        .info = info, .input = std::make_shared<const Bytes>(std::move(input)), .mesh = nullptr};
  }
  done({});
}

void MemoryJobStore::End(const JobInfo& ended, Bytes mesh, Done done) {
  {
    const std::lock_guard lock(mutex_);
    // A job that expired in the meantime stays forgotten.
    if (const auto found = entries_.find(ended.key); found != entries_.end()) {
      found->second = {
          .info = ended, .input = nullptr, .mesh = std::make_shared<const Bytes>(std::move(mesh))};
    }
  }
  done({});
}

void MemoryJobStore::Delete(const JobKey& key, Done done) {
  {
    const std::lock_guard lock(mutex_);
    entries_.erase(key);
  }
  done({});
}

Result<SharedBytes> MemoryJobStore::LoadInput(const JobKey& key) {
  if (SharedBytes input = Part(key, &Entry::input)) return input;
  return NotStored(key, "input");
}

Result<SharedBytes> MemoryJobStore::LoadMesh(const JobKey& key) {
  if (SharedBytes mesh = Part(key, &Entry::mesh)) return mesh;
  return NotStored(key, "mesh");
}

SharedBytes MemoryJobStore::Part(const JobKey& key, SharedBytes Entry::*part) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  return found == entries_.end() ? nullptr : found->second.*part;
}

Result<std::vector<JobInfo>> MemoryJobStore::List() {
  const std::lock_guard lock(mutex_);
  std::vector<JobInfo> jobs;
  jobs.reserve(entries_.size());
  for (const auto& [key, entry] : entries_) jobs.push_back(entry.info);
  return jobs;
}

}  // namespace pliant::server
