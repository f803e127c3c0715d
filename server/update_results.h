#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "server/session_messages.h"

namespace pliant::server {

/// The answers to the last numbered updates of a session, so that one that is sent again is
/// answered again and not applied again. Diffs are not kept: a client that lost one gets it, or a
/// snapshot, when it opens its stream again.
///
/// *Invariants*: at most `count_max` answers, their ids ascending. An accepted update, the most
/// frequent answer by far, costs 40 bytes; a thousand of them are kept for each session.
/// *Threads*: one caller at a time.
class UpdateResults {
 public:
  explicit UpdateResults(std::size_t count_max) : count_max_(count_max) {}

  /// Greatest id that was ever added; 0 before.
  [[nodiscard]] std::int64_t last_update_id() const { return last_update_id_; }

  /// Remembers an answer; forgets the oldest beyond the bound.
  /// @pre event.update_id > last_update_id()
  void Add(const SessionEvent& event);

  /// How many are remembered.
  [[nodiscard]] std::size_t count() const { return entries_.size(); }
  /// One of them, oldest first. @pre index < count()
  [[nodiscard]] SessionEvent At(std::size_t index) const;

  /// The answer to an update; nothing if it is forgotten or never was.
  [[nodiscard]] std::optional<SessionEvent> Find(std::int64_t update_id) const;

 private:
  struct Entry {
    std::int64_t update_id = 0;
    Revision revision = Revision::kNone;
    std::int32_t staged_count = 0;              // Of an accepted update...
    std::shared_ptr<const SessionEvent> other;  // ...or any other answer.
  };

  std::size_t count_max_;
  std::deque<Entry> entries_;
  std::int64_t last_update_id_ = 0;
};

}  // namespace pliant::server
