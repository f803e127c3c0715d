#include "tests/simulation/schedule.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <variant>

namespace pliant::simulation {
namespace {

constexpr int kSteps = 160;
constexpr int kUnansweredMax = 5;
constexpr int kFollowers = 2;
constexpr int kSettleMax = 20'000;

server::EngineInput SmallInput() {
  Domain square;
  square.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  square.segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}};
  server::EngineInput input;
  input.start = std::move(square);
  input.metric.source = SizeMetric{"0.4"};
  return input;
}

// Everything that a repeated answer must say again.
std::string Essence(const v1::EditResponse& response) {
  if (response.has_rejected()) return "rejected " + response.rejected().error().reason();
  if (response.has_advanced()) {
    return "advanced " + std::to_string(response.advanced().revision()) + " " +
           std::to_string(response.advanced().state_hash());
  }
  return "accepted";
}

// As the server's stream gives each command one; here no two say the same.
server::UpdateCommand WithFingerprint(server::UpdateCommand command) {
  command.fingerprint.hash = static_cast<std::uint64_t>(command.update_id);
  if (std::holds_alternative<server::AdvanceSpec>(command.body)) {
    command.fingerprint.kind = server::UpdateKind::kAdvance;
  } else if (std::holds_alternative<server::DiscardUpdate>(command.body)) {
    command.fingerprint.kind = server::UpdateKind::kDiscard;
  } else {
    command.fingerprint.kind = server::UpdateKind::kMetric;
  }
  return command;
}

}  // namespace

