#include "server/session_journal.h"

#include "server/limits.h"

namespace pliant::server {

SessionJournal::SessionJournal(std::shared_ptr<Journal> journal, Durability durability,
                               std::function<std::function<void()>()> make_wake)
    : journal_(std::move(journal)), durability_(durability), make_wake_(std::move(make_wake)) {}

void SessionJournal::Create(Bytes head, Bytes snapshot) {
  const std::size_t bytes = snapshot.size();
  ++submitted_;
  bytes_submitted_ += bytes;
  journal_->Create(std::move(head), std::move(snapshot), DoneOf(bytes, revision_));
}

void SessionJournal::Add(const Record& record) {
  records_.push_back(WriteRecord(record));
  bytes_ += records_.back().size();
}

void SessionJournal::AddCommit(const CommitRecord& record) {
  Add(record);
  revision_ = record.revision;
  commit_batch_ = batch();
}

void SessionJournal::Hold(std::function<void(const Status&)> action) {
  const bool must_wait = durability_ == Durability::kStrict && batch() > done_;
  if (!must_wait && held_.empty()) {
    action({});
  } else {
    held_.push_back({batch(), std::move(action)});
  }
}

void SessionJournal::HoldUntilStored(std::function<void(const Status&)> action) {
  if (batch() <= done_ && held_.empty()) {
    action({});
  } else {
    held_.push_back({batch(), std::move(action)});
  }
}

void SessionJournal::Submit(const std::function<Bytes()>& head) {
  if (records_.empty() || failed_) return;
  const std::size_t bytes = std::exchange(bytes_, 0);
  ++submitted_;
  bytes_submitted_ += bytes;
  journal_->Append(std::exchange(records_, {}), head(), DoneOf(bytes, revision_));
}

// Outlives the session: the writer may be the last to know.
Journal::Done SessionJournal::DoneOf(std::size_t bytes, Revision revision) {
  return [progress = progress_, wake = make_wake_(), bytes, revision](const Status& status) {
    {
      const std::lock_guard lock(progress->mutex);
      ++progress->batches_done;
      progress->bytes_done += bytes;
      if (!status.ok()) {
        if (!progress->error) progress->error = status.error();
      } else if (!progress->error) {
        progress->revision = revision;
      }
    }
    wake();
  };
}

std::optional<Error> SessionJournal::Settle() {
  std::optional<Error> error;
  {
    const std::lock_guard lock(progress_->mutex);
    error = progress_->error;
    failed_ = error.has_value();
    bytes_done_ = progress_->bytes_done;
    if (!failed_) done_ = progress_->batches_done;
    if (!failed_ || progress_->batches_done < submitted_) return std::nullopt;
    progress_->error.reset();
    done_ = progress_->batches_done;
  }
  failed_ = false;
  records_.clear();
  bytes_ = 0;
  commit_batch_ = 0;
  Drop(*error);
  return error;
}

void SessionJournal::Drop(const Error& error) {
  records_.clear();
  bytes_ = 0;
  std::deque<Held> lost;
  lost.swap(held_);
  for (Held& held : lost) held.action(error);
}

void SessionJournal::SetDurable(Revision revision) {
  revision_ = revision;
  const std::lock_guard lock(progress_->mutex);
  progress_->revision = revision;
}

void SessionJournal::Release() {
  while (!held_.empty() && held_.front().batch <= done_) {
    const Held held = std::move(held_.front());
    held_.pop_front();
    held.action({});
  }
}

void SessionJournal::ReleaseDone() {
  if (held_.empty()) return;
  {
    const std::lock_guard lock(progress_->mutex);
    if (progress_->error || failed_) return;
    done_ = progress_->batches_done;
    bytes_done_ = progress_->bytes_done;
  }
  Release();
}

bool SessionJournal::waits() const {
  if (failed_) return true;
  if (durability_ == Durability::kStrict) return commit_batch_ > done_;
  return bytes_submitted_ + bytes_ - bytes_done_ > kJournalPendingBytesMax;
}

bool SessionJournal::is_clean() const {
  return records_.empty() && held_.empty() && submitted_ == done_ && !failed_;
}

Revision SessionJournal::durable_revision() const {
  const std::lock_guard lock(progress_->mutex);
  return progress_->revision;
}

}  // namespace pliant::server
