#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "server/store/store.h"

namespace pliant::server {

/// A store in memory that keeps what Store promises, for tests: the same contract test runs on it
/// and on the real one. Writes are done at once, or when the test says so.
class MemoryStore final : public Store {
 public:
  void Create(const StoreKey& key, Draft draft, Done done) override {
    Do(
        [this, key, draft = std::move(draft)]() -> Status {
          if (documents_.contains(key)) return Error{ErrorCode::kSessionExists, "exists", {}};
          Document& document = documents_[key];
          document.order = ++last_order_;
          document.stored.head.key = key;
          document.stored.head.epoch = Epoch::kFirst;
          document.stored.head.head = draft.head;
          document.stored.head.snapshot_size = draft.snapshot.size();
          document.stored.snapshot = draft.snapshot;
          return {};
        },
        std::move(done));
  }
  Result<Epoch> Claim(const StoreKey& key) override {
    const std::lock_guard lock(mutex_);
    const auto found = documents_.find(key);
    if (found == documents_.end()) return Missing();
    StoredHead& head = found->second.stored.head;
    return head.epoch = Epoch(static_cast<std::int64_t>(head.epoch) + 1);
  }
  Status Renew(const StoreKey& key, Epoch epoch) override {
    const std::lock_guard lock(mutex_);
    const auto found = Own(key, epoch);
    return found.ok() ? Status() : Status(found.error());
  }
  Status Release(const StoreKey& key, Epoch epoch) override {
    const std::lock_guard lock(mutex_);
    PLIANT_ASSIGN_OR_RETURN(Document * document, Own(key, epoch));
    document->stored.head.epoch = Epoch(static_cast<std::int64_t>(epoch) + 1);
    return {};
  }
  void Append(const StoreKey& key, Epoch epoch, StoreBatch batch, Done done) override {
    Do(
        [this, key, epoch, batch = std::move(batch)]() -> Status {
          PLIANT_ASSIGN_OR_RETURN(Document * document, Own(key, epoch));
          StoredHead& head = document->stored.head;
          if (batch.first != head.last_number + 1) return Error{ErrorCode::kInternal, "a gap", {}};
          for (const Bytes& record : batch.records) {
            document->stored.records.push_back(record);
            head.journal_size += record.size();
            ++head.last_number;
          }
          head.head = batch.head;
          return {};
        },
        std::move(done));
  }
  void PutSnapshot(const StoreKey& key, Epoch epoch, StoreSnapshot snapshot, Done done) override {
    Do(
        [this, key, epoch, snapshot = std::move(snapshot)]() -> Status {
          PLIANT_ASSIGN_OR_RETURN(Document * document, Own(key, epoch));
          StoredHead& head = document->stored.head;
          if (snapshot.number <= head.snapshot_number || snapshot.number > head.last_number)
            return {};
          auto& records = document->stored.records;
          const auto covered = snapshot.number - head.snapshot_number;
          records.erase(records.begin(), records.begin() + covered);
          head.journal_size = 0;
          for (const Bytes& record : records) head.journal_size += record.size();
          head.snapshot_number = snapshot.number;
          head.snapshot_size = snapshot.bytes.size();
          document->stored.snapshot = snapshot.bytes;
          return {};
        },
        std::move(done));
  }
  void Delete(const StoreKey& key, Epoch epoch, Done done) override {
    Do(
        [this, key, epoch]() -> Status {
          PLIANT_ASSIGN_OR_RETURN(const Document* document, Own(key, epoch));
          static_cast<void>(document);
          documents_.erase(key);
          return {};
        },
        std::move(done));
  }
  Result<StoredDocument> Load(const StoreKey& key) override {
    const std::lock_guard lock(mutex_);
    const auto found = documents_.find(key);
    if (found == documents_.end()) return Missing();
    return found->second.stored;
  }
  Result<std::vector<StoredHead>> List(DocumentKind kind) override {
    const std::lock_guard lock(mutex_);
    std::map<std::int64_t, StoredHead> heads;
    for (const auto& [key, document] : documents_) {
      if (key.kind == kind) heads[document.order] = document.stored.head;
    }
    std::vector<StoredHead> list;
    for (auto& [order, head] : heads) list.push_back(std::move(head));
    return list;
  }

  /// From now on writes wait for Flush.
  void Hold() { held_ = true; }
  /// Carries out what waits; with an error, fails all of it instead.
  void Flush(const std::optional<Error>& error = {}) {
    held_ = false;
    std::vector<std::pair<std::function<Status()>, Done>> waiting;
    waiting.swap(waiting_);
    for (auto& [work, done] : waiting) done(error ? Status(*error) : Locked(work));
  }
  [[nodiscard]] std::size_t waiting_count() const { return waiting_.size(); }

 private:
  struct Document {
    std::int64_t order = 0;
    StoredDocument stored;
  };

  static Error Missing() { return {ErrorCode::kSessionNotFound, "nothing is stored", {}}; }
  Result<Document*> Own(const StoreKey& key, Epoch epoch) {
    const auto found = documents_.find(key);
    if (found == documents_.end()) return Missing();
    if (found->second.stored.head.epoch == epoch) return &found->second;
    return Error{ErrorCode::kSessionBusy, "another epoch", {}};
  }
  Status Locked(const std::function<Status()>& work) {
    const std::lock_guard lock(mutex_);
    return work();
  }
  void Do(std::function<Status()> work, Done done) {
    if (held_) {
      waiting_.emplace_back(std::move(work), std::move(done));
    } else {
      done(Locked(work));
    }
  }

  std::mutex mutex_;  // Guards documents_ and last_order_.
  std::map<StoreKey, Document> documents_;
  std::int64_t last_order_ = 0;
  bool held_ = false;
  std::vector<std::pair<std::function<Status()>, Done>> waiting_;
};

}  // namespace pliant::server
