#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>

#include "core/base/result.h"
#include "server/session_messages.h"

namespace pliant::server {

/// The answers to the last numbered updates of a session, so that one that is sent again is
/// answered again and not applied again, and another one under its number is refused. Diffs are not
/// kept: a client that lost one gets it, or a snapshot, when it opens its stream again.
///
/// *Invariants*: at most `count_max` answers, their ids ascending. An accepted update, the most
/// frequent answer by far, costs 48 bytes; a thousand of them are kept for each session.
/// *Threads*: one caller at a time.
class UpdateResults {
 public:
  explicit UpdateResults(std::size_t count_max) : count_max_(count_max) {}

  /// Greatest id that was ever added; 0 before.
  [[nodiscard]] std::int64_t last_update_id() const { return last_update_id_; }

  /// Whether a new number leaves enough of them to come after it: at least half of those that are
  /// left before it, up to kUpdateIdMax. Error: kOutOfRange.
  /// @pre update_id > last_update_id()
  [[nodiscard]] Status CheckNew(std::int64_t update_id) const;

  /// Remembers an answer; forgets the oldest beyond the bound.
  /// @pre answer.event.update_id > last_update_id()
  void Add(const UpdateAnswer& answer);

  /// How many are remembered.
  [[nodiscard]] std::size_t count() const { return entries_.size(); }
  /// One of them, oldest first. @pre index < count()
  [[nodiscard]] UpdateAnswer At(std::size_t index) const;

  /// The first answer to an update that comes again. An answer that was stored without a
  /// fingerprint is that of any update that could have been answered so.
  /// Errors: kProtocolOrder if it is forgotten or never was, or answers another update; that of
  /// CheckNew.
  /// @pre update_id <= last_update_id(), or CheckNew refuses it
  [[nodiscard]] Result<SessionEvent> Repeat(std::int64_t update_id,
                                            const Fingerprint& update) const;

 private:
  struct Entry {
    std::int64_t update_id = 0;
    Revision revision = Revision::kNone;
    std::uint64_t hash = 0;         // Of the update.
    std::int32_t staged_count = 0;  // Of an accepted update...
    UpdateKind kind = UpdateKind::kUnknown;
    std::shared_ptr<const SessionEvent> other;  // ...or any other answer.
  };

  std::size_t count_max_;
  std::deque<Entry> entries_;
  std::int64_t last_update_id_ = 0;
};

}  // namespace pliant::server
