// Editors and followers of a server that is killed and started again.

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "client/cpp/client.h"
#include "tests/client/live/inputs.h"
#include "tests/client/live/pliantd_process.h"

namespace pliant::client {
namespace {

void ExpectSameAsServer(Session& session) {
  const Result<MeshReplica> mesh = session.GetMesh();
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh->revision(), session.replica().revision());
  EXPECT_EQ(mesh->summary().state_hash, session.replica().summary().state_hash);
}

// Goal: no step fails while the server is away for a moment: neither an update that finds it gone,
//       nor an advance that it dies in; and what was staged is there afterwards.
TEST(LiveRestart, StepsGoOnWhenTheServerIsBack) {
  PliantdProcess server(/*with_store=*/true);
  Result<Client> client = Client::Connect(server.address());
  ASSERT_TRUE(client.ok()) << client.error().message;
  auto session = client->CreateSession(Square(), Size("0.1"));
  ASSERT_TRUE(session.ok()) << session.error().message;
  ASSERT_TRUE((*session)->Advance().ok());
  const auto subscription = client->Subscribe((*session)->id());
  ASSERT_TRUE(subscription->Next().ok());

  ASSERT_TRUE((*session)->UpdateMetric(Size("0.3")).ok());
  server.Kill();
  {
    std::thread other([&] { server.Start(); });
    const auto report = (*session)->Advance();
    other.join();
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_LT(report->summary.vertex_count, 60) << "what was staged is lost";
  }
  ASSERT_TRUE((*session)->UpdateMetric(Size("0.005")).ok());
  {
    std::promise<void> runs;
    std::thread other([&] {
      runs.get_future().wait();
      server.Kill();
      server.Start();
    });
    bool is_first = true;
    AdvanceOptions options;
    options.progress_interval = std::chrono::milliseconds(20);
    const auto report = (*session)->Advance(options, [&](const AdvanceProgress&) {
      if (std::exchange(is_first, false)) runs.set_value();
    });
    other.join();
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->stop, AdvanceStop::kConverged);
  }
  ExpectSameAsServer(**session);
  server.Kill();
  server.Start();
  const auto status = (*session)->UpdateMetric(Size("0.2"));
  ASSERT_TRUE(status.ok()) << status.error().message;
  ASSERT_TRUE((*session)->Advance().ok());
  ExpectSameAsServer(**session);
  while (subscription->replica().revision() < (*session)->replica().revision()) {
    const auto change = subscription->Next();
    ASSERT_TRUE(change.ok()) << change.error().message;
  }
  EXPECT_EQ(subscription->replica().summary().state_hash,
            (*session)->replica().summary().state_hash);
}

}  // namespace
}  // namespace pliant::client
