#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "server/log.h"
#include "server/scheduler.h"
#include "server/session.h"
#include "tests/simulation/simulated_network.h"
#include "tests/support/mirror.h"

namespace pliant::simulation {

/// What happened in one schedule, so that a test can see that it was worth running.
struct Tally {
  std::int64_t advances = 0;
  std::int64_t rejections = 0;
  std::int64_t deaths = 0;
  std::int64_t repeats = 0;
  std::int64_t unfinished = 0;
  std::int64_t merged = 0;
  std::int64_t snapshots = 0;
  std::int64_t busy = 0;
};

/// One session with the real engine, one editing client that keeps to proto/README.md, and some
/// subscribers, in a random order of events: messages arrive or are lost with their connection,
/// readers are slow, updates are sent again, advances are cancelled or run out of time.
class Schedule {
 public:
  explicit Schedule(std::uint64_t seed);
  ~Schedule();

  /// Runs it. @return what was wrong; empty if every mirror is the server's mesh in the end.
  std::string Run();
  [[nodiscard]] const Tally& tally() const { return tally_; }

 private:
  struct Update {
    server::UpdateCommand command;
    int times_sent = 0;
  };
  struct Follower {
    test::Mirror mirror;
    std::shared_ptr<SubscribeLink> link;
  };

  void Step();
  void ClientActs();
  void Connect();
  void SendAgain();
  server::UpdateCommand RandomUpdate();
  void ServerReceives();
  void ClientReceives();
  void Take(const v1::EditResponse& response);
  void LoseConnection();
  void ServerNotices();
  void FollowerActs(Follower& follower);
  void FollowerReceives(Follower& follower);
  void Settle();
  void CheckEnd();
  void Fail(const std::string& what);

  Rng rng_;
  RandomClock clock_;
  server::Log log_{server::LogLevel::kError, server::LogFormat::kText};
  server::Scheduler scheduler_;
  std::shared_ptr<server::Session> session_;

  std::shared_ptr<EditLink> link_;
  bool is_open_ = false;
  std::vector<std::shared_ptr<EditLink>> unnoticed_;  // Dead, but the server does not know.
  test::Mirror mirror_;
  std::int64_t last_update_id_ = 0;
  std::int64_t committed_ = 0;  // The revision that the answers to advances lead to.
  std::map<std::int64_t, Update> unanswered_;
  std::map<std::int64_t, std::string> answers_;  // First answer to each update.
  std::vector<Follower> followers_;
  Tally tally_;
  std::string wrong_;
};

}  // namespace pliant::simulation
