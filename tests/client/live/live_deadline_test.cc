// Deadlines of a solver that sends a whole step at once, against a server of its own.

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "client/cpp/client.h"
#include "tests/client/live/inputs.h"
#include "tests/client/live/pliantd_process.h"

namespace pliant::client {
namespace {

std::unique_ptr<Session> CreateSquare(Client& client) {
  auto session = client.CreateSession(Square(), Size("0.006"));
  EXPECT_TRUE(session.ok()) << session.error().message;
  EXPECT_TRUE((*session)->Advance().ok());
  (*session)->SetAnswers(Answers::kWithAdvance);
  return *std::move(session);
}

/// Every node goes a little to the right.
Status Shear(Session& session) {
  std::vector<Vec2> positions;
  for (const VertexId id : session.replica().Compact().vertex_ids) {
    const Vec2 p = session.replica().positions()[id.index()];
    positions.push_back({p.x + 0.001 * p.y, p.y});
  }
  return session.MoveNodes({}, positions);
}

// Goal: who sends a step with a deadline that it cannot meet is told in time, and then commits the
// whole of it: to the last bit what comes of the same step without a deadline.
TEST(LiveDeadline, EndsTheWaitForAStepAndLosesNothing) {
  PliantdProcess server(/*with_store=*/true);
  Result<Client> client = Client::Connect(server.address());
  ASSERT_TRUE(client.ok()) << client.error().message;
  const auto hurried = CreateSquare(*client);
  const auto patient = CreateSquare(*client);
  int told_count = 0;
  for (int step = 0; step < 5; ++step) {
    SCOPED_TRACE(step);
    ASSERT_TRUE(Shear(*hurried).ok());
    const Revision before = hurried->replica().revision();
    const auto due = hurried->Advance({.visits_max = 1, .time_max = std::chrono::milliseconds(1)});
    ASSERT_TRUE(due.ok()) << due.error().message;
    if (due->stop == AdvanceStop::kStaging) {
      ++told_count;
      EXPECT_EQ(due->base_revision, before);
      EXPECT_EQ(due->revision, before);
      EXPECT_EQ(hurried->replica().revision(), before);
      const auto rest = hurried->Advance({.visits_max = 1});
      ASSERT_TRUE(rest.ok()) << rest.error().message;
      EXPECT_EQ(rest->base_revision, before);
      EXPECT_EQ(rest->motion_fraction, 1);
    }
    ASSERT_TRUE(Shear(*patient).ok());
    ASSERT_TRUE(patient->Advance({.visits_max = 1}).ok());
    ASSERT_TRUE(hurried->Advance().ok());
    ASSERT_TRUE(patient->Advance().ok());
    EXPECT_EQ(hurried->replica().summary(), patient->replica().summary());
  }
  // It is a race: where a machine does something else for long, a step may be staged in time.
  EXPECT_GT(told_count, 0);
}

}  // namespace
}  // namespace pliant::client
