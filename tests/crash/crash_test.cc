// Goal: an acknowledged revision survives kill -9, whenever it comes.
// Method: a real pliantd with a store serves three editors and a reader; it is killed, by SIGKILL
// at random moments or by itself inside a random write or synchronisation (disk_fault), and started
// again. Clients check at every reconnection that nothing that was acknowledged to them is lost.
// Afterwards the whole history of each session, one state hash for each revision, must be that of a
// server that was never killed.
//
// PLIANT_KILLS=10000 PLIANT_SEED=7 crash_tests replays another campaign.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
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

  /// What disk_fault does; at 0: nothing.
  struct Fault {
    const char* kind = "kill";
    std::int64_t at = 0;
  };
  void Start(const Fault& fault) {
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
    if (fault.at > 0) {
      variables.push_back(std::string("LD_PRELOAD=") + DISK_FAULT);
      variables.push_back(std::string("PLIANT_FAULT=") + fault.kind);
      variables.push_back("PLIANT_FAULT_AT=" + std::to_string(fault.at));
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
  /// Asks it to stop, and waits. @return its exit status; -1 if a signal ended it
  int Terminate() {
    kill(process_, SIGTERM);
    int status = 0;
    waitpid(process_, &status, 0);
    process_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
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
  server.Start({});
  Faults faults;
  CrashEditor editor("unix:" + socket, "twin", seed, faults);
  const std::atomic<bool> stop = false;
  editor.Create(stop, v1::DURABILITY_NONE);
  editor.Run(stop, update_count);
  EXPECT_THAT(faults.all(), testing::IsEmpty());
  return editor.hashes();
}

constexpr int kEditors = 3;

/// How a campaign goes, and what is broken on purpose.
struct Plan {
  std::int64_t kills = 200;
  std::uint64_t seed = 1;
  /// What the editors' sessions ask for, who count on STRICT.
  v1::Durability durability = v1::DURABILITY_STRICT;
  /// The disk loses what is written from some moment on.
  bool disk_drops = false;
};

/// What a campaign has found.
struct Campaign {
  explicit Campaign(const Plan& the_plan) : plan(the_plan) {}

  const Plan plan;
  const TemporaryFolder folder;
  const std::string socket = folder.path() + "/socket";
  const std::string data = folder.path() + "/data";
  Faults faults;
  std::vector<std::unique_ptr<CrashEditor>> editors;
  std::unique_ptr<CrashSubscriber> reader;
  int kills = 0;
  int kills_in_writes = 0;
};

// What goes wrong with the disk until the next kill.
KillableServer::Fault NextFault(const Plan& plan, std::mt19937_64& rng) {
  const auto at = 1 + static_cast<std::int64_t>(rng() % 120);
  if (plan.disk_drops) return {"drop", at};
  return {"kill", rng() % 2 == 0 ? at : 0};
}

// Kills the server when it has answered, or tried to, for a random while.
void KillAgainAndAgain(KillableServer& server, Campaign& campaign) {
  std::mt19937_64 rng(campaign.plan.seed);
  std::mutex mutex;
  std::condition_variable never;
  while (campaign.kills < campaign.plan.kills && !campaign.faults.any()) {
    const KillableServer::Fault fault = NextFault(campaign.plan, rng);
    server.Start(fault);
    const bool in_write = fault.at > 0 && !campaign.plan.disk_drops;
    // From the moment when it starts, its recovery included.
    const auto moment =
        std::chrono::steady_clock::now() + std::chrono::milliseconds(40 + rng() % 160);
    std::unique_lock lock(mutex);
    if (in_write) {
      // It dies by itself, unless nobody lets it write so much.
      while (!server.IsDead() &&
             std::chrono::steady_clock::now() < moment + std::chrono::milliseconds(300)) {
        never.wait_for(lock, std::chrono::milliseconds(5));
      }
    } else {
      while (std::chrono::steady_clock::now() < moment) never.wait_until(lock, moment);
    }
    campaign.kills_in_writes += server.Kill() ? 1 : 0;
    ++campaign.kills;
  }
}

// Editors and a reader, and a server that is killed under them, until the plan is done or a fault
// found.
void RunCampaign(Campaign& campaign) {
  const Plan& plan = campaign.plan;
  std::cout << "seed " << plan.seed << ": replay with PLIANT_SEED=" << plan.seed
            << " PLIANT_KILLS=" << plan.kills << " crash_tests" << std::endl;
  const std::string address = "unix:" + campaign.socket;
  KillableServer server(campaign.socket, campaign.data);
  std::atomic<bool> stop = false;
  std::vector<std::thread> threads;
  for (std::uint64_t i = 0; i < kEditors; ++i) {
    campaign.editors.push_back(std::make_unique<CrashEditor>(address, "e" + std::to_string(i),
                                                             plan.seed + i, campaign.faults));
    threads.emplace_back([&, editor = campaign.editors.back().get()] {
      editor->Create(stop, plan.durability);
      editor->Run(stop, INT64_MAX - 1);
    });
  }
  campaign.reader = std::make_unique<CrashSubscriber>(address, "e0", campaign.faults);
  threads.emplace_back([&] { campaign.reader->Run(stop); });
  KillAgainAndAgain(server, campaign);
  // In peace, so that everything that was sent is answered.
  if (!campaign.faults.any()) server.Start({});
  stop = true;
  for (std::thread& thread : threads) thread.join();
}

TEST(Crash, NothingAcknowledgedIsLost) {
  Campaign campaign({.kills = NumberFrom("PLIANT_KILLS", 200),
                     .seed = static_cast<std::uint64_t>(NumberFrom("PLIANT_SEED", 1))});
  RunCampaign(campaign);
  EXPECT_THAT(campaign.faults.all(), testing::IsEmpty());
  std::size_t revisions = 0;
  int streams = 0;
  for (std::uint64_t i = 0; i < kEditors; ++i) {
    const CrashEditor& editor = *campaign.editors[i];
    EXPECT_GT(editor.answered(), campaign.kills / 4) << "the clients were hardly served";
    EXPECT_EQ(editor.hashes(),
              UndisturbedHashes(campaign.folder.path(), campaign.plan.seed + i, editor.answered()))
        << "editor " << i << " has another history than without the crashes";
    revisions += editor.hashes().size();
    streams += editor.streams();
  }
  const auto& acknowledged = campaign.editors[0]->hashes();
  const auto& seen = campaign.reader->hashes();
  EXPECT_GT(seen.size(), 1u);
  for (const auto& [revision, hash] : seen) {
    const auto found = acknowledged.find(revision);
    ASSERT_NE(found, acknowledged.end()) << "a reader saw what was never acknowledged";
    EXPECT_EQ(found->second, hash) << "at revision " << revision;
  }
  const auto damage = server::CheckStore({.directory = campaign.data, .vfs = {}});
  ASSERT_TRUE(damage.ok()) << damage.error().message;
  EXPECT_THAT(*damage, testing::IsEmpty());
  std::cout << campaign.kills << " kills, " << campaign.kills_in_writes
            << " of them inside a write; " << streams << " streams of " << kEditors << " editors, "
            << revisions << " acknowledged revisions, " << seen.size() << " seen by the reader\n";
}

// Goal: the campaign is no idle ceremony: where durability is broken, it fails.
// Method: the same campaign on servers that acknowledge before they commit, and on a disk that says
// it has written what it has not. It ends at the first loss that a client notices.
TEST(CrashCampaign, NoticesThatUpdatesAreAcknowledgedBeforeTheyAreCommitted) {
  Campaign campaign({.seed = static_cast<std::uint64_t>(NumberFrom("PLIANT_SEED", 1)),
                     .durability = v1::DURABILITY_RELAXED});
  RunCampaign(campaign);
  ASSERT_TRUE(campaign.faults.any()) << campaign.kills << " kills, and nobody misses anything";
  EXPECT_THAT(campaign.faults.all(),
              testing::Contains(testing::ContainsRegex("lost|last that|no session")));
  std::cout << "noticed after " << campaign.kills << " kills: " << campaign.faults.all()[0] << "\n";
}

TEST(CrashCampaign, NoticesADiskThatLies) {
  Campaign campaign(
      {.seed = static_cast<std::uint64_t>(NumberFrom("PLIANT_SEED", 1)), .disk_drops = true});
  RunCampaign(campaign);
  ASSERT_TRUE(campaign.faults.any()) << campaign.kills << " kills, and nobody misses anything";
  std::cout << "noticed after " << campaign.kills << " kills: " << campaign.faults.all()[0] << "\n";
}

// --- The end in peace ---------------------------------------------------------------------------

// Goal: SIGTERM loses nothing that was told, of relaxed sessions neither, however slow the disk.
// Method: updates are answered while the disk takes 50 ms for each synchronisation, so that some of
// what was told is not written when the signal comes; the next server knows it all.
class Sigterm : public testing::TestWithParam<v1::Durability> {};

TEST_P(Sigterm, LosesNothingThatWasTold) {
  const TemporaryFolder folder;
  const std::string socket = folder.path() + "/socket";
  KillableServer server(socket, folder.path() + "/data");
  server.Start({"slow", 50});
  v1::EditResponse last;
  const auto read = [&last](auto& stream) {
    v1::EditResponse response;
    while (stream.Read(&response)) {
      last = response;
      if (response.has_advanced() || response.has_opened()) return;
    }
  };
  const auto open = [&](const std::shared_ptr<grpc::Channel>& channel,
                        grpc::ClientContext& context) {
    auto stream = v1::SessionService::NewStub(channel)->Edit(&context);
    v1::EditRequest request;
    request.mutable_open()->set_session_id("e");
    request.mutable_open()->set_mirror_mode(v1::MIRROR_MODE_NONE);
    stream->Write(request);
    read(*stream);
    return stream;
  };
  Faults faults;
  std::atomic<bool> stop = false;
  CrashEditor creator("unix:" + socket, "e", 1, faults);
  creator.Create(stop, GetParam());
  {
    const std::shared_ptr<grpc::Channel> channel = Connect("unix:" + socket);
    ASSERT_NE(channel, nullptr);
    grpc::ClientContext context;
    const auto stream = open(channel, context);
    for (std::int64_t id = 1; id <= 10; ++id) {
      v1::EditRequest request;
      request.set_update_id(id);
      request.mutable_advance()->set_budget_visits(10);
      stream->Write(request);
      read(*stream);
    }
    ASSERT_EQ(last.update_id(), 10);
    ASSERT_EQ(last.revision(), 10);
    if (GetParam() == v1::DURABILITY_RELAXED) {
      EXPECT_LT(last.advanced().durable_revision(), 10) << "nothing is left for the end to write";
    }
    EXPECT_EQ(server.Terminate(), 0);
    context.TryCancel();
    static_cast<void>(stream->Finish());
  }
  const std::uint64_t hash = last.advanced().state_hash();
  server.Start({});
  std::shared_ptr<grpc::Channel> channel;
  while (channel == nullptr) channel = Connect("unix:" + socket);
  grpc::ClientContext context;
  v1::GetSessionRequest request;
  request.set_session_id("e");
  v1::GetSessionResponse response;
  ASSERT_TRUE(v1::SessionService::NewStub(channel)->GetSession(&context, request, &response).ok());
  EXPECT_EQ(response.session().revision(), 10);
  EXPECT_EQ(response.session().state_hash(), hash);
  EXPECT_EQ(response.session().last_update_id(), 10);
  // Loaded, too.
  grpc::ClientContext edit_context;
  const auto stream = open(channel, edit_context);
  EXPECT_EQ(last.opened().last_update_id(), 10);
  edit_context.TryCancel();
  static_cast<void>(stream->Finish());
}

INSTANTIATE_TEST_SUITE_P(Durability, Sigterm,
                         testing::Values(v1::DURABILITY_STRICT, v1::DURABILITY_RELAXED),
                         [](const auto& durability) {
                           return durability.param == v1::DURABILITY_STRICT ? "Strict" : "Relaxed";
                         });

}  // namespace
}  // namespace pliant::test
