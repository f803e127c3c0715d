#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "server/log.h"
#include "server/scheduler.h"
#include "tests/simulation/simulated_network.h"

namespace pliant::simulation {

/// Sessions with the real engine on one scheduler without threads, and what comes between them and
/// the network: streams are opened, messages converted, calls run, as server/session_stream.cc and
/// server/service_revisions.cc do.
class SimulatedServer {
 public:
  SimulatedServer(Rng& rng, std::uint64_t clock_seed);
  ~SimulatedServer();
  SimulatedServer(const SimulatedServer&) = delete;
  SimulatedServer& operator=(const SimulatedServer&) = delete;

  /// The sessions; their addresses stay.
  [[nodiscard]] std::deque<Place>& places() { return places_; }
  [[nodiscard]] Place* Find(const std::string& session_id);

  /// Runs a slice of one session. @return false if none has anything to do
  bool RunOne() { return scheduler_.RunOne(); }
  /// The oldest message of an edit stream arrives.
  void Receive(const std::shared_ptr<EditLink>& link);
  /// The server notices that a stream is dead.
  void Drop(EditLink& link);

  // Calls, answered when the session gets to them.
  void RollbackTo(Place& place, std::int64_t to_revision, std::int64_t update_id);
  void Save(Place& place);
  void Release(Place& place);
  /// A copy of the current revision as another place.
  void Fork(Place& place);

  /// What is wrong; empty: nothing.
  [[nodiscard]] std::string wrong() const;
  [[nodiscard]] std::int64_t saved_count() const { return saved_count_; }

 private:
  [[nodiscard]] std::shared_ptr<server::Session> NewSession(const std::string& id);
  void Create(const std::string& id);
  void Open(const std::shared_ptr<EditLink>& link, const v1::EditRequest& request);

  Rng& rng_;
  RandomClock clock_;
  server::Log log_{server::LogLevel::kError, server::LogFormat::kText};
  server::Scheduler scheduler_;
  std::deque<Place> places_;
  std::int64_t saved_count_ = 0;
  int fork_count_ = 0;
  std::string wrong_;
};

}  // namespace pliant::simulation
