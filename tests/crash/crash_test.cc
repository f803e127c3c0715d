// Goal: an acknowledged revision survives kill -9, whenever it comes.
// Method: a real pliantd with a store serves three editors and a reader; it is killed, by SIGKILL
// at random moments or by itself inside a random write or synchronisation (disk_fault), and started
// again. Clients check at every reconnection that nothing that was acknowledged to them is lost.
// Afterwards the whole history of each session, one state hash for each revision, must be that of a
// server that was never killed.
//
// PLIANT_KILLS=10000 PLIANT_SEED=7 crash_tests replays another campaign.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <random>
#include <thread>

#include "server/store/maintenance.h"
#include "tests/crash/crash_client.h"
#include "tests/support/temporary_folder.h"

namespace pliant::test {
namespace {

std::int64_t NumberFrom(const char* name, std::int64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::atoll(text);
}

// A pliantd that can be killed and started again.
class KillableServer {
 public:
  KillableServer(std::string socket, std::string data)
      : socket_(std::move(socket)), data_(std::move(data)) {}
  ~KillableServer() {
    if (process_ > 0) Kill();
  }

  /// @param fault_at  the write or synchronisation in which it dies; 0: none
  void Start(std::int64_t fault_at) {
    std::vector<std::string> arguments = {
        PLIANTD, "--listen",    "unix:" + socket_, "--data",     data_, "--workers",
        "2",     "--log-level", "error",           "--drain-ms", "100"};
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    std::vector<std::string> variables;
    for (char** variable = environ; *variable != nullptr; ++variable) {
      variables.emplace_back(*variable);
    }
    if (fault_at > 0) {
      variables.push_back(std::string("LD_PRELOAD=") + DISK_FAULT);
      variables.push_back("PLIANT_FAULT_AT=" + std::to_string(fault_at));
    }
    std::vector<char*> envp;
    for (std::string& variable : variables) envp.push_back(variable.data());
    envp.push_back(nullptr);
    unlink(socket_.c_str());
    ASSERT_EQ(posix_spawn(&process_, PLIANTD, nullptr, nullptr, argv.data(), envp.data()), 0);
  }

  /// True if it has died already, by itself.
  bool Kill() {
    const bool was_dead = waitpid(process_, nullptr, WNOHANG) == process_;
    if (!was_dead) {
      kill(process_, SIGKILL);
      waitpid(process_, nullptr, 0);
    }
    process_ = 0;
    return was_dead;
  }
  [[nodiscard]] bool IsDead() {
    siginfo_t info{};
    return waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           info.si_pid == process_;
  }

