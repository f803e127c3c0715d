#include "client/cpp/grpc_error.h"

#include <string>

namespace pliant::client {
namespace {

ErrorCode CodeFromGrpc(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::CANCELLED:
      return ErrorCode::kCancelled;
    case grpc::StatusCode::INVALID_ARGUMENT:
    case grpc::StatusCode::OUT_OF_RANGE:
      return ErrorCode::kOutOfRange;
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return ErrorCode::kDeadlineExceeded;
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return ErrorCode::kResourceExhausted;
    case grpc::StatusCode::FAILED_PRECONDITION:
      return ErrorCode::kProtocolOrder;
    case grpc::StatusCode::UNIMPLEMENTED:
      return ErrorCode::kUnimplemented;
    case grpc::StatusCode::UNAVAILABLE:
      return ErrorCode::kUnavailable;
    default:
      return ErrorCode::kInternal;
  }
}

/// The sentence for a person where only gRPC itself had something to say.
std::string Sentence(const grpc::Status& status, ErrorCode code) {
  switch (code) {
    case ErrorCode::kUnavailable:
      return "the server cannot be reached, or the connection broke (" + status.error_message() +
             "); check that pliantd runs at this address";
    case ErrorCode::kDeadlineExceeded:
      return "the server did not answer in time; try again, or allow more time";
    case ErrorCode::kUnimplemented:
      return "the server does not know this call (" + status.error_message() +
             "); is it a pliantd, and as new as this client?";
    default:
      return status.error_message().empty() ? "the call failed" : status.error_message();
  }
}

}  // namespace

ErrorCode ErrorCodeFromName(std::string_view name, ErrorCode fallback) {
  for (int i = 0; i <= static_cast<int>(ErrorCode::kInternal); ++i) {
    const auto code = static_cast<ErrorCode>(i);
    if (ErrorCodeName(code) == name) return code;
  }
  return fallback;
}

Error ErrorFromDetail(const v1::ErrorDetail& detail) {
  const ErrorCode nearest = CodeFromGrpc(static_cast<grpc::StatusCode>(detail.code()));
  std::string message = detail.message();
  if (!detail.reference().empty()) message += " (reference " + detail.reference() + ")";
  return {.code = ErrorCodeFromName(detail.reason(), nearest),
          .message = std::move(message),
          .field = detail.field(),
          .index = detail.index(),
          .other_index = detail.other_index(),
          .retry_after_ms = detail.retry_after_ms()};
}

Error ErrorFromStatus(const grpc::Status& status) {
  v1::ErrorStatus details;
  if (details.ParseFromString(status.error_details())) {
    for (const google::protobuf::Any& any : details.details()) {
      v1::ErrorDetail detail;
      if (any.Is<v1::ErrorDetail>() && any.UnpackTo(&detail)) return ErrorFromDetail(detail);
    }
  }
  ErrorCode code = CodeFromGrpc(status.error_code());
  // gRPC's own word for calls that reach a server while it shuts down. Whoever cancels a call of
  // this client knows that, and does not look at its status.
  if (code == ErrorCode::kCancelled) code = ErrorCode::kUnavailable;
  return {.code = code, .message = Sentence(status, code)};
}

}  // namespace pliant::client
