#include "server/importing.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "server/limits.h"
#include "server/session_file.h"
#include "tests/support/files.h"
#include "tests/support/in_process_server.h"

namespace pliant::server {
namespace {

using test::Import;
using test::ImportFile;
using test::ImportOf;
using test::ReasonOf;

std::string Make(test::InProcessServer& server) {
  std::string id;
  EXPECT_TRUE(server.Create(test::UnitSquare("0.1"), &id).ok());
  test::EditClient edit(server, id);
  edit.Advance(1);
  EXPECT_TRUE(edit.Until(1).back().has_advanced());
  return id;
}

std::int64_t SessionCount(test::InProcessServer& server) {
  grpc::ClientContext context;
  v1::ListSessionsResponse response;
  EXPECT_TRUE(server.sessions->ListSessions(&context, {}, &response).ok());
  return response.sessions_size();
}

grpc::Status Upload(test::InProcessServer& server,
                    const std::vector<v1::ImportSessionRequest>& requests) {
  grpc::ClientContext context;
  v1::ImportSessionResponse response;
  const auto writer = server.sessions->ImportSession(&context, &response);
  for (const v1::ImportSessionRequest& request : requests) writer->Write(request);
  writer->WritesDone();
  return writer->Finish();
}

TEST(Importing, RefusesMessagesInTheWrongOrder) {
  test::InProcessServer server;
  EXPECT_EQ(ReasonOf(Upload(server, {})), "PROTOCOL_ORDER");
  EXPECT_EQ(ReasonOf(Upload(server, {v1::ImportSessionRequest()})), "PROTOCOL_ORDER");
  v1::ImportSessionRequest request;
  *request.mutable_import() = ImportOf("x", "a");
  EXPECT_EQ(ReasonOf(Upload(server, {request, request})), "PROTOCOL_ORDER");
  request.mutable_import()->mutable_file()->mutable_data()->set_blob_id(1);
  EXPECT_EQ(ReasonOf(Upload(server, {request})), "PROTOCOL_ORDER");
}

// Goal: nothing is left of a file that was refused: neither a session nor its name.
TEST(Importing, RefusesWhatIsNoFileAndLeavesNothing) {
  test::InProcessServer server;
  const std::string id = Make(server);
  const std::string file = test::ExportFile(server, id);
  v1::ImportSession absent;
  EXPECT_EQ(ReasonOf(Import(server, absent)), "ARRAY_TYPE");
  v1::ImportSession numbers = ImportOf(file, "a");
  numbers.mutable_file()->mutable_data()->set_dtype(v1::DTYPE_INT32);
  EXPECT_EQ(ReasonOf(Import(server, numbers)), "ARRAY_TYPE");
  v1::ImportSession shape = ImportOf(file, "a");
  shape.mutable_file()->mutable_data()->set_shape(0, 7);
  EXPECT_EQ(ReasonOf(Import(server, shape)), "ARRAY_LENGTH");
  EXPECT_EQ(ReasonOf(ImportFile(server, "", "a")), "DATA_CORRUPT");
  EXPECT_EQ(ReasonOf(ImportFile(server, file.substr(0, file.size() / 2), "a")), "DATA_CORRUPT");
  const grpc::Status corrupt = ImportFile(server, file + "x", "a");
  EXPECT_EQ(corrupt.error_code(), grpc::StatusCode::DATA_LOSS);
  std::string newer = file;
  newer[4] = 9;
  const grpc::Status version = ImportFile(server, newer, "a");
  EXPECT_EQ(ReasonOf(version), "DATA_VERSION");
  EXPECT_EQ(version.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(ReasonOf(ImportFile(server, file, "no name!")), "OUT_OF_RANGE");
  EXPECT_EQ(ReasonOf(ImportFile(server, file, id)), "SESSION_EXISTS");
  EXPECT_EQ(SessionCount(server), 1);
  // Sealed as it should be, but what is inside is no session: found on a worker.
  const Bytes hollow = [] {
    ByteWriter writer;
    writer.Put(std::uint32_t{0});
    writer.Put(std::uint64_t{3});
    for (int i = 0; i < 3; ++i) writer.Put(std::uint8_t{0});
    return SealBytes({.kind = 0x46534c50, .version = 1}, std::move(writer).Take());
  }();
  EXPECT_EQ(
      ReasonOf(ImportFile(
          server, std::string(reinterpret_cast<const char*>(hollow.data()), hollow.size()), "a")),
      "DATA_CORRUPT");
  EXPECT_TRUE(ImportFile(server, file, "a").ok()) << "its name is free";
  EXPECT_EQ(SessionCount(server), 2);
}

TEST(Importing, RefusesTooManyLabels) {
  test::InProcessServer server;
  for (const std::size_t count : {kLabelsMax, kLabelsMax + 1}) {
    ByteWriter writer;
    writer.Put(static_cast<std::uint32_t>(count));
    for (std::size_t i = 0; i < count; ++i) {
      writer.PutText("key" + std::to_string(i));
      writer.PutText("value");
    }
    writer.Put(std::uint64_t{0});
    const Bytes bytes = SealBytes({.kind = 0x46534c50, .version = 1}, std::move(writer).Take());
    EXPECT_EQ(
        ReasonOf(ImportFile(
            server, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()), "a")),
        count > kLabelsMax ? "TOO_LARGE" : "DATA_CORRUPT");
  }
}

// Goal: limits of server and tenant hold for sessions that come as files.
TEST(Importing, RespectsTheLimits) {
  test::InProcessServer from;
  const std::string file = test::ExportFile(from, Make(from));
  v1::Session session;
  ASSERT_TRUE(ImportFile(from, file, "", &session).ok());
  EXPECT_FALSE(session.session_id().empty());
  const std::int64_t count = session.counts().vertex_count();

  Config config;
  config.sessions_per_tenant_max = 1;
  test::InProcessServer one(RemesherFactory(), config);
  EXPECT_TRUE(ImportFile(one, file, "a").ok());
  EXPECT_EQ(ReasonOf(ImportFile(one, file, "b")), "RESOURCE_EXHAUSTED");

  config = {};
  config.tenant_vertices_max = 2 * count - 1;
  test::InProcessServer small(RemesherFactory(), config);
  EXPECT_TRUE(ImportFile(small, file, "a").ok());
  EXPECT_EQ(ReasonOf(ImportFile(small, file, "b")), "RESOURCE_EXHAUSTED");
  EXPECT_EQ(SessionCount(small), 1);
  grpc::ClientContext context;
  v1::DeleteSessionRequest request;
  request.set_session_id("a");
  v1::DeleteSessionResponse response;
  EXPECT_TRUE(small.sessions->DeleteSession(&context, request, &response).ok());
  EXPECT_TRUE(ImportFile(small, file, "b").ok()) << "what was refused is not counted";
}

TEST(Importing, PromisesWhatTheServerCan) {
  test::InProcessServer server;
  const std::string file = test::ExportFile(server, Make(server));
  v1::ImportSession import = ImportOf(file, "a");
  import.set_durability(v1::DURABILITY_STRICT);
  EXPECT_EQ(ReasonOf(Import(server, import)), "UNIMPLEMENTED") << "there is no store";
  import.set_durability(v1::DURABILITY_UNSPECIFIED);
  EXPECT_EQ(ReasonOf(Import(server, import)), "OUT_OF_RANGE");
  import.set_durability(v1::DURABILITY_NONE);
  EXPECT_TRUE(Import(server, import).ok());
}

}  // namespace
}  // namespace pliant::server
