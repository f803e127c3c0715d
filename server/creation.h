#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <optional>
#include <string>

#include "pliant/v1/session.pb.h"
#include "server/blobs.h"
#include "server/service.h"

namespace pliant::server {

/// What a new session promises: what its creator wishes, else strict where there is a store.
/// Error: kUnimplemented with `field`.
[[nodiscard]] Result<Durability> DurabilityOr(const std::optional<Durability>& wished,
                                              const ServiceContext& context,
                                              const std::string& field);

/// One CreateSession: takes the upload, then has the session built on a worker.
///
/// *Threads*: gRPC's callbacks follow each other; the worker's answer comes after the last of them
/// that touches anything.
class Creation final : public grpc::ServerReadReactor<v1::CreateSessionRequest> {
 public:
  /// @param context, call, response  outlive the call. gRPC owns the result.
  Creation(const ServiceContext& context, grpc::CallbackServerContext* call,
           v1::CreateSessionResponse* response);

  void OnReadDone(bool ok) override;
  void OnDone() override;

 private:
  Status Take(v1::CreateSessionRequest& request);
  Status Begin();
  void Complete(const std::shared_ptr<Session>& session, const Status& status);

  const ServiceContext& context_;
  grpc::CallbackServerContext* const call_;
  v1::CreateSessionResponse* const response_;
  const std::string request_id_;
  const std::optional<std::string> tenant_;  // Of the caller; nothing: refused.
  v1::CreateSessionRequest request_;
  BlobAssembler blobs_;
  std::optional<v1::CreateSession> create_;
};

}  // namespace pliant::server
