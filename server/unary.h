#pragma once

#include <grpcpp/grpcpp.h>

#include "core/base/result.h"
#include "server/access.h"
#include "server/error_status.h"

/// How calls with one answer end. Any thread.
namespace pliant::server {

/// Ends the call now: with its response, or with the error.
inline grpc::ServerUnaryReactor* End(grpc::CallbackServerContext* call, const Status& status) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  reactor->Finish(status.ok() ? grpc::Status::OK : ToGrpcStatus(status.error()));
  return reactor;
}

/// Ends the call of somebody whom the server does not know.
inline grpc::ServerUnaryReactor* Refuse(grpc::CallbackServerContext* call) {
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  reactor->Finish(Access::Refusal());
  return reactor;
}

}  // namespace pliant::server
