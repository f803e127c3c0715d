#include "client/cpp/session.h"

#include <algorithm>
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

/// So many commands are sent before their answers are read; the server reads on only while no more
/// than 64 wait, so that a client which never read would hang.
constexpr std::size_t kAheadMax = 32;

Error NotOpen() {
  return {.code = ErrorCode::kUnavailable,
          .message = "the stream of this session is closed after an earlier error; call Reopen"};
}

// The report of an advance that came in two parts.
AdvanceReport Joined(const AdvanceReport& first, AdvanceReport rest) {
  rest.base_revision = first.base_revision;
  rest.visits += first.visits;
  rest.moves += first.moves;
  rest.insertions += first.insertions;
  rest.deletions += first.deletions;
  rest.swaps += first.swaps;
  rest.cooled_count += first.cooled_count;
  rest.softened_count += first.softened_count;
  if (!rest.motion_fraction) rest.motion_fraction = first.motion_fraction;
  rest.compute_time += first.compute_time;
  rest.elapsed_time += first.elapsed_time;
  return rest;
}

Error StageLost() {
  return {.code = ErrorCode::kUpdateRejected,
          .message =
              "what was staged was lost together with the connection, or another editor "
              "has taken it: send the step again"};
}

Error OutOfOrder(const std::string& what) {
  return {.code = ErrorCode::kProtocolOrder, .message = "the server sent " + what};
}

}  // namespace

Session::Impl::Impl(std::shared_ptr<Connection> connection, std::string session_id, Parts parts)
    : connection_(std::move(connection)),
      session_id_(std::move(session_id)),
      parts_(parts),
      outage_(connection_->options().reconnect_max),
      // One for all streams: pieces that are sent again keep their numbers, and these only grow.
      writer_(std::make_unique<wire::ColumnWriter>([this](v1::BlobChunk chunk) {
        *unanswered_.back().messages.emplace_back().mutable_chunk() = std::move(chunk);
      })) {}

Session::Impl::~Impl() { Close(); }

Status Session::Impl::Open() {
  Close();
  Status status = OpenOnce();
  auto pause = kBusyPause;
  for (int tries = 1; tries < kBusyTries && !status.ok(); ++tries) {
    if (status.error().code != ErrorCode::kSessionBusy) break;
    Wait(pause);
    pause *= 2;
    status = OpenOnce();
  }
  return status;
}

Status Session::Impl::OpenOnce() {
  {
    const std::lock_guard lock(write_mutex_);
    context_ = connection_->NewContext();
    is_ready_ = false;
    stream_ = connection_->Edit(*context_);
  }
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
  while (static_cast<std::int64_t>(replica_.revision()) < response.revision()) {
    PLIANT_ASSIGN_OR_RETURN(const v1::EditResponse next, Read());
    PLIANT_RETURN_IF_ERROR(Follow(next));
  }
  // Others have used numbers after ours: whether what we staged was committed, thrown away or is
  // still there, nobody knows. With the next number they would have refused what came too late.
  const bool is_overtaken = response.opened().last_update_id() > last_update_id_;
  const std::int32_t staged_count = StagedCountAt(response.opened());
  lost_stage_ = response.opened().staged_count() < staged_count ||
                (is_overtaken && (staged_count > 0 || has_rejection_));
  staged_left_ = response.opened().staged_count();
  last_update_id_ = std::max(last_update_id_, response.opened().last_update_id());
  opened_at_ = Outage::Clock::now();
  const std::lock_guard lock(write_mutex_);
  is_ready_ = true;
  return {};
}

// How much must be staged, if the server and everybody else have left the stage alone. One that an
// advance has taken whose answer was lost is not lost.
std::int32_t Session::Impl::StagedCountAt(const v1::Opened& opened) const {
  std::int32_t count = staged_count_;
  for (const Sent& sent : unanswered_) {
    if (sent.id > opened.last_update_id()) break;
    const v1::EditRequest& request = sent.messages.back();
    if (request.has_advance() || request.has_discard()) return 0;
    if (!request.has_rollback()) ++count;
  }
  return count;
}

