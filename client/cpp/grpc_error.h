#pragma once

#include <grpcpp/support/status.h>

#include <string_view>

#include "core/base/result.h"
#include "pliant/v1/errors.pb.h"

namespace pliant::client {

/// The cause with this name on the wire; `fallback` for a name that this version does not know.
[[nodiscard]] ErrorCode ErrorCodeFromName(std::string_view name, ErrorCode fallback);

/// A refusal as it was on the server: code, message, field and indices.
[[nodiscard]] Error ErrorFromDetail(const v1::ErrorDetail& detail);

/// The failure of a call: the refusal in its trailer, or, where gRPC itself or something between
/// speaks, the nearest cause (kUnavailable, also for a call that a closing server cancelled,
/// kDeadlineExceeded, kUnimplemented, kResourceExhausted, else kInternal). @pre !status.ok()
[[nodiscard]] Error ErrorFromStatus(const grpc::Status& status);

}  // namespace pliant::client
