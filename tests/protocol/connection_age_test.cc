// Goal: connections that have reached their age end with grace, and no update is lost, refused or
// applied twice because of it.
// Method: a client whose edit stream follows the rules for lost connections edits without a pause
// until its stream has ended twice. gRPC counts ages in real time; the least is a second.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>

#include "tests/protocol/follow.h"
#include "tests/support/in_process_server.h"
#include "tests/support/mirror.h"

namespace pliant::test {
namespace {

TEST(ConnectionAge, EndsConnectionsWithGraceWhileUpdatesGoOn) {
  constexpr std::chrono::milliseconds kGrace(100);
  server::Config config;
  config.connection_age_max_s = 1;
  config.drain_ms = kGrace.count();
  InProcessServer server(server::RemesherFactory(), config);
  std::string id;
  ASSERT_TRUE(server.Create(UnitSquare("0.3"), &id).ok());

  Mirror mirror;
  std::int64_t answered = 0;
  std::int64_t committed = 0;
  int ended_count = 0;
  for (bool is_over = false; !is_over;) {
    SCOPED_TRACE(testing::Message() << ended_count << " streams have ended");
    const auto begin = std::chrono::steady_clock::now();
    EditClient edit(server, id, mirror.revision);
    // The third one ends by itself.
    const std::int64_t last = ended_count == 2 ? answered + 20 : INT64_MAX;
    bool is_open = true;
    while (is_open && answered < last) {
      const std::int64_t update = answered + 1;
      // Odd ones stage, even ones advance: what has no answer is sent again with the same number.
      const bool advances = update % 2 == 0;
      is_open =
          advances ? edit.Advance(update) : edit.Size(update, update % 4 == 1 ? "0.25" : "0.3");
      while (is_open && answered < update) {
        const v1::EditResponse response = edit.Next();
        if (response.event_case() == v1::EditResponse::EVENT_NOT_SET) is_open = false;
        ASSERT_FALSE(response.has_rejected()) << response.rejected().error().message();
        if (response.has_diff()) {
          ASSERT_EQ(mirror.Apply(response.diff()), "");
        }
        if (response.has_snapshot()) {
          ASSERT_EQ(mirror.Take(response.snapshot()), "");
        }
        if (response.update_id() != update) continue;
        if (response.has_advanced()) {
          ASSERT_EQ(response.advanced().base_revision(), committed) << "applied once";
          committed = response.advanced().revision();
        }
        if (response.has_accepted() || response.has_advanced()) answered = update;
      }
    }
    if (answered == last) {
      EXPECT_TRUE(edit.Finish().ok());
      is_over = true;
      continue;
    }
    const grpc::Status status = edit.End();
    if (ReasonOf(status) == "SESSION_BUSY") continue;  // The server has not noticed yet.
    ASSERT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE) << status.error_message();
    // gRPC lets ages differ by a tenth.
    EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(800)) << "grace";
    ++ended_count;
  }
  EXPECT_GT(committed, 20);
  EXPECT_EQ(mirror.revision, committed);
  EXPECT_EQ(Fetch(server, id).Hash(), mirror.Hash());
}

}  // namespace
}  // namespace pliant::test