Schedule::Schedule(std::uint64_t seed) : rng_(seed), clock_(seed + 1), scheduler_(0, clock_) {
  session_ = std::make_shared<server::Session>(
      server::Session::Environment{.clock = &clock_,
                                   .scheduler = &scheduler_,
                                   .log = &log_,
                                   .factory = server::RemesherFactory(),
                                   .on_broken = [](const std::string&) {},
                                   .visits_per_step = 7,
                                   .history_bytes_max = 1 + rng_.Below(20'000)},
      "s", std::map<std::string, std::string>{});
  session_->Start(SmallInput(), [this](const Status& status) {
    if (!status.ok()) Fail("create: " + status.error().message);
  });
  followers_.resize(kFollowers);
}

Schedule::~Schedule() {
  session_->Close({ErrorCode::kSessionNotFound, "the schedule is over", {}});
  while (scheduler_.RunOne()) {
  }
}

std::string Schedule::Run() {
  for (int step = 0; step < kSteps && wrong_.empty(); ++step) Step();
  if (wrong_.empty()) Settle();
  if (wrong_.empty()) CheckEnd();
  return wrong_;
}

void Schedule::Fail(const std::string& what) {
  if (wrong_.empty()) wrong_ = what;
}

void Schedule::Step() {
  switch (rng_.Below(16)) {
    case 0:
    case 1:
    case 2:
      return ClientActs();
    case 3:
    case 4:
    case 5:
      return ServerReceives();
    case 6:
    case 7:
    case 8:
      return ClientReceives();
    case 9:
    case 10:
    case 11:
      scheduler_.RunOne();
      return;
    case 12:
      if (rng_.Below(3) == 0) LoseConnection();
      return;
    case 13:
      return ServerNotices();
    case 14:
      session_->CancelAdvance(last_update_id_);
      return;
    default:
      return FollowerActs(followers_[rng_.Below(followers_.size())]);
  }
}

// --- The editing client
// ---------------------------------------------------------------------------

void Schedule::ClientActs() {
  if (link_ == nullptr) return Connect();
  if (!is_open_ || unanswered_.size() >= kUnansweredMax) return;
  Update update{RandomUpdate(), 1};
  link_->up.emplace_back(update.command);
  unanswered_.emplace(update.command.update_id, std::move(update));
}

void Schedule::Connect() {
  link_ = std::make_shared<EditLink>(1 + rng_.Below(6));
  is_open_ = false;
  link_->up.emplace_back(server::OpenCommand{.mirror_revision = Revision(mirror_.revision)});
}

void Schedule::SendAgain() {
  for (auto& [id, update] : unanswered_) {
    link_->up.emplace_back(update.command);
    if (++update.times_sent > 1) ++tally_.repeats;
  }
}

server::UpdateCommand Schedule::RandomUpdate() {
  server::UpdateCommand command{.update_id = ++last_update_id_, .body = server::DiscardUpdate{}};
  const std::uint64_t kind = rng_.Below(10);
  if (kind < 5) {
    server::AdvanceSpec spec;
    if (rng_.Below(2) == 0) spec.visits_max = 1 + static_cast<std::int64_t>(rng_.Below(60));
    if (rng_.Below(3) == 0) spec.time_max = std::chrono::milliseconds(1 + rng_.Below(3));
    if (rng_.Below(3) == 0) spec.commit_interval = std::chrono::milliseconds(1);
    command.body = spec;
  } else if (kind < 7) {
    server::MetricUpdate update;
    update.source = SizeMetric{rng_.Below(6) == 0 ? "-1" : std::to_string(rng_.Uniform(0.2, 0.6))};
    command.body = std::move(update);
  } else if (kind < 9) {
    server::MetricUpdate update;
    server::VertexTensors tensors{.revision = Revision(mirror_.revision)};
    tensors.tensors.assign(mirror_.vertices.size(), Metric::Isotropic(rng_.Uniform(0.2, 0.6)));
    update.source = std::move(tensors);
    command.body = std::move(update);
  }
  return WithFingerprint(std::move(command));
}

void Schedule::ClientReceives() {
  if (link_ == nullptr) return;
  if (link_->down.empty()) {
    if (link_->is_dead) LoseConnection();
    return;
  }
  const v1::EditResponse response = std::move(link_->down.front());
  link_->down.pop_front();
  session_->Wake();  // There is room for answers again.
  Take(response);
}

void Schedule::Take(const v1::EditResponse& response) {
  if (response.has_opened()) {
    is_open_ = true;
    SendAgain();
  } else if (response.has_diff()) {
    if (response.diff().revision() - response.diff().base_revision() > 1) ++tally_.merged;
    if (const std::string wrong = mirror_.Apply(response.diff()); !wrong.empty()) Fail(wrong);
  } else if (response.has_snapshot()) {
    ++tally_.snapshots;
    if (const std::string wrong = mirror_.Take(response.snapshot()); !wrong.empty()) Fail(wrong);
  } else if (!response.has_progress()) {
    const std::int64_t id = response.update_id();
    const auto [first, is_first] = answers_.emplace(id, Essence(response));
    if (!is_first && first->second != Essence(response)) {
      Fail("update " + std::to_string(id) + " was answered with '" + first->second +
           "' and then with '" + Essence(response) + "'");
    }
    if (is_first) {
      tally_.rejections += response.has_rejected();
      tally_.advances += response.has_advanced();
      if (response.has_advanced()) {
        if (response.advanced().base_revision() != committed_) Fail("an advance is missing");
        committed_ = response.advanced().revision();
      }
      tally_.unfinished += response.advanced().active_count() > 0;
    }
    if (unanswered_.empty() || (is_first && unanswered_.begin()->first != id)) {
      Fail("the answer to update " + std::to_string(id) + " came out of order");
    }
    unanswered_.erase(id);
  }
}

// --- The connection
// -------------------------------------------------------------------------------

void Schedule::ServerReceives() {
  if (link_ == nullptr || link_->is_dead || link_->up.empty()) return;
  server::SessionCommand command = std::move(link_->up.front());
  link_->up.pop_front();
  if (std::holds_alternative<server::OpenCommand>(command) && !session_->Attach(link_).ok()) {
    ++tally_.busy;
    link_ = nullptr;  // Refused: the client will come again.
    return;
  }
  link_->arrived.push_back(std::move(command));
  session_->Wake();
}

// The client notices; the server perhaps later. Whatever was on its way is lost.
void Schedule::LoseConnection() {
  if (link_ == nullptr) return;
  ++tally_.deaths;
  unnoticed_.push_back(std::exchange(link_, nullptr));
  is_open_ = false;
  if (rng_.Below(2) == 0) ServerNotices();
}

void Schedule::ServerNotices() {
  for (const auto& link : std::exchange(unnoticed_, {})) {
    link->is_dead = true;
    session_->Detach(link.get());
  }
  session_->Wake();
}

// --- Subscribers
// ----------------------------------------------------------------------------------

void Schedule::FollowerActs(Follower& follower) {
  if (follower.link == nullptr || follower.link->is_dead) {
    follower.link = std::make_shared<SubscribeLink>();
    if (!session_->Subscribe(follower.link, Revision(follower.mirror.revision)).ok()) {
      follower.link = nullptr;
    }
  } else if (rng_.Below(8) == 0) {
    session_->Unsubscribe(follower.link.get());
    follower.link = nullptr;
  } else {
    FollowerReceives(follower);
  }
}

void Schedule::FollowerReceives(Follower& follower) {
  if (follower.link == nullptr || follower.link->down.empty()) return;
  const v1::SubscribeResponse response = std::move(follower.link->down.front());
  follower.link->down.pop_front();
  session_->WakeForSubscriber();
  std::string wrong;
  if (response.has_diff()) {
    if (response.diff().revision() - response.diff().base_revision() > 1) ++tally_.merged;
    wrong = follower.mirror.Apply(response.diff());
  }
  if (response.has_snapshot()) {
    ++tally_.snapshots;
    wrong = follower.mirror.Take(response.snapshot());
  }
  if (!wrong.empty()) Fail("a subscriber: " + wrong);
}

// --- The end
// --------------------------------------------------------------------------------------

// The network is well from now on: everything must be answered.
void Schedule::Settle() {
  ServerNotices();
  bool is_last_sent = false;
  for (int round = 0; round < kSettleMax && wrong_.empty(); ++round) {
    if (link_ == nullptr) Connect();
    ServerReceives();
    scheduler_.RunOne();
    ClientReceives();
    ServerNotices();
    for (Follower& follower : followers_) {
      if (follower.link == nullptr || follower.link->is_dead) FollowerActs(follower);
      FollowerReceives(follower);
    }
    if (link_ == nullptr || !is_open_ || !unanswered_.empty()) continue;
    if (!is_last_sent) {
      is_last_sent = true;
      Update update{
          WithFingerprint({.update_id = ++last_update_id_, .body = server::DiscardUpdate{}}), 1};
      link_->up.emplace_back(update.command);
      unanswered_.emplace(update.command.update_id, std::move(update));
      continue;
    }
    const bool all_follow = std::all_of(
        followers_.begin(), followers_.end(),
        [this](const Follower& follower) { return follower.mirror.revision == mirror_.revision; });
    if (link_->down.empty() && all_follow) return;
  }
  Fail("the schedule does not settle: " + std::to_string(unanswered_.size()) +
       " updates are without an answer");
}

void Schedule::CheckEnd() {
  const server::SessionInfo info = session_->info();
  const auto revision = static_cast<std::int64_t>(info.revision);
  if (mirror_.revision != revision) Fail("the editor's mirror is not at the last revision");
  if (revision != committed_) {
    Fail("the session is at revision " + std::to_string(revision) + "; its answers said " +
         std::to_string(committed_));
  }
  if (revision == 0) return;
  if (mirror_.Hash() != info.summary->state_hash) Fail("the editor's mirror differs by its hash");
  for (const Follower& follower : followers_) {
    if (follower.mirror.Hash() != info.summary->state_hash) {
      Fail("a subscriber's mirror differs by its hash");
    }
  }
}

}  // namespace pliant::simulation
