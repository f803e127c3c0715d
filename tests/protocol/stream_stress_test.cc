// Goal: no crash, no hang, no race and no wrong mesh under 64 streams at once that open, edit,
// cancel, subscribe, roll back, fork and die at random; afterwards every session still serves.
// Method: 64 threads on one server of 4 workers, each with its own random choices. Which of them
// meet is up to the machine; what must hold does not depend on it. Made for the sanitizers.
//
//   PLIANT_STRESS_ROUNDS=500 protocol_tests --gtest_filter='StreamStress.*'     longer
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "tests/protocol/promises.h"
#include "tests/support/in_process_server.h"
#include "tests/support/mirror.h"
#include "tests/support/subscribe_client.h"

namespace pliant::test {
namespace {

constexpr int kStreams = 64;
constexpr int kSessions = 24;

int Rounds() {
  const char* rounds = std::getenv("PLIANT_STRESS_ROUNDS");
  return rounds != nullptr ? std::atoi(rounds) : 6;
}

std::string NameOf(std::uint64_t session) { return "s" + std::to_string(session); }

/// One of the threads.
class RandomClient {
 public:
  RandomClient(InProcessServer& server, std::uint64_t seed) : server_(server), rng_(seed) {}

  void Run() {
    for (int round = 0; round < Rounds(); ++round) {
      const std::string id = NameOf(rng_.Below(kSessions));
      switch (rng_.Below(10)) {
        case 0:
          Delete(id);
          break;
        case 1:
          Fork(id);
          break;
        case 2:
        case 3:
          Subscribe(id);
          break;
        case 4:
          Download(id);
          break;
        default:
          Edit(id);
          break;
      }
    }
  }

  std::int64_t revisions = 0;  ///< That it saw committed.

 private:
  void Edit(const std::string& id) {
    v1::CreateSession create = UnitSquare("0.15");
    create.set_session_id(id);
    static_cast<void>(server_.Create(std::move(create), nullptr));  // May be there.
    EditClient edit(server_, id);
    const v1::EditResponse opened = edit.Next();
    if (!opened.has_opened()) return;  // Busy, or deleted meanwhile.
    std::int64_t update = opened.opened().last_update_id();
    Transcript transcript{.updates = {}, .advances = {}, .seen = {opened}};
    const auto read = [&] {
      for (v1::EditResponse& response : edit.Until(update)) {
        const bool is_end = response.has_closing() || response.event_case() == 0;
        if (is_end) continue;  // Somebody has deleted the session.
        revisions += response.has_advanced();
        transcript.seen.push_back(std::move(response));
      }
    };
    for (std::uint64_t step = rng_.Below(4); step > 0; --step) {
      edit.Size(++update, rng_.Below(8) == 0 ? "0.1 +" : SizeText());
      transcript.updates.insert(update);
      edit.Advance(++update);
      transcript.advances.insert(update);
      if (rng_.Below(3) == 0) {
        v1::EditRequest cancel;
        cancel.mutable_cancel()->set_advance_update_id(update);
        edit.Send(cancel);
      }
      if (rng_.Below(4) == 0) break;  // Dies with an advance on its way.
      read();
      if (rng_.Below(4) == 0) {
        v1::EditRequest rollback;
        rollback.set_update_id(++update);
        rollback.mutable_rollback()->set_to_revision(1);
        edit.Send(rollback);
        transcript.advances.insert(update);  // It makes one revision, or none, as they do.
        read();
      }
    }
    EXPECT_EQ(CheckOrdered(transcript), "");
    EXPECT_EQ(CheckAtomic(transcript), "");
    if (rng_.Below(2) == 0) {
      edit.Cancel();
    } else {
      static_cast<void>(edit.Finish());
    }
  }

  void Subscribe(const std::string& id) {
    if (!HasMesh(id)) return;
    // It leaves after a message or none, and the server finds out.
    SubscribeClient reader(server_, id);
    if (rng_.Below(3) == 0) return;
    Mirror mirror;
    const v1::SubscribeResponse first = reader.Next();
    if (first.has_snapshot()) {
      EXPECT_EQ(mirror.Take(first.snapshot()), "");
    }
  }

  void Download(const std::string& id) {
    v1::GetMeshRequest request;
    request.set_session_id(id);
    v1::MeshSnapshot snapshot;
    if (!server_.GetMesh(request, &snapshot).ok()) return;
    Mirror mirror;
    EXPECT_EQ(mirror.Take(snapshot), "");
  }

  void Delete(const std::string& id) {
    grpc::ClientContext context;
    v1::DeleteSessionRequest request;
    request.set_session_id(id);
    v1::DeleteSessionResponse response;
    static_cast<void>(server_.sessions->DeleteSession(&context, request, &response));
  }

  void Fork(const std::string& id) {
    grpc::ClientContext context;
    v1::ForkRequest request;
    request.set_session_id(id);
    request.set_new_session_id(NameOf(rng_.Below(kSessions)));
    v1::ForkResponse response;
    static_cast<void>(server_.sessions->Fork(&context, request, &response));
  }

  bool HasMesh(const std::string& id) {
    grpc::ClientContext context;
    v1::GetSessionRequest request;
    request.set_session_id(id);
    v1::GetSessionResponse response;
    return server_.sessions->GetSession(&context, request, &response).ok() &&
           response.session().revision() > 0;
  }

  std::string SizeText() { return std::to_string(rng_.Uniform(0.05, 0.2)); }

  InProcessServer& server_;
  Rng rng_;
};

TEST(StreamStress, SixtyFourStreamsThatOpenCancelAndDie) {
  server::Config config;
  config.workers = 4;
  InProcessServer server(server::RemesherFactory(), config);
  std::atomic<std::int64_t> revisions = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < kStreams; ++i) {
    threads.emplace_back([&server, &revisions, i] {
      RandomClient client(server, /*seed=*/static_cast<std::uint64_t>(i) + 1);
      client.Run();
      revisions += client.revisions;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_GT(revisions, 0) << "nobody got anywhere";

  // Every session that is left takes an editor and a step, and its mirror is its mesh.
  int left = 0;
  for (std::uint64_t i = 0; i < kSessions; ++i) {
    const std::string id = NameOf(i);
    EditClient edit(server, id);
    const v1::EditResponse opened = edit.Next();
    if (!opened.has_opened()) continue;
    ++left;
    Mirror mirror;
    std::int64_t update = opened.opened().last_update_id();
    v1::EditRequest discard;
    discard.set_update_id(++update);
    discard.mutable_discard();
    edit.Send(discard);
    edit.Advance(++update);
    bool advanced = false;
    for (const v1::EditResponse& response : edit.Until(update)) {
      if (response.has_snapshot()) {
        EXPECT_EQ(mirror.Take(response.snapshot()), "");
      } else if (response.has_diff()) {
        EXPECT_EQ(mirror.Apply(response.diff()), "");
      }
      advanced = response.has_advanced();
    }
    EXPECT_TRUE(advanced) << id;
  }
  EXPECT_GT(left, 0);
}

}  // namespace
}  // namespace pliant::test