Status Session::Impl::Reopen() {
  PLIANT_RETURN_IF_ERROR(CheckFree());
  outage_.End();
  Status status = Open();
  while (!status.ok() && status.error().code == ErrorCode::kUnavailable && Pause()) {
    status = Open();
  }
  if (!status.ok()) return status;
  // What was accepted may be gone: lost by the server, or taken by an editor that came in between.
  // Of what was sent ahead nobody knows how much is staged: the step begins anew.
  const bool is_with_advance = answers_ == Answers::kWithAdvance;
  const bool is_half = unanswered_.size() > (is_with_advance ? 0 : 1) ||
                       std::ranges::any_of(unanswered_, &Sent::is_ahead);
  tells_loss_ = tells_loss_ || lost_stage_ || (is_half && !is_with_advance);
  must_discard_ = must_discard_ || is_half || tells_loss_;
  staged_count_ = staged_left_;
  has_rejection_ = false;
  unanswered_.clear();
  refusal_.reset();
  return BeginCall();
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
  if (on_change_) on_change_(last_change_);
  return {};
}

Result<v1::EditResponse> Session::Impl::Call(const MakeRequest& make,
                                             const OnProgress& on_progress) {
  PLIANT_RETURN_IF_ERROR(Send(make));
  PLIANT_RETURN_IF_ERROR(AwaitAllBut(1));
  PLIANT_ASSIGN_OR_RETURN(v1::EditResponse answer, NextAnswer(on_progress));
  if (answer.has_rejected()) return ErrorFromDetail(answer.rejected().error());
  return answer;
}

Status Session::Impl::Send(const MakeRequest& make) {
  if (!is_open()) return NotOpen();
  Sent& sent = unanswered_.emplace_back();
  sent.id = ++last_update_id_;
  v1::EditRequest request = make(*writer_);
  request.set_update_id(sent.id);
  sent.messages.push_back(std::move(request));
  const Status status = Write(sent);
  return status.ok() || status.error().code != ErrorCode::kUnavailable ? status
                                                                       : Repeat(status.error());
}

Status Session::Impl::Write(const Sent& sent) {
  for (const v1::EditRequest& message : sent.messages) PLIANT_RETURN_IF_ERROR(Write(message));
  return {};
}

bool Session::Impl::Pause() {
  const std::optional<std::chrono::milliseconds> pause = outage_.NextPause();
  if (!pause) return false;
  Wait(*pause);
  connection_->LookForServer(outage_.end(), [this] { return is_cancelled(); });
  return !is_cancelled();
}

void Session::Impl::Wait(std::chrono::milliseconds time) {
  std::unique_lock lock(write_mutex_);
  connection_->Wait(lock, cancelled_, time, [this] { return is_cancelled_; });
}

bool Session::Impl::is_cancelled() {
  const std::lock_guard lock(write_mutex_);
  return is_cancelled_;
}

Status Session::Impl::Repeat(Error lost) {
  // A server that commands kill again and again is given up; one that is lost long after the last
  // time is not.
  if (Outage::Clock::now() - opened_at_ > outage_.bound()) outage_.End();
  while (Pause()) {
    Status status = RepeatOnce();
    if (status.ok() || status.error().code != ErrorCode::kUnavailable) return status;
    lost = status.error();
  }
  return lost;
}

// Commands are repeated under their numbers: the server answers what it has seen and applies what
// it has not.
Status Session::Impl::RepeatOnce() {
  PLIANT_RETURN_IF_ERROR(Open());
  if (lost_stage_) {
    unanswered_.clear();
    refusal_.reset();
    staged_count_ = 0;
    has_rejection_ = false;
    must_discard_ = true;
    return StageLost();
  }
  for (const Sent& sent : unanswered_) PLIANT_RETURN_IF_ERROR(Write(sent));
  if (is_cancelled()) Cancel();  // Nothing has been told the server meanwhile.
  return {};
}

