#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "pliant/v1/session.grpc.pb.h"
#include "server/access.h"
#include "server/call_counter.h"
#include "server/convert.h"
#include "server/download.h"
#include "server/keeper.h"
#include "server/session.h"
#include "server/session_registry.h"

namespace pliant::server {

/// What the services share; everything outlives them.
struct ServiceContext {
  /// Where sessions are kept; null: in memory only.
  Keeper* keeper = nullptr;
  SessionRegistry* registry = nullptr;
  const Access* access = nullptr;
  /// Of the calls that last: uploads, downloads, edit streams.
  CallCounter* calls = nullptr;
  Session::Environment session;
  TenantAccounts* accounts = nullptr;
  RequestLimits limits;
  std::size_t sessions_max = 0;
  std::size_t jobs_max = 0;
  std::chrono::milliseconds bookmark_interval{0};
};

/// The metric and the loop of the current revision are at hand. Error: kProtocolOrder.
[[nodiscard]] Status CheckNothingStaged(const CommittedState& state);

/// What a new or stored session of a tenant uses.
[[nodiscard]] Session::Environment EnvironmentOf(const ServiceContext& context,
                                                 const std::string& tenant, const std::string& id,
                                                 Durability durability);

/// The calls on sessions. None of them computes: they look up, queue and answer.
///
/// *Threads*: any; gRPC calls it from several at once.
class SessionServiceImpl final : public v1::SessionService::CallbackService {
 public:
  explicit SessionServiceImpl(ServiceContext context) : context_(std::move(context)) {}

  grpc::ServerReadReactor<v1::CreateSessionRequest>* CreateSession(
      grpc::CallbackServerContext* call, v1::CreateSessionResponse* response) override;
  grpc::ServerUnaryReactor* GetSession(grpc::CallbackServerContext* call,
                                       const v1::GetSessionRequest* request,
                                       v1::GetSessionResponse* response) override;
  grpc::ServerUnaryReactor* ListSessions(grpc::CallbackServerContext* call,
                                         const v1::ListSessionsRequest* request,
                                         v1::ListSessionsResponse* response) override;
  grpc::ServerUnaryReactor* DeleteSession(grpc::CallbackServerContext* call,
                                          const v1::DeleteSessionRequest* request,
                                          v1::DeleteSessionResponse* response) override;
  grpc::ServerBidiReactor<v1::EditRequest, v1::EditResponse>* Edit(
      grpc::CallbackServerContext* call) override;
  grpc::ServerWriteReactor<v1::SubscribeResponse>* Subscribe(
      grpc::CallbackServerContext* call, const v1::SubscribeRequest* request) override;
  grpc::ServerWriteReactor<v1::GetMeshResponse>* GetMesh(
      grpc::CallbackServerContext* call, const v1::GetMeshRequest* request) override;
  grpc::ServerUnaryReactor* GetQuality(grpc::CallbackServerContext* call,
                                       const v1::GetQualityRequest* request,
                                       v1::GetQualityResponse* response) override;
  // In service_revisions.cc.
  grpc::ServerUnaryReactor* SaveRevision(grpc::CallbackServerContext* call,
                                         const v1::SaveRevisionRequest* request,
                                         v1::SaveRevisionResponse* response) override;
  grpc::ServerUnaryReactor* RollbackTo(grpc::CallbackServerContext* call,
                                       const v1::RollbackToRequest* request,
                                       v1::RollbackToResponse* response) override;
  grpc::ServerUnaryReactor* Release(grpc::CallbackServerContext* call,
                                    const v1::ReleaseRequest* request,
                                    v1::ReleaseResponse* response) override;
  grpc::ServerUnaryReactor* Fork(grpc::CallbackServerContext* call, const v1::ForkRequest* request,
                                 v1::ForkResponse* response) override;
  // In service_files.cc.
  grpc::ServerWriteReactor<v1::ExportSessionResponse>* ExportSession(
      grpc::CallbackServerContext* call, const v1::ExportSessionRequest* request) override;
  grpc::ServerReadReactor<v1::ImportSessionRequest>* ImportSession(
      grpc::CallbackServerContext* call, v1::ImportSessionResponse* response) override;

 private:
  Status BeginExport(const Result<const CommittedState*>& result, const std::string& tenant,
                     Download<v1::ExportSessionResponse>* download);
  static void SendFile(Download<v1::ExportSessionResponse>* download,
                       const std::map<std::string, std::string>& labels,
                       Result<SessionMemory> memory);
  Status BeginFork(const CommittedState& state, const std::string& tenant,
                   const v1::ForkRequest& request, v1::ForkResponse& response,
                   const std::function<void(const Status&)>& finish);

  const ServiceContext context_;
  std::atomic<int> downloads_ = 0;
};

/// What the server says about itself.
class ServerServiceImpl final : public v1::ServerService::CallbackService {
 public:
  explicit ServerServiceImpl(ServiceContext context) : context_(std::move(context)) {}

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* call,
                                          const v1::GetServerInfoRequest* request,
                                          v1::GetServerInfoResponse* response) override;

 private:
  const ServiceContext context_;
};

}  // namespace pliant::server
