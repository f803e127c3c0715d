#include "server/keeper.h"

#include <exception>
#include <span>
#include <utility>

namespace pliant::server {
namespace {

Error Ending() { return {ErrorCode::kUnavailable, "the server shuts down; try again later", {}}; }

}  // namespace

Keeper::Keeper(std::unique_ptr<Store> store, SessionMakers makers, const Log& log)
    : store_(std::move(store)),
      makers_(std::move(makers)),
      log_(log),
      thread_([this] { Work(); }) {}

Keeper::~Keeper() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

std::shared_ptr<Journal> Keeper::JournalOf(const std::string& tenant,
                                           const std::string& session_id) {
  return std::make_shared<StoreJournal>(
      *store_, StoreKey{DocumentKind::kSession, tenant, session_id},
      [this](const std::shared_ptr<StoreJournal>& journal) { Grown(journal); });
}

// A journal is in the queue once at most, so sessions bound it.
void Keeper::Grown(const std::shared_ptr<StoreJournal>& journal) {
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    grown_.push_back(journal);
  }
  wake_.notify_all();
}

void Keeper::Recall(const std::string& tenant, const std::string& session_id, Recalled done) {
  {
    const std::lock_guard lock(mutex_);
    if (!stopping_) {
      recalls_.push_back({{DocumentKind::kSession, tenant, session_id}, std::move(done)});
      wake_.notify_all();
      return;
    }
  }
  done(Ending());
}

// Somebody waits for a recall, nobody for a snapshot.
void Keeper::Work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return stopping_ || !grown_.empty() || !recalls_.empty(); });
    if (stopping_) break;
    if (!recalls_.empty()) {
      const Request request = std::move(recalls_.front());
      recalls_.pop_front();
      lock.unlock();
      request.done(Load(request.key));
    } else {
      const std::shared_ptr<StoreJournal> journal = std::move(grown_.front());
      grown_.pop_front();
      lock.unlock();
      Compact(*journal);
    }
    lock.lock();
  }
  const std::deque<Request> left = std::move(recalls_);
  lock.unlock();
  for (const Request& request : left) request.done(Ending());
}

void Keeper::Compact(StoreJournal& journal) {
  Status status;
  try {
    status = journal.Compact(
        [this](const Journal::Contents& contents) { return CompactSession(contents, makers_); });
  } catch (const std::exception& exception) {
    // Of this session the journal stays as it is, which is all that it needs.
    status = Error{ErrorCode::kInternal, exception.what(), {}};
  }
  if (!status.ok()) {
    log_.Error("compact_failed",
               {{"session", journal.key().name}, {"what", status.error().message}});
  }
}

Result<SessionMemory> Keeper::Load(const StoreKey& key) {
  try {
    PLIANT_ASSIGN_OR_RETURN(StoredDocument document, store_->Load(key));
    return ReadUnstaged({std::move(document.snapshot), std::move(document.records)}, makers_);
  } catch (const std::exception& exception) {
    log_.Error("bug", {{"session", key.name}, {"what", exception.what()}});
    return Error{ErrorCode::kInternal,
                 "a bug of the server was met while it loaded session " + key.name, key.name};
  }
}

Result<SessionMemory> ReadUnstaged(const Journal::Contents& contents, const SessionMakers& makers) {
  PLIANT_ASSIGN_OR_RETURN(const std::size_t count, CountUnstaged(contents.records));
  PLIANT_ASSIGN_OR_RETURN(
      SessionMemory memory,
      ReadMemory(contents.snapshot, std::span(contents.records).first(count), makers));
  if (memory.revision == Revision::kNone) {
    return Error{ErrorCode::kRevisionNotFound, "the session has no revision yet: advance it first",
                 "revision"};
  }
  return memory;
}

Result<std::optional<StoreJournal::Compacted>> CompactSession(const Journal::Contents& contents,
                                                              const SessionMakers& makers) {
  using Compacted = StoreJournal::Compacted;
  PLIANT_ASSIGN_OR_RETURN(const std::size_t count, CountSettled(contents.records));
  if (count == 0) return std::optional<Compacted>();
  PLIANT_ASSIGN_OR_RETURN(
      const SessionMemory memory,
      ReadMemory(contents.snapshot, std::span(contents.records).first(count), makers));
  PLIANT_ASSIGN_OR_RETURN(Bytes snapshot, WriteMemory(memory));
  return std::optional(Compacted{std::move(snapshot), count});
}

}  // namespace pliant::server
