// The calls on files where a server misbehaves; against a real one they are tested by the command
// line's and the Python package's tests.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "client/cpp/client.h"
#include "pliant/v1/session.grpc.pb.h"
#include "tests/client/loopback_server.h"

namespace pliant::client {
namespace {

/// Sends what a test says, and keeps what it is sent.
class FakeFiles final : public v1::SessionService::Service, public v1::ServerService::Service {
 public:
  [[nodiscard]] const std::string& address() const { return server_.address(); }

  std::vector<v1::ExportSessionResponse> messages;
  std::string received;
  v1::ImportSession import;

 private:
  grpc::Status GetServerInfo(grpc::ServerContext*, const v1::GetServerInfoRequest*,
                             v1::GetServerInfoResponse*) override {
    return grpc::Status::OK;
  }
  grpc::Status ExportSession(grpc::ServerContext*, const v1::ExportSessionRequest*,
                             grpc::ServerWriter<v1::ExportSessionResponse>* writer) override {
    for (const v1::ExportSessionResponse& message : messages) writer->Write(message);
    return grpc::Status::OK;
  }
  grpc::Status ImportSession(grpc::ServerContext*,
                             grpc::ServerReader<v1::ImportSessionRequest>* reader,
                             v1::ImportSessionResponse* response) override {
    v1::ImportSessionRequest request;
    while (reader->Read(&request)) {
      if (request.has_chunk()) received += request.chunk().data();
      if (request.has_import()) import = request.import();
    }
    response->mutable_session()->set_session_id(import.session_id());
    return grpc::Status::OK;
  }

  LoopbackServer server_{static_cast<v1::SessionService::Service*>(this),
                         static_cast<v1::ServerService::Service*>(this)};
};

class ClientFiles : public testing::Test {
 protected:
  FakeFiles fake_;
  Client client_ = Client::Connect(fake_.address()).value();
};

TEST_F(ClientFiles, ADownloadWithoutAFileIsAnError) {
  EXPECT_EQ(client_.ExportSession("s").error().code, ErrorCode::kInternal);
  v1::ExportSessionResponse chunk;
  chunk.mutable_chunk()->set_blob_id(1);
  chunk.mutable_chunk()->set_total_bytes(10);
  chunk.mutable_chunk()->set_data("12345");
  v1::ExportSessionResponse file;
  file.mutable_file()->mutable_data()->set_dtype(v1::DTYPE_UINT8);
  file.mutable_file()->mutable_data()->add_shape(10);
  file.mutable_file()->mutable_data()->set_blob_id(1);
  fake_.messages = {chunk, file};
  EXPECT_EQ(client_.ExportSession("s").error().code, ErrorCode::kProtocolOrder)
      << "half of it is missing";
  v1::ExportSessionResponse rest = chunk;
  rest.mutable_chunk()->set_offset_bytes(5);
  fake_.messages = {chunk, rest, file};
  const Result<Bytes> bytes = client_.ExportSession("s");
  ASSERT_TRUE(bytes.ok()) << bytes.error().message;
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()), "1234512345");
}

TEST_F(ClientFiles, AnUploadGoesAheadInChunks) {
  const Bytes bytes(1'000'001, std::byte{'x'});
  const Result<SessionInfo> session = client_.ImportSession(bytes, "mine");
  ASSERT_TRUE(session.ok()) << session.error().message;
  EXPECT_EQ(session->session_id, "mine");
  EXPECT_EQ(fake_.received, std::string(bytes.size(), 'x'));
  EXPECT_EQ(fake_.import.file().data().dtype(), v1::DTYPE_UINT8);
  EXPECT_EQ(fake_.import.file().data().shape(0), 1'000'001);
  ASSERT_TRUE(client_.ImportSession(Bytes(5, std::byte{'y'})).ok());
  EXPECT_EQ(fake_.import.file().data().data(), "yyyyy");
}

}  // namespace
}  // namespace pliant::client
