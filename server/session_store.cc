// How a session is kept: what it writes, when it leaves memory and how it comes back; see
// session.h.
#include <string>
#include <utility>

#include "core/base/check.h"
#include "server/revision_text.h"
#include "server/session.h"

namespace pliant::server {

Session::Session(Environment environment, SessionInfo stored)
    : Session(std::move(environment), stored.session_id, std::move(stored.labels)) {
  asleep_ = true;
  revision_ = stored.revision;
  summary_ = stored.summary;
  commit_time_ = stored.commit_time;
  active_count_ = stored.active_count;
  history_bytes_asked_ = stored.history_bytes_max;
  const std::lock_guard lock(mutex_);
  info_.revision = stored.revision;
  info_.summary = stored.summary;
  info_.active_count = stored.active_count;
  info_.last_update_id = stored.last_update_id;
  info_.saved_revisions = std::move(stored.saved_revisions);
  info_.create_time = stored.create_time;
  info_.commit_time = stored.commit_time;
  info_.history_bytes_max = stored.history_bytes_max;
  info_.asleep = true;
}

void Session::RequestSleep() {
  sleep_wanted_ = true;
  Wake();
}

void Session::Delete(Error error, std::function<void(const Status&)> done) {
  {
    const std::lock_guard lock(mutex_);
    if (!close_error_) close_error_ = error;
    stop_work_.Set(true);
    if (delete_done_ == nullptr) delete_done_ = std::exchange(done, nullptr);
  }
  if (done == nullptr) {
    Wake();
  } else {
    done(std::move(error));  // Somebody else is deleting it.
  }
}

// At the end of a session: whoever wanted it deleted is told when nothing of it is stored.
void Session::DeleteStored() {
  std::function<void(const Status&)> done;
  {
    const std::lock_guard lock(mutex_);
    done = std::exchange(delete_done_, nullptr);
  }
  if (!done) return;
  if (environment_.journal == nullptr) {
    done({});
  } else {
    environment_.journal->Delete(std::move(done));
  }
}

// --- Writing ------------------------------------------------------------------------------------

void Session::RecordAnswer(const SessionEvent* answer, StageEffect effect, const Bytes& form) {
  if (journal_ == nullptr) return;
  AnswerRecord record{.answer = {}, .effect = effect, .update = form};
  if (answer != nullptr) record.answer = UpdateAnswer{*answer, update_};
  journal_->Add(record);
}

// A commit; what it follows is written when it is another than the journal's last.
void Session::RecordCommit(const MeshDiff& diff, const RevisionDelta* delta,
                           std::int64_t update_id) {
  if (journal_ == nullptr) return;
  commit_time_ = environment_.clock->WallNow();
  CommitRecord record{.revision = diff.revision,
                      .update_id = update_id,
                      .active_count = active_count_,
                      .time = *commit_time_,
                      .spec = {},
                      .change = {},
                      .transfer = diff.transfer,
                      .fields = diff.fields};
  if (engine_->committed_spec() != recorded_spec_ || delta == nullptr) {
    record.spec = recorded_spec_ = engine_->committed_spec();
  }
  Result<Bytes> bytes = delta != nullptr ? WriteDelta(*delta) : engine_->Save();
  // A session's metric always has a written form, and everything of it is committed here.
  PLIANT_CHECK(bytes.ok(), "record", bytes.ok() ? "" : bytes.error().message);
  if (delta != nullptr) {
    record.change.emplace<0>(std::move(bytes).value());
  } else {
    record.change.emplace<1>(std::move(bytes).value());
  }
  journal_->AddCommit(record);
}

void Session::RecordSaved() {
  if (journal_ != nullptr) journal_->Add(SavedRecord{undo_.saved()});
}

void Session::WhenDurable(std::function<void(const Status&)> action) {
  if (journal_ == nullptr) {
    action({});
  } else {
    journal_->Hold(std::move(action));
  }
}

void Session::WhenStored(std::function<void(const Status&)> action) {
  if (journal_ == nullptr) {
    action({});
  } else {
    journal_->HoldUntilStored(std::move(action));
  }
}

std::optional<Revision> Session::DurableRevision() const {
  if (journal_ == nullptr) return std::nullopt;
  // A strict session tells this only when the revision is durable.
  return journal_->durability() == Durability::kStrict ? revision_ : journal_->durable_revision();
}

Bytes Session::Head() const {
  StoredInfo stored{.info = info(), .durability = environment_.durability};
  stored.info.revision = revision_;
  stored.info.summary = summary_;
  stored.info.active_count = active_count_;
  stored.info.last_update_id = results_.last_update_id();
  stored.info.saved_revisions = undo_.saved();
  stored.info.commit_time = commit_time_;
  stored.info.history_bytes_max = history_bytes_asked_;
  return WriteInfo(stored);
}

void Session::Submit() {
  if (journal_ != nullptr) journal_->Submit([this] { return Head(); });
}

// Looks at what has become of what was written. False: there is nothing to do before the journal
// wakes the session.
bool Session::Settled() {
  if (journal_ == nullptr) return true;
  if (const std::optional<Error> error = journal_->Settle()) LoseMemory(*error);
  if (journal_->waits()) return false;
  if (memory_lost_) {
    journal_->Submit([this] { return Head(); });
    journal_->Release();
    if (!journal_->is_clean()) return false;
    Sleep();
  }
  PublishInfo();
  journal_->Release();
  return true;
}

// A write failed: what the session did since the last one that did not never happened.
void Session::LoseMemory(const Error& error) {
  environment_.log->Error("store", {{"session", session_id_}, {"what", error.message}});
  memory_lost_ = true;
  advance_.reset();
  put_off_.clear();
  EndCall(error);
  std::shared_ptr<Editor> editor;
  {
    const std::lock_guard lock(mutex_);
    running_update_id_ = 0;
    stop_work_.Set(false);
    editor = std::exchange(editor_, nullptr);
  }
  if (editor != nullptr) editor->Close(error);
}

// --- Beginning ----------------------------------------------------------------------------------

Status Session::BeginFrom(EngineInput input, const Bytes& form) {
  PLIANT_ASSIGN_OR_RETURN(engine_, StagedEngine::Create(std::move(input), environment_.factory));
  active_count_ = engine_->engine().vertex_count();
  PLIANT_RETURN_IF_ERROR(CheckRoom(Usage()));
  recorded_spec_ = engine_->committed_spec();
  if (journal_ != nullptr) journal_->Create(Head(), WriteInput(form));
  return {};
}

Status Session::BeginFrom(SessionMemory memory) {
  Bytes snapshot;
  if (journal_ != nullptr) {
    PLIANT_ASSIGN_OR_RETURN(snapshot, WriteMemory(memory));
  }
  Adopt(std::move(memory));
  PLIANT_RETURN_IF_ERROR(CheckRoom(Usage()));
  if (journal_ != nullptr) journal_->Create(Head(), std::move(snapshot));
  return {};
}

// --- Coming and going ---------------------------------------------------------------------------

bool Session::MaySleep() const {
  if (journal_ == nullptr || asleep_ || advance_ || !engine_ || !journal_->is_clean()) return false;
  const std::lock_guard lock(mutex_);
  return !close_error_ && !start_;
}

void Session::PublishRest() {
  const std::int64_t bytes = Usage().bytes;
  std::int64_t change = 0;
  {
    const std::lock_guard lock(mutex_);
    change = bytes - rest_.bytes;
    rest_ = {.last_used = environment_.clock->Now(),
             .bytes = bytes,
             .may_sleep = journal_ != nullptr && engine_.has_value() && !advance_};
  }
  // Outside the lock: it may wake who sends sessions to sleep.
  if (environment_.budget != nullptr && change != 0) environment_.budget->Add(change);
}

Session::Rest Session::rest() const {
  const std::lock_guard lock(mutex_);
  return rest_;
}

void Session::Sleep() {
  asleep_ = true;
  memory_lost_ = false;
  engine_.reset();
  history_ = DiffHistory(environment_.history_bytes_max);
  undo_.Clear();
  ReportUsage();
  PublishInfo();
}

// Loads the session if it sleeps.
Status Session::Need() {
  if (!asleep_) return {};
  Status status;
  try {
    status = Load();
  } catch (const std::exception& exception) {
    status =
        Error{ErrorCode::kInternal,
              "a bug of the server was met while it loaded session " + session_id_, session_id_};
    environment_.log->Error("bug", {{"session", session_id_}, {"what", exception.what()}});
  }
  if (!status.ok()) {
    environment_.log->Error("load_failed",
                            {{"session", session_id_}, {"what", status.error().message}});
  }
  return status;
}

Status Session::Load() {
  PLIANT_ASSIGN_OR_RETURN(const Journal::Contents contents, environment_.journal->Load());
  PLIANT_ASSIGN_OR_RETURN(SessionMemory memory,
                          ReadMemory(contents.snapshot, contents.records,
                                     {.factory = environment_.factory,
                                      .loader = environment_.loader,
                                      .codec = environment_.codec,
                                      .history_bytes_max = environment_.history_bytes_max}));
  Adopt(std::move(memory));
  ReportUsage();
  PublishInfo();
  environment_.log->Info("load", {{"session", session_id_}, {"revision", RevisionText(revision_)}});
  return {};
}

void Session::Adopt(SessionMemory memory) {
  asleep_ = false;
  engine_ = std::move(memory.engine);
  history_ = std::move(memory.history);
  undo_ = std::move(memory.undo);
  results_ = std::move(memory.results);
  revision_ = memory.revision;
  applied_update_id_ = memory.applied_update_id;
  active_count_ = memory.active_count;
  summary_ = memory.summary;
  commit_time_ = memory.commit_time;
  history_bytes_asked_ = memory.history_bytes_max;
  recorded_spec_ = engine_->committed_spec();
  if (journal_ != nullptr) journal_->SetDurable(revision_);
}

}  // namespace pliant::server
