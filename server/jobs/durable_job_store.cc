#include "server/jobs/durable_job_store.h"

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <utility>

namespace pliant::server {
namespace {

constexpr Seal kHeadSeal{.kind = 0x484a4c50, .version = 1};  // "PLJH"
constexpr std::size_t kHeadNumbers = 8;                      // Of a head, beside its outcome.
constexpr Seal kEndSeal{.kind = 0x454a4c50, .version = 1};   // "PLJE"

StoreKey KeyOf(const JobKey& key) {
  return {.kind = DocumentKind::kJob, .tenant = key.tenant, .name = key.job_id};
}

std::int64_t Nanoseconds(Clock::WallTime time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

Clock::WallTime TimeOf(std::int64_t ns) {
  return Clock::WallTime(
      std::chrono::duration_cast<Clock::WallTime::duration>(std::chrono::nanoseconds(ns)));
}

// The store speaks of sessions whatever a document is.
Error Named(Error error) {
  if (error.code == ErrorCode::kSessionNotFound) error.code = ErrorCode::kJobNotFound;
  if (error.code == ErrorCode::kSessionExists) error.code = ErrorCode::kJobExists;
  return error;
}

Status Named(const Status& status) { return status.ok() ? status : Status(Named(status.error())); }

// How a job ended, with its mesh.
struct StoredEnd {
  JobInfo info;
  Bytes mesh;
};

Bytes WriteEnd(const JobInfo& ended, const Bytes& mesh) {
  ByteWriter writer;
  writer.PutColumn(std::span<const std::byte>(WriteJobInfo(ended)));
  writer.PutColumn(std::span<const std::byte>(mesh));
  return SealBytes(kEndSeal, std::move(writer).Take());
}

Result<StoredEnd> ReadEnd(const JobKey& key, std::span<const std::byte> bytes) {
  PLIANT_ASSIGN_OR_RETURN(const std::span<const std::byte> payload,
                          OpenSeal(bytes, kEndSeal, "job"));
  ByteReader reader(payload);
  const Bytes head = reader.TakeColumn<std::byte>();
  StoredEnd end;
  end.mesh = reader.TakeColumn<std::byte>();
  if (!reader.AtEnd()) return CorruptData("job", "its end is not as long as it says");
  PLIANT_ASSIGN_OR_RETURN(end.info, ReadJobInfo(key, head));
  return end;
}

}  // namespace

void DurableJobStore::Create(const JobInfo& info, Bytes input, Done done) {
  {
    const std::lock_guard lock(claim_mutex_);
    epochs_[info.key] = Epoch::kFirst;
  }
  const Bytes head = WriteJobInfo(info);
  // The writes take effect, and tell, in this order; where the first one fails it has the reason.
  const auto created = std::make_shared<Status>();
  store_.Create(KeyOf(info.key), {.head = head},
                [created](const Status& status) { *created = status; });
  StoreBatch batch{.first = 1, .head = head};
  batch.records.push_back(std::move(input));
  store_.Append(KeyOf(info.key), Epoch::kFirst, std::move(batch),
                [created, done = std::move(done)](const Status& status) {
                  done(Named(created->ok() ? status : *created));
                });
}

void DurableJobStore::End(const JobInfo& ended, Bytes mesh, Done done) {
  const Result<Epoch> epoch = EpochOf(ended.key);
  if (!epoch.ok()) {
    done(epoch.error());
    return;
  }
  // For lists alone: it does not count without the snapshot, nor is it missed beside it.
  store_.Append(KeyOf(ended.key), *epoch, {.first = 2, .head = WriteJobInfo(ended)},
                [](const Status&) {});
  store_.PutSnapshot(KeyOf(ended.key), *epoch, {.number = 1, .bytes = WriteEnd(ended, mesh)},
                     [done = std::move(done)](const Status& status) { done(Named(status)); });
}

void DurableJobStore::Delete(const JobKey& key, Done done) {
  const Result<Epoch> epoch = EpochOf(key);
  Forget(key);
  if (!epoch.ok()) {
    done(epoch.error().code == ErrorCode::kJobNotFound ? Status() : Status(epoch.error()));
    return;
  }
  store_.Delete(KeyOf(key), *epoch, [done = std::move(done)](const Status& status) {
    const bool is_gone = status.ok() || status.error().code == ErrorCode::kSessionNotFound;
    done(is_gone ? Status() : status);
  });
}

Result<SharedBytes> DurableJobStore::LoadInput(const JobKey& key) {
  Result<StoredDocument> document = store_.Load(KeyOf(key));
  if (!document.ok()) return Named(document.error());
  if (document->head.snapshot_number != 0 || document->records.empty()) {
    return NotStored(key, "input");
  }
  return std::make_shared<const Bytes>(std::move(document->records.front()));
}

Result<SharedBytes> DurableJobStore::LoadMesh(const JobKey& key) {
  const Result<StoredDocument> document = store_.Load(KeyOf(key));
  if (!document.ok()) return Named(document.error());
  if (document->head.snapshot_number == 0) return NotStored(key, "mesh");
  PLIANT_ASSIGN_OR_RETURN(StoredEnd end, ReadEnd(key, document->snapshot));
  return std::make_shared<const Bytes>(std::move(end.mesh));
}

Result<std::vector<JobInfo>> DurableJobStore::List() {
  PLIANT_ASSIGN_OR_RETURN(const std::vector<StoredHead> heads, store_.List(DocumentKind::kJob));
  std::vector<JobInfo> jobs;
  jobs.reserve(heads.size());
  for (const StoredHead& head : heads) {
    Result<std::optional<JobInfo>> job = Read(head);
    if (!job.ok()) {
      log_.Error("job_unreadable", {{"job", head.key.name}, {"message", job.error().message}});
    } else if (*job) {
      jobs.push_back(**std::move(job));
    }
  }
  return jobs;
}

// Nothing for a submission that was not finished.
Result<std::optional<JobInfo>> DurableJobStore::Read(const StoredHead& stored) {
  const JobKey key{stored.key.tenant, stored.key.name};
  if (stored.last_number == 0) {
    Delete(key, [](const Status&) {});
    return std::optional<JobInfo>();
  }
  PLIANT_ASSIGN_OR_RETURN(JobInfo info, ReadJobInfo(key, stored.head));
  if (stored.snapshot_number == 0) {
    if (HasEnded(info.state)) {  // Its end was not stored, so it has none.
      info.state = JobState::kQueued;
      info.input_size = stored.journal_size;
      info.mesh_size = 0;
      info.end_time.reset();
      info.outcome = nullptr;
    }
    return std::optional(std::move(info));
  }
  if (HasEnded(info.state)) return std::optional(std::move(info));
  const Result<StoredDocument> document = store_.Load(stored.key);
  if (!document.ok()) return Named(document.error());
  PLIANT_ASSIGN_OR_RETURN(StoredEnd end, ReadEnd(key, document->snapshot));
  return std::optional(std::move(end.info));
}

// Claims a job of an earlier server when it is first written to.
Result<Epoch> DurableJobStore::EpochOf(const JobKey& key) {
  const std::lock_guard lock(claim_mutex_);
  if (const auto found = epochs_.find(key); found != epochs_.end()) return found->second;
  Result<Epoch> epoch = store_.Claim(KeyOf(key));
  if (!epoch.ok()) return Named(epoch.error());
  epochs_[key] = *epoch;
  return epoch;
}

void DurableJobStore::Forget(const JobKey& key) {
  const std::lock_guard lock(claim_mutex_);
  epochs_.erase(key);
}

Bytes WriteJobInfo(const JobInfo& info) {
  ByteWriter writer;
  // A job that runs is one that waits for whoever takes it up again.
  const JobState state = HasEnded(info.state) ? info.state : JobState::kQueued;
  const std::array<std::int64_t, kHeadNumbers> numbers = {
      info.number,
      static_cast<std::int64_t>(state),
      info.priority,
      info.keep.count(),
      static_cast<std::int64_t>(info.input_size),
      static_cast<std::int64_t>(info.mesh_size),
      Nanoseconds(info.create_time),
      info.end_time ? Nanoseconds(*info.end_time) : 0};
  writer.PutColumn(std::span<const std::int64_t>(numbers));
  writer.PutColumn(info.outcome ? std::span<const std::byte>(*info.outcome)
                                : std::span<const std::byte>());
  return SealBytes(kHeadSeal, std::move(writer).Take());
}

Result<JobInfo> ReadJobInfo(const JobKey& key, std::span<const std::byte> bytes) {
  PLIANT_ASSIGN_OR_RETURN(const std::span<const std::byte> payload,
                          OpenSeal(bytes, kHeadSeal, "job"));
  ByteReader reader(payload);
  JobInfo info{.key = key};
  const std::vector<std::int64_t> numbers = reader.TakeColumn<std::int64_t>();
  if (numbers.size() != kHeadNumbers) return CorruptData("job", "its head cannot be");
  info.number = numbers[0];
  const std::int64_t state = numbers[1];
  info.priority = static_cast<std::int32_t>(numbers[2]);
  info.keep = std::chrono::milliseconds(numbers[3]);
  info.input_size = static_cast<std::size_t>(numbers[4]);
  info.mesh_size = static_cast<std::size_t>(numbers[5]);
  info.create_time = TimeOf(numbers[6]);
  const std::int64_t end_ns = numbers[7];
  Bytes outcome = reader.TakeColumn<std::byte>();
  const bool is_known = state >= static_cast<std::int64_t>(JobState::kQueued) &&
                        state <= static_cast<std::int64_t>(JobState::kCancelled);
  info.state = is_known ? static_cast<JobState>(state) : JobState::kQueued;
  if (!reader.AtEnd() || !is_known || info.number < 1 || HasEnded(info.state) != (end_ns != 0)) {
    return CorruptData("job", "its head cannot be");
  }
  if (end_ns != 0) info.end_time = TimeOf(end_ns);
  if (!outcome.empty()) info.outcome = std::make_shared<const Bytes>(std::move(outcome));
  return info;
}

}  // namespace pliant::server
