#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "server/session_messages.h"

namespace pliant::server {

/// The answers to the last numbered updates of a session, so that one that is sent again is
/// answered again and not applied again. Diffs are not kept: a client that lost one gets it, or a
/// snapshot, when it opens its stream again.
///
/// *Invariants*: at most `count_max` answers, their ids ascending.
/// *Threads*: one caller at a time.
class UpdateResults {
 public:
  explicit UpdateResults(std::size_t count_max) : count_max_(count_max) {}

  /// Greatest id that was ever added; 0 before.
  [[nodiscard]] std::int64_t last_update_id() const { return last_update_id_; }

  /// Remembers an answer; forgets the oldest beyond the bound.
  /// @pre event.update_id > last_update_id()
  void Add(const SessionEvent& event);

  /// All of them, by id.
  [[nodiscard]] const std::deque<SessionEvent>& events() const { return events_; }

  /// The answer to an update; nothing if it is forgotten or never was.
  [[nodiscard]] std::optional<SessionEvent> Find(std::int64_t update_id) const;

 private:
  std::size_t count_max_;
  std::deque<SessionEvent> events_;
  std::int64_t last_update_id_ = 0;
};

}  // namespace pliant::server
