#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "server/journal.h"
#include "server/store/store.h"

namespace pliant::server {

/// A session's journal as a document of a store. Claims it when it is first loaded.
class StoreJournal final : public Journal, public std::enable_shared_from_this<StoreJournal> {
 public:
  /// @param store     outlives it.
  /// @param on_grown  called when the journal has outgrown twice its snapshot: Compact is due.
  StoreJournal(Store& store, StoreKey key,
               std::function<void(const std::shared_ptr<StoreJournal>&)> on_grown);

  void Create(Bytes head, Bytes snapshot, Done done) override;
  void Append(std::vector<Bytes> records, Bytes head, Done done) override;
  Result<Contents> Load() override;
  void Delete(Done done) override;

  /// Makes the snapshot of a journal's contents: bytes, and how many records they cover; none if
  /// there is nothing to gain.
  struct Compacted {
    Bytes snapshot;
    std::size_t record_count = 0;
  };
  using Compactor = std::function<Result<std::optional<Compacted>>(const Contents&)>;
  /// Replaces old records by a snapshot, beside the session, which goes on. From any thread.
  Status Compact(const Compactor& compactor);

  [[nodiscard]] const StoreKey& key() const { return key_; }

 private:
  void Count(std::size_t bytes);
  [[nodiscard]] Status Claim();

  Store& store_;
  const StoreKey key_;
  const std::function<void(const std::shared_ptr<StoreJournal>&)> on_grown_;
  std::atomic<Epoch> epoch_ = Epoch::kNone;
  std::int64_t last_number_ = 0;
  // About what the store holds, so that nobody has to ask it.
  std::atomic<std::size_t> journal_size_ = 0;
  std::atomic<std::size_t> snapshot_size_ = 0;
  std::atomic<bool> compacting_ = false;
};

}  // namespace pliant::server
