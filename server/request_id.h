#pragma once

#include <grpcpp/grpcpp.h>

#include <string>

namespace pliant::server {

/// The name of a call in the log: what the client sent as `x-request-id` (its first 64 characters),
/// or one made up, "r-17".
[[nodiscard]] std::string RequestIdOf(const grpc::CallbackServerContext& call);

}  // namespace pliant::server
