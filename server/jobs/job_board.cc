#include "server/jobs/job_board.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <tuple>
#include <utility>

#include "core/base/check.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

// 48 random bits, as for sessions; the letter tells a person which of the two an id names.
std::string RandomId(Rng& rng) {
  std::array<char, 16> text{};
  const int length = std::snprintf(text.data(), text.size(), "j-%012llx",
                                   static_cast<unsigned long long>(rng.Next() >> 16));
  return std::string(text.data(), static_cast<std::size_t>(length));
}

Error Full(std::string what) {
  return {.code = ErrorCode::kResourceExhausted,
          .message = std::move(what) +
                     "; jobs that have ended count until they expire: try again later, and submit "
                     "with a smaller keep_ms",
          .retry_after_ms = kSessionRetryMs};
}

std::pair<std::int64_t, std::int64_t> PlaceInQueue(const JobInfo& info) {
  return {-std::int64_t{info.priority}, info.number};
}

}  // namespace

JobBoard::JobBoard(const Bounds& bounds, std::uint64_t seed, const Clock& clock)
    : bounds_(bounds), clock_(clock), rng_(seed) {}

Result<JobInfo> JobBoard::Reserve(const JobDraft& draft) {
  const std::lock_guard lock(mutex_);
  if (!draft.key.job_id.empty() && numbers_.contains(draft.key)) {
    return Error{ErrorCode::kJobExists, "a job " + draft.key.job_id + " exists already", "job_id"};
  }
  PLIANT_RETURN_IF_ERROR(CheckRoom(draft));
  JobInfo info{.key = draft.key,
               .number = ++last_number_,
               .priority = draft.priority,
               .keep = draft.keep,
               .input_size = draft.input_size,
               .create_time = clock_.WallNow()};
  while (info.key.job_id.empty() || numbers_.contains(info.key)) info.key.job_id = RandomId(rng_);
  numbers_[info.key] = info.number;
  Tenant& tenant = tenants_[info.key.tenant];
  ++tenant.count;
  tenant.bytes += info.size();
  bytes_ += info.size();
  entries_[info.number].info = info;
  return info;
}

Status JobBoard::CheckRoom(const JobDraft& draft) const {
  if (stopped_) {
    return Error{ErrorCode::kUnavailable, "the server shuts down; connect again later", {}};
  }
  if (entries_.size() >= bounds_.jobs_max) {
    return Full("this server has its " + std::to_string(bounds_.jobs_max) + " jobs already");
  }
  if (bytes_ >= bounds_.bytes_max) {
    return Full("the jobs of this server hold " + std::to_string(bytes_) + " bytes; allowed are " +
                std::to_string(bounds_.bytes_max));
  }
  const auto own = tenants_.find(draft.key.tenant);
  if (own == tenants_.end()) return {};
  if (own->second.count >= bounds_.jobs_per_tenant_max) {
    return Full("you have your " + std::to_string(bounds_.jobs_per_tenant_max) + " jobs already");
  }
  if (own->second.bytes >= bounds_.bytes_per_tenant_max) {
    return Full("your jobs hold " + std::to_string(own->second.bytes) + " bytes; allowed are " +
                std::to_string(bounds_.bytes_per_tenant_max));
  }
  return {};
}

void JobBoard::Publish(std::int64_t number) {
  const std::lock_guard lock(mutex_);
  Entry& entry = entries_.at(number);
  PLIANT_CHECK(entry.reserved, "number", number);
  Enqueue(entry.info);
  entry.reserved = false;
}

void JobBoard::Enqueue(const JobInfo& info) {
  Tenant& tenant = tenants_[info.key.tenant];
  tenant.queue.insert(PlaceInQueue(info));
  tenant.seen.insert(info.number);
}

void JobBoard::Withdraw(std::int64_t number) {
  const std::lock_guard lock(mutex_);
  Erase(number);
}

void JobBoard::Restore(JobInfo info) {
  const std::lock_guard lock(mutex_);
  PLIANT_CHECK(!entries_.contains(info.number) && !numbers_.contains(info.key), "job",
               info.key.job_id);
  last_number_ = std::max(last_number_, info.number);
  numbers_[info.key] = info.number;
  Tenant& tenant = tenants_[info.key.tenant];
  ++tenant.count;
  tenant.bytes += info.size();
  bytes_ += info.size();
  Entry& entry = entries_[info.number];
  entry.info = std::move(info);
  entry.reserved = false;
  if (HasEnded(entry.info.state)) {
    tenant.seen.insert(entry.info.number);
    expiry_.emplace(*entry.info.expire_time(), entry.info.number);
    return;
  }
  entry.info.state = JobState::kQueued;
  Enqueue(entry.info);
}

std::optional<JobBoard::Start> JobBoard::TakeNext() {
  const std::lock_guard lock(mutex_);
  if (stopped_ || places_.size() >= bounds_.running_max) return std::nullopt;
  Tenant* next = nullptr;
  for (auto& [name, tenant] : tenants_) {
    if (tenant.queue.empty()) continue;
    if (next == nullptr ||
        std::tie(tenant.running, tenant.last_start) < std::tie(next->running, next->last_start)) {
      next = &tenant;
    }
  }
  if (next == nullptr) return std::nullopt;
  const std::int64_t number = next->queue.begin()->second;
  next->queue.erase(next->queue.begin());
  ++next->running;
  next->last_start = ++start_count_;
  Entry& entry = entries_.at(number);
  entry.info.state = JobState::kRunning;
  entry.info.progress = JobProgress{};
  entry.stop = std::make_shared<StopFlag>();
  places_[number] = entry.info.key.tenant;
  return Start{.info = entry.info, .stop = entry.stop};
}

