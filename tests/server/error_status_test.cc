#include "server/error_status.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

namespace pliant::server {
namespace {

// Goal: the table of proto/README.md is what clients get; one row of each status is spelled out.
TEST(ErrorStatus, MapsCausesAsTheReadmeSays) {
  const std::map<ErrorCode, grpc::StatusCode> table = {
      {ErrorCode::kCrossingSegments, grpc::StatusCode::INVALID_ARGUMENT},
      {ErrorCode::kArrayType, grpc::StatusCode::INVALID_ARGUMENT},
      {ErrorCode::kSessionNotFound, grpc::StatusCode::NOT_FOUND},
      {ErrorCode::kRevisionNotFound, grpc::StatusCode::NOT_FOUND},
      {ErrorCode::kJobNotFound, grpc::StatusCode::NOT_FOUND},
      {ErrorCode::kJobExists, grpc::StatusCode::ALREADY_EXISTS},
      {ErrorCode::kJobNotDone, grpc::StatusCode::FAILED_PRECONDITION},
      {ErrorCode::kSessionExists, grpc::StatusCode::ALREADY_EXISTS},
      {ErrorCode::kProtocolOrder, grpc::StatusCode::FAILED_PRECONDITION},
      {ErrorCode::kUpdateRejected, grpc::StatusCode::FAILED_PRECONDITION},
      {ErrorCode::kSessionBusy, grpc::StatusCode::ABORTED},
      {ErrorCode::kTooLarge, grpc::StatusCode::RESOURCE_EXHAUSTED},
      {ErrorCode::kUnavailable, grpc::StatusCode::UNAVAILABLE},
      {ErrorCode::kUnimplemented, grpc::StatusCode::UNIMPLEMENTED},
      {ErrorCode::kReplicaMismatch, grpc::StatusCode::DATA_LOSS},
      {ErrorCode::kInternal, grpc::StatusCode::INTERNAL}};
  for (const auto& [code, status] : table) {
    EXPECT_EQ(StatusCodeOf(code), status) << ErrorCodeName(code);
  }
}

TEST(ErrorStatus, SaysWhenToTryAgain) {
  const grpc::Status status = ToGrpcStatus(
      {.code = ErrorCode::kResourceExhausted, .message = "later", .retry_after_ms = 2'500});
  v1::ErrorStatus wire;
  ASSERT_TRUE(wire.ParseFromString(status.error_details()));
  ASSERT_EQ(wire.details_size(), 2);
  v1::ErrorDetail detail;
  ASSERT_TRUE(detail.ParseFromString(wire.details(0).value()));
  EXPECT_EQ(detail.retry_after_ms(), 2'500);
  EXPECT_EQ(wire.details(1).type_url(), "type.googleapis.com/google.rpc.RetryInfo");
  v1::RetryInfo retry;
  ASSERT_TRUE(retry.ParseFromString(wire.details(1).value()));
  EXPECT_EQ(retry.retry_delay().seconds(), 2);
  EXPECT_EQ(retry.retry_delay().nanos(), 500'000'000);
}

TEST(ErrorStatus, SendsDetailsForProgramsAndABadRequestForTools) {
  const grpc::Status status = ToGrpcStatus({.code = ErrorCode::kCrossingSegments,
                                            .message = "segments 7 and 12 cross",
                                            .field = "domain.segments",
                                            .index = 7,
                                            .other_index = 12});
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(status.error_message(), "segments 7 and 12 cross");

  v1::ErrorStatus wire;
  ASSERT_TRUE(wire.ParseFromString(status.error_details()));
  EXPECT_EQ(wire.code(), 3);
  ASSERT_EQ(wire.details_size(), 2);
  EXPECT_EQ(wire.details(0).type_url(), "type.googleapis.com/pliant.v1.ErrorDetail");
  v1::ErrorDetail detail;
  ASSERT_TRUE(detail.ParseFromString(wire.details(0).value()));
  EXPECT_EQ(detail.reason(), "CROSSING_SEGMENTS");
  EXPECT_EQ(detail.field(), "domain.segments");
  EXPECT_EQ(detail.index(), 7);
  EXPECT_EQ(detail.other_index(), 12);
  EXPECT_EQ(detail.code(), 3);

  EXPECT_EQ(wire.details(1).type_url(), "type.googleapis.com/google.rpc.BadRequest");
  v1::BadRequest bad_request;
  ASSERT_TRUE(bad_request.ParseFromString(wire.details(1).value()));
  EXPECT_EQ(bad_request.field_violations(0).field(), "domain.segments[7]");
  EXPECT_EQ(bad_request.field_violations(0).description(),
            "CROSSING_SEGMENTS: segments 7 and 12 cross");
}

TEST(ErrorStatus, PutsTheReferenceOfABugIntoItsOwnField) {
  const v1::ErrorDetail detail =
      ToErrorDetail({.code = ErrorCode::kInternal, .message = "a bug", .field = "s-1-2-3"});
  EXPECT_EQ(detail.reference(), "s-1-2-3");
  EXPECT_EQ(detail.field(), "");
}

}  // namespace
}  // namespace pliant::server
