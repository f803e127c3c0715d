#include "tests/simulation/library_editor.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "client/cpp/session_impl.h"
#include "server/stored_form.h"
#include "tests/simulation/simulated_server.h"

namespace pliant::simulation {
namespace {

constexpr int kWaitMax = 20'000;
constexpr int kEventsPerPause = 3;

// An edit stream of the library, on a connection of the schedule.
class SimulatedCall final : public client::EditCall {
 public:
  SimulatedCall(World& world, LibraryEditor& editor)
      : world_(world), editor_(editor), link_(world.Connect()) {}
  ~SimulatedCall() override {
    if (!is_finished_) world_.Leave(link_);
  }
  SimulatedCall(const SimulatedCall&) = delete;
  SimulatedCall& operator=(const SimulatedCall&) = delete;

  bool Write(const v1::EditRequest& request, grpc::WriteOptions) override {
    if (link_->is_lost || link_->end) return false;
    if (request.has_metric()) editor_.Sent(server::FingerprintOf(request).hash);
    link_->up.push_back(request);
    return true;
  }
  bool Read(v1::EditResponse* response) override {
    for (int i = 0; i < kWaitMax; ++i) {
      if (link_->is_lost) return false;
      if (!link_->down.empty()) {
        *response = std::move(link_->down.front());
        link_->down.pop_front();
        link_->place->session->Wake();  // There is room for answers again.
        return true;
      }
      if (link_->end) return false;
      world_.Meanwhile();
    }
    world_.Fail("the client library waits for an answer that never comes");
    return false;
  }
  grpc::Status Finish() override {
    is_finished_ = true;
    const bool was_lost = link_->is_lost;
    if (!was_lost) world_.Leave(link_);
    if (was_lost) return {grpc::StatusCode::UNAVAILABLE, "the cable was pulled"};
    return link_->end.value_or(grpc::Status(grpc::StatusCode::CANCELLED, "cancelled"));
  }
  bool WritesDone() override { return true; }
  void WaitForInitialMetadata() override {}
  bool NextMessageSize(std::uint32_t*) override { return false; }

 private:
  World& world_;
  LibraryEditor& editor_;
  std::shared_ptr<EditLink> link_;
  bool is_finished_ = false;
};

client::ConnectOptions OptionsAtRandom(Rng& rng) {
  client::ConnectOptions options;
  // Who does not try again has to call Reopen.
  if (rng.Below(2) == 0) options.reconnect_max = std::chrono::milliseconds(0);
  return options;
}

class SimulatedConnection final : public client::Connection {
 public:
  SimulatedConnection(World& world, LibraryEditor& editor)
      : Connection(OptionsAtRandom(world.rng())), world_(world), editor_(editor) {}

  std::unique_ptr<client::EditCall> Edit(grpc::ClientContext&) const override {
    return std::make_unique<SimulatedCall>(world_, editor_);
  }
  void Wait(std::unique_lock<std::mutex>& lock, std::condition_variable&, std::chrono::milliseconds,
            const std::function<bool()>&) const override {
    lock.unlock();
    for (int i = 0; i < kEventsPerPause; ++i) world_.Meanwhile();
    lock.lock();
  }
  void LookForServer(std::chrono::steady_clock::time_point,
                     const std::function<bool()>&) const override {}