void JobBoard::Tell(std::int64_t number, const JobProgress& progress) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(number);
  if (found == entries_.end() || found->second.info.state != JobState::kRunning) return;
  found->second.info.progress = progress;
}

std::optional<JobInfo> JobBoard::BeginEnd(std::int64_t number, const JobEnd& end) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(number);
  if (found == entries_.end() || found->second.info.state != JobState::kRunning) {
    return std::nullopt;
  }
  found->second.ending = true;
  JobInfo ended = found->second.info;
  ended.state = end.state;
  ended.outcome = std::make_shared<const Bytes>(end.outcome);
  ended.mesh_size = end.mesh.size();
  ended.input_size = 0;
  ended.progress.reset();
  ended.end_time = clock_.WallNow();
  return ended;
}

void JobBoard::FinishEnd(const JobInfo& ended) {
  const std::lock_guard lock(mutex_);
  Entry& entry = entries_.at(ended.number);
  PLIANT_CHECK(entry.ending, "number", ended.number);
  Tenant& tenant = tenants_[ended.key.tenant];
  tenant.bytes += ended.size() - entry.info.size();
  bytes_ += ended.size() - entry.info.size();
  entry.info = ended;
  entry.ending = false;
  Settle(entry);
  FreePlace(ended.number, ended.key.tenant);
}

// A job that has ended waits for the end of its time.
void JobBoard::Settle(Entry& entry) {
  entry.stop = nullptr;
  expiry_.emplace(*entry.info.expire_time(), entry.info.number);
}

void JobBoard::GiveBack(std::int64_t number) {
  const std::lock_guard lock(mutex_);
  const auto place = places_.find(number);
  if (place != places_.end()) FreePlace(number, std::string(place->second));
}

void JobBoard::FreePlace(std::int64_t number, const std::string& tenant) {
  if (places_.erase(number) == 1) --tenants_[tenant].running;
}

const JobBoard::Entry* JobBoard::FindSeen(const JobKey& key) const {
  const auto number = numbers_.find(key);
  if (number == numbers_.end()) return nullptr;
  const Entry& entry = entries_.at(number->second);
  const std::optional<Clock::WallTime> expire_time = entry.info.expire_time();
  if (entry.reserved || (expire_time && *expire_time <= clock_.WallNow())) return nullptr;
  return &entry;
}

Result<JobInfo> JobBoard::Find(const JobKey& key) const {
  const std::lock_guard lock(mutex_);
  if (const Entry* entry = FindSeen(key)) return entry->info;
  return Error{ErrorCode::kJobNotFound,
               "there is no job '" + key.job_id + "'; its time may be over", "job_id"};
}

JobBoard::Page JobBoard::List(const std::string& tenant, std::int64_t before,
                              std::size_t count_max) const {
  const std::lock_guard lock(mutex_);
  Page page;
  const auto own = tenants_.find(tenant);
  if (own == tenants_.end()) return page;
  const std::set<std::int64_t>& seen = own->second.seen;
  for (auto it = before > 0 ? seen.lower_bound(before) : seen.end(); it != seen.begin();) {
    const Entry& entry = entries_.at(*--it);
    if (FindSeen(entry.info.key) == nullptr) continue;
    if (page.jobs.size() == count_max) return page;
    page.jobs.push_back(entry.info);
    page.next = *it;
  }
  page.next = 0;
  return page;
}

Result<JobBoard::Cancelled> JobBoard::Cancel(const JobKey& key) {
  const std::lock_guard lock(mutex_);
  if (FindSeen(key) == nullptr) {
    return Error{ErrorCode::kJobNotFound,
                 "there is no job '" + key.job_id + "'; its time may be over", "job_id"};
  }
  Entry& entry = entries_.at(numbers_.at(key));
  if (HasEnded(entry.info.state) || entry.ending) return Cancelled{.info = entry.info};
  Tenant& tenant = tenants_[key.tenant];
  tenant.queue.erase(PlaceInQueue(entry.info));
  if (entry.stop != nullptr) entry.stop->Set(true);
  tenant.bytes -= entry.info.input_size;
  bytes_ -= entry.info.input_size;
  entry.info.input_size = 0;
  entry.info.state = JobState::kCancelled;
  entry.info.progress.reset();
  entry.info.end_time = clock_.WallNow();
  Settle(entry);
  return Cancelled{.info = entry.info, .changed = true};
}

std::vector<JobKey> JobBoard::TakeExpired() {
  const std::lock_guard lock(mutex_);
  std::vector<JobKey> expired;
  while (!expiry_.empty() && expiry_.begin()->first <= clock_.WallNow()) {
    const std::int64_t number = expiry_.begin()->second;
    expired.push_back(entries_.at(number).info.key);
    Erase(number);
  }
  return expired;
}

void JobBoard::Erase(std::int64_t number) {
  const auto found = entries_.find(number);
  PLIANT_CHECK(found != entries_.end(), "number", number);
  const JobInfo& info = found->second.info;
  Tenant& tenant = tenants_[info.key.tenant];
  --tenant.count;
  tenant.bytes -= info.size();
  bytes_ -= info.size();
  tenant.seen.erase(number);
  if (const auto expire_time = info.expire_time()) expiry_.erase({*expire_time, number});
  numbers_.erase(info.key);
  entries_.erase(found);
}

JobBoard::Unfinished JobBoard::StopAll() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  Unfinished unfinished;
  for (auto& [number, entry] : entries_) {
    if (entry.info.state == JobState::kQueued && !entry.reserved) ++unfinished.queued;
    if (entry.info.state != JobState::kRunning || entry.ending) continue;
    ++unfinished.running;
    entry.stop->Set(true);
  }
  return unfinished;
}

}  // namespace pliant::server
