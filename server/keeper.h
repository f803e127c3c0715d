#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/clock.h"
#include "server/log.h"
#include "server/saved_state.h"
#include "server/store/store.h"
#include "server/store_journal.h"

namespace pliant::server {

/// Keeps a server's sessions in its store: gives each its journal, and replaces journals that have
/// grown by snapshots, on a thread of its own: it makes the session again from what is stored,
/// beside the one that goes on, so that nobody waits for a snapshot.
///
/// *Threads*: all functions from any thread.
class Keeper {
 public:
  /// @param log  outlives it.
  Keeper(std::unique_ptr<Store> store, SessionMakers makers, const Log& log);
  /// Ends the thread, then writes what is queued.
  ~Keeper();

  [[nodiscard]] std::shared_ptr<Journal> JournalOf(const std::string& tenant,
                                                   const std::string& session_id);
  [[nodiscard]] Store& store() { return *store_; }

  /// What a session that is stored was when last nothing was staged, made from the store on the
  /// keeper's thread, one after the other: the session is not asked. What is not on disk yet is not
  /// in it.
  /// @param done  called on that thread. Errors: those of Store::Load and ReadMemory; kUnavailable
  /// at the end of the keeper.
  using Recalled = std::function<void(Result<SessionMemory>)>;
  void Recall(const std::string& tenant, const std::string& session_id, Recalled done);

 private:
  void Grown(const std::shared_ptr<StoreJournal>& journal);
  void Work();
  void Compact(StoreJournal& journal);
  [[nodiscard]] Result<SessionMemory> Load(const StoreKey& key);

  struct Request {
    StoreKey key;
    Recalled done;
  };

  const std::unique_ptr<Store> store_;
  const SessionMakers makers_;
  const Log& log_;

  std::mutex mutex_;  // Guards all below; a leaf lock.
  std::condition_variable wake_;
  std::deque<std::shared_ptr<StoreJournal>> grown_;
  std::deque<Request> recalls_;  // Bounded by the calls that want them.
  bool stopping_ = false;
  std::thread thread_;
};

/// A session as it was when last nothing was staged; kRevisionNotFound before the first commit.
[[nodiscard]] Result<SessionMemory> ReadUnstaged(const Journal::Contents& contents,
                                                 const SessionMakers& makers);

/// Makes the snapshot of what a journal holds up to its last commit; none if there is none.
[[nodiscard]] Result<std::optional<StoreJournal::Compacted>> CompactSession(
    const Journal::Contents& contents, const SessionMakers& makers);

}  // namespace pliant::server
