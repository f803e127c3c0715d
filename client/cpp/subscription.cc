#include "client/cpp/subscription.h"

#include <utility>

#include "client/cpp/convert.h"
#include "client/cpp/grpc_error.h"
#include "client/cpp/subscription_impl.h"

namespace pliant::client {

Subscription::Impl::~Impl() {
  if (stream_ == nullptr) return;
  context_->TryCancel();
  static_cast<void>(stream_->Finish());
}

void Subscription::Impl::Connect() {
  v1::SubscribeRequest request;
  request.set_session_id(session_id_);
  request.set_mirror_revision(static_cast<std::int64_t>(replica_.revision()));
  if (options_.parts != Parts::kMesh) request.add_parts(v1::MESH_PART_METRIC);
  if (options_.follow == Follow::kVertices) request.set_mirror_mode(v1::MIRROR_MODE_POSITIONS);
  for (const std::int32_t tag : options_.region_tags) request.add_region_tags(tag);
  reader_ = std::make_unique<wire::ColumnReader>(kBlobBytesMax);
  const std::lock_guard lock(mutex_);
  context_ = connection_->NewContext();
  if (is_cancelled_) context_->TryCancel();
  stream_ = connection_->sessions().Subscribe(context_.get(), request);
}

Result<MeshDiff> Subscription::Impl::Next() {
  Outage outage(options_.reconnect_max);
  for (;;) {
    if (stream_ == nullptr) Connect();
    v1::SubscribeResponse response;
    while (stream_->Read(&response)) {
      if (response.has_diff() || response.has_snapshot()) return Follow(response);
      if (response.has_chunk()) PLIANT_RETURN_IF_ERROR(reader_->Add(response.chunk()));
      // A first message, if only a bookmark, means that the server is there again.
      outage.End();
    }
    const Error error = End();
    if (is_cancelled()) {
      return Error{.code = ErrorCode::kCancelled, .message = "the subscription was cancelled"};
    }
    if (error.code != ErrorCode::kUnavailable) return error;
    const std::optional<std::chrono::milliseconds> pause = outage.NextPause();
    if (!pause) return error;
    if (Pause(*pause)) {
      connection_->LookForServer(outage.end(), [this] { return is_cancelled(); });
    }
  }
}

Error Subscription::Impl::End() {
  const grpc::Status status = stream_->Finish();
  stream_ = nullptr;
  if (!status.ok()) return CallError(*connection_, status);
  return {.code = ErrorCode::kUnavailable,
          .message = connection_->address() + ": the server has ended the subscription"};
}

bool Subscription::Impl::Pause(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  return !cancelled_.wait_for(lock, time, [this] { return is_cancelled_; });
}

bool Subscription::Impl::is_cancelled() {
  const std::lock_guard lock(mutex_);
  return is_cancelled_;
}

Result<MeshDiff> Subscription::Impl::Follow(const v1::SubscribeResponse& response) {
  PLIANT_ASSIGN_OR_RETURN(MeshDiff diff, response.has_diff()
                                             ? FromWire(response.diff(), *reader_)
                                             : FromWire(response.snapshot(), *reader_));
  const Status status = response.has_diff() ? replica_.Apply(diff) : replica_.Reset(diff);
  absent_region_tags_.assign(response.absent_region_tags().begin(),
                             response.absent_region_tags().end());
  if (status.ok()) return diff;
  // What follows would not fit either: the whole mesh comes next.
  replica_ = {};
  context_->TryCancel();
  static_cast<void>(stream_->Finish());
  stream_ = nullptr;
  return status.error();
}

void Subscription::Impl::Cancel() {
  const std::lock_guard lock(mutex_);
  is_cancelled_ = true;
  if (context_ != nullptr) context_->TryCancel();
  cancelled_.notify_all();
}

Subscription::Subscription(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Subscription::~Subscription() = default;

const MeshReplica& Subscription::replica() const { return impl_->replica(); }
const std::vector<std::int32_t>& Subscription::absent_region_tags() const {
  return impl_->absent_region_tags();
}
Result<MeshDiff> Subscription::Next() { return impl_->Next(); }
void Subscription::Cancel() { impl_->Cancel(); }

}  // namespace pliant::client