 private:
  World& world_;
  LibraryEditor& editor_;
};

std::string SizeAtRandom(Rng& rng) {
  return rng.Below(7) == 0 ? "-1" : std::to_string(rng.Uniform(0.2, 0.6));
}

}  // namespace

LibraryEditor::LibraryEditor(World& world) : world_(world) {}
LibraryEditor::~LibraryEditor() = default;

void LibraryEditor::Act() {
  if (waits_) return;
  waits_ = true;
  ActOnce();
  waits_ = false;
}

void LibraryEditor::ActOnce() {
  Rng& rng = world_.rng();
  if (session_ == nullptr) return Open();
  if (is_lost_) return rng.Below(12) == 0 ? Close() : Reopen();
  switch (rng.Below(16)) {
    case 0:
      return rng.Below(2) == 0 ? Close() : Reopen();
    case 1:
      return Discard();
    case 2:
    case 3:
      return Rollback();
    case 4:
      answers_ = rng.Below(2) == 0 ? client::Answers::kAtOnce : client::Answers::kWithAdvance;
      return session_->SetAnswers(answers_);
    case 5:
    case 6:
    case 7:
    case 8:
    case 9:
      return Update();
    default:
      return Advance();
  }
}

void LibraryEditor::Cancel() {
  if (waits_ && session_ != nullptr) session_->Cancel();
}

// --- Streams ------------------------------------------------------------------------------------

void LibraryEditor::Open() {
  std::deque<Place>& places = world_.server().places();
  place_ = &places[world_.rng().Below(places.size())];
  auto impl = std::make_unique<client::Session::Impl>(
      std::make_shared<SimulatedConnection>(world_, *this), place_->id, client::Parts::kMesh);
  const Status status = impl->Open();
  staged_.clear();
  has_refusal_ = is_lost_ = false;
  if (!status.ok()) return Note(status.error());
  session_ = std::make_unique<client::Session>(std::move(impl));
  session_->SetAnswers(answers_);
  CheckReplica();
}

void LibraryEditor::Close() {
  session_.reset();
  is_lost_ = false;
}

void LibraryEditor::Reopen() {
  ++reopen_count_;
  const Status status = session_->Reopen();
  if (!status.ok()) {
    Note(status.error());
    return;
  }
  is_lost_ = false;
  has_refusal_ = false;
  if (answers_ == client::Answers::kWithAdvance) staged_.clear();
  CheckReplica();
}

// --- Commands -----------------------------------------------------------------------------------

void LibraryEditor::Update() {
  const Status status = StageSomething();
  if (status.ok()) {
    staged_.push_back(sent_hash_);
    return;
  }
  const ErrorCode code = status.error().code;
  if (code != ErrorCode::kUnavailable && code != ErrorCode::kUpdateRejected) has_refusal_ = true;
  Note(status.error());
}

Status LibraryEditor::StageSomething() {
  Rng& rng = world_.rng();
  if (rng.Below(3) != 0 || session_->replica().revision() == Revision::kNone) {
    return session_->UpdateMetric(MetricSpec{.source = SizeMetric{SizeAtRandom(rng)}});
  }
  const auto count = static_cast<std::size_t>(session_->replica().summary().vertex_count);
  const std::vector<Metric> tensors(count, Metric::Isotropic(rng.Uniform(0.2, 0.6)));
  return session_->UpdateTensors({}, tensors);
}

void LibraryEditor::Advance() {
  Rng& rng = world_.rng();
  client::AdvanceOptions options;
  if (rng.Below(2) == 0) options.visits_max = 1 + static_cast<std::int64_t>(rng.Below(60));
  if (rng.Below(2) == 0) options.time_max = std::chrono::milliseconds(1 + rng.Below(5) / 3);
  if (rng.Below(3) == 0) options.commit_interval = std::chrono::milliseconds(10);
  const auto report = session_->Advance(options);
  if (report.ok()) {
    CheckCommit(*report);
    // What is on its way to the stage is in the next commit.
    if (report->stop == client::AdvanceStop::kStaging) return;
  } else {
    Note(report.error());
  }
  staged_.clear();
  has_refusal_ = false;
}

void LibraryEditor::Discard() {
  const Status status = session_->Discard();
  if (!status.ok()) Note(status.error());
  // Without an answer it may have come through or not.
  staged_.clear();
  has_refusal_ = false;
}

void LibraryEditor::Rollback() {
  const auto revision = static_cast<std::uint64_t>(session_->replica().revision());
  if (revision == 0) return;
  const auto to = Revision(static_cast<std::int64_t>(1 + world_.rng().Below(revision)));
  const auto report = session_->Rollback(to);
  if (!report.ok()) return Note(report.error());
  CheckReplica();
}

void LibraryEditor::Note(const Error& error) {
  switch (error.code) {
    case ErrorCode::kUnavailable:
    case ErrorCode::kSessionBusy:
      is_lost_ = true;
      return;
    case ErrorCode::kUpdateRejected:
      // The step is to be sent again.
      staged_.clear();
      has_refusal_ = is_lost_ = false;
      ++refusal_count_;
      return;
    case ErrorCode::kProtocolOrder:
    case ErrorCode::kRevisionMismatch:
    case ErrorCode::kRevisionNotFound:
    case ErrorCode::kExpressionValue:
    case ErrorCode::kCancelled:
      ++refusal_count_;
      return;
    default:
      world_.Fail("the client library says " + std::string(ErrorCodeName(error.code)) + ": " +
                  error.message);
  }
}

// --- What must hold -----------------------------------------------------------------------------

void LibraryEditor::CheckCommit(const client::AdvanceReport& report) {
  if (report.stop == client::AdvanceStop::kStaging) return CheckReplica();
  ++commit_count_;
  const auto revision = static_cast<std::int64_t>(report.revision);
  if (has_refusal_) {
    world_.Fail(test::Broken(test::kAtomic, "revision " + test::Text(revision) +
                                                " has a step of which a part was refused"));
  }
  for (const std::uint64_t update : staged_) {
    if (place_->ledger.WasCommitted(update, revision)) continue;
    world_.Fail(test::Broken(
        test::kAtomic, "revision " + test::Text(revision) + " is without an update of its step"));
  }
  CheckReplica();
}

void LibraryEditor::CheckReplica() {
  const client::MeshReplica& replica = session_->replica();
  if (replica.revision() == Revision::kNone) return;
  if (!place_->ledger.MayHave(static_cast<std::int64_t>(replica.revision()),
                              replica.summary().state_hash)) {
    world_.Fail(test::Broken(test::kComplete, "the library's replica differs by its hash"));
  }
}

bool LibraryEditor::Finish() {
  if (session_ == nullptr) return true;
  session_->SetAnswers(client::Answers::kAtOnce);
  if (is_lost_) Reopen();
  if (is_lost_) return false;
  Discard();
  const auto report = session_->Advance();
  if (!report.ok()) {
    Note(report.error());
    return false;
  }
  const server::SessionInfo info = place_->session->info();
  if (session_->replica().revision() != info.revision ||
      session_->replica().summary().state_hash != info.summary->state_hash) {
    world_.Fail(test::Broken(test::kComplete, "the library's replica is not the server's mesh"));
  }
  Close();
  return true;
}

}  // namespace pliant::simulation
