#include "server/access.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor_database.h>
#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/job_client.h"

namespace pliant::server {
namespace {

constexpr const char* kTokens =
    "# token            tenant\n"
    "aaaaaaaaaaaaaaaa   wing\n"
    "bbbbbbbbbbbbbbbb   wing\n"
    "\n"
    "cccccccccccccccc   rotor\n";

TEST(Access, KnowsTheTenantOfAToken) {
  const Access access = Access::FromText(kTokens).value();
  EXPECT_EQ(access.TenantOf("Bearer aaaaaaaaaaaaaaaa").value(), "wing");
  EXPECT_EQ(access.TenantOf("Bearer bbbbbbbbbbbbbbbb").value(), "wing");
  EXPECT_EQ(access.TenantOf("Bearer cccccccccccccccc").value(), "rotor");
  for (const char* wrong : {"", "Bearer ", "Bearer aaaaaaaaaaaaaaa", "aaaaaaaaaaaaaaaa",
                            "Bearer aaaaaaaaaaaaaaab", "bearer aaaaaaaaaaaaaaaa"}) {
    EXPECT_FALSE(access.TenantOf(wrong).has_value()) << wrong;
  }
  EXPECT_EQ(Access().TenantOf("").value(), "");
}

TEST(Access, RefusesAFileThatIsNotMeantSo) {
  EXPECT_EQ(Access::FromText("aaaaaaaaaaaaaaaa").error().index, 0);
  EXPECT_EQ(Access::FromText("#\naaaaaaaaaaaaaaaa a b").error().index, 1);
  EXPECT_EQ(Access::FromText("short a").error().index, 0);
  EXPECT_EQ(Access::FromText("# nothing\n").error().code, ErrorCode::kFileSyntax);
  EXPECT_EQ(Access::FromFile("/nowhere").error().code, ErrorCode::kFileNotFound);
}

// Of all services of the protocol that this program knows.
std::map<std::string, std::set<std::string>> MethodsOfServices() {
  // Files are known once a message of theirs is used.
  static_cast<void>(v1::GetSessionRequest::descriptor());
  static_cast<void>(v1::GetJobRequest::descriptor());
  std::vector<std::string> names;
  using google::protobuf::DescriptorPool;
  EXPECT_TRUE(DescriptorPool::internal_generated_database()->FindAllFileNames(&names));
  std::map<std::string, std::set<std::string>> methods;
  for (const std::string& name : names) {
    const auto* file = DescriptorPool::generated_pool()->FindFileByName(name);
    if (file == nullptr || file->package() != "pliant.v1") continue;
    for (int i = 0; i < file->service_count(); ++i) {
      for (int j = 0; j < file->service(i)->method_count(); ++j) {
        methods[file->service(i)->name()].insert(file->service(i)->method(j)->name());
      }
    }
  }
  return methods;
}

// Goal: one tenant never sees another's session, whatever call it makes; without a token nobody
// sees anything.
// Method: every call of the service on a session of `wing`, as its owner, as `rotor`, and as
// nobody. The service itself says which calls it has: one that nobody has thought of fails.
class TenantsTest : public testing::Test {
 protected:
  static Config WithTokens() {
    Config config;
    config.tokens = std::string(PLIANT_SOURCE_DIR) + "/tests/data/tokens.txt";
    config.sessions_per_tenant_max = 3;
    return config;
  }
  using Call = std::function<grpc::Status(grpc::ClientContext*)>;
  grpc::Status As(const std::string& token, const Call& call) {
    grpc::ClientContext context;
    if (!token.empty()) context.AddMetadata("authorization", "Bearer " + token);
    return call(&context);
  }
  template <class Request>
  static Request Named(const std::string& id) {
    Request request;
    request.set_session_id(id);
    return request;
  }
  grpc::Status Create(grpc::ClientContext* context, const std::string& id) {
    v1::CreateSessionResponse response;
    const auto writer = server_.sessions->CreateSession(context, &response);
    v1::CreateSessionRequest request;
    *request.mutable_create() = test::UnitSquare("0.5");
    request.mutable_create()->set_session_id(id);
    writer->Write(request);
    writer->WritesDone();
    return writer->Finish();
  }
  grpc::Status Open(grpc::ClientContext* context, const std::string& id) {
    const auto stream = server_.sessions->Edit(context);
    v1::EditRequest request;
    request.mutable_open()->set_session_id(id);
    stream->Write(request);
    request.Clear();
    request.set_update_id(++last_update_id_);
    request.mutable_advance();
    stream->Write(request);
    stream->WritesDone();
    v1::EditResponse response;
    while (stream->Read(&response)) {
    }
    return stream->Finish();
  }
  template <class Reader, class Response>
  static grpc::Status First(const Reader& reader, Response response, grpc::ClientContext* context) {
    if (reader->Read(&response)) {
      context->TryCancel();
      reader->Finish();
      return grpc::Status::OK;
    }
    return reader->Finish();
  }

