// Goal: each limit of a tenant, at it and one past it, as a client meets it; and that another
// tenant does not notice.
#include <gtest/gtest.h>

#include <string>

#include "tests/support/in_process_server.h"
#include "tests/support/mirror.h"

namespace pliant::test {
namespace {

v1::ErrorDetail DetailOf(const grpc::Status& status) {
  v1::ErrorStatus details;
  v1::ErrorDetail detail;
  EXPECT_TRUE(details.ParseFromString(status.error_details()));
  if (details.details_size() > 0) detail.ParseFromString(details.details(0).value());
  return detail;
}

v1::EditResponse AdvanceOnce(EditClient& edit, std::int64_t update_id) {
  edit.Advance(update_id);
  return edit.Until(update_id).back();
}

TEST(TenantLimits, VerticesOfAllSessionsTogether) {
  server::Config config;
  config.tenant_vertices_max = 400;
  InProcessServer server(server::RemesherFactory(), config);
  std::string first;
  ASSERT_TRUE(server.Create(UnitSquare("0.1"), &first).ok());  // About 120 vertices.
  EditClient edit(server, first);
  const v1::EditResponse made = AdvanceOnce(edit, 1);
  ASSERT_TRUE(made.has_advanced());
  const std::int64_t count = made.advanced().counts().vertex_count();
  ASSERT_GT(count, 50);
  ASSERT_LT(count, 400);

  // Growth beyond the limit is refused as a whole; the session stays as it was and goes on.
  edit.Size(2, "0.02");
  const v1::EditResponse refused = AdvanceOnce(edit, 3);
  ASSERT_TRUE(refused.has_rejected());
  EXPECT_EQ(refused.rejected().error().reason(), "RESOURCE_EXHAUSTED");
  EXPECT_EQ(refused.rejected().error().code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(refused.rejected().error().retry_after_ms(), 0) << "waiting alone frees nothing...";
  EXPECT_NE(refused.rejected().error().message().find("delete a session"), std::string::npos)
      << "...but that";
  const v1::EditResponse again = AdvanceOnce(edit, 4);
  ASSERT_TRUE(again.has_advanced());
  EXPECT_EQ(again.advanced().state_hash(), made.advanced().state_hash());

  // What a deleted session used is free again.
  std::string second;
  ASSERT_TRUE(server.Create(UnitSquare("0.07"), &second).ok());
  EditClient other(server, second);
  const v1::EditResponse too_much = AdvanceOnce(other, 1);
  EXPECT_TRUE(edit.Finish().ok());
  if (too_much.has_advanced()) {
    EXPECT_LE(count + too_much.advanced().counts().vertex_count(), 400);
  }
  grpc::ClientContext context;
  v1::DeleteSessionRequest request;
  request.set_session_id(first);
  v1::DeleteSessionResponse response;
  ASSERT_TRUE(server.sessions->DeleteSession(&context, request, &response).ok());
  // The session is gone at once, its memory a moment later.
  bool advanced = false;
  for (std::int64_t update = 2; !advanced && update < 1000; ++update) {
    advanced = AdvanceOnce(other, update).has_advanced();
  }
  EXPECT_TRUE(advanced);
}

TEST(TenantLimits, ASessionThatBeginsTooLargeIsRefused) {
  server::Config config;
  config.tenant_vertices_max = 4;
  InProcessServer server(server::RemesherFactory(), config);
  std::string id;
  EXPECT_TRUE(server.Create(UnitSquare("0.5"), &id).ok()) << "four vertices, at the limit";
  const grpc::Status refused = server.Create(UnitSquare("0.5"), &id);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(DetailOf(refused).reason(), "RESOURCE_EXHAUSTED");
}

TEST(TenantLimits, BytesOfAllSessionsTogether) {
  server::Config config;
  config.tenant_bytes_max = 4 * server::kBytesPerVertex;
  InProcessServer server(server::RemesherFactory(), config);
  std::string id;
  EXPECT_TRUE(server.Create(UnitSquare("0.5"), &id).ok());
  EditClient edit(server, id);
  EXPECT_TRUE(AdvanceOnce(edit, 1).has_rejected()) << "a fifth vertex";
}

// Method: a tenant with half a worker and a small burst updates as fast as it can, until it is told
//         to wait; the step that was refused is taken once it has.
TEST(TenantLimits, ComputeTimeWithAHintWhenToComeBack) {
  server::Config config;
  config.tenant_compute_percent = 50;
  config.tenant_compute_burst_ms = 100;
  InProcessServer server(server::RemesherFactory(), config);
  std::string id;
  ASSERT_TRUE(server.Create(UnitSquare("0.02"), &id).ok());
  EditClient edit(server, id);
  std::int64_t update = 1;
  v1::EditResponse answer = AdvanceOnce(edit, update);
  ASSERT_TRUE(answer.has_advanced());
  std::int64_t revision = 1;
  for (int step = 0; step < 1000 && answer.has_advanced(); ++step) {
    revision = answer.advanced().revision();
    edit.Size(++update, step % 2 == 0 ? "0.01" : "0.02");
    ASSERT_TRUE(edit.Until(update).back().has_accepted());
    answer = AdvanceOnce(edit, ++update);
  }
  ASSERT_TRUE(answer.has_rejected()) << "nothing was refused";
  EXPECT_EQ(answer.rejected().error().reason(), "RESOURCE_EXHAUSTED");
  EXPECT_GT(answer.rejected().error().retry_after_ms(), 0);

  // Asking again and again costs nothing of it; the clock pays.
  while (answer.has_rejected()) {
    ASSERT_EQ(answer.rejected().error().reason(), "RESOURCE_EXHAUSTED");
    answer = AdvanceOnce(edit, ++update);
  }
  ASSERT_TRUE(answer.has_advanced());
  EXPECT_EQ(answer.advanced().revision(), revision + 1) << "the stage was as it had been";
  EXPECT_GT(answer.advanced().visit_count(), 0);
}

}  // namespace
}  // namespace pliant::test
