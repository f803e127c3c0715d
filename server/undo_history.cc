#include "server/undo_history.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "core/base/check.h"
#include "server/revision_text.h"

namespace pliant::server {

void UndoHistory::Add(UndoStep undo) {
  PLIANT_CHECK(steps_.empty() || steps_.back().delta.base == undo.delta.revision, "undo to",
               static_cast<std::int64_t>(undo.delta.revision));
  bytes_ += undo.delta.bytes();
  steps_.push_back(std::move(undo));
  Shrink();
}

void UndoHistory::Clear() {
  steps_.clear();
  saved_.clear();
  bytes_ = 0;
}

void UndoHistory::KeepSavedOnly() {
  const std::size_t bytes_max = std::exchange(bounds_.bytes_max, 0);
  Shrink();
  bounds_.bytes_max = bytes_max;
}

// Oldest first: before the oldest saved revision deltas go, after it they are merged.
void UndoHistory::Shrink() {
  while (bytes_ > bounds_.bytes_max && !steps_.empty()) {
    const bool is_needed = !saved_.empty() && *saved_.begin() <= steps_.front().delta.revision;
    if (is_needed) {
      if (!MergeOnePair()) return;
      continue;
    }
    bytes_ -= steps_.front().delta.bytes();
    steps_.pop_front();
  }
}

// Merges the oldest two steps that meet at a revision that nobody has saved.
bool UndoHistory::MergeOnePair() {
  for (std::size_t i = 0; i + 1 < steps_.size(); ++i) {
    RevisionDelta& older = steps_[i].delta;
    const RevisionDelta& newer = steps_[i + 1].delta;
    if (saved_.contains(older.base)) continue;
    const std::array<const RevisionDelta*, 2> pair = {&newer, &older};
    RevisionDelta merged = Merge(pair);
    bytes_ -= older.bytes() + newer.bytes();
    bytes_ += merged.bytes();
    older = std::move(merged);
    steps_.erase(steps_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    return true;
  }
  return false;
}

bool UndoHistory::Restore(std::deque<UndoStep> steps, const std::vector<std::int64_t>& saved,
                          Revision newest) {
  Clear();
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Revision next = i + 1 < steps.size() ? steps[i + 1].delta.revision : newest;
    if (steps[i].delta.base != next) return false;
    bytes_ += steps[i].delta.bytes();
  }
  steps_ = std::move(steps);
  for (const std::int64_t revision : saved) {
    if (!Save(Revision(revision), newest).ok()) return false;
  }
  return true;
}

Revision UndoHistory::Oldest(Revision newest) const {
  return steps_.empty() ? newest : steps_.front().delta.revision;
}

bool UndoHistory::Reaches(Revision revision, Revision newest) const {
  return revision == newest || std::any_of(steps_.begin(), steps_.end(), [=](const UndoStep& step) {
           return step.delta.revision == revision;
         });
}

Result<UndoStep> UndoHistory::WayTo(Revision revision, Revision newest) const {
  std::vector<const RevisionDelta*> way;
  for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
    way.push_back(&step->delta);
    if (step->delta.revision == revision) {
      return UndoStep{Merge(way), step->spec, step->active_count};
    }
  }
  if (revision == newest) {
    return Error{ErrorCode::kRevisionNotFound,
                 "the session is at revision " + RevisionText(revision) +
                     " already; expected an earlier one, from " + RevisionText(Oldest(newest)) +
                     " on; to throw away what is staged, send discard",
                 "to_revision"};
  }
  return Error{ErrorCode::kRevisionNotFound,
               "revision " + RevisionText(revision) + " is not kept; the session is at " +
                   RevisionText(newest) + " and the oldest that it can go back to is " +
                   RevisionText(Oldest(newest)),
               "to_revision"};
}

Status UndoHistory::Save(Revision revision, Revision newest) {
  if (!Reaches(revision, newest)) {
    return Error{ErrorCode::kRevisionNotFound,
                 "revision " + RevisionText(revision) + " is not kept; the oldest that is, is " +
                     RevisionText(Oldest(newest)),
                 "revision"};
  }
  if (!saved_.contains(revision) && saved_.size() >= bounds_.saved_max) {
    return Error{ErrorCode::kResourceExhausted,
                 "the session has " + std::to_string(bounds_.saved_max) +
                     " saved revisions already: release one, such as revision " +
                     RevisionText(*saved_.begin()) + "; waiting frees none",
                 "revision"};
  }
  saved_.insert(revision);
  return {};
}

Status UndoHistory::Release(const std::vector<std::int64_t>& revisions) {
  for (std::size_t i = 0; i < revisions.size(); ++i) {
    if (saved_.contains(Revision(revisions[i]))) continue;
    return Error{ErrorCode::kRevisionNotFound,
                 "revision " + std::to_string(revisions[i]) + " is not saved", "revisions",
                 static_cast<std::int64_t>(i)};
  }
  for (const std::int64_t revision : revisions) saved_.erase(Revision(revision));
  Shrink();
  return {};
}

std::vector<std::int64_t> UndoHistory::saved() const {
  std::vector<std::int64_t> revisions;
  for (const Revision revision : saved_) revisions.push_back(static_cast<std::int64_t>(revision));
  return revisions;
}

}  // namespace pliant::server
