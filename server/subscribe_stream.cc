#include "server/subscribe_stream.h"

#include <utility>
#include <variant>

#include "server/access.h"
#include "server/blobs.h"
#include "server/convert_reply.h"
#include "server/error_status.h"

namespace pliant::server {

grpc::ServerWriteReactor<v1::SubscribeResponse>* SubscribeStream::Begin(
    Environment environment, const v1::SubscribeRequest& request) {
  // Not make_shared: the constructor is private.
  const std::shared_ptr<SubscribeStream> stream(new SubscribeStream(std::move(environment)));
  stream->self_ = stream;
  const bool is_known = stream->environment_.tenant.has_value();
  const Status status = is_known ? stream->Open(request) : Status();
  const std::lock_guard lock(stream->mutex_);
  if (!is_known) stream->End(Access::Refusal());
  if (!status.ok()) stream->End(ToGrpcStatus(status.error()));
  stream->SetAlarm();
  stream->Pump();
  return stream.get();
}

SubscribeStream::SubscribeStream(Environment environment) : environment_(std::move(environment)) {
  environment_.calls->Begin();
}

Status SubscribeStream::Open(const v1::SubscribeRequest& request) {
  PLIANT_ASSIGN_OR_RETURN(spec_, ConvertSubscribe(request));
  Revision mirror = spec_.mirror_revision;
  if (spec_.partial()) {
    view_.emplace(MeshView::Spec{.region_tags = spec_.region_tags,
                                 .only_vertices = spec_.mirror == Mirror::kPositions,
                                 .with_values = spec_.parts.metric || spec_.parts.fields});
    mirror = Revision::kNone;  // What was in view then is not known any more.
  }
  PLIANT_ASSIGN_OR_RETURN(std::shared_ptr<Session> session,
                          environment_.registry->Find(*environment_.tenant, request.session_id()));
  {
    const std::lock_guard lock(mutex_);
    session_ = session;
    revision_ = static_cast<std::int64_t>(mirror);
  }
  environment_.log->Info(
      "subscribe", {{"session", session->session_id()}, {"request", environment_.request_id}});
  return session->Subscribe(shared_from_this(), mirror);
}

// --- Called by gRPC -----------------------------------------------------------------------------

void SubscribeStream::OnWriteDone(bool ok) {
  std::shared_ptr<Session> session;
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    if (!ok) {
      messages_.clear();
      last_word_.reset();
      End(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
    }
    Pump();
    if (messages_.empty() && !finished_) session = session_;
  }
  if (session != nullptr) session->WakeForSubscriber();
}

void SubscribeStream::OnCancel() {
  const std::lock_guard lock(mutex_);
  if (!writing_) messages_.clear();
  last_word_.reset();
  End(grpc::Status(grpc::StatusCode::CANCELLED, "the client is gone"));
  Pump();
}

void SubscribeStream::OnDone() {
  std::shared_ptr<SubscribeStream> self;
  std::shared_ptr<Session> session;
  std::shared_ptr<grpc::Alarm> alarm;
  {
    const std::lock_guard lock(mutex_);
    self = std::move(self_);
    session = std::move(session_);
    alarm = std::move(alarm_);
  }
  if (alarm != nullptr) alarm->Cancel();
  if (session != nullptr) session->Unsubscribe(this);
  environment_.log->Info("subscribe_end", {{"session", session ? session->session_id() : ""},
                                           {"request", environment_.request_id}});
  environment_.calls->End();
}

// --- Called by the session ----------------------------------------------------------------------

bool SubscribeStream::ready() const {
  const std::lock_guard lock(mutex_);
  return !end_ && !converting_ && messages_.empty();
}

bool SubscribeStream::Follows(const MeshDiff& diff) {
  // Dense numbers change with every revision.
  if (spec_.numbering == v1::NUMBERING_DENSE) return false;
  if (!view_) return true;
  seen_ = view_->Follow(diff);
  return seen_.has_value();
}

void SubscribeStream::Send(SessionEvent event) { Write(std::move(event)); }

void SubscribeStream::Close(const Error& error) {
  SessionEvent event;
  event.body = ClosingEvent{error};
  v1::SubscribeResponse response = ToSubscribeResponse(event, spec_.parts, spec_.numbering);
  const std::lock_guard lock(mutex_);
  if (!end_) last_word_ = std::move(response);
  End(ToGrpcStatus(error));
  Pump();
}

void SubscribeStream::Write(SessionEvent event) {
  {
    const std::lock_guard lock(mutex_);
    if (end_) return;
    converting_ = true;
  }
  // Conversion copies the mesh: not under the lock.
  if (view_) {
    if (auto* diff = std::get_if<DiffEvent>(&event.body)) {
      diff->diff = std::make_shared<const MeshDiff>(*std::exchange(seen_, std::nullopt));
    } else if (auto* snapshot = std::get_if<SnapshotEvent>(&event.body)) {
      snapshot->snapshot = std::make_shared<const MeshDiff>(view_->Reset(*snapshot->snapshot));
    }
  }
  v1::SubscribeResponse response = ToSubscribeResponse(event, spec_.parts, spec_.numbering);
  if (view_) {
    for (const std::int32_t tag : view_->AbsentTags()) response.add_absent_region_tags(tag);
  }
  std::vector<v1::SubscribeResponse> messages;
  for (v1::BlobChunk& chunk : TakeLargeArrays(response, last_blob_id_)) {
    v1::SubscribeResponse& message = messages.emplace_back();
    message.set_revision(response.revision());
    *message.mutable_chunk() = std::move(chunk);
  }
  messages.push_back(std::move(response));
  const std::lock_guard lock(mutex_);
  converting_ = false;
  if (!end_) {
    messages_ = std::move(messages);
    next_ = 0;
    revision_ = static_cast<std::int64_t>(event.revision);
  }
  Pump();
}

// --- Below mutex_ -------------------------------------------------------------------------------

void SubscribeStream::End(grpc::Status status) {
  if (!end_) end_ = std::move(status);
}

// Starts whatever can be started now.
void SubscribeStream::Pump() {
  if (finished_ || writing_ || converting_) return;
  if (next_ > 0 && next_ <= messages_.size()) messages_[next_ - 1].Clear();  // It is sent.
  if (next_ < messages_.size()) {
    writing_ = true;
    is_quiet_ = false;
    // As in EditStream::Pump.
    grpc::WriteOptions options;
    if (next_ + 1 < messages_.size()) options.set_buffer_hint();
    StartWrite(&messages_[next_++], options);
    return;
  }
  messages_.clear();
  next_ = 0;
  if (last_word_) {
    messages_.push_back(*std::exchange(last_word_, std::nullopt));
    return Pump();
  }
  if (!end_) return;
  finished_ = true;
  Finish(*end_);
}

void SubscribeStream::SetAlarm() {
  if (end_ || finished_) return;
  is_quiet_ = true;
  alarm_ = std::make_shared<grpc::Alarm>();
  // The alarm must not keep a call alive whose client has gone.
  alarm_->Set(std::chrono::system_clock::now() + environment_.bookmark_interval,
              [weak = weak_from_this()](bool rang) {
                if (!rang) return;
                if (const auto self = weak.lock()) self->OnAlarm();
              });
}

void SubscribeStream::OnAlarm() {
  const std::lock_guard lock(mutex_);
  if (end_ || finished_) return;
  if (is_quiet_ && messages_.empty() && !converting_) {
    v1::SubscribeResponse& message = messages_.emplace_back();
    message.set_revision(revision_);
    message.mutable_bookmark();
    Pump();
  }
  SetAlarm();
}

}  // namespace pliant::server
