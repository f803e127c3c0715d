#include "tests/crash/crash_client.h"

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <utility>

#include "tests/support/wire_arrays.h"

namespace pliant::test {
namespace {

// Updates that an editor has under way.
constexpr std::size_t kUnderWay = 4;

std::uint64_t Mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

}  // namespace

v1::EditRequest CrashScript::Next() {
  v1::EditRequest request;
  const std::int64_t id = ++update_id_;
  request.set_update_id(id);
  const std::uint64_t random = Mix(seed_ * 1'000'003 + static_cast<std::uint64_t>(id));
  const std::string number = std::to_string(0.08 + 0.001 * static_cast<double>(random % 40));
  switch (id % 8) {
    case 1:
    case 3:
    case 4:
      request.mutable_metric()->add_sources()->mutable_size()->set_size(
          number + (random % 2 == 0 ? " + 0.1*x" : " + 0.1*y"));
      return request;
    case 6:
      // Not converged: the loop's own state has to survive too.
      request.mutable_advance()->set_budget_visits(100);
      break;
    case 0:
      request.mutable_rollback()->set_to_revision(commits_ - 1);
      break;
    default:
      request.mutable_advance();
  }
  ++commits_;
  return request;
}

void Faults::Add(const std::string& sentence) {
  const std::lock_guard lock(mutex_);
  if (++count_ <= 10) sentences_.push_back(sentence);
}

std::vector<std::string> Faults::all() const {
  const std::lock_guard lock(mutex_);
  return sentences_;
}

std::shared_ptr<grpc::Channel> Connect(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 10);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 10);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 20);
  auto channel = grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
  if (!channel->WaitForConnected(std::chrono::system_clock::now() + std::chrono::seconds(1))) {
    return nullptr;
  }
  return channel;
}

// --- The editor ---------------------------------------------------------------------------------

void CrashEditor::Create(const std::atomic<bool>& stop, v1::Durability durability) {
  while (!stop) {
    const auto channel = Connect(address_);
    if (channel == nullptr) continue;
    const auto stub = v1::SessionService::NewStub(channel);
    grpc::ClientContext context;
    v1::CreateSessionResponse response;
    const auto writer = stub->CreateSession(&context, &response);
    v1::CreateSessionRequest request;
    *request.mutable_create() = UnitSquare("0.15");
    request.mutable_create()->set_session_id(session_id_);
    request.mutable_create()->mutable_options()->set_durability(durability);
    writer->Write(request);
    writer->WritesDone();
    const grpc::Status status = writer->Finish();
    if (status.ok() || status.error_code() == grpc::StatusCode::ALREADY_EXISTS) return;
    if (status.error_code() != grpc::StatusCode::UNAVAILABLE) Fault(status.error_message());
  }
}

void CrashEditor::Run(const std::atomic<bool>& stop, std::int64_t updates_max) {
  while (!faults_.any() && sent_ < updates_max + 1 && (!stop || !unanswered_.empty())) {
    RunStream(stop, updates_max);
    if (answered_ >= updates_max) return;
  }
}

void CrashEditor::RunStream(const std::atomic<bool>& stop, std::int64_t updates_max) {
  const auto channel = Connect(address_);
  if (channel == nullptr) return;
  ++streams_;
  const auto stub = v1::SessionService::NewStub(channel);
  grpc::ClientContext context;
  const auto stream = stub->Edit(&context);
  v1::EditRequest open;
  open.mutable_open()->set_session_id(session_id_);
  open.mutable_open()->set_mirror_revision(mirror_.revision);
  bool alive = stream->Write(open);
  for (const v1::EditRequest& request : unanswered_) alive = alive && stream->Write(request);
  server::BlobAssembler blobs;
  v1::EditResponse response;
  while (alive && !faults_.any()) {
    while (alive && unanswered_.size() < kUnderWay && !stop && sent_ < updates_max) {
      ++sent_;
      unanswered_.push_back(script_.Next());
      alive = stream->Write(unanswered_.back());
    }
    if (unanswered_.empty()) break;
    alive = stream->Read(&response);
    if (!alive) break;
    if (response.has_chunk()) {
      if (!blobs.Add(response.chunk()).ok()) Fault("a chunk does not fit");
      continue;
    }
    if (!blobs.Resolve(response).ok()) Fault("a blob is missing");
    if (response.has_opened()) TakeOpened(response);
    if (response.has_diff() || response.has_snapshot()) TakeMesh(response);
    if (response.has_accepted() || response.has_rejected() || response.has_advanced()) {
      TakeAnswer(response);
    }
  }
  if (unanswered_.empty()) stream->WritesDone();
  // A stream that the server has ended is not cancelled: that would hide why.
  if (alive) context.TryCancel();
  while (stream->Read(&response)) {
  }
  const grpc::Status status = stream->Finish();
  // A killed server looks like that; anything else is a refusal.
  if (status.error_code() != grpc::StatusCode::UNAVAILABLE &&
      status.error_code() != grpc::StatusCode::CANCELLED &&
      status.error_code() != grpc::StatusCode::ABORTED && !status.ok()) {
    Fault("the stream ended: " + status.error_message());
  }
}

