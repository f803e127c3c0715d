#include "server/followers.h"

#include <algorithm>
#include <map>
#include <utility>

#include "server/limits.h"

namespace pliant::server {

Status Followers::Add(std::shared_ptr<Subscriber> subscriber, Revision revision) {
  auto entry = std::make_shared<Entry>();
  entry->subscriber = std::move(subscriber);
  entry->revision = revision;
  const std::lock_guard lock(mutex_);
  if (entries_.size() >= count_max_) {
    return Error{.code = ErrorCode::kResourceExhausted,
                 .message = "the session has its " + std::to_string(count_max_) +
                            " subscribers already; try again later",
                 .retry_after_ms = kSessionRetryMs};
  }
  entries_.push_back(std::move(entry));
  return {};
}

void Followers::Remove(const Subscriber* subscriber) {
  const std::lock_guard lock(mutex_);
  std::erase_if(entries_, [&](const auto& entry) { return entry->subscriber.get() == subscriber; });
}

bool Followers::AnyWaits(Revision revision) const {
  for (const std::shared_ptr<Entry>& entry : Entries()) {
    const bool is_behind = revision != Revision::kNone && entry->revision != revision;
    if ((is_behind || entry->is_new) && entry->subscriber->ready()) return true;
  }
  return false;
}

std::size_t Followers::count() const {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

bool Followers::AnyWantsTransfer() const {
  const std::lock_guard lock(mutex_);
  return std::any_of(entries_.begin(), entries_.end(),
                     [](const auto& entry) { return entry->subscriber->wants_transfer(); });
}

std::vector<std::shared_ptr<Followers::Entry>> Followers::Entries() const {
  const std::lock_guard lock(mutex_);
  return entries_;
}

bool Followers::Serve(const Source& source, const Clock& clock, Clock::Time end) {
  // Subscribers that stand at the same revision share what they get.
  std::map<Revision, std::shared_ptr<const MeshDiff>> diffs;
  std::shared_ptr<const MeshDiff> snapshot;
  const std::vector<std::shared_ptr<Entry>> entries = Entries();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    // The next slice goes on after the last one served, so that nobody is always last.
    const std::shared_ptr<Entry>& entry = entries[(first_ + i) % entries.size()];
    const bool is_behind = source.revision != Revision::kNone && entry->revision != source.revision;
    if ((!is_behind && !entry->is_new) || !entry->subscriber->ready()) continue;
    SessionEvent event{.update_id = 0, .revision = source.revision, .body = BookmarkEvent{}};
    if (is_behind && entry->subscriber->wants_mesh()) {
      std::shared_ptr<const MeshDiff> diff;
      // Who comes with nothing gets the mesh as it is, not its whole history.
      if (!entry->is_new || entry->revision != Revision::kNone) {
        const auto [found, is_first] = diffs.try_emplace(entry->revision);
        if (is_first) found->second = source.history->Since(entry->revision);
        diff = found->second;
      }
      if (diff != nullptr && entry->subscriber->Follows(*diff)) {
        event.body = DiffEvent{diff, source.applied_update_id};
      } else {
        if (snapshot == nullptr) snapshot = source.snapshot();
        event.body = SnapshotEvent{snapshot, source.applied_update_id};
      }
    }
    entry->revision = source.revision;
    entry->is_new = false;
    entry->subscriber->Send(std::move(event));
    if (clock.Now() >= end) {
      first_ = (first_ + i + 1) % entries.size();
      return false;
    }
  }
  return true;
}

void Followers::CloseAll(const Error& error) {
  std::vector<std::shared_ptr<Entry>> entries;
  {
    const std::lock_guard lock(mutex_);
    entries.swap(entries_);
  }
  for (const std::shared_ptr<Entry>& entry : entries) entry->subscriber->Close(error);
}

}  // namespace pliant::server
