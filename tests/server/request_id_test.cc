#include "server/request_id.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "pliant/v1/session.grpc.pb.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

// Answers each call with the id that it has in the log.
class EchoService final : public v1::ServerService::CallbackService {
 public:
  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* call,
                                          const v1::GetServerInfoRequest*,
                                          v1::GetServerInfoResponse* response) override {
    response->set_version(RequestIdOf(*call));
    grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
    reactor->Finish(grpc::Status::OK);
    return reactor;
  }
};

TEST(RequestId, IsTheClientsOrMadeUp) {
  EchoService service;
  int port = 0;
  grpc::ServerBuilder builder;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  builder.RegisterService(&service);
  const std::unique_ptr<grpc::Server> server = builder.BuildAndStart();
  const auto stub = v1::ServerService::NewStub(
      grpc::CreateChannel("127.0.0.1:" + std::to_string(port), grpc::InsecureChannelCredentials()));
  const auto id_of = [&](const std::string& sent) {
    grpc::ClientContext context;
    if (!sent.empty()) context.AddMetadata("x-request-id", sent);
    v1::GetServerInfoResponse response;
    EXPECT_TRUE(stub->GetServerInfo(&context, {}, &response).ok());
    return response.version();
  };
  EXPECT_EQ(id_of("abc-1"), "abc-1");
  EXPECT_EQ(id_of(std::string(kRequestIdLengthMax + 1, 'x')),
            std::string(kRequestIdLengthMax, 'x'));
  EXPECT_NE(id_of(""), id_of(""));
}

}  // namespace
}  // namespace pliant::server
