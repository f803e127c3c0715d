#include "server/server.h"

#include <gmock/gmock.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "tests/support/fake_server_parts.h"
#include "tests/support/in_process_server.h"

namespace pliant::server {
namespace {

// The wire of grpc.health.v1: a request with a name in field 1, an answer with a status in field 1.
grpc::Status Health(test::InProcessServer& server, std::string* answer) {
  grpc::GenericStub stub(server.channel());
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  const grpc::Slice nothing("");  // An empty message, which is not the same as none.
  const grpc::ByteBuffer request(&nothing, 1);
  const auto call =
      stub.PrepareUnaryCall(&context, "/grpc.health.v1.Health/Check", request, &queue);
  call->StartCall();
  grpc::ByteBuffer response;
  grpc::Status status;
  call->Finish(&response, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  queue.Next(&tag, &ok);
  std::vector<grpc::Slice> slices;
  if (status.ok() && response.Dump(&slices).ok()) {
    for (const grpc::Slice& slice : slices) {
      answer->append(reinterpret_cast<const char*>(slice.begin()), slice.size());
    }
  }
  return status;
}

TEST(Server, SaysThatItServes) {
  test::InProcessServer server(FakeFactory(std::make_shared<FakeEngineScript>()));
  std::string answer;
  ASSERT_TRUE(Health(server, &answer).ok());
  EXPECT_EQ(answer, "\x08\x01") << "SERVING";
}

TEST(Server, TellsTheAddressThatItReallyBound) {
  const SystemClock clock;
  const Log log(LogLevel::kError, LogFormat::kText);
  const EngineFactory factory = FakeFactory(std::make_shared<FakeEngineScript>());
  const Config config{.listen = "127.0.0.1:0", .workers = 1};
  const auto server = Server::Start(config, {&clock, &log, factory});
  ASSERT_TRUE(server.ok());
  EXPECT_THAT((*server)->address(), testing::MatchesRegex("127\\.0\\.0\\.1:[1-9][0-9]*"));
  const auto second =
      Server::Start({.listen = (*server)->address(), .workers = 1}, {&clock, &log, factory});
  ASSERT_FALSE(second.ok()) << "two servers must not share a port";
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
}

TEST(Server, RefusesABadConfiguration) {
  const SystemClock clock;
  const Log log(LogLevel::kError, LogFormat::kText);
  const auto server = Server::Start({.listen = "0.0.0.0:0"}, {&clock, &log, nullptr});
  ASSERT_FALSE(server.ok());
  EXPECT_EQ(server.error().field, "listen");
}

// Goal: at SIGTERM a running advance is committed and told before its stream ends.
TEST(Server, DrainsStreamsWithCommitsAndAReason) {
  const auto script = std::make_shared<FakeEngineScript>();
  script->visits_needed = INT64_MAX / 2;  // Never converges by itself.
  test::InProcessServer server(FakeFactory(script));
  std::string id;
  ASSERT_TRUE(server.Create(test::UnitSquare(), &id).ok());
  test::EditClient edit(server, id);
  v1::Advance advance;
  advance.set_progress_interval_ms(10);
  edit.Advance(1, advance);
  EXPECT_TRUE(edit.Next().has_opened());
  EXPECT_TRUE(edit.Next().has_progress()) << "the advance runs";
  std::thread shutdown([&] { server.server().Shutdown(); });
  v1::EditResponse response = edit.Next();
  while (response.has_progress()) response = edit.Next();
  EXPECT_EQ(response.diff().revision(), 1);
  response = edit.Next();
  EXPECT_EQ(response.advanced().stop_reason(), v1::STOP_REASON_SERVER_CLOSING);
  EXPECT_GT(response.advanced().active_count(), 0);
  EXPECT_EQ(edit.Next().closing().error().reason(), "UNAVAILABLE");
  EXPECT_EQ(edit.End().error_code(), grpc::StatusCode::UNAVAILABLE);
  shutdown.join();
}

// Goal: who asks for health sends nobody here any more while the server drains.
// Method: a step of an advance holds the drain until health has been asked.
TEST(Server, SaysThatItDoesNotServeWhileItDrains) {
  std::promise<void> asked;
  std::promise<void> runs;
  const auto script = std::make_shared<FakeEngineScript>();
  std::once_flag once;
  script->during_step = [&] {
    std::call_once(once, [&] {
      runs.set_value();
      asked.get_future().wait();
    });
  };
  test::InProcessServer server(FakeFactory(script));
  std::string id;
  ASSERT_TRUE(server.Create(test::UnitSquare(), &id).ok());
  test::EditClient edit(server, id);
  edit.Advance(1);
  runs.get_future().wait();
  std::thread shutdown([&] { server.server().Shutdown(); });
  std::string answer;
  grpc::Status status;
  do {
    answer.clear();
    status = Health(server, &answer);
  } while (status.ok() && answer == "\x08\x01");  // The shutdown has not begun.
  EXPECT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(answer, "\x08\x02") << "NOT_SERVING";
  asked.set_value();
  EXPECT_TRUE(edit.Until(1).back().has_advanced()) << "what runs is committed all the same";
  shutdown.join();
}

TEST(Server, StopsInTimeAlthoughAClientHoldsAStreamThatItNeverOpened) {
  test::InProcessServer server(FakeFactory(std::make_shared<FakeEngineScript>()),
                               {.drain_ms = 100});
  test::EditClient edit(server);
  server.server().Shutdown();
  EXPECT_FALSE(edit.End().ok());
}

}  // namespace
}  // namespace pliant::server
