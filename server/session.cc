#include "server/session.h"

#include <algorithm>
#include <exception>
#include <utility>
#include <variant>

#include "core/base/check.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

std::string Text(Revision revision) { return std::to_string(static_cast<std::int64_t>(revision)); }

}  // namespace

Session::Session(Environment environment, std::string session_id,
                 std::map<std::string, std::string> labels)
    : environment_(std::move(environment)),
      session_id_(std::move(session_id)),
      calls_({.count_max = kCallsMax, .bytes_max = SIZE_MAX}),
      results_(kUpdateResultsMax) {
  info_.session_id = session_id_;
  info_.labels = std::move(labels);
  info_.create_time = environment_.clock->WallNow();
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
  return {};
}

void Session::Detach(const Editor* editor) {
  const std::lock_guard lock(mutex_);
  if (editor_.get() == editor) editor_ = nullptr;
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
      return Error{ErrorCode::kResourceExhausted,
                   std::to_string(kCallsMax) + " calls wait for session " + session_id_ +
                       " already; try again later",
                   {}};
    }
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
  // A bug here must reach the creator, who waits for this answer and nothing else.
  try {
    Result<StagedEngine> engine =
        StagedEngine::Create(std::move(start.input), environment_.factory);
    if (engine.ok()) {
      engine_.emplace(std::move(engine).value());
      active_count_ = engine_->engine().vertex_count();
    } else {
      status = engine.error();
    }
  } catch (const std::exception& exception) {
    environment_.log->Error("bug", {{"session", session_id_}, {"what", exception.what()}});
    status = Error{ErrorCode::kInternal,
                   "a bug of the server was met while it read this input; nothing was created",
                   session_id_};
  }
  if (!status.ok()) torn_down_ = true;
  PublishInfo();
  start.done(status);
  return status.ok();
}

void Session::HandleCall(const SessionCall& call) {
  if (!engine_) {
    call(Error{ErrorCode::kSessionNotFound, "session " + session_id_ + " does not exist", {}});
    return;
  }
  const CommittedState state{engine_->engine(),       revision_,
                             applied_update_id_,      active_count_,
                             engine_->staged_count(), info().summary.value_or(MeshSummary{})};
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
  if (mirror_ == Mirror::kFull && open.mirror_revision != revision_ &&
      revision_ != Revision::kNone) {
    SessionEvent snapshot = MakeEvent(0);
    snapshot.body = SnapshotEvent{.snapshot = engine_->engine().Snapshot(),
                                  .applied_update_id = applied_update_id_};
    editor->Send(std::move(snapshot));
  }
  editor->CommandDone();
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
  } else if (const auto* spec = std::get_if<AdvanceSpec>(&command.body)) {
    BeginAdvance(editor, id, *spec);
  } else {
    const auto* metric = std::get_if<MetricUpdate>(&command.body);
    const Status status = metric != nullptr ? engine_->Stage(*metric) : engine_->Discard();
    if (!status.ok()) {
      Reject(editor, id, status.error());
      return;
    }
    SessionEvent accepted = MakeEvent(id);
    accepted.body = AcceptedEvent{.staged_count = engine_->staged_count()};
    Answer(editor, std::move(accepted));
  }
}

void Session::BeginAdvance(const std::shared_ptr<Editor>& editor, std::int64_t update_id,
                           const AdvanceSpec& spec) {
  if (engine_->tainted()) {
    const Status status = engine_->Discard();
    Reject(editor, update_id,
           status.ok() ? Error{ErrorCode::kUpdateRejected,
                               "an update since the last advance was refused, so nothing was "
                               "committed and the stage is empty now: send the step again",
                               {}}
                       : status.error());
    return;
  }
  const Clock::Time now = environment_.clock->Now();
  advance_ = RunningAdvance{.editor = editor,
                            .update_id = update_id,
                            .spec = spec,
                            .begin = now,
                            .progress = {},
                            .last_progress = now};
  const std::lock_guard lock(mutex_);
  running_update_id_ = update_id;
  stop_advance_ = cancel_update_id_ == update_id || close_error_ || drain_error_;
  info_.running = true;
}

