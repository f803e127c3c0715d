#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>

#include "pliant/v1/session.pb.h"
#include "server/service.h"
#include "server/upload.h"

namespace pliant::server {

/// One ImportSession: takes the upload, then has the session read on a worker.
class Importing final : public Upload<v1::ImportSessionRequest, v1::ImportSession> {
 public:
  /// @param context, call, response  outlive the call.
  Importing(const ServiceContext& context, grpc::CallbackServerContext* call,
            v1::ImportSessionResponse* response);

 private:
  v1::ImportSession* LastIn(v1::ImportSessionRequest& request) override;
  Status Begin(v1::ImportSession import) override;
  void Complete(const std::shared_ptr<Session>& session, const Status& status);

  const ServiceContext& context_;
  grpc::CallbackServerContext* const call_;
  v1::ImportSessionResponse* const response_;
};

}  // namespace pliant::server
