#include "tests/simulation/simulated_server.h"

#include <map>
#include <utility>

#include "server/convert.h"
#include "server/stored_form.h"

namespace pliant::simulation {
namespace {

server::EngineInput SmallInput() {
  Domain square;
  square.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  square.segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}};
  server::EngineInput input;
  input.start = std::move(square);
  input.metric.source = SizeMetric{"0.4"};
  return input;
}

// A rollback as the editor would send it.
v1::EditRequest RollbackRequest(std::int64_t to_revision, std::int64_t update_id) {
  v1::EditRequest request;
  request.set_update_id(update_id);
  request.mutable_rollback()->set_to_revision(to_revision);
  return request;
}

}  // namespace

SimulatedServer::SimulatedServer(Rng& rng, std::uint64_t clock_seed)
    : rng_(rng), clock_(clock_seed), scheduler_(0, clock_) {
  Create("a");
  Create("b");
}

SimulatedServer::~SimulatedServer() {
  for (Place& place : places_) {
    place.session->Close({ErrorCode::kSessionNotFound, "the schedule is over", {}});
  }
  while (scheduler_.RunOne()) {
  }
}

std::shared_ptr<server::Session> SimulatedServer::NewSession(const std::string& id) {
  return std::make_shared<server::Session>(
      server::Session::Environment{.clock = &clock_,
                                   .scheduler = &scheduler_,
                                   .log = &log_,
                                   .factory = server::RemesherFactory(),
                                   .on_broken = [](const std::string&) {},
                                   .visits_per_step = 7,
                                   .history_bytes_max = 1 + rng_.Below(20'000)},
      id, std::map<std::string, std::string>{});
}

void SimulatedServer::Create(const std::string& id) {
  Place& place = places_.emplace_back();
  place.id = id;
  place.session = NewSession(id);
  place.session->Start(SmallInput(), [&place](const Status& status) {
    if (!status.ok()) place.ledger.Check("create: " + status.error().message);
  });
}

Place* SimulatedServer::Find(const std::string& session_id) {
  for (Place& place : places_) {
    if (place.id == session_id) return &place;
  }
  return nullptr;
}

std::string SimulatedServer::wrong() const {
  for (const Place& place : places_) {
    if (!place.ledger.wrong().empty()) return "session " + place.id + ": " + place.ledger.wrong();
  }
  return wrong_;
}

// --- Streams ------------------------------------------------------------------------------------

void SimulatedServer::Receive(const std::shared_ptr<EditLink>& link) {
  if (link->is_dead || link->up.empty()) return;
  const v1::EditRequest request = std::move(link->up.front());
  link->up.pop_front();
  if (request.has_open()) return Open(link, request);
  server::Session& session = *link->place->session;
  if (request.has_cancel()) {
    session.CancelAdvance(request.cancel().advance_update_id());
    return;
  }
  server::UpdateCommand command = server::ConvertUpdate(request, {});
  command.fingerprint = server::FingerprintOf(request);
  if (auto* advance = std::get_if<server::AdvanceSpec>(&command.body)) {
    advance->arrival = clock_.Now();
  }
  link->arrived.emplace_back(std::move(command));
  session.Wake();
}

void SimulatedServer::Open(const std::shared_ptr<EditLink>& link, const v1::EditRequest& request) {
  Place* place = Find(request.open().session_id());
  const Result<server::OpenCommand> open = server::ConvertOpen(request.open());
  if (place == nullptr || !open.ok()) {
    wrong_ = "somebody has opened what is not there";
    return;
  }
  link->place = place;
  if (const Status status = place->session->Attach(link); !status.ok()) {
    link->End(server::ToGrpcStatus(status.error()));
    return;
  }
  link->arrived.emplace_back(*open);
  place->session->Wake();
}

void SimulatedServer::Drop(EditLink& link) {
  link.is_dead = true;
  if (link.place == nullptr) return;
  link.place->session->Detach(&link);
  link.place->session->Wake();
}

// --- Calls --------------------------------------------------------------------------------------

void SimulatedServer::RollbackTo(Place& place, std::int64_t to_revision, std::int64_t update_id) {
  const server::Fingerprint update = server::FingerprintOf(RollbackRequest(to_revision, update_id));
  static_cast<void>(place.session->Post([=, &place](const auto& state) {
    if (!state.ok()) return;
    const std::int64_t base = place.ledger.revision();
    const bool is_new = update_id > place.ledger.last_update_id();
    const auto done = (*state)->session->RollbackTo(Revision(to_revision), update_id, update);
    if (!done.ok()) return;  // And takes no number.
    v1::EditResponse response;
    v1::AdvanceResult& advanced = *response.mutable_advanced();
    if (is_new) advanced.set_base_revision(base);
    advanced.set_revision(static_cast<std::int64_t>(done->revision));
    advanced.set_state_hash(done->state_hash);
    place.ledger.Answered({update_id, update, to_revision}, response);
  }));
}

void SimulatedServer::Save(Place& place) {
  static_cast<void>(place.session->Post([this](const auto& state) {
    if (!state.ok() || (*state)->revision == Revision::kNone) return;
    if ((*state)->session->SaveRevision((*state)->revision).ok()) ++saved_count_;
  }));
}

void SimulatedServer::Release(Place& place) {
  static_cast<void>(place.session->Post([&place](const auto& state) {
    if (!state.ok()) return;
    const std::vector<std::int64_t> saved = place.session->info().saved_revisions;
    if (saved.empty()) return;
    const Status released = (*state)->session->Release({saved.front()});
    if (!released.ok()) place.ledger.Check("release: " + released.error().message);
  }));
}

void SimulatedServer::Fork(Place& place) {
  const std::string id = "fork" + std::to_string(++fork_count_);
  static_cast<void>(place.session->Post([this, id, &place](const auto& state) {
    if (!state.ok() || (*state)->revision == Revision::kNone || (*state)->staged_count > 0) return;
    Result<server::SessionMemory> memory = (*state)->session->Fork((*state)->revision);
    if (!memory.ok()) return;  // Something that was to be staged was refused.
    const auto revision = static_cast<std::int64_t>((*state)->revision);
    const std::uint64_t hash = (*state)->summary.state_hash;
    if (memory->summary->state_hash != hash) place.ledger.Check("a fork has another mesh");
    Place& fork = places_.emplace_back();
    fork.id = id;
    fork.ledger.BeginAt(revision, hash);
    fork.session = NewSession(id);
    const auto begin = std::make_shared<server::SessionMemory>(std::move(memory).value());
    fork.session->Start([begin]() -> Result<server::SessionMemory> { return std::move(*begin); },
                        [&fork](const Status& status) {
                          if (!status.ok()) fork.ledger.Check("fork: " + status.error().message);
                        });
  }));
}

}  // namespace pliant::simulation
