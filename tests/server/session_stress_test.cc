// Goal: no lost wake, no lost or doubled answer and no data race between a session's worker and the
// threads that feed, cancel, read, leave and delete it. Made for the thread sanitizer: gRPC, which
// it cannot see into, is not in it.
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "server/session_registry.h"
#include "tests/support/fake_server_parts.h"

namespace pliant::server {
namespace {

// An editor whose two ends live on different threads, as EditStream's do.
class SharedEditor final : public Editor {
 public:
  std::optional<SessionCommand> NextCommand() override {
    const std::lock_guard lock(mutex_);
    if (commands_.empty() || left_) return std::nullopt;
    SessionCommand command = std::move(commands_.front());
    commands_.pop_front();
    ++taken_;
    return command;
  }
  void LookAhead(const std::function<bool(const SessionCommand&)>& look) const override {
    const std::lock_guard lock(mutex_);
    if (left_) return;
    for (const SessionCommand& command : commands_) {
      if (!look(command)) return;
    }
  }
  [[nodiscard]] bool HasRoom() const override { return true; }
  void CommandDone() override {
    const std::lock_guard lock(mutex_);
    ++done_;
    changed_.notify_all();
  }
  void Send(SessionEvent event) override {
    const std::lock_guard lock(mutex_);
    if (event.update_id == 0 || std::holds_alternative<DiffEvent>(event.body)) return;
    if (!std::holds_alternative<ProgressEvent>(event.body)) ++answers_;
  }
  void Close(const Error&) override {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }

  void Push(SessionCommand command) {
    const std::lock_guard lock(mutex_);
    commands_.push_back(std::move(command));
  }
  /// Waits until everything that was pushed is answered, or the session ended.
  void Settle() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return closed_ || (commands_.empty() && taken_ == done_); });
    // The first command is `open`, which has no answer of its own here.
    EXPECT_TRUE(closed_ || answers_ == done_ - 1) << answers_ << " answers to " << done_;
  }
  /// The client is gone: nothing more is taken.
  void Leave() {
    const std::lock_guard lock(mutex_);
    left_ = true;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<SessionCommand> commands_;
  int taken_ = 0;
  int done_ = 0;
  int answers_ = 0;
  bool closed_ = false;
  bool left_ = false;
};

// What the threads of a test share.
struct World {
  World()
      : scheduler(/*worker_count=*/4, clock),
        registry({.sessions_max = 100, .sessions_per_tenant_max = 100}, /*seed=*/1) {}

  void Create(const std::string& id) {
    const Result<std::string> reserved = registry.Reserve("", id);
    if (!reserved.ok()) return;
    auto script = std::make_shared<FakeEngineScript>();
    script->visits_needed = 20'000;
    script->visits_per_update = 3'000;
    auto session =
        std::make_shared<Session>(Session::Environment{.clock = &clock,
                                                       .scheduler = &scheduler,
                                                       .log = &log,
                                                       .factory = FakeFactory(script),
                                                       .on_broken = [](const std::string&) {},
                                                       .account = accounts.Of("")},
                                  id, std::map<std::string, std::string>());
    session->Start(EngineInput{}, [this, session](const Status& status) {
      if (status.ok()) registry.Publish("", session);
    });
  }

  const SystemClock clock;
  const Log log{LogLevel::kError, LogFormat::kText};
  Scheduler scheduler;
  SessionRegistry registry;
  TenantAccounts accounts{{.vertices_max = 1'000, .compute_percent = 1'000}};
  std::atomic<std::int64_t> next_update_id = 1;
  std::atomic<int> calls_posted = 0;
  std::atomic<int> calls_answered = 0;
};

void Edit(World& world, const std::shared_ptr<Session>& session, std::mt19937_64& rng) {
  const auto editor = std::make_shared<SharedEditor>();
  editor->Push(OpenCommand{});
  if (!session->Attach(editor).ok()) return;
  std::int64_t last = 0;
  for (int i = 0; i < 6; ++i) {
    last = world.next_update_id++;
    if (rng() % 2 == 0) {
      editor->Push(UpdateCommand{last, MetricUpdate{.time = static_cast<double>(i)}});
    } else {
      editor->Push(UpdateCommand{last, AdvanceSpec{}});
    }
    session->Wake();
    if (rng() % 4 == 0) session->CancelAdvance(last);
  }
  if (rng() % 3 == 0) {
    editor->Leave();
  } else {
    editor->Settle();
  }
  session->Detach(editor.get());
}

void Client(World& world, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  for (int i = 0; i < 20; ++i) {
    const std::string id = std::string("s").append(std::to_string(rng() % 20));
    const auto session = world.registry.Find("", id);
    if (!session.ok()) {
      world.Create(id);
      continue;
    }
    switch (rng() % 8) {
      case 0:
        if (const auto removed = world.registry.Remove("", id)) {
          removed->Close({ErrorCode::kSessionNotFound, "deleted"});
        }
        break;
      case 1:
      case 2:
        if ((*session)
                ->Post([&](const Result<const CommittedState*>& state) {
                  EXPECT_TRUE(!state.ok() || !(*state)->engine.Snapshot().vertex_ids.empty());
                  ++world.calls_answered;
                })
                .ok()) {
          ++world.calls_posted;
        }
        break;
      case 3:
        EXPECT_EQ((*session)->info().session_id, id);
        if (rng() % 8 == 0) {
          world.registry.CloseIdle(world.clock.Now(), {ErrorCode::kSessionNotFound, "idle"});
        }
        break;
      default:
        Edit(world, *session, rng);
    }
  }
}

TEST(SessionStress, AnswersEverythingOnceWhateverClientsDo) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    World world;
    for (int i = 0; i < 5; ++i) world.Create(std::string("s").append(std::to_string(i)));
    std::vector<std::thread> clients;
    for (std::uint64_t k = 0; k < 64; ++k) {
      clients.emplace_back([&world, seed, k] { Client(world, 1000 * seed + k); });
    }
    for (std::thread& client : clients) client.join();
    for (const auto& session : world.registry.All()) {
      session->Close({ErrorCode::kSessionNotFound, "the end"});
    }
    while (world.calls_answered < world.calls_posted) std::this_thread::yield();
    world.scheduler.Stop();
    EXPECT_EQ(world.calls_answered, world.calls_posted);
  }
}

}  // namespace
}  // namespace pliant::server
