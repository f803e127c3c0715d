#include "server/session_stream.h"

#include <string>
#include <utility>
#include <vector>

#include "server/access.h"
#include "server/convert_reply.h"
#include "server/convert_request.h"
#include "server/error_status.h"
#include "server/limits.h"
#include "server/stored_form.h"

namespace pliant::server {
namespace {

Error OrderError(std::string message, std::string field) {
  return {ErrorCode::kProtocolOrder, std::move(message), std::move(field)};
}

}  // namespace

grpc::ServerBidiReactor<v1::EditRequest, v1::EditResponse>* EditStream::Begin(
    Environment environment) {
  // Not make_shared: the constructor is private.
  const std::shared_ptr<EditStream> stream(new EditStream(std::move(environment)));
  stream->self_ = stream;
  if (stream->environment_.tenant) {
    stream->StartRead(&stream->request_);
  } else {
    const std::lock_guard lock(stream->mutex_);
    stream->reading_ = false;
    stream->End(Access::Refusal());
    stream->Pump();
  }
  return stream.get();
}

EditStream::EditStream(Environment environment)
    : environment_(std::move(environment)),
      inbox_({.count_max = kInboxCommandsMax, .bytes_max = kInboxBytesMax}),
      outbox_(kOutboxBytesMax) {
  environment_.calls->Begin();
}

// --- Called by gRPC -----------------------------------------------------------------------------

void EditStream::OnReadDone(bool ok) {
  if (!ok) {
    const std::lock_guard lock(mutex_);
    reading_ = false;
    client_is_done_ = true;
    Pump();
    return;
  }
  const std::size_t bytes = request_.ByteSizeLong() + blobs_.pending_bytes();
  Result<std::optional<SessionCommand>> command = Handle(request_);
  {
    const std::lock_guard lock(mutex_);
    reading_ = false;
    if (!command.ok()) {
      End(ToGrpcStatus(command.error()));
    } else if (command->has_value()) {
      // There is room: the read was started only because of it.
      PLIANT_CHECK(!inbox_.Push(**std::move(command), bytes).has_value());
    }
    Pump();
  }
  WakeSession();
}

void EditStream::OnWriteDone(bool ok) {
  bool is_awaited = false;
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    if (!ok) End(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
    Pump();
    is_awaited = !ok || (awaits_room_ && outbox_.has_room());
    if (is_awaited) awaits_room_ = false;
  }
  if (is_awaited) WakeSession();
}

void EditStream::OnCancel() {
  const std::lock_guard lock(mutex_);
  while (outbox_.Pop()) {
  }
  End(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
  Pump();
}

void EditStream::OnDone() {
  std::shared_ptr<EditStream> self;
  std::shared_ptr<Session> session;
  grpc::Status status;
  {
    const std::lock_guard lock(mutex_);
    self = std::move(self_);
    session = std::move(session_);
    status = end_.value_or(grpc::Status::OK);
  }
  environment_.log->Info("edit_end", {{"session", session ? session->session_id() : ""},
                                      {"request", environment_.request_id},
                                      {"status", std::to_string(status.error_code())},
                                      {"message", status.error_message()}});
  environment_.calls->End();
}

// --- Called by the session ----------------------------------------------------------------------

std::optional<SessionCommand> EditStream::NextCommand() {
  const std::lock_guard lock(mutex_);
  if (end_) return std::nullopt;
  if (!outbox_.has_room()) {
    awaits_room_ = true;
    return std::nullopt;
  }
  std::optional<SessionCommand> command = inbox_.Pop();
  if (command) ++commands_taken_;
  Pump();
  return command;
}

void EditStream::LookAhead(const std::function<bool(const SessionCommand&)>& look) const {
  const std::lock_guard lock(mutex_);
  if (!end_ && outbox_.has_room()) inbox_.LookThrough(look);
}

void EditStream::CommandDone() {
  const std::lock_guard lock(mutex_);
  --commands_taken_;
  Pump();
}

bool EditStream::HasRoom() const {
  const std::lock_guard lock(mutex_);
  return !end_ && outbox_.has_room();
}

void EditStream::Send(SessionEvent event) {
  {
    const std::lock_guard lock(mutex_);
    if (end_) return;
    if (std::holds_alternative<ProgressEvent>(event.body) && !outbox_.has_room()) return;
  }
  // Conversion copies the mesh: not under the lock.
  v1::EditResponse response = ToEditResponse(event, parts_);
  std::vector<v1::BlobChunk> chunks = TakeLargeArrays(response, last_blob_id_);
  const std::lock_guard lock(mutex_);
  for (v1::BlobChunk& chunk : chunks) {
    v1::EditResponse message;
    message.set_update_id(response.update_id());
    message.set_revision(response.revision());
    *message.mutable_chunk() = std::move(chunk);
    Queue(std::move(message));
  }
  Queue(std::move(response));
  Pump();
}

void EditStream::Close(const Error& error) {
  SessionEvent event;
  event.body = ClosingEvent{error};
  Send(std::move(event));
  const std::lock_guard lock(mutex_);
  End(ToGrpcStatus(error));
  Pump();
}

// --- Requests -----------------------------------------------------------------------------------

// What a request is for the session; nothing if it was for the stream alone. An error ends the
// stream.
Result<std::optional<SessionCommand>> EditStream::Handle(v1::EditRequest& request) {
  std::shared_ptr<Session> session;
  {
    const std::lock_guard lock(mutex_);
    session = session_;
  }
  if ((session == nullptr) != request.has_open()) {
    return OrderError("the first message of an edit stream, and only the first, is `open`", "open");
  }
  switch (request.command_case()) {
    case v1::EditRequest::kOpen: {
      PLIANT_ASSIGN_OR_RETURN(SessionCommand open, HandleOpen(request));
      return std::optional<SessionCommand>(std::move(open));
    }
    case v1::EditRequest::kChunk:
      PLIANT_RETURN_IF_ERROR(blobs_.Add(std::move(*request.mutable_chunk())));
      return std::optional<SessionCommand>();
    case v1::EditRequest::kCancel:
      session->CancelAdvance(request.cancel().advance_update_id());
      return std::optional<SessionCommand>();
    case v1::EditRequest::kAcknowledge:
      return std::optional<SessionCommand>();  // Nothing is kept for resumption yet.
    case v1::EditRequest::COMMAND_NOT_SET:
      return OrderError("the message has no command", "command");
    default:
      break;
  }
  PLIANT_RETURN_IF_ERROR(CheckUpdateId(request.update_id()));
  if (const Status status = blobs_.Resolve(request); !status.ok()) {
    return std::optional<SessionCommand>(UpdateCommand{.update_id = request.update_id(),
                                                       .body = BadUpdate{status.error()},
                                                       .fingerprint = {.kind = KindOf(request)}});
  }
  UpdateCommand command = ConvertUpdate(request, environment_.limits);
  if (auto* advance = std::get_if<AdvanceSpec>(&command.body)) {
    advance->arrival = environment_.clock->Now();
  }
  command.fingerprint = FingerprintOf(request);
  if (session->is_stored() && !request.has_advance()) command.form = FormOf(request);
  return std::optional<SessionCommand>(std::move(command));
}

Result<SessionCommand> EditStream::HandleOpen(const v1::EditRequest& request) {
  PLIANT_ASSIGN_OR_RETURN(OpenCommand open, ConvertOpen(request.open()));
  PLIANT_ASSIGN_OR_RETURN(const WantedParts parts, ConvertParts(request.open().parts()));
  open.wants_transfer = parts.transfer && open.mirror == Mirror::kFull;
  PLIANT_ASSIGN_OR_RETURN(
      std::shared_ptr<Session> session,
      environment_.registry->Find(*environment_.tenant, request.open().session_id()));
  {
    const std::lock_guard lock(mutex_);
    parts_ = parts;  // Before a worker can send anything.
  }
  PLIANT_RETURN_IF_ERROR(session->Attach(shared_from_this()));
  environment_.log->Info(
      "edit_open", {{"session", session->session_id()}, {"request", environment_.request_id}});
  const std::lock_guard lock(mutex_);
  session_ = std::move(session);
  if (finished_) session_->Detach(this);  // Cancelled meanwhile.
  return SessionCommand(open);
}

// --- Below mutex_ -------------------------------------------------------------------------------

void EditStream::End(grpc::Status status) {
  if (end_) return;
  end_ = std::move(status);
  while (inbox_.Pop()) {
  }
}

void EditStream::Queue(v1::EditResponse response) {
  if (end_) return;
  const std::size_t bytes = response.ByteSizeLong();
  outbox_.Push(std::move(response), bytes);
}

// Starts whatever can be started now.
void EditStream::Pump() {
  if (finished_) return;
  if (!reading_ && !client_is_done_ && !end_ && !inbox_.full()) {
    reading_ = true;
    StartRead(&request_);
  }
  if (writing_) return;
  if (std::optional<v1::EditResponse> response = outbox_.Pop()) {
    writing_ = true;
    response_ = *std::move(response);
    // With more to come the bytes may wait for it: one system call and one wake-up for all. Of an
    // update that is accepted nobody wants to hear who has sent the next command already.
    grpc::WriteOptions options;
    const bool may_wait = response_.has_accepted() && (!inbox_.empty() || commands_taken_ > 1);
    if (!outbox_.empty() || may_wait) options.set_buffer_hint();
    StartWrite(&response_, options);
    return;
  }
  const bool all_answered = client_is_done_ && inbox_.empty() && commands_taken_ == 0;
  if (!end_ && !all_answered) return;
  finished_ = true;
  // Free the session first, so that the client can open the next stream at once.
  if (session_ != nullptr) session_->Detach(this);
  Finish(end_.value_or(grpc::Status::OK));
}

void EditStream::WakeSession() {
  std::shared_ptr<Session> session;
  {
    const std::lock_guard lock(mutex_);
    session = session_;
  }
  if (session != nullptr) session->Wake();
}

}  // namespace pliant::server
