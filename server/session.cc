#include "server/session.h"

#include <algorithm>
#include <exception>
#include <utility>
#include <variant>

#include "core/base/check.h"
#include "server/limits.h"

namespace pliant::server {
std::unique_ptr<SessionJournal> Session::MakeJournal() {
  if (environment_.journal == nullptr) return nullptr;
  return std::make_unique<SessionJournal>(environment_.journal, environment_.durability, [this] {
    return [weak = weak_from_this()] {
      if (const std::shared_ptr<Session> self = weak.lock()) self->Wake();
    };
  });
}

Session::Session(Environment environment, std::string session_id,
                 std::map<std::string, std::string> labels)
    : environment_(std::move(environment)),
      session_id_(std::move(session_id)),
      calls_({.count_max = kCallsMax, .bytes_max = SIZE_MAX}),
      followers_(kSubscribersMax),
      journal_(MakeJournal()),
      history_(environment_.history_bytes_max),
      results_(kUpdateResultsMax),
      history_bytes_asked_(environment_.history_bytes_asked) {
  info_.session_id = session_id_;
  info_.labels = std::move(labels);
  info_.create_time = environment_.clock->WallNow();
  last_used_ = environment_.clock->Now();
}

// --- Called by RPC threads ----------------------------------------------------------------------

void Session::Start(EngineInput input, std::function<void(const Status&)> done, Bytes form) {
  {
    const std::lock_guard lock(mutex_);
    start_ = StartRequest{std::move(input), std::move(done), std::move(form)};
  }
  Wake();
}

void Session::Start(SessionReader read, std::function<void(const Status&)> done) {
  {
    const std::lock_guard lock(mutex_);
    start_ = StartRequest{{}, std::move(done), {}, std::move(read)};
  }
  Wake();
}

Status Session::Attach(std::shared_ptr<Editor> editor) {
  const std::lock_guard lock(mutex_);
  if (close_error_) return *close_error_;
  if (drain_error_) return *drain_error_;
  if (editor_ != nullptr) {
    return Error{ErrorCode::kSessionBusy,
                 "session " + session_id_ + " has an editor; a session has one at a time",
                 {}};
  }
  editor_ = std::move(editor);
  last_used_ = environment_.clock->Now();
  return {};
}

void Session::Detach(const Editor* editor) {
  const std::lock_guard lock(mutex_);
  if (editor_.get() == editor) {
    editor_ = nullptr;
    if (staging_update_id_ != 0) stop_work_.Set(true);
  }
  last_used_ = environment_.clock->Now();
}

Status Session::Subscribe(std::shared_ptr<Subscriber> subscriber, Revision mirror_revision) {
  {
    // Under the lock: a session that ends closes those who came before.
    const std::lock_guard lock(mutex_);
    if (close_error_) return *close_error_;
    if (drain_error_) return *drain_error_;
    PLIANT_RETURN_IF_ERROR(followers_.Add(std::move(subscriber), mirror_revision));
  }
  WakeForSubscriber();
  return {};
}

void Session::Unsubscribe(const Subscriber* subscriber) {
  followers_.Remove(subscriber);
  const std::lock_guard lock(mutex_);
  last_used_ = environment_.clock->Now();
}

bool Session::CloseIfIdle(Clock::Time before, Error error) {
  {
    const std::lock_guard lock(mutex_);
    if (close_error_ || drain_error_ || start_ || editor_ != nullptr || info_.running ||
        !calls_.empty() || last_used_ > before || followers_.count() > 0) {
      return false;
    }
    close_error_ = std::move(error);
    // Nobody could ever ask for what is stored of it.
    if (journal_ != nullptr) delete_done_ = [](const Status&) {};
  }
  Wake();
  return true;
}

void Session::WakeForSubscriber() {
  followers_wait_ = true;
  Wake();
}

void Session::CancelAdvance(std::int64_t update_id) {
  const std::lock_guard lock(mutex_);
  // Remembered also if it runs: dropped with its stream and sent again, it is still cancelled.
  cancelled_.insert(update_id);
  if (cancelled_.size() > kCancelsMax) cancelled_.erase(*cancelled_.rbegin());
  if (running_update_id_ == update_id || staging_update_id_ == update_id) stop_work_.Set(true);
}

Status Session::Post(SessionCall call) {
  {
    const std::lock_guard lock(mutex_);
    if (close_error_) return *close_error_;
    if (calls_.Push(std::move(call), 0)) {
      return Error{.code = ErrorCode::kResourceExhausted,
                   .message = std::to_string(kCallsMax) + " calls wait for session " + session_id_ +
                              " already; try again later",
                   .retry_after_ms = kCallRetryMs};
    }
    last_used_ = environment_.clock->Now();
  }
  Wake();
  return {};
}

void Session::Close(Error error) {
  {
    const std::lock_guard lock(mutex_);
    if (close_error_) return;
    close_error_ = std::move(error);
    stop_work_.Set(true);
  }
  Wake();
}

void Session::Drain(Error error) {
  {
    const std::lock_guard lock(mutex_);
    if (drain_error_) return;
    drain_error_ = std::move(error);
    stop_work_.Set(true);
  }
  Wake();
}

SessionInfo Session::info() const {
  const std::lock_guard lock(mutex_);
  return info_;
}

std::shared_ptr<Editor> Session::CurrentEditor() const {
  const std::lock_guard lock(mutex_);
  return editor_;
}

// --- Run by workers -----------------------------------------------------------------------------

Task::Outcome Session::RunSlice(Clock::Time slice_end) {
  // The edge of the session: what goes wrong inside must not leave it.
  Outcome outcome = Outcome::kMore;
  try {
    outcome = RunUnguarded(slice_end);
  } catch (const std::exception& exception) {
    HandleBug(exception.what());
  }
  Submit();
  return outcome;
}

Task::Outcome Session::RunUnguarded(Clock::Time slice_end) {
  if (torn_down_) {
    // Calls that slipped in after the end.
    TearDown({ErrorCode::kSessionNotFound, "session " + session_id_ + " has ended", {}});
    return Outcome::kIdle;
  }
  for (int i = 0; i < kCommandsPerSlice; ++i) {
    std::optional<Error> close_error;
    {
      const std::lock_guard lock(mutex_);
      close_error = close_error_;
    }
    if (close_error) {
      TearDown(*close_error);
      return Outcome::kIdle;
    }
    if (!Settled()) return Outcome::kIdle;
    if (followers_wait_.exchange(false) && !ServeFollowers(slice_end)) {
      followers_wait_ = true;
      // An advance or call that runs gets its part of the next slice all the same.
      if (!advance_ && !call_rest_) return Outcome::kMore;
    }
    if (call_rest_) {
      if (!ContinueCall(slice_end)) return Outcome::kMore;
    } else if (advance_) {
      if (!ContinueAdvance(slice_end)) return Outcome::kMore;
    } else if (!HandleOneThing()) {
      if (sleep_wanted_.exchange(false) && MaySleep()) Sleep();
      return Outcome::kIdle;
    }
    if (environment_.clock->Now() >= slice_end) return Outcome::kMore;
  }
  return Outcome::kMore;
}

// Does the next thing that waits; false if nothing does.
bool Session::HandleOneThing() {
  std::optional<Error> drain_error;
  std::shared_ptr<Editor> editor;
  bool starting = false;
  {
    const std::lock_guard lock(mutex_);
    starting = start_.has_value();
    if (!starting) current_call_ = calls_.Pop().value_or(nullptr);
    drain_error = drain_error_;
    editor = editor_;
  }
  if (starting) return Build();
  if (current_call_) {
    HandleCall(current_call_);
    current_call_ = nullptr;
    return true;
  }
  if (!put_off_.empty() && !drain_error) {
    StagePutOff();
    return true;
  }
  // Answers that wait for the disk go first; their arrival wakes the session.
  if (drain_error && journal_ != nullptr && !journal_->is_clean()) return false;
  if (drain_error) followers_.CloseAll(*drain_error);
  if (editor == nullptr) return false;
  if (drain_error) {
    Detach(editor.get());
    editor->Close(*drain_error);
    return true;
  }
  std::optional<SessionCommand> command = editor->NextCommand();
  if (!command) return false;
  current_editor_ = editor;
  if (const Status there = Need(); !there.ok()) {
    Detach(editor.get());
    editor->Close(there.error());
  } else if (const auto* open = std::get_if<OpenCommand>(&*command)) {
    HandleOpen(editor, *open);
  } else {
    HandleUpdate(editor, std::get<UpdateCommand>(*command));
  }
  current_editor_ = nullptr;
  current_update_id_ = 0;
  PublishInfo();
  return true;
}

bool Session::Build() {
  StartRequest start;
  {
    const std::lock_guard lock(mutex_);
    start = std::move(*start_);
    start_.reset();
  }
  Status status;
  const Clock::Time begin = environment_.clock->Now();
  // A bug here must reach the creator, who waits for this answer and nothing else.
  try {
    if (start.read) {
      Result<SessionMemory> memory = start.read();
      status = memory.ok() ? BeginFrom(std::move(memory).value()) : Status(memory.error());
    } else {
      status = BeginFrom(std::move(start.input), start.form);
    }
  } catch (const std::exception& exception) {
    environment_.log->Error("bug", {{"session", session_id_}, {"what", exception.what()}});
    status = Error{ErrorCode::kInternal,
                   "a bug of the server was met while it read this input; nothing was created",
                   session_id_};
  }
  Charge(environment_.clock->Now() - begin);
  if (status.ok()) {
    ReportUsage();
  } else {
    engine_.reset();
    torn_down_ = true;
  }
  PublishInfo();
  if (!status.ok()) {
    start.done(status);
  } else {
    WhenDurable(std::move(start.done));
  }
  return status.ok();
}

void Session::HandleOpen(const std::shared_ptr<Editor>& editor, const OpenCommand& open) {
  mirror_ = open.mirror;
  step_refused_ = false;
  editor_wants_transfer_ = open.wants_transfer;
  SessionEvent opened = MakeEvent(0);
  opened.body = OpenedEvent{.last_update_id = results_.last_update_id(),
                            .active_count = active_count_,
                            .staged_count = engine_->staged_count()};
  Tell(editor, std::move(opened));
  if (mirror_ == Mirror::kFull) SendMissed(editor, open.mirror_revision);
  opened_ = editor;
  WhenDurable([editor](const Status&) { editor->CommandDone(); });
}

// What takes a mirror to the current revision: one diff, or a snapshot if the history is too short.
void Session::SendMissed(const std::shared_ptr<Editor>& editor, Revision mirror_revision) {
  if (mirror_revision == revision_ || revision_ == Revision::kNone) return;
  SessionEvent event = MakeEvent(0);
  std::shared_ptr<const MeshDiff> diff;
  if (mirror_revision != Revision::kNone) diff = history_.Since(mirror_revision);
  if (diff != nullptr) {
    event.body = DiffEvent{std::move(diff), applied_update_id_};
  } else {
    event.body = SnapshotEvent{std::make_shared<const MeshDiff>(engine_->engine().Snapshot()),
                               applied_update_id_};
  }
  Tell(editor, std::move(event));
}

bool Session::ServeFollowers(Clock::Time slice_end) {
  if (asleep_ && followers_.AnyWaits(revision_)) {
    if (const Status there = Need(); !there.ok()) followers_.CloseAll(there.error());
  }
  if (!engine_) return true;
  const Followers::Source source{
      .revision = revision_,
      .applied_update_id = applied_update_id_,
      .history = &history_,
      .snapshot = [this] {
        return std::make_shared<const MeshDiff>(engine_->engine().Snapshot());
      }};
  const bool all_served = followers_.Serve(source, *environment_.clock, slice_end);
  if (all_served) history_.Trim();
  return all_served;
}

void Session::HandleUpdate(const std::shared_ptr<Editor>& editor, const UpdateCommand& command) {
  const std::int64_t id = command.update_id;
  if (id <= results_.last_update_id() || !results_.CheckNew(id).ok()) {
    AnswerAgain(editor, command);
    return;
  }
  current_update_id_ = id;
  update_ = command.fingerprint;
  step_refused_ = false;
  if (const auto* bad = std::get_if<BadUpdate>(&command.body)) {
    engine_->Taint();
    Reject(editor, id, bad->error, StageEffect::kTainted);
  } else if (const auto* advance = std::get_if<BadAdvance>(&command.body)) {
    Reject(editor, id, advance->error, StageEffect::kNone);
  } else if (const auto* rollback = std::get_if<RollbackUpdate>(&command.body)) {
    HandleRollback(editor, id, rollback->to_revision);
  } else if (const auto* spec = std::get_if<AdvanceSpec>(&command.body)) {
    BeginAdvance(editor, id, *spec);
  } else {
    StageUpdate(editor, command);
  }
}

// An update whose number was used, or is too great: its first answer, or a refusal, which counts as
// any other does, so that nobody commits half of a step.
void Session::AnswerAgain(const std::shared_ptr<Editor>& editor, const UpdateCommand& command) {
  const bool advances = std::holds_alternative<AdvanceSpec>(command.body);
  Result<SessionEvent> first = results_.Repeat(command.update_id, command.fingerprint);
  if (first.ok() && advances && step_refused_) {
    first = Error{ErrorCode::kUpdateRejected,
                  "an update before this advance was refused, as its number was used by another "
                  "one, so nothing was committed: send the step again under new numbers",
                  {}};
  }
  SessionEvent answer = first.ok() ? *first : MakeEvent(command.update_id);
  if (!first.ok()) answer.body = RejectedEvent{first.error()};
  if (!first.ok() && IsStaging(command)) {
    step_refused_ = step_refused_ || !engine_->tainted();
    engine_->Taint();
    RecordAnswer(nullptr, StageEffect::kTainted);
  }
  // With its advance the whole step is refused, unless another stream's editor is to hear that.
  if (!first.ok() && advances && step_refused_ && engine_->Discard().ok()) {
    RecordAnswer(nullptr, StageEffect::kEmptied);
  }
  step_refused_ = step_refused_ && !advances;
  Tell(editor, std::move(answer));
  WhenDurable([editor](const Status&) { editor->CommandDone(); });
}

// Whether the update that begins has been cancelled already. None with a lower number begins again,
// so those cancels are forgotten. Under mutex_.
bool Session::IsCancelled(std::int64_t update_id) {
  cancelled_.erase(cancelled_.begin(), cancelled_.lower_bound(update_id));
  return cancelled_.contains(update_id);
}

void Session::Reject(const std::shared_ptr<Editor>& editor, std::int64_t update_id,
                     const Error& error, StageEffect effect) {
  environment_.log->Debug("reject", {{"session", session_id_},
                                     {"update", std::to_string(update_id)},
                                     {"reason", std::string(ErrorCodeName(error.code))}});
  SessionEvent rejected = MakeEvent(update_id);
  rejected.body = RejectedEvent{error};
  Answer(editor, std::move(rejected), effect);
}

void Session::Answer(const std::shared_ptr<Editor>& editor, SessionEvent event, StageEffect effect,
                     const Bytes& form) {
  results_.Add({event, update_});
  RecordAnswer(&event, effect, form);
  // Before the answer: who has it and asks for the session must not see the state before it.
  PublishInfo();
  Tell(editor, std::move(event));
  WhenDurable([editor](const Status&) { editor->CommandDone(); });
}

// Sends an event once all that it tells is durable; never if that fails, for then the stream ends.
void Session::Tell(const std::shared_ptr<Editor>& editor, SessionEvent event) {
  if (journal_ == nullptr) {
    editor->Send(std::move(event));
    return;
  }
  journal_->Hold([editor, event = std::move(event)](const Status& status) {
    if (status.ok()) editor->Send(event);
  });
}

SessionEvent Session::MakeEvent(std::int64_t update_id) const {
  return {.update_id = update_id, .revision = revision_, .body = OpenedEvent{}};
}

void Session::PublishInfo() {
  PublishRest();
  // What is not durable yet is told when it is.
  if (journal_ != nullptr && journal_->waits()) return;
  const std::lock_guard lock(mutex_);
  info_.running = advance_.has_value();
  info_.asleep = asleep_;
  if (asleep_) return;
  info_.revision = revision_;
  info_.active_count = active_count_;
  info_.last_update_id = results_.last_update_id();
  info_.summary = summary_;
  info_.commit_time = commit_time_;
  info_.saved_revisions = undo_.saved();
  info_.history_bytes_max = history_bytes_asked_;
}

}  // namespace pliant::server
