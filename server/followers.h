#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/clock.h"
#include "server/diff_history.h"
#include "server/session_messages.h"

namespace pliant::server {

/// The other end of a Subscribe call.
///
/// *Threads*: all functions from any thread; none calls back into the session.
class Subscriber {
 public:
  virtual ~Subscriber() = default;
  /// Nothing is under way to it: it can take one message more. Whoever makes this true wakes the
  /// session.
  [[nodiscard]] virtual bool ready() const = 0;
  /// Wants transfer rows with the diffs, from beginning to end.
  [[nodiscard]] virtual bool wants_transfer() const { return false; }
  /// Wants meshes and diffs; else it gets a BookmarkEvent for every revision.
  [[nodiscard]] virtual bool wants_mesh() const { return true; }
  /// Can be brought up to date with this diff, which is sent next if so; else it gets a snapshot.
  [[nodiscard]] virtual bool Follows(const MeshDiff& diff) {
    static_cast<void>(diff);
    return true;
  }
  /// Takes a message: DiffEvent, SnapshotEvent or BookmarkEvent. Only while ready.
  virtual void Send(SessionEvent event) = 0;
  /// Ends the call with this error, after a closing event.
  virtual void Close(const Error& error) = 0;
};

/// The subscribers of one session and the revision that each has. One that is ready and behind gets
/// one diff from its revision to the newest, or a snapshot where the history does not reach back.
/// One that is not ready costs nothing but its entry: what it misses is merged when it comes back.
///
/// *Invariants*: at most one message is on its way to a subscriber; at most `count_max` entries.
/// *Threads*: Add and Remove from any thread; Serve and CloseAll from one at a time.
class Followers {
 public:
  explicit Followers(std::size_t count_max) : count_max_(count_max) {}

  /// @param revision  that the subscriber has. Error: kResourceExhausted.
  Status Add(std::shared_ptr<Subscriber> subscriber, Revision revision);
  void Remove(const Subscriber* subscriber);
  /// Somebody is ready and does not have this revision, or has had no answer yet.
  [[nodiscard]] bool AnyWaits(Revision revision) const;
  [[nodiscard]] std::size_t count() const;
  [[nodiscard]] bool AnyWantsTransfer() const;

  /// Where the session is. The snapshot is made only if somebody needs it.
  struct Source {
    Revision revision = Revision::kNone;
    std::int64_t applied_update_id = 0;
    const DiffHistory* history = nullptr;
    std::function<std::shared_ptr<const MeshDiff>()> snapshot;
  };
  /// Serves those who are ready and behind, or new, until all are or the time is over.
  /// @return true if nobody is left that could be served now.
  bool Serve(const Source& source, const Clock& clock, Clock::Time end);

  /// Ends all calls.
  void CloseAll(const Error& error);

 private:
  struct Entry {
    std::shared_ptr<Subscriber> subscriber;
    Revision revision = Revision::kNone;
    bool is_new = true;  // Has not had its first message.
  };
  [[nodiscard]] std::vector<std::shared_ptr<Entry>> Entries() const;

  const std::size_t count_max_;
  mutable std::mutex mutex_;                     // Guards entries_, not what they point at.
  std::vector<std::shared_ptr<Entry>> entries_;  // The contents belong to Serve.
  std::size_t first_ = 0;                        // Who is served first; used by Serve alone.
};

}  // namespace pliant::server
