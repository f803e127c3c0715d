#include "server/error_status.h"

#include "core/base/check.h"

namespace pliant::server {
namespace {

constexpr const char* kTypePrefix = "type.googleapis.com/";

std::string PathOf(const Error& error) {
  if (error.index < 0) return error.field;
  return error.field + "[" + std::to_string(error.index) + "]";
}

}  // namespace

grpc::Status ToGrpcStatus(const Error& error) {
  const grpc::StatusCode code = StatusCodeOf(error.code);
  v1::ErrorStatus status;
  status.set_code(code);
  status.set_message(error.message);

  google::protobuf::Any* detail = status.add_details();
  detail->set_type_url(std::string(kTypePrefix) + "pliant.v1.ErrorDetail");
  detail->set_value(ToErrorDetail(error).SerializeAsString());

  if (code == grpc::StatusCode::INVALID_ARGUMENT) {
    v1::BadRequest bad_request;
    v1::BadRequest::FieldViolation* violation = bad_request.add_field_violations();
    violation->set_field(PathOf(error));
    violation->set_description(std::string(ErrorCodeName(error.code)) + ": " + error.message);
    google::protobuf::Any* any = status.add_details();
    // The same bytes as Google's message, under its name, so that generic tools understand it.
    any->set_type_url(std::string(kTypePrefix) + "google.rpc.BadRequest");
    any->set_value(bad_request.SerializeAsString());
  }
  if (error.retry_after_ms > 0) {
    v1::RetryInfo retry;
    retry.mutable_retry_delay()->set_seconds(error.retry_after_ms / 1000);
    retry.mutable_retry_delay()->set_nanos(
        static_cast<std::int32_t>(error.retry_after_ms % 1000 * 1'000'000));
    google::protobuf::Any* any = status.add_details();
    any->set_type_url(std::string(kTypePrefix) + "google.rpc.RetryInfo");
    any->set_value(retry.SerializeAsString());
  }
  return grpc::Status(code, error.message, status.SerializeAsString());
}

v1::ErrorDetail ToErrorDetail(const Error& error) {
  v1::ErrorDetail detail;
  detail.set_reason(std::string(ErrorCodeName(error.code)));
  if (error.code == ErrorCode::kInternal) {
    detail.set_reference(error.field);  // A bug has no field; what it has is a name to quote.
  } else {
    detail.set_field(error.field);
  }
  detail.set_index(error.index);
  detail.set_other_index(error.other_index);
  detail.set_message(error.message);
  detail.set_code(StatusCodeOf(error.code));
  detail.set_retry_after_ms(error.retry_after_ms);
  return detail;
}

grpc::StatusCode StatusCodeOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::kArrayLength:
    case ErrorCode::kArrayType:
    case ErrorCode::kIndexOutOfRange:
    case ErrorCode::kDuplicateId:
    case ErrorCode::kNotFinite:
    case ErrorCode::kOutOfRange:
    case ErrorCode::kEmpty:
    case ErrorCode::kDuplicatePoint:
    case ErrorCode::kZeroLengthSegment:
    case ErrorCode::kDuplicateSegment:
    case ErrorCode::kCrossingSegments:
    case ErrorCode::kPointOnSegment:
    case ErrorCode::kOpenLoop:
    case ErrorCode::kSegmentOutsideDomain:
    case ErrorCode::kPointOutsideDomain:
    case ErrorCode::kSeedOutsideDomain:
    case ErrorCode::kConflictingRegions:
    case ErrorCode::kNothingInside:
    case ErrorCode::kTriangleDegenerate:
    case ErrorCode::kTriangleOrientation:
    case ErrorCode::kNonManifoldEdge:
    case ErrorCode::kNotConforming:
    case ErrorCode::kEdgeNotInMesh:
    case ErrorCode::kNotPositiveDefinite:
    case ErrorCode::kExpressionSyntax:
    case ErrorCode::kExpressionValue:
    case ErrorCode::kFileSyntax:
    case ErrorCode::kFileUnsupported:
      return grpc::StatusCode::INVALID_ARGUMENT;
    case ErrorCode::kSessionNotFound:
    case ErrorCode::kRevisionNotFound:
    case ErrorCode::kFileNotFound:
    case ErrorCode::kJobNotFound:
      return grpc::StatusCode::NOT_FOUND;
    case ErrorCode::kSessionExists:
    case ErrorCode::kJobExists:
      return grpc::StatusCode::ALREADY_EXISTS;
    case ErrorCode::kProtocolOrder:
    case ErrorCode::kUpdateRejected:
    case ErrorCode::kFrozen:
    case ErrorCode::kRevisionMismatch:
    case ErrorCode::kJobNotDone:
    case ErrorCode::kFileUnreadable:
    case ErrorCode::kFileUnwritable:
    case ErrorCode::kDataVersion:
      return grpc::StatusCode::FAILED_PRECONDITION;
    case ErrorCode::kSessionBusy:
      return grpc::StatusCode::ABORTED;
    case ErrorCode::kResourceExhausted:
    case ErrorCode::kTooLarge:
      return grpc::StatusCode::RESOURCE_EXHAUSTED;
    case ErrorCode::kCancelled:
      return grpc::StatusCode::CANCELLED;
    case ErrorCode::kDeadlineExceeded:
      return grpc::StatusCode::DEADLINE_EXCEEDED;
    case ErrorCode::kUnavailable:
      return grpc::StatusCode::UNAVAILABLE;
    case ErrorCode::kUnimplemented:
      return grpc::StatusCode::UNIMPLEMENTED;
    case ErrorCode::kReplicaMismatch:
    case ErrorCode::kDataCorrupt:
      return grpc::StatusCode::DATA_LOSS;
    case ErrorCode::kInternal:
      return grpc::StatusCode::INTERNAL;
  }
  // Out of the enum: memory is broken.
  PLIANT_CHECK(false, "code", static_cast<int>(code));
}

}  // namespace pliant::server
