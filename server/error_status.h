#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "core/base/result.h"
#include "pliant/v1/errors.pb.h"

namespace pliant::server {

/// The gRPC status that belongs to a cause: the table of proto/README.md.
[[nodiscard]] grpc::StatusCode StatusCodeOf(ErrorCode code);

/// The refusal as it stands in an edit stream. A kInternal error carries its reference in `field`.
[[nodiscard]] v1::ErrorDetail ToErrorDetail(const Error& error);

/// The refusal as the status that ends a call, with the details of errors.proto in its trailer.
[[nodiscard]] grpc::Status ToGrpcStatus(const Error& error);

}  // namespace pliant::server
