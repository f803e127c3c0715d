#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <optional>
#include <string>

#include "pliant/v1/session.pb.h"
#include "server/blobs.h"
#include "server/service.h"

namespace pliant::server {

/// One ImportSession: takes the upload, then has the session read on a worker.
///
/// *Threads*: gRPC's callbacks follow each other; the worker's answer comes after the last of them
/// that touches anything.
class Importing final : public grpc::ServerReadReactor<v1::ImportSessionRequest> {
 public:
  /// @param context, call, response  outlive the call. gRPC owns the result.
  Importing(const ServiceContext& context, grpc::CallbackServerContext* call,
            v1::ImportSessionResponse* response);

  void OnReadDone(bool ok) override;
  void OnDone() override;

 private:
  Status Take(v1::ImportSessionRequest& request);
  Status Begin();
  void Complete(const std::shared_ptr<Session>& session, const Status& status);

  const ServiceContext& context_;
  grpc::CallbackServerContext* const call_;
  v1::ImportSessionResponse* const response_;
  const std::optional<std::string> tenant_;  // Of the caller; nothing: refused.
  v1::ImportSessionRequest request_;
  BlobAssembler blobs_;
  std::optional<v1::ImportSession> import_;
};

}  // namespace pliant::server
