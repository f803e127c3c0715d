#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "tests/simulation/imitated_editor.h"
#include "tests/simulation/library_editor.h"
#include "tests/simulation/simulated_network.h"
#include "tests/simulation/simulated_server.h"
#include "tests/simulation/world.h"
#include "tests/support/mirror.h"

namespace pliant::simulation {

/// What happened in one schedule, so that a test can see that it was worth running.
struct Tally {
  std::int64_t commits = 0;     ///< That the client library was told of.
  std::int64_t refusals = 0;    ///< The same.
  std::int64_t reopens = 0;     ///< By hand, after the library had given up.
  std::int64_t deaths = 0;      ///< Of connections.
  std::int64_t repeats = 0;     ///< Commands that were answered again.
  std::int64_t collisions = 0;  ///< Commands under a number that another one had used.
  std::int64_t rollbacks = 0;
  std::int64_t put_off = 0;  ///< Advances that were due while updates were being staged.
  std::int64_t saved = 0;
  std::int64_t forks = 0;
  std::int64_t unfinished = 0;
  std::int64_t merged = 0;
  std::int64_t snapshots = 0;
  std::int64_t busy = 0;

  void Add(const Tally& other);
};

/// Sessions with the real engine on one server; editors that compete for them, two by the client
/// library itself and one that keeps to proto/README.md alone; callers that roll back, save,
/// release and fork; subscribers. All in a random order of events: messages arrive or are lost with
/// their connection, readers are slow, updates are sent again, advances are cancelled or run out
/// of time.
class Schedule final : public World {
 public:
  explicit Schedule(std::uint64_t seed);
  ~Schedule() override;
  Schedule(const Schedule&) = delete;
  Schedule& operator=(const Schedule&) = delete;

  /// Runs it. @return what was wrong; empty if every mirror is the server's mesh in the end.
  std::string Run();
  [[nodiscard]] Tally tally();

  std::shared_ptr<EditLink> Connect() override;
  void Leave(const std::shared_ptr<EditLink>& link) override;
  void Meanwhile() override;
  [[nodiscard]] bool is_settling() const override { return is_settling_; }
  [[nodiscard]] Rng& rng() override { return rng_; }
  [[nodiscard]] SimulatedServer& server() override { return server_; }
  void Fail(const std::string& what) override;

 private:
  struct Follower {
    test::Mirror mirror = {};
    Place* place = nullptr;
    std::shared_ptr<SubscribeLink> link = {};
  };

  void Happens();
  void Deliver();
  void LoseConnection();
  void ServerNotices();
  void SomebodyCalls();
  void FollowerActs(Follower& follower);
  void FollowerReceives(Follower& follower);
  void Settle();
  [[nodiscard]] bool AllFollow();
  void CheckEnd();
  void Count(const LibraryEditor& editor);

  Rng rng_;
  SimulatedServer server_;
  std::vector<std::shared_ptr<EditLink>> links_;      // That clients use.
  std::vector<std::shared_ptr<EditLink>> unnoticed_;  // Dead, but the server does not know.
  ImitatedEditor imitation_;
  std::vector<std::unique_ptr<LibraryEditor>> library_;
  std::vector<Follower> followers_;
  int event_count_ = 0;
  bool is_settling_ = false;
  Tally tally_;
  std::string wrong_;
};

}  // namespace pliant::simulation
