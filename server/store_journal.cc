#include "server/store_journal.h"

#include <utility>

#include "server/limits.h"

namespace pliant::server {

StoreJournal::StoreJournal(Store& store, StoreKey key,
                           std::function<void(const std::shared_ptr<StoreJournal>&)> on_grown)
    : store_(store), key_(std::move(key)), on_grown_(std::move(on_grown)) {}

void StoreJournal::Create(Bytes head, Bytes snapshot, Done done) {
  epoch_ = Epoch::kFirst;
  last_number_ = 0;
  snapshot_size_ = snapshot.size();
  store_.Create(key_, {std::move(head), std::move(snapshot)}, std::move(done));
}

void StoreJournal::Append(std::vector<Bytes> records, Bytes head, Done done) {
  StoreBatch batch{
      .first = last_number_ + 1, .records = std::move(records), .head = std::move(head)};
  last_number_ += static_cast<std::int64_t>(batch.records.size());
  std::size_t size = 0;
  for (const Bytes& record : batch.records) size += record.size();
  // Counted when it is stored: who is told that the journal has grown will find it so.
  store_.Append(key_, epoch_, std::move(batch),
                [self = shared_from_this(), size, done = std::move(done)](const Status& status) {
                  if (status.ok()) self->Count(size);
                  done(status);
                });
}

void StoreJournal::Count(std::size_t bytes) {
  const std::size_t size = journal_size_ += bytes;
  if (size < kJournalBytesMin || size < 2 * snapshot_size_ || on_grown_ == nullptr) return;
  if (!compacting_.exchange(true)) on_grown_(shared_from_this());
}

Status StoreJournal::Claim() {
  if (epoch_ != Epoch::kNone) return {};
  PLIANT_ASSIGN_OR_RETURN(epoch_, store_.Claim(key_));
  return {};
}

Result<Journal::Contents> StoreJournal::Load() {
  PLIANT_RETURN_IF_ERROR(Claim());
  PLIANT_ASSIGN_OR_RETURN(StoredDocument document, store_.Load(key_));
  last_number_ = document.head.last_number;
  snapshot_size_ = document.snapshot.size();
  std::size_t size = 0;
  for (const Bytes& record : document.records) size += record.size();
  journal_size_ = size;
  return Contents{std::move(document.snapshot), std::move(document.records)};
}

void StoreJournal::Delete(Done done) {
  if (const Status claimed = Claim(); !claimed.ok()) {
    done(claimed);
    return;
  }
  store_.Delete(key_, epoch_, std::move(done));
}

Status StoreJournal::Compact(const Compactor& compactor) {
  const auto work = [&]() -> Status {
    PLIANT_ASSIGN_OR_RETURN(StoredDocument document, store_.Load(key_));
    const std::int64_t first = document.head.snapshot_number;
    PLIANT_ASSIGN_OR_RETURN(std::optional<Compacted> compacted,
                            compactor({std::move(document.snapshot), std::move(document.records)}));
    if (!compacted || compacted->record_count == 0) {
      compacting_ = false;
      return {};
    }
    const std::size_t size = compacted->snapshot.size();
    store_.PutSnapshot(key_, epoch_,
                       {first + static_cast<std::int64_t>(compacted->record_count),
                        std::move(compacted->snapshot)},
                       [self = shared_from_this(), size](const Status& status) {
                         if (status.ok()) {
                           self->snapshot_size_ = size;
                           self->journal_size_ = 0;
                         }
                         self->compacting_ = false;
                       });
    return {};
  };
  Status status = work();
  // Otherwise it is the last write that says so; a journal that cannot be compacted grows, and is
  // tried again when it has grown by as much.
  if (!status.ok()) {
    snapshot_size_ = journal_size_.load();
    compacting_ = false;
  }
  return status;
}

}  // namespace pliant::server