Status Session::Impl::AwaitAllBut(std::size_t count) {
  while (unanswered_.size() > count) {
    PLIANT_ASSIGN_OR_RETURN(const v1::EditResponse answer, NextAnswer({}));
    if (answer.has_rejected() && !refusal_) refusal_ = ErrorFromDetail(answer.rejected().error());
  }
  return {};
}

Status Session::Impl::CheckFree() const {
  if (!advances_) return {};
  return Error{.code = ErrorCode::kProtocolOrder,
               .message =
                   "an advance of this session runs, and this is one of its callbacks: Cancel and "
                   "looking at things are possible here; do the rest when it returns"};
}

Status Session::Impl::BeginCall() {
  PLIANT_RETURN_IF_ERROR(CheckFree());
  outage_.End();
  if (!is_open()) return {};
  if (must_discard_) PLIANT_RETURN_IF_ERROR(EmptyStage());
  return std::exchange(tells_loss_, false) ? Status(StageLost()) : Status();
}

Status Session::Impl::Await() {
  if (advances_) return {};
  PLIANT_RETURN_IF_ERROR(BeginCall());
  if (!is_open()) return {};  // Reopen is to tell what has become of it.
  return AwaitAllBut(0);
}

Result<v1::EditResponse> Session::Impl::NextAnswer(const OnProgress& on_progress) {
  Result<v1::EditResponse> answer = ReadAnswer(on_progress);
  while (!answer.ok() && answer.error().code == ErrorCode::kUnavailable) {
    PLIANT_RETURN_IF_ERROR(Repeat(answer.error()));
    answer = ReadAnswer(on_progress);
  }
  outage_.End();
  return answer;
}

Result<v1::EditResponse> Session::Impl::ReadAnswer(const OnProgress& on_progress) {
  while (true) {
    PLIANT_ASSIGN_OR_RETURN(v1::EditResponse response, Read());
    PLIANT_RETURN_IF_ERROR(Follow(response));
    if (response.update_id() != unanswered_.front().id) continue;
    if (response.has_progress() && on_progress) on_progress(FromWire(response.progress()));
    if (!response.has_accepted() && !response.has_advanced() && !response.has_rejected()) continue;
    unanswered_.pop_front();
    if (response.has_accepted()) staged_count_ = response.accepted().staged_count();
    has_rejection_ = has_rejection_ || response.has_rejected();
    return response;
  }
}

Status Session::Impl::Update(const MakeRequest& make) {
  PLIANT_RETURN_IF_ERROR(BeginCall());
  if (answers_ == Answers::kAtOnce) {
    const Result<v1::EditResponse> answer = Call(make, {});
    return answer.ok() ? Status() : Status(answer.error());
  }
  PLIANT_RETURN_IF_ERROR(Send(make));
  unanswered_.back().is_ahead = true;
  return AwaitAllBut(kAheadMax);
}

Status Session::Impl::Discard() {
  PLIANT_RETURN_IF_ERROR(CheckFree());
  outage_.End();
  PLIANT_RETURN_IF_ERROR(EmptyStage());
  tells_loss_ = false;
  return {};
}

Status Session::Impl::EmptyStage() {
  const auto make = [](wire::ColumnWriter&) {
    v1::EditRequest request;
    request.mutable_discard();
    return request;
  };
  const Result<v1::EditResponse> answer = Call(make, {});
  if (!answer.ok()) return answer.error();
  refusal_.reset();
  has_rejection_ = must_discard_ = false;
  return {};
}