 private:
  const std::string socket_;
  const std::string data_;
  pid_t process_ = 0;
};

// The history of a session whose server is left in peace.
std::map<std::int64_t, std::uint64_t> UndisturbedHashes(const std::string& folder,
                                                        std::uint64_t seed,
                                                        std::int64_t update_count) {
  const std::string socket = folder + "/undisturbed";
  KillableServer server(socket, "none");
  server.Start(0);
  Faults faults;
  CrashEditor editor("unix:" + socket, "twin", seed, faults);
  const std::atomic<bool> stop = false;
  editor.Create(stop);
  editor.Run(stop, update_count);
  EXPECT_THAT(faults.all(), testing::IsEmpty());
  return editor.hashes();
}

struct Tally {
  int kills = 0;
  int kills_in_writes = 0;
};

// Kills the server when it has answered, or tried to, for a random while.
Tally KillAgainAndAgain(KillableServer& server, std::int64_t kills, std::mt19937_64& rng,
                        const Faults& faults) {
  Tally tally;
  std::mutex mutex;
  std::condition_variable never;
  for (std::int64_t i = 0; i < kills && !faults.any(); ++i) {
    const bool in_write = rng() % 2 == 0;
    server.Start(in_write ? 1 + static_cast<std::int64_t>(rng() % 120) : 0);
    // From the moment when it starts, its recovery included.
    const auto moment =
        std::chrono::steady_clock::now() + std::chrono::milliseconds(40 + rng() % 160);
    std::unique_lock lock(mutex);
    if (in_write) {
      // It dies by itself, unless nobody lets it write so much.
      never.wait_until(lock, moment + std::chrono::milliseconds(300),
                       [&] { return server.IsDead(); });
      while (!server.IsDead() &&
             std::chrono::steady_clock::now() < moment + std::chrono::milliseconds(300)) {
        never.wait_for(lock, std::chrono::milliseconds(5));
      }
    } else {
      while (std::chrono::steady_clock::now() < moment) never.wait_until(lock, moment);
    }
    tally.kills_in_writes += server.Kill() ? 1 : 0;
    ++tally.kills;
  }
  return tally;
}

TEST(Crash, NothingAcknowledgedIsLost) {
  const std::int64_t kills = NumberFrom("PLIANT_KILLS", 200);
  const auto seed = static_cast<std::uint64_t>(NumberFrom("PLIANT_SEED", 1));
  std::cout << "seed " << seed << ": replay with PLIANT_SEED=" << seed << " PLIANT_KILLS=" << kills
            << " crash_tests" << std::endl;
  constexpr int kEditors = 3;
  const TemporaryFolder folder;
  const std::string socket = folder.path() + "/socket";
  const std::string data = folder.path() + "/data";
  KillableServer server(socket, data);
  Faults faults;
  std::atomic<bool> stop = false;
  std::vector<std::unique_ptr<CrashEditor>> editors;
  std::vector<std::thread> threads;
  for (std::uint64_t i = 0; i < kEditors; ++i) {
    editors.push_back(
        std::make_unique<CrashEditor>("unix:" + socket, "e" + std::to_string(i), seed + i, faults));
    threads.emplace_back([&, editor = editors.back().get()] {
      editor->Create(stop);
      editor->Run(stop, INT64_MAX - 1);
    });
  }
  CrashSubscriber reader("unix:" + socket, "e0", faults);
  threads.emplace_back([&] { reader.Run(stop); });

  std::mt19937_64 rng(seed);
  const Tally tally = KillAgainAndAgain(server, kills, rng, faults);
  // In peace, so that everything that was sent is answered.
  server.Start(0);
  stop = true;
  for (std::thread& thread : threads) thread.join();
  server.Kill();

  EXPECT_THAT(faults.all(), testing::IsEmpty());
  std::size_t revisions = 0;
  int streams = 0;
  for (std::uint64_t i = 0; i < kEditors; ++i) {
    const auto& hashes = editors[i]->hashes();
    EXPECT_GT(editors[i]->answered(), kills / 4) << "the clients were hardly served";
    EXPECT_EQ(hashes, UndisturbedHashes(folder.path(), seed + i, editors[i]->answered()))
        << "editor " << i << " has another history than without the crashes";
    revisions += hashes.size();
    streams += editors[i]->streams();
  }
  EXPECT_GT(reader.hashes().size(), 1u);
  for (const auto& [revision, hash] : reader.hashes()) {
    const auto found = editors[0]->hashes().find(revision);
    ASSERT_NE(found, editors[0]->hashes().end()) << "a reader saw what was never acknowledged";
    EXPECT_EQ(found->second, hash) << "at revision " << revision;
  }
  const auto damage = server::CheckStore({.directory = data, .vfs = {}});
  ASSERT_TRUE(damage.ok()) << damage.error().message;
  EXPECT_THAT(*damage, testing::IsEmpty());
  std::cout << tally.kills << " kills, " << tally.kills_in_writes << " of them inside a write; "
            << streams << " streams of " << kEditors << " editors, " << revisions
            << " acknowledged revisions, " << reader.hashes().size() << " seen by the reader\n";
}

}  // namespace
}  // namespace pliant::test