void CrashEditor::TakeOpened(const v1::EditResponse& response) {
  if (response.opened().last_update_id() < answered_) {
    Fault("update " + std::to_string(answered_) + " was answered, but the last that the server " +
          "knows is " + std::to_string(response.opened().last_update_id()));
  }
  if (response.revision() < mirror_.revision) {
    Fault("revision " + std::to_string(mirror_.revision) + " was acknowledged and is lost; the " +
          "server is at " + std::to_string(response.revision()));
  }
}

void CrashEditor::TakeMesh(const v1::EditResponse& response) {
  const std::string wrong =
      response.has_diff() ? mirror_.Apply(response.diff()) : mirror_.Take(response.snapshot());
  if (!wrong.empty()) Fault("the mirror: " + wrong);
}

void CrashEditor::TakeAnswer(const v1::EditResponse& response) {
  if (unanswered_.empty() || response.update_id() != unanswered_.front().update_id()) {
    return Fault("update " + std::to_string(response.update_id()) + " is answered out of turn");
  }
  unanswered_.pop_front();
  answered_ = response.update_id();
  if (response.has_rejected()) {
    Fault("update " + std::to_string(answered_) +
          " was refused: " + response.rejected().error().message());
  }
  if (!response.has_advanced()) return;
  const v1::AdvanceResult& result = response.advanced();
  const auto [known, is_new] = hashes_.emplace(result.revision(), result.state_hash());
  if (!is_new) Fault("revision " + std::to_string(result.revision()) + " came twice");
  if (result.revision() != static_cast<std::int64_t>(hashes_.size())) {
    Fault("commit " + std::to_string(hashes_.size()) + " made revision " +
          std::to_string(result.revision()) + ": something was applied twice, or lost");
  }
}

void CrashEditor::Fault(const std::string& what) { faults_.Add(session_id_ + ": " + what); }

// --- The reader ---------------------------------------------------------------------------------

void CrashSubscriber::Run(const std::atomic<bool>& stop) {
  while (!stop && !faults_.any()) RunStream(stop);
}

void CrashSubscriber::RunStream(const std::atomic<bool>& stop) {
  const auto channel = Connect(address_);
  if (channel == nullptr) return;
  const auto stub = v1::SessionService::NewStub(channel);
  grpc::ClientContext context;
  v1::SubscribeRequest request;
  request.set_session_id(session_id_);
  request.set_mirror_revision(mirror_.revision);
  const auto stream = stub->Subscribe(&context, request);
  server::BlobAssembler blobs;
  v1::SubscribeResponse response;
  while (!stop && stream->Read(&response)) {
    if (response.has_chunk()) {
      if (!blobs.Add(response.chunk()).ok()) faults_.Add("reader: a chunk does not fit");
      continue;
    }
    if (!blobs.Resolve(response).ok()) faults_.Add("reader: a blob is missing");
    const std::int64_t before = mirror_.revision;
    std::string wrong;
    if (response.has_diff()) wrong = mirror_.Apply(response.diff());
    if (response.has_snapshot()) wrong = mirror_.Take(response.snapshot());
    if (!wrong.empty()) faults_.Add("reader: " + wrong);
    if (response.revision() < before || mirror_.revision < before) {
      faults_.Add("reader: had revision " + std::to_string(before) + " and is told of " +
                  std::to_string(response.revision()));
    }
    if (mirror_.revision > 0) hashes_[mirror_.revision] = mirror_.Hash();
  }
  context.TryCancel();
  while (stream->Read(&response)) {
  }
  static_cast<void>(stream->Finish());
}

}  // namespace pliant::test