Result<AdvanceReport> Session::Impl::Rollback(Revision to_revision) {
  const auto make = [&](wire::ColumnWriter&) {
    v1::EditRequest request;
    request.mutable_rollback()->set_to_revision(static_cast<std::int64_t>(to_revision));
    return request;
  };
  PLIANT_RETURN_IF_ERROR(BeginCall());
  PLIANT_ASSIGN_OR_RETURN(const v1::EditResponse answer, Call(make, {}));
  return FromWire(answer.advanced());
}

Result<AdvanceReport> Session::Impl::Advance(const AdvanceOptions& options,
                                             const OnProgress& on_progress,
                                             const OnChange& on_change) {
  PLIANT_RETURN_IF_ERROR(BeginCall());
  on_change_ = on_change;
  advances_ = true;
  Result<AdvanceReport> report = AdvanceWithParts(options, on_progress);
  advances_ = false;
  on_change_ = {};
  const std::lock_guard lock(write_mutex_);
  advance_id_ = 0;
  is_cancelled_ = false;
  return report;
}

// An advance, and where the server ends it because it shuts down, the rest of it on the next one.
Result<AdvanceReport> Session::Impl::AdvanceWithParts(const AdvanceOptions& options,
                                                      const OnProgress& on_progress) {
  Result<AdvanceReport> report = AdvanceOnce(options, on_progress);
  const bool until_converged = !options.visits_max && !options.time_max;
  while (report.ok() && report->stop == AdvanceStop::kServerClosing && until_converged) {
    const Result<AdvanceReport> rest = AdvanceOnce(options, on_progress);
    if (rest.ok()) {
      report = Joined(*report, *rest);
    } else if (rest.error().code == ErrorCode::kUnavailable ||
               rest.error().code == ErrorCode::kCancelled) {
      break;  // What is committed is committed.
    } else {
      report = rest;
    }
  }
  return report;
}

Result<AdvanceReport> Session::Impl::AdvanceOnce(const AdvanceOptions& options,
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
    if (is_cancelled_) return Error{.code = ErrorCode::kCancelled, .message = "cancelled"};
    advance_id_ = last_update_id_ + 1;
  }
  const Result<v1::EditResponse> answer = Call(make, on_progress);
  // Whether it committed or was refused: the stage is empty, unless the answer is lost.
  const bool is_staging =
      answer.ok() && answer->advanced().stop_reason() == v1::STOP_REASON_STAGING;
  if (unanswered_.empty() && !is_staging) {
    staged_count_ = 0;
    has_rejection_ = false;
  }
  const std::optional<Error> refusal = std::exchange(refusal_, std::nullopt);
  // Also where the advance is answered: then its number was another one's, and so is that commit.
  if (refusal && (answer.ok() || answer.error().code == ErrorCode::kUpdateRejected)) {
    return *refusal;
  }
  if (!answer.ok()) return answer.error();
  return FromWire(answer->advanced());
}

void Session::Impl::Cancel() {
  const std::lock_guard lock(write_mutex_);
  if (advance_id_ == 0) return;
  is_cancelled_ = true;
  cancelled_.notify_all();
  if (stream_ == nullptr || !is_ready_) return;
  v1::EditRequest request;
  request.mutable_cancel()->set_advance_update_id(advance_id_);
  stream_->Write(request);
}

Session::Session(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Session::~Session() = default;

const std::string& Session::id() const { return impl_->id(); }
const MeshReplica& Session::replica() const { return impl_->replica(); }

Result<AdvanceReport> Session::Advance(
    const AdvanceOptions& options, const std::function<void(const AdvanceProgress&)>& on_progress,
    const std::function<void(const MeshDiff&)>& on_change) {
  return impl_->Advance(options, on_progress, on_change);
}

void Session::Cancel() { impl_->Cancel(); }

void Session::SetAnswers(Answers answers) { impl_->SetAnswers(answers); }

Status Session::Reopen() { return impl_->Reopen(); }

Status Session::Resync() {
  PLIANT_RETURN_IF_ERROR(impl_->CheckFree());
  impl_->ForgetReplica();
  return impl_->Reopen();
}

}  // namespace pliant::client