// Works on the advance until it ends (true) or the slice does (false).
bool Session::ContinueAdvance(Clock::Time slice_end) {
  RunningAdvance& advance = *advance_;
  const Clock& clock = *environment_.clock;
  for (;;) {
    const std::int64_t visits_left = advance.spec.visits_max - advance.progress.counts.visits;
    const Clock::Time step_begin = clock.Now();
    const Result<Progress> result = engine_->Step(
        {.visits_max = std::min(visits_left, kVisitsPerStep), .cancel = &stop_advance_});
    const Clock::Time now = clock.Now();
    advance.compute += now - step_begin;
    if (!result.ok()) {
      FailAdvance(result.error());
      return true;
    }
    advance.progress = *result;
    if (advance.progress.stop_reason == StopReason::kCancelled) {
      const std::lock_guard lock(mutex_);
      if (close_error_) return true;  // Nobody is left to commit for.
    }
    if (advance.progress.stop_reason != StopReason::kVisitBudget ||
        advance.progress.counts.visits >= advance.spec.visits_max) {
      FinishAdvance(AdvanceEnd::kEngine);
      return true;
    }
    if (advance.spec.time_max && now - advance.begin >= *advance.spec.time_max) {
      FinishAdvance(AdvanceEnd::kTimeBudget);
      return true;
    }
    if (advance.spec.progress_interval &&
        now - advance.last_progress >= *advance.spec.progress_interval) {
      advance.last_progress = now;
      SessionEvent event = MakeEvent(advance.update_id);
      event.body = ProgressEvent{
          .progress = advance.progress,
          .vertex_count = engine_->engine().vertex_count(),
          .elapsed = std::chrono::duration_cast<std::chrono::milliseconds>(now - advance.begin)};
      advance.editor->Send(std::move(event));
    }
    if (now >= slice_end) return false;
  }
}

void Session::FinishAdvance(AdvanceEnd end) {
  RunningAdvance advance = *std::move(advance_);
  current_editor_ = advance.editor;
  current_update_id_ = advance.update_id;
  advance_.reset();
  const Revision base_revision = revision_;
  const Clock::Time commit_begin = environment_.clock->Now();
  MeshDiff diff = engine_->Commit();
  const Clock::Time now = environment_.clock->Now();
  revision_ = diff.revision;
  applied_update_id_ = advance.update_id;
  active_count_ = advance.progress.active_count;
  {
    const std::lock_guard lock(mutex_);
    running_update_id_ = 0;
    stop_advance_ = false;
    if (drain_error_ && advance.progress.stop_reason == StopReason::kCancelled) {
      end = AdvanceEnd::kServerClosing;
    }
    info_.revision = revision_;
    info_.active_count = active_count_;
    info_.summary = diff.summary;
    info_.commit_time = environment_.clock->WallNow();
  }
  SessionEvent advanced = MakeEvent(advance.update_id);
  advanced.body = AdvancedEvent{
      .base_revision = base_revision,
      .summary = diff.summary,
      .progress = advance.progress,
      .end = end,
      .compute = std::chrono::duration_cast<std::chrono::microseconds>(advance.compute +
                                                                       (now - commit_begin)),
      .elapsed = std::chrono::duration_cast<std::chrono::microseconds>(now - advance.begin)};
  environment_.log->Info("commit", {{"session", session_id_},
                                    {"update", std::to_string(advance.update_id)},
                                    {"revision", Text(revision_)},
                                    {"vertices", std::to_string(diff.summary.vertex_count)},
                                    {"visits", std::to_string(advance.progress.counts.visits)},
                                    {"active", std::to_string(active_count_)}});
  if (mirror_ == Mirror::kFull) {
    SessionEvent event = MakeEvent(advance.update_id);
    event.body = DiffEvent{.diff = std::move(diff), .applied_update_id = applied_update_id_};
    advance.editor->Send(std::move(event));
  }
  Answer(advance.editor, std::move(advanced));
  current_editor_ = nullptr;
  current_update_id_ = 0;
  PublishInfo();
}

void Session::FailAdvance(const Error& error) {
  const RunningAdvance advance = *std::move(advance_);
  advance_.reset();
  {
    const std::lock_guard lock(mutex_);
    running_update_id_ = 0;
    stop_advance_ = false;
  }
  const Status status = engine_->Discard();
  PLIANT_CHECK(status.ok(), "discard", status.ok() ? "" : status.error().message);
  Reject(advance.editor, advance.update_id, error);
  PublishInfo();
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