  template <class Request, class Response>
  using Method = grpc::Status (v1::SessionService::Stub::*)(grpc::ClientContext*, const Request&,
                                                            Response*);
  // A call with one answer.
  template <class Request, class Response>
  Call Unary(Method<Request, Response> method, const Request& request) {
    return [this, method, request](grpc::ClientContext* context) {
      Response response;
      return (server_.sessions.get()->*method)(context, request, &response);
    };
  }

  // Every call of the service that names a session, on the session `s`, which has two revisions; in
  // an order in which its owner can make them all.
  std::vector<std::pair<std::string, Call>> Calls() {
    using Stub = v1::SessionService::Stub;
    auto& stub = *server_.sessions;
    auto save = Named<v1::SaveRevisionRequest>("s");
    save.set_revision(1);
    auto release = Named<v1::ReleaseRequest>("s");
    release.add_revisions(1);
    auto roll_back = Named<v1::RollbackToRequest>("s");
    roll_back.set_to_revision(1);
    roll_back.set_update_id(1'000);
    auto fork = Named<v1::ForkRequest>("s");
    fork.set_new_session_id("f");
    return {
        {"Edit", [&](grpc::ClientContext* context) { return Open(context, "s"); }},
        {"GetSession", Unary(&Stub::GetSession, Named<v1::GetSessionRequest>("s"))},
        {"GetQuality", Unary(&Stub::GetQuality, Named<v1::GetQualityRequest>("s"))},
        {"SaveRevision", Unary(&Stub::SaveRevision, save)},
        {"Release", Unary(&Stub::Release, release)},
        {"RollbackTo", Unary(&Stub::RollbackTo, roll_back)},
        {"Fork", Unary(&Stub::Fork, fork)},
        {"Subscribe",
         [&](grpc::ClientContext* context) {
           return First(stub.Subscribe(context, Named<v1::SubscribeRequest>("s")),
                        v1::SubscribeResponse(), context);
         }},
        {"GetMesh",
         [&](grpc::ClientContext* context) {
           return First(stub.GetMesh(context, Named<v1::GetMeshRequest>("s")),
                        v1::GetMeshResponse(), context);
         }},
        {"ExportSession",
         [&](grpc::ClientContext* context) {
           return First(stub.ExportSession(context, Named<v1::ExportSessionRequest>("s")),
                        v1::ExportSessionResponse(), context);
         }},
        {"DeleteSession", Unary(&Stub::DeleteSession, Named<v1::DeleteSessionRequest>("s"))},
    };
  }
  // Calls that name no session of somebody's, and why they need no entry above.
  static std::map<std::string, std::string> OtherCalls() {
    return {{"CreateSession", "makes one of the caller's own; names are a tenant's own, see below"},
            {"ImportSession", "as CreateSession, by the same code"},
            {"ListSessions", "lists the caller's own, see ListsAndIdsAndLimitsAreATenantsOwn"}};
  }

  test::InProcessServer server_{RemesherFactory(), WithTokens()};
  std::int64_t last_update_id_ = 0;
};

TEST_F(TenantsTest, NoCallSeesAnothersSession) {
  const std::vector<std::pair<std::string, Call>> calls = Calls();
  std::set<std::string> covered;
  for (const auto& [name, call] : calls) EXPECT_TRUE(covered.insert(name).second) << name;
  for (const auto& [name, why] : OtherCalls()) EXPECT_TRUE(covered.insert(name).second) << name;
  ASSERT_EQ(covered, MethodsOfServices()["SessionService"])
      << "a call without an entry in Calls() or OtherCalls(), or an entry without a call";

  ASSERT_TRUE(As("aaaaaaaaaaaaaaaa", [&](auto* context) { return Create(context, "s"); }).ok());
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(As("aaaaaaaaaaaaaaaa", calls[0].second).ok());
  for (const auto& [name, call] : calls) {
    SCOPED_TRACE(name);
    EXPECT_EQ(test::ReasonOf(As("cccccccccccccccc", call)), "SESSION_NOT_FOUND");
    EXPECT_EQ(test::ReasonOf(As("", call)), "UNAUTHENTICATED");
    EXPECT_EQ(As("dddddddddddddddd", call).error_code(), grpc::StatusCode::UNAUTHENTICATED);
    const grpc::Status status = As("bbbbbbbbbbbbbbbb", call);
    EXPECT_TRUE(status.ok()) << status.error_message();
  }
}

// The other services: that of jobs is asked below, and what a server tells of itself is no tenant's
// (but for nobody to see who has no token).
TEST_F(TenantsTest, EveryServiceHasATest) {
  std::set<std::string> services;
  for (const auto& [name, methods] : MethodsOfServices()) services.insert(name);
  EXPECT_THAT(services, testing::ElementsAre("JobService", "ServerService", "SessionService"));
  EXPECT_THAT(MethodsOfServices()["ServerService"], testing::ElementsAre("GetServerInfo"));
  const Call info = [&](grpc::ClientContext* context) {
    v1::GetServerInfoResponse response;
    return server_.info->GetServerInfo(context, {}, &response);
  };
  EXPECT_EQ(test::ReasonOf(As("", info)), "UNAUTHENTICATED");
  EXPECT_TRUE(As("cccccccccccccccc", info).ok());
}

// Method: every call of the service for jobs on a job of `wing`, as its owner, as `rotor`, and as
// nobody; then the same id for `rotor`, who sees his own.
TEST_F(TenantsTest, NoCallSeesAnothersJob) {
  test::JobClient wing(server_, "aaaaaaaaaaaaaaaa");
  test::JobClient wing_too(server_, "bbbbbbbbbbbbbbbb");
  test::JobClient rotor(server_, "cccccccccccccccc");
  test::JobClient nobody(server_);
  EXPECT_EQ(nobody.Submit(test::SquareJob("j")).error_code(), grpc::StatusCode::UNAUTHENTICATED);
  ASSERT_TRUE(wing.Submit(test::SquareJob("j", "0.5")).ok());
  EXPECT_EQ(wing.Wait("j").state(), v1::JOB_STATE_DONE);
  v1::Job job;
  v1::MeshSnapshot mesh;
  v1::ListJobsResponse list;
  const std::map<std::string, std::function<grpc::Status(test::JobClient&)>> calls = {
      {"GetJob", [&](test::JobClient& client) { return client.Get("j", &job); }},
      {"CancelJob", [&](test::JobClient& client) { return client.Cancel("j", &job); }},
      {"FetchResult", [&](test::JobClient& client) { return client.Fetch("j", &mesh); }}};
  // Submitted and listed above and below.
  std::set<std::string> covered{"SubmitJob", "ListJobs"};
  for (const auto& [name, call] : calls) covered.insert(name);
  ASSERT_EQ(covered, MethodsOfServices()["JobService"]) << "a call without an entry";
  for (const auto& [name, call] : calls) {
    SCOPED_TRACE(name);
    EXPECT_EQ(test::ReasonOf(call(rotor)), "JOB_NOT_FOUND");
    EXPECT_EQ(test::ReasonOf(call(nobody)), "UNAUTHENTICATED");
    EXPECT_TRUE(call(wing_too).ok());
  }
  EXPECT_EQ(nobody.List({}, &list).error_code(), grpc::StatusCode::UNAUTHENTICATED);
  ASSERT_TRUE(rotor.List({}, &list).ok());
  EXPECT_EQ(list.jobs_size(), 0);
  ASSERT_TRUE(rotor.Submit(test::SquareJob("j", "0.3")).ok());
  EXPECT_EQ(rotor.Wait("j").state(), v1::JOB_STATE_DONE);
  ASSERT_TRUE(wing.List({}, &list).ok());
  EXPECT_EQ(list.jobs_size(), 1);
}

TEST_F(TenantsTest, ListsAndIdsAndLimitsAreATenantsOwn) {
  const auto create = [&](const std::string& token, const std::string& id) {
    return As(token, [&](auto* context) { return Create(context, id); });
  };
  const auto list = [&](const std::string& token) {
    v1::ListSessionsResponse response;
    EXPECT_TRUE(As(token, [&](auto* context) {
                  return server_.sessions->ListSessions(context, {}, &response);
                }).ok());
    return response.sessions_size();
  };
  EXPECT_EQ(create("", "s").error_code(), grpc::StatusCode::UNAUTHENTICATED);
  for (const char* id : {"s", "t", "u"}) EXPECT_TRUE(create("aaaaaaaaaaaaaaaa", id).ok());
  const grpc::Status full = create("bbbbbbbbbbbbbbbb", "v");
  EXPECT_EQ(test::ReasonOf(full), "RESOURCE_EXHAUSTED");
  EXPECT_TRUE(create("cccccccccccccccc", "s").ok())
      << "the other tenant has room and its own names";
  EXPECT_EQ(list("aaaaaaaaaaaaaaaa"), 3);
  EXPECT_EQ(list("cccccccccccccccc"), 1);
  v1::ListSessionsResponse response;
  EXPECT_EQ(
      As("", [&](auto* context) { return server_.sessions->ListSessions(context, {}, &response); })
          .error_code(),
      grpc::StatusCode::UNAUTHENTICATED);
}

}  // namespace
}  // namespace pliant::server
