#include "server/update_results.h"

#include <algorithm>

#include "core/base/check.h"

namespace pliant::server {

void UpdateResults::Add(const SessionEvent& event) {
  PLIANT_CHECK(event.update_id > last_update_id_, "update", event.update_id, "last",
               last_update_id_);
  last_update_id_ = event.update_id;
  events_.push_back(event);
  if (events_.size() > count_max_) events_.pop_front();
}

std::optional<SessionEvent> UpdateResults::Find(std::int64_t update_id) const {
  const auto found = std::lower_bound(
      events_.begin(), events_.end(), update_id,
      [](const SessionEvent& event, std::int64_t id) { return event.update_id < id; });
  if (found == events_.end() || found->update_id != update_id) return std::nullopt;
  return *found;
}

}  // namespace pliant::server
