#include "server/session.h"

#include <algorithm>
#include <exception>
#include <utility>
#include <variant>

#include "core/base/check.h"
#include "server/limits.h"

namespace pliant::server {
Session::Session(Environment environment, std::string session_id,
                 std::map<std::string, std::string> labels)
    : environment_(std::move(environment)),
      session_id_(std::move(session_id)),
      calls_({.count_max = kCallsMax, .bytes_max = SIZE_MAX}),
      followers_(kSubscribersMax),
      history_(environment_.history_bytes_max),
      results_(kUpdateResultsMax) {
  info_.session_id = session_id_;
  info_.labels = std::move(labels);
  info_.create_time = environment_.clock->WallNow();
  last_used_ = environment_.clock->Now();
}

// --- Called by RPC threads ----------------------------------------------------------------------

void Session::Start(EngineInput input, std::function<void(const Status&)> done) {
  {
    const std::lock_guard lock(mutex_);
    start_ = StartRequest{std::move(input), std::move(done)};
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
  if (editor_.get() == editor) editor_ = nullptr;
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
  cancel_update_id_ = update_id;
  if (running_update_id_ == update_id) stop_advance_ = true;
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
    stop_advance_ = true;
  }
  Wake();
}

void Session::Drain(Error error) {
  {
    const std::lock_guard lock(mutex_);
    if (drain_error_) return;
    drain_error_ = std::move(error);
    stop_advance_ = true;
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
  try {
    return RunUnguarded(slice_end);
  } catch (const std::exception& exception) {
    HandleBug(exception.what());
  }
  return Outcome::kMore;
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
    if (followers_wait_.exchange(false) && !ServeFollowers(slice_end)) {
      followers_wait_ = true;
      // An advance that runs gets its part of the next slice all the same.
      if (!advance_) return Outcome::kMore;
    }
    if (advance_) {
      if (!ContinueAdvance(slice_end)) return Outcome::kMore;
    } else if (!HandleOneThing()) {
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
  if (const auto* open = std::get_if<OpenCommand>(&*command)) {
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
    Result<StagedEngine> engine =
        StagedEngine::Create(std::move(start.input), environment_.factory);
    if (engine.ok()) {
      engine_.emplace(std::move(engine).value());
      active_count_ = engine_->engine().vertex_count();
      status = CheckRoom(Usage());
    } else {
      status = engine.error();
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
  start.done(status);
  return status.ok();
}

void Session::HandleCall(const SessionCall& call) {
  if (!engine_) {
    call(Error{ErrorCode::kSessionNotFound, "session " + session_id_ + " does not exist", {}});
    return;
  }
  const CommittedState state{engine_->engine(),
                             revision_,
                             applied_update_id_,
                             active_count_,
                             engine_->staged_count(),
                             info().summary.value_or(MeshSummary{}),
                             this};
  if (revision_ == Revision::kNone) {
    call(Error{ErrorCode::kRevisionNotFound,
               "session " + session_id_ + " has no revision yet: advance it first", "revision"});
    return;
  }
  call(&state);
}

void Session::HandleOpen(const std::shared_ptr<Editor>& editor, const OpenCommand& open) {
  mirror_ = open.mirror;
  SessionEvent opened = MakeEvent(0);
  opened.body = OpenedEvent{.last_update_id = results_.last_update_id(),
                            .active_count = active_count_,
                            .staged_count = engine_->staged_count()};
  editor->Send(std::move(opened));
  if (mirror_ == Mirror::kFull) SendMissed(editor, open.mirror_revision);
  editor->CommandDone();
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
  editor->Send(std::move(event));
}

bool Session::ServeFollowers(Clock::Time slice_end) {
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
  if (id <= results_.last_update_id()) {
    std::optional<SessionEvent> answer = results_.Find(id);
    if (!answer) {
      answer = MakeEvent(id);
      answer->body =
          RejectedEvent{{ErrorCode::kProtocolOrder,
                         "update_id " + std::to_string(id) + " is neither new (the last was " +
                             std::to_string(results_.last_update_id()) + ") nor among the last " +
                             std::to_string(kUpdateResultsMax) + " updates",
                         "update_id"}};
    }
    editor->Send(*std::move(answer));
    editor->CommandDone();
    return;
  }
  current_update_id_ = id;
  if (const auto* bad = std::get_if<BadUpdate>(&command.body)) {
    engine_->Taint();
    Reject(editor, id, bad->error);
  } else if (const auto* advance = std::get_if<BadAdvance>(&command.body)) {
    Reject(editor, id, advance->error);
  } else if (const auto* rollback = std::get_if<RollbackUpdate>(&command.body)) {
    HandleRollback(editor, id, rollback->to_revision);
  } else if (const auto* spec = std::get_if<AdvanceSpec>(&command.body)) {
    BeginAdvance(editor, id, *spec);
  } else {
    const auto* metric = std::get_if<MetricUpdate>(&command.body);
    const auto* motion = std::get_if<MotionUpdate>(&command.body);
    const auto* fields = std::get_if<FieldsUpdate>(&command.body);
    const auto* options = std::get_if<OptionsUpdate>(&command.body);
    const auto* constraints = std::get_if<ConstraintsUpdate>(&command.body);
    const Status status = metric != nullptr        ? engine_->Stage(*metric)
                          : motion != nullptr      ? engine_->StageMotion(*motion)
                          : fields != nullptr      ? engine_->Stage(*fields)
                          : options != nullptr     ? engine_->Stage(*options)
                          : constraints != nullptr ? engine_->Stage(*constraints)
                                                   : engine_->Discard();
    if (!status.ok()) {
      Reject(editor, id, status.error());
      return;
    }
    SessionEvent accepted = MakeEvent(id);
    accepted.body = AcceptedEvent{.staged_count = engine_->staged_count()};
    Answer(editor, std::move(accepted));
  }
}

void Session::Reject(const std::shared_ptr<Editor>& editor, std::int64_t update_id,
                     const Error& error) {
  environment_.log->Debug("reject", {{"session", session_id_},
                                     {"update", std::to_string(update_id)},
                                     {"reason", std::string(ErrorCodeName(error.code))}});
  SessionEvent rejected = MakeEvent(update_id);
  rejected.body = RejectedEvent{error};
  Answer(editor, std::move(rejected));
}

void Session::Answer(const std::shared_ptr<Editor>& editor, SessionEvent event) {
  results_.Add(event);
  // Before the answer: who has it and asks for the session must not see the state before it.
  PublishInfo();
  editor->Send(std::move(event));
  editor->CommandDone();
}

SessionEvent Session::MakeEvent(std::int64_t update_id) const {
  return {.update_id = update_id, .revision = revision_, .body = OpenedEvent{}};
}

void Session::PublishInfo() {
  const std::lock_guard lock(mutex_);
  info_.revision = revision_;
  info_.active_count = active_count_;
  info_.last_update_id = results_.last_update_id();
  info_.running = advance_.has_value();
}

}  // namespace pliant::server
