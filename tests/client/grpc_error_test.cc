#include "client/cpp/grpc_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pliant::client {
namespace {

using testing::HasSubstr;

TEST(GrpcError, EveryCauseHasANameThatLeadsBack) {
  for (int i = 0; i <= static_cast<int>(ErrorCode::kInternal); ++i) {
    const auto code = static_cast<ErrorCode>(i);
    const auto other = code == ErrorCode::kInternal ? ErrorCode::kCancelled : ErrorCode::kInternal;
    EXPECT_EQ(ErrorCodeFromName(ErrorCodeName(code), other), code) << ErrorCodeName(code);
  }
  EXPECT_EQ(ErrorCodeFromName("A_NAME_TO_COME", ErrorCode::kOutOfRange), ErrorCode::kOutOfRange);
}

v1::ErrorDetail Detail() {
  v1::ErrorDetail detail;
  detail.set_reason("CROSSING_SEGMENTS");
  detail.set_field("domain.segments");
  detail.set_index(7);
  detail.set_other_index(12);
  detail.set_message("segments 7 and 12 cross");
  detail.set_code(grpc::StatusCode::INVALID_ARGUMENT);
  return detail;
}

TEST(GrpcError, ARefusalKeepsCodeFieldAndIndices) {
  v1::ErrorStatus details;
  details.set_code(grpc::StatusCode::INVALID_ARGUMENT);
  v1::BadRequest bad_request;
  bad_request.add_field_violations()->set_field("domain.segments[7]");
  details.add_details()->PackFrom(bad_request);
  details.add_details()->PackFrom(Detail());
  const Error error = ErrorFromStatus(
      grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "other words", details.SerializeAsString()));
  EXPECT_EQ(error.code, ErrorCode::kCrossingSegments);
  EXPECT_EQ(error.field, "domain.segments");
  EXPECT_EQ(error.index, 7);
  EXPECT_EQ(error.other_index, 12);
  EXPECT_EQ(error.message, "segments 7 and 12 cross");
}

TEST(GrpcError, AnUnknownReasonFallsBackToTheGrpcCode) {
  v1::ErrorDetail detail = Detail();
  detail.set_reason("SOMETHING_NEW");
  detail.set_code(grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ErrorFromDetail(detail).code, ErrorCode::kResourceExhausted);
}

TEST(GrpcError, TheReferenceOfABugIsPartOfTheMessage) {
  v1::ErrorDetail detail = Detail();
  detail.set_reference("r-42");
  EXPECT_THAT(ErrorFromDetail(detail).message, HasSubstr("r-42"));
}

TEST(GrpcError, WithoutDetailsTheGrpcCodeSpeaks) {
  const auto code = [](grpc::StatusCode status, const std::string& details = {}) {
    return ErrorFromStatus(grpc::Status(status, "m", details)).code;
  };
  EXPECT_EQ(code(grpc::StatusCode::UNAVAILABLE), ErrorCode::kUnavailable);
  EXPECT_EQ(code(grpc::StatusCode::UNAVAILABLE, "no protobuf \xff"), ErrorCode::kUnavailable);
  EXPECT_EQ(code(grpc::StatusCode::DEADLINE_EXCEEDED), ErrorCode::kDeadlineExceeded);
  EXPECT_EQ(code(grpc::StatusCode::CANCELLED), ErrorCode::kUnavailable) << "a server that closes";
  EXPECT_EQ(code(grpc::StatusCode::UNIMPLEMENTED), ErrorCode::kUnimplemented);
  EXPECT_EQ(code(grpc::StatusCode::UNKNOWN), ErrorCode::kInternal);
}

}  // namespace
}  // namespace pliant::client
