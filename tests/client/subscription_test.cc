#include "client/cpp/subscription.h"

#include <gtest/gtest.h>

#include <thread>
#include <utility>

#include "client/cpp/client.h"
#include "tests/client/fake_server.h"
#include "tests/client/model_mesh.h"

namespace pliant::client {
namespace {

/// A few revisions of a mesh: models[r] is revision r.
struct Models {
  std::vector<ModelMesh> models{1};
  explicit Models(int count) {
    ModelChanger changer(/*seed=*/1996);
    for (int r = 0; r < count; ++r) models.push_back(changer.Next(models.back(), 20));
  }
  [[nodiscard]] MeshDiff Diff(std::size_t to) const { return DiffOf(models[to - 1], models[to]); }
  [[nodiscard]] MeshDiff Snapshot(std::size_t of) const { return DiffOf({}, models[of]); }
};

class SubscriptionTest : public testing::Test {
 protected:
  std::unique_ptr<Subscription> Subscribe(std::chrono::milliseconds reconnect_max) {
    Result<Client> client = Client::Connect(server_.address());
    EXPECT_TRUE(client.ok());
    return client->Subscribe("s1", {.reconnect_max = reconnect_max});
  }
  static void Send(const MeshDiff& diff, SubscribeWriter* writer) {
    v1::SubscribeResponse response;
    wire::ColumnWriter columns([&](v1::BlobChunk chunk) {
      v1::SubscribeResponse message;
      *message.mutable_chunk() = std::move(chunk);
      writer->Write(message);
    });
    if (diff.base_revision == Revision::kNone) {
      WriteElements(diff, columns, *response.mutable_snapshot());
    } else {
      WriteElements(diff, columns, *response.mutable_diff());
    }
    writer->Write(response);
  }

  FakeServer server_;
  const Models models_{5};
};

// Goal: a stream that breaks is taken up at the replica's revision, until the session is gone.
TEST_F(SubscriptionTest, FollowsOverBrokenStreams) {
  std::vector<std::int64_t> mirrors;
  server_.on_subscribe = [&](const v1::SubscribeRequest& request, SubscribeWriter* writer) {
    mirrors.push_back(request.mirror_revision());
    switch (mirrors.size()) {
      case 1:
        Send(models_.Snapshot(2), writer);
        Send(models_.Diff(3), writer);
        return grpc::Status(grpc::StatusCode::UNAVAILABLE, "reset");
      case 2:
        return grpc::Status::OK;
      case 3:
        Send(models_.Diff(4), writer);
        Send(models_.Diff(5), writer);
        return grpc::Status(grpc::StatusCode::UNAVAILABLE, "reset");
      default:
        return grpc::Status(grpc::StatusCode::NOT_FOUND, "deleted");
    }
  };
  const auto subscription = Subscribe(std::chrono::seconds(20));
  for (std::size_t revision = 2; revision <= 5; ++revision) {
    const Result<MeshDiff> diff = subscription->Next();
    ASSERT_TRUE(diff.ok()) << diff.error().message;
    EXPECT_EQ(diff->revision, Revision(static_cast<std::int64_t>(revision)));
    EXPECT_EQ(subscription->replica().summary(), models_.Snapshot(revision).summary);
  }
  EXPECT_FALSE(subscription->Next().ok());
  EXPECT_EQ(mirrors, (std::vector<std::int64_t>{0, 3, 3, 5}));
}

TEST_F(SubscriptionTest, ADiffThatDoesNotFitIsHealedByASnapshot) {
  int calls = 0;
  server_.on_subscribe = [&](const v1::SubscribeRequest& request, SubscribeWriter* writer) {
    EXPECT_EQ(request.mirror_revision(), 0);
    Send(models_.Snapshot(++calls == 1 ? 1 : 4), writer);
    if (calls == 1) Send(models_.Diff(4), writer);
    return grpc::Status(grpc::StatusCode::NOT_FOUND, "deleted");
  };
  const auto subscription = Subscribe(std::chrono::seconds(0));
  EXPECT_TRUE(subscription->Next().ok());
  EXPECT_EQ(subscription->Next().error().code, ErrorCode::kReplicaMismatch);
  EXPECT_TRUE(subscription->Next().ok());
  EXPECT_EQ(subscription->replica().revision(), Revision(4));
}

TEST_F(SubscriptionTest, GivesUpAfterItsTimeAndWhenItIsCancelled) {
  server_.on_subscribe = [](const v1::SubscribeRequest&, SubscribeWriter*) {
    return grpc::Status(grpc::StatusCode::UNAVAILABLE, "no");
  };
  EXPECT_EQ(Subscribe(std::chrono::milliseconds(50))->Next().error().code, ErrorCode::kUnavailable);
  const auto patient = Subscribe(std::chrono::hours(1));
  std::thread other([&] { patient->Cancel(); });
  EXPECT_EQ(patient->Next().error().code, ErrorCode::kCancelled);
  other.join();
}

}  // namespace
}  // namespace pliant::client
