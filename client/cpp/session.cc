#include "client/cpp/session.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "client/cpp/convert.h"
#include "client/cpp/grpc_error.h"
#include "client/cpp/session_impl.h"

namespace pliant::client {
namespace {

/// The stream that this client had before may take the server a moment to notice as closed. Eight
/// tries with pauses that double make about a second.
constexpr int kBusyTries = 8;
constexpr std::chrono::milliseconds kBusyPause{4};

Error NotOpen() {
  return {.code = ErrorCode::kUnavailable,
          .message = "the stream of this session is closed after an earlier error; call Reopen"};
}

Error OutOfOrder(const std::string& what) {
  return {.code = ErrorCode::kProtocolOrder, .message = "the server sent " + what};
}

}  // namespace

Session::Impl::Impl(std::shared_ptr<Connection> connection, std::string session_id, Parts parts)
    : connection_(std::move(connection)), session_id_(std::move(session_id)), parts_(parts) {}

Session::Impl::~Impl() { Close(); }

Status Session::Impl::Open() {
  Close();
  Status status = OpenOnce();
  auto pause = kBusyPause;
  for (int tries = 1; tries < kBusyTries && !status.ok(); ++tries) {
    if (status.error().code != ErrorCode::kSessionBusy) break;
    std::this_thread::sleep_for(pause);
    pause *= 2;
    status = OpenOnce();
  }
  return status;
}

Status Session::Impl::OpenOnce() {
  {
    const std::lock_guard lock(write_mutex_);
    context_ = connection_->NewContext();
    stream_ = connection_->sessions().Edit(context_.get());
  }
  // A failed write shows in the next Read, which has the reason.
  writer_ = std::make_unique<wire::ColumnWriter>([this](v1::BlobChunk chunk) {
    v1::EditRequest request;
    *request.mutable_chunk() = std::move(chunk);
    static_cast<void>(Write(request));
  });
  reader_ = std::make_unique<wire::ColumnReader>(kBlobBytesMax);

  v1::EditRequest request;
  v1::OpenEdit& open = *request.mutable_open();
  open.set_session_id(session_id_);
  open.set_mirror_revision(static_cast<std::int64_t>(replica_.revision()));
  if (parts_ != Parts::kMesh) open.add_parts(v1::MESH_PART_METRIC);
  if (parts_ == Parts::kEverything) {
    open.add_parts(v1::MESH_PART_FIELDS);
    open.add_parts(v1::MESH_PART_TRANSFER);
  }
  PLIANT_RETURN_IF_ERROR(Write(request));

  PLIANT_ASSIGN_OR_RETURN(const v1::EditResponse response, Read());
  if (!response.has_opened()) {
    return Abandon(OutOfOrder("something else than `opened` first"));
  }
  last_update_id_ = std::max(last_update_id_, response.opened().last_update_id());
  lost_stage_ = response.opened().staged_count() < staged_count_;
  staged_count_ = response.opened().staged_count();
  while (static_cast<std::int64_t>(replica_.revision()) < response.revision()) {
    PLIANT_ASSIGN_OR_RETURN(const v1::EditResponse next, Read());
    PLIANT_RETURN_IF_ERROR(Follow(next));
  }
  return {};
}

void Session::Impl::Close() {
  const std::lock_guard lock(write_mutex_);
  if (stream_ == nullptr) return;
  stream_->WritesDone();
  // Without this an advance that still runs would be waited for.
  context_->TryCancel();
  static_cast<void>(stream_->Finish());
  stream_.reset();
}

Error Session::Impl::Abandon(Error error) {
  Close();
  return error;
}

Error Session::Impl::FinishError() {
  const std::lock_guard lock(write_mutex_);
  stream_->WritesDone();
  const grpc::Status status = stream_->Finish();
  stream_.reset();
  if (!status.ok()) return CallError(*connection_, status);
  return {.code = ErrorCode::kUnavailable,
          .message = connection_->address() + ": the server has closed the session's stream; " +
                     "call Reopen, or connect again later"};
}

Status Session::Impl::Write(const v1::EditRequest& request) {
  {
    const std::lock_guard lock(write_mutex_);
    if (stream_ == nullptr) return NotOpen();
    if (stream_->Write(request)) return {};
  }
  // What the server had sent before it ended the stream is of no use any more.
  v1::EditResponse unread;
  while (stream_->Read(&unread)) {
  }
  return FinishError();
}

Result<v1::EditResponse> Session::Impl::Read() {
  if (stream_ == nullptr) return NotOpen();
  v1::EditResponse response;
  while (stream_->Read(&response)) {
    if (response.has_closing()) {
      return Abandon(ErrorFromDetail(response.closing().error()));
    }
    if (!response.has_chunk()) return response;
    if (const Status status = reader_->Add(response.chunk()); !status.ok()) {
      return Abandon(status.error());
    }
  }
  return FinishError();
}

Status Session::Impl::Follow(const v1::EditResponse& response) {
  if (!response.has_diff() && !response.has_snapshot()) return {};
  Result<MeshDiff> diff = response.has_diff() ? FromWire(response.diff(), *reader_)
                                              : FromWire(response.snapshot(), *reader_);
  if (!diff.ok()) return Abandon(diff.error());
  const Status status = response.has_diff() ? replica_.Apply(*diff) : replica_.Reset(*diff);
  if (!status.ok()) return Abandon(status.error());
  last_change_ = *std::move(diff);
  return {};
}

// Sends a command and reads up to its answer. Where the connection breaks on the way, it is made
// again, once, and the command is repeated under its number: the server answers what it has seen
// and applies what it has not.
Result<v1::EditResponse> Session::Impl::Call(const MakeRequest& make,
                                             const OnProgress& on_progress) {
  if (!is_open()) return NotOpen();
  const std::int64_t id = ++last_update_id_;
  Result<v1::EditResponse> answer = CallOnce(id, make, on_progress);
  if (answer.ok() || answer.error().code != ErrorCode::kUnavailable) return answer;
  PLIANT_RETURN_IF_ERROR(Open());
  if (lost_stage_) {
    return Error{.code = ErrorCode::kUpdateRejected,
                 .message =
                     "the server has lost what was staged together with the connection: "
                     "send the step again"};
  }
  return CallOnce(id, make, on_progress);
}

Result<v1::EditResponse> Session::Impl::CallOnce(std::int64_t id, const MakeRequest& make,
                                                 const OnProgress& on_progress) {
  v1::EditRequest request = make(*writer_);
  request.set_update_id(id);
  PLIANT_RETURN_IF_ERROR(Write(request));
  while (true) {
    PLIANT_ASSIGN_OR_RETURN(v1::EditResponse response, Read());
    PLIANT_RETURN_IF_ERROR(Follow(response));
    if (response.update_id() != id) continue;
    if (response.has_progress() && on_progress) on_progress(FromWire(response.progress()));
    if (response.has_rejected()) return ErrorFromDetail(response.rejected().error());
    if (response.has_accepted() || response.has_advanced()) return response;
  }
}

Status Session::Impl::Update(const MakeRequest& make) {
  PLIANT_ASSIGN_OR_RETURN(const v1::EditResponse answer, Call(make, {}));
  staged_count_ = answer.accepted().staged_count();
  return {};
}

Result<AdvanceReport> Session::Impl::Rollback(Revision to_revision) {
  const auto make = [&](wire::ColumnWriter&) {
    v1::EditRequest request;
    request.mutable_rollback()->set_to_revision(static_cast<std::int64_t>(to_revision));
    return request;
  };
  PLIANT_ASSIGN_OR_RETURN(const v1::EditResponse answer, Call(make, {}));
  return FromWire(answer.advanced());
}

Result<AdvanceReport> Session::Impl::Advance(const AdvanceOptions& options,
                                             const OnProgress& on_progress) {
  const auto make = [&](wire::ColumnWriter&) {
    v1::EditRequest request;
    *request.mutable_advance() = ToWire(options);
    if (on_progress) {
      request.mutable_advance()->set_progress_interval_ms(options.progress_interval.count());
    }
    return request;
  };
  {
    const std::lock_guard lock(write_mutex_);
    advance_id_ = last_update_id_ + 1;
  }
  const Result<v1::EditResponse> answer = Call(make, on_progress);
  const std::lock_guard lock(write_mutex_);
  advance_id_ = 0;
  // Whether it committed or was refused: the stage is empty, unless the answer is lost.
  if (is_open()) staged_count_ = 0;
  if (!answer.ok()) return answer.error();
  return FromWire(answer->advanced());
}

void Session::Impl::Cancel() {
  const std::lock_guard lock(write_mutex_);
  if (stream_ == nullptr || advance_id_ == 0) return;
  v1::EditRequest request;
  request.mutable_cancel()->set_advance_update_id(advance_id_);
  stream_->Write(request);
}

Session::Session(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Session::~Session() = default;

const std::string& Session::id() const { return impl_->id(); }
const MeshReplica& Session::replica() const { return impl_->replica(); }

Result<AdvanceReport> Session::Advance(
    const AdvanceOptions& options, const std::function<void(const AdvanceProgress&)>& on_progress) {
  return impl_->Advance(options, on_progress);
}

void Session::Cancel() { impl_->Cancel(); }

Status Session::Reopen() { return impl_->Open(); }

Status Session::Resync() {
  impl_->ForgetReplica();
  return impl_->Open();
}

Result<MeshReplica> Session::GetMesh() {
  return impl_->connection().GetMesh(impl_->id(), Parts::kMesh);
}

Result<Quality> Session::GetQuality() { return impl_->connection().GetQuality(impl_->id()); }

}  // namespace pliant::client
