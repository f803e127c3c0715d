#include "server/update_results.h"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "core/base/check.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

const char* NameOf(UpdateKind kind) {
  switch (kind) {
    case UpdateKind::kUnknown:
      return "of another kind";
    case UpdateKind::kMetric:
      return "a metric";
    case UpdateKind::kBoundary:
      return "a motion of boundaries";
    case UpdateKind::kNodes:
      return "a motion of vertices";
    case UpdateKind::kDomain:
      return "a domain";
    case UpdateKind::kFields:
      return "values of fields";
    case UpdateKind::kConstraints:
      return "constraints";
    case UpdateKind::kOptions:
      return "options";
    case UpdateKind::kRollback:
      return "a rollback";
    case UpdateKind::kDiscard:
      return "a discard";
    case UpdateKind::kAdvance:
      return "an advance";
  }
  return "of another kind";
}

bool MayAnswer(const UpdateAnswer& answer, const Fingerprint& update) {
  const Fingerprint& first = answer.update;
  if (update.kind == UpdateKind::kUnknown) return true;
  if (first.kind != UpdateKind::kUnknown) {
    return first.kind == update.kind &&
           (first.hash == update.hash || first.hash == 0 || update.hash == 0);
  }
  return CanAnswer(answer.event, update.kind);
}

}  // namespace

Status UpdateResults::CheckNew(std::int64_t update_id) const {
  const std::int64_t left = kUpdateIdMax - last_update_id_;
  const std::int64_t greatest = last_update_id_ + std::max<std::int64_t>(1, left / 2);
  if (update_id <= greatest) return {};
  return Error{ErrorCode::kOutOfRange,
               "update_id is " + std::to_string(update_id) + "; after " +
                   std::to_string(last_update_id_) + ", numbers up to " + std::to_string(greatest) +
                   " are allowed, so that enough are left to come after them: take the session's "
                   "last_update_id + 1",
               "update_id"};
}

void UpdateResults::Add(const UpdateAnswer& answer) {
  const SessionEvent& event = answer.event;
  PLIANT_CHECK(event.update_id > last_update_id_, "update", event.update_id, "last",
               last_update_id_);
  last_update_id_ = event.update_id;
  Entry entry{.update_id = event.update_id,
              .revision = event.revision,
              .hash = answer.update.hash,
              .kind = answer.update.kind,
              .other = nullptr};
  if (const auto* accepted = std::get_if<AcceptedEvent>(&event.body)) {
    entry.staged_count = accepted->staged_count;
  } else {
    entry.other = std::make_shared<const SessionEvent>(event);
  }
  entries_.push_back(std::move(entry));
  if (entries_.size() > count_max_) entries_.pop_front();
}

UpdateAnswer UpdateResults::At(std::size_t index) const {
  const Entry& entry = entries_.at(index);
  const Fingerprint update{.kind = entry.kind, .hash = entry.hash};
  if (entry.other != nullptr) return {.event = *entry.other, .update = update};
  return {.event = {.update_id = entry.update_id,
                    .revision = entry.revision,
                    .body = AcceptedEvent{.staged_count = entry.staged_count}},
          .update = update};
}

Result<SessionEvent> UpdateResults::Repeat(std::int64_t update_id,
                                           const Fingerprint& update) const {
  if (update_id > last_update_id_) return CheckNew(update_id).error();
  const auto found =
      std::lower_bound(entries_.begin(), entries_.end(), update_id,
                       [](const Entry& entry, std::int64_t id) { return entry.update_id < id; });
  if (found == entries_.end() || found->update_id != update_id) {
    return Error{ErrorCode::kProtocolOrder,
                 "update_id " + std::to_string(update_id) + " is neither new (the last was " +
                     std::to_string(last_update_id_) + ") nor among the last " +
                     std::to_string(count_max_) +
                     " updates: take the session's last_update_id + 1; another client or a "
                     "RollbackTo may have used numbers meanwhile",
                 "update_id"};
  }
  UpdateAnswer first = At(static_cast<std::size_t>(found - entries_.begin()));
  if (MayAnswer(first, update)) return std::move(first.event);
  return Error{ErrorCode::kProtocolOrder,
               "update_id " + std::to_string(update_id) + " was used by another update (" +
                   NameOf(first.update.kind) +
                   "), perhaps of another client or a RollbackTo, and nothing was applied: take "
                   "the session's last_update_id + 1, now " +
                   std::to_string(last_update_id_ + 1),
               "update_id"};
}

}  // namespace pliant::server
