#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "server/journal.h"
#include "server/record.h"

namespace pliant::server {

/// A session's side of its journal: gathers records, and keeps answers back until what they tell is
/// durable.
///
/// Records of one slice are written together. With strict durability a session that has committed
/// waits for its disk before it does anything else, so that nobody ever sees what a crash could
/// undo; others have the worker meanwhile. Relaxed durability holds nothing back, but also waits
/// when too much is on its way.
///
/// *Threads*: one caller at a time; what `make_wake` makes is called from any thread, perhaps after
/// the session's end.
class SessionJournal {
 public:
  SessionJournal(std::shared_ptr<Journal> journal, Durability durability,
                 std::function<std::function<void()>()> make_wake);

  /// Begins the journal; then as a batch.
  void Create(Bytes head, Bytes snapshot);
  void Add(const Record& record);
  /// As Add, of a revision that others may not see before it is durable.
  void AddCommit(const CommitRecord& record);
  /// Does something when all that was added is durable, or fails; at once if nothing has to wait.
  void Hold(std::function<void(const Status&)> action);
  /// The same whatever the durability: what is added meanwhile by Hold waits with it.
  void HoldUntilStored(std::function<void(const Status&)> action);
  /// Writes what was added. @param head  made only if there is something
  void Submit(const std::function<Bytes()>& head);

  /// Learns what has become of what was submitted. An error, once, when a write has failed and none
  /// is on its way any more: what was added since the last durable batch is lost.
  [[nodiscard]] std::optional<Error> Settle();
  /// The session was loaded: this revision is durable.
  void SetDurable(Revision revision);
  /// The session ends: what is held fails.
  void Drop(const Error& error);
  /// Does what was held for batches that are durable. @pre Settle gave no error
  void Release();
  /// Does what was held for batches that are durable by now; for a session in the middle of
  /// something, which leaves it to Settle to learn of a write that failed.
  void ReleaseDone();

  /// The session must not go on before it is woken.
  [[nodiscard]] bool waits() const;
  /// Nothing was added or held that is not done.
  [[nodiscard]] bool is_clean() const;
  /// Greatest revision that is durable.
  [[nodiscard]] Revision durable_revision() const;
  [[nodiscard]] Durability durability() const { return durability_; }
  [[nodiscard]] Journal& journal() { return *journal_; }

 private:
  struct Held {
    std::int64_t batch = 0;
    std::function<void(const Status&)> action;
  };
  // What the thread that writes tells.
  struct Progress {
    std::mutex mutex;  // Guards all below; a leaf lock.
    std::int64_t batches_done = 0;
    std::size_t bytes_done = 0;
    Revision revision = Revision::kNone;
    std::optional<Error> error;
  };
  Journal::Done DoneOf(std::size_t bytes, Revision revision);
  [[nodiscard]] std::int64_t batch() const {
    return records_.empty() ? submitted_ : submitted_ + 1;
  }

  const std::shared_ptr<Journal> journal_;
  const Durability durability_;
  const std::function<std::function<void()>()> make_wake_;
  const std::shared_ptr<Progress> progress_ = std::make_shared<Progress>();

  std::vector<Bytes> records_;  // Not submitted.
  std::size_t bytes_ = 0;       // Of them.
  Revision revision_ = Revision::kNone;
  std::deque<Held> held_;
  std::int64_t submitted_ = 0;     // Batches.
  std::int64_t commit_batch_ = 0;  // The last one with a commit.
  std::size_t bytes_submitted_ = 0;
  std::int64_t done_ = 0;  // As of the last Settle, batches...
  std::size_t bytes_done_ = 0;
  bool failed_ = false;  // ...of which one failed.
};

}  // namespace pliant::server
