#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <optional>
#include <string>

#include "pliant/v1/session.pb.h"
#include "server/service.h"
#include "server/upload.h"

namespace pliant::server {

/// What a new session promises: what its creator wishes, else strict where there is a store.
/// Error: kUnimplemented with `field`.
[[nodiscard]] Result<Durability> DurabilityOr(const std::optional<Durability>& wished,
                                              const ServiceContext& context,
                                              const std::string& field);

/// Makes a session known that was started for the caller; takes its id back if `started` is an
/// error or nobody waits for it any more. Returns how the call ends.
[[nodiscard]] grpc::Status Admit(const ServiceContext& context, const std::string& tenant,
                                 const std::shared_ptr<Session>& session, const Status& started,
                                 const grpc::CallbackServerContext& call);

/// One CreateSession: takes the upload, then has the session built on a worker.
class Creation final : public Upload<v1::CreateSessionRequest, v1::CreateSession> {
 public:
  /// @param context, call, response  outlive the call.
  Creation(const ServiceContext& context, grpc::CallbackServerContext* call,
           v1::CreateSessionResponse* response);

 private:
  v1::CreateSession* LastIn(v1::CreateSessionRequest& request) override;
  Status Begin(v1::CreateSession create) override;
  void Complete(const std::shared_ptr<Session>& session, const Status& status);

  const ServiceContext& context_;
  grpc::CallbackServerContext* const call_;
  v1::CreateSessionResponse* const response_;
  const std::string request_id_;
};

}  // namespace pliant::server
