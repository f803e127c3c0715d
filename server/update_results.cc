#include "server/update_results.h"

#include <algorithm>
#include <utility>

#include "core/base/check.h"

namespace pliant::server {

void UpdateResults::Add(const SessionEvent& event) {
  PLIANT_CHECK(event.update_id > last_update_id_, "update", event.update_id, "last",
               last_update_id_);
  last_update_id_ = event.update_id;
  Entry entry{.update_id = event.update_id, .revision = event.revision, .other = nullptr};
  if (const auto* accepted = std::get_if<AcceptedEvent>(&event.body)) {
    entry.staged_count = accepted->staged_count;
  } else {
    entry.other = std::make_shared<const SessionEvent>(event);
  }
  entries_.push_back(std::move(entry));
  if (entries_.size() > count_max_) entries_.pop_front();
}

SessionEvent UpdateResults::At(std::size_t index) const {
  const Entry& entry = entries_.at(index);
  if (entry.other != nullptr) return *entry.other;
  return {.update_id = entry.update_id,
          .revision = entry.revision,
          .body = AcceptedEvent{.staged_count = entry.staged_count}};
}

std::optional<SessionEvent> UpdateResults::Find(std::int64_t update_id) const {
  const auto found =
      std::lower_bound(entries_.begin(), entries_.end(), update_id,
                       [](const Entry& entry, std::int64_t id) { return entry.update_id < id; });
  if (found == entries_.end() || found->update_id != update_id) return std::nullopt;
  return At(static_cast<std::size_t>(found - entries_.begin()));
}

}  // namespace pliant::server
