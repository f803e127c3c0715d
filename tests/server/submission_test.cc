#include "server/submission.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "server/limits.h"
#include "tests/support/fake_server_parts.h"
#include "tests/support/job_client.h"

namespace pliant::server {
namespace {

v1::SubmitJobRequest RequestOf(const v1::SubmitJob& submit) {
  v1::SubmitJobRequest request;
  *request.mutable_submit() = submit;
  return request;
}

class SubmissionTest : public testing::Test {
 protected:
  test::InProcessServer server_{FakeFactory(std::make_shared<FakeEngineScript>())};
  test::JobClient client_{server_};
};

TEST_F(SubmissionTest, MakesAnIdOrTakesTheWishedOne) {
  v1::Job job;
  ASSERT_TRUE(client_.Submit(test::SquareJob(""), &job).ok());
  EXPECT_FALSE(job.job_id().empty());
  ASSERT_TRUE(client_.Submit(test::SquareJob("mine"), &job).ok());
  EXPECT_EQ(job.job_id(), "mine");
  EXPECT_EQ(job.state(), v1::JOB_STATE_QUEUED);
  const grpc::Status again = client_.Submit(test::SquareJob("mine"));
  EXPECT_EQ(again.error_code(), grpc::StatusCode::ALREADY_EXISTS);
  EXPECT_EQ(test::ReasonOf(again), "JOB_EXISTS");
}

TEST_F(SubmissionTest, RefusesMessagesInTheWrongOrder) {
  EXPECT_EQ(test::ReasonOf(client_.Upload({})), "PROTOCOL_ORDER");
  EXPECT_EQ(test::ReasonOf(client_.Upload({v1::SubmitJobRequest()})), "PROTOCOL_ORDER");
  const v1::SubmitJobRequest submit = RequestOf(test::SquareJob("a"));
  EXPECT_EQ(test::ReasonOf(client_.Upload({submit, submit})), "PROTOCOL_ORDER");
  v1::SubmitJob blob = test::SquareJob("a");
  blob.mutable_input()->mutable_domain()->mutable_points()->set_blob_id(1);
  EXPECT_EQ(test::ReasonOf(client_.Upload({RequestOf(blob)})), "PROTOCOL_ORDER");
  EXPECT_TRUE(client_.Submit(test::SquareJob("a")).ok()) << "no refusal took the id";
}

TEST_F(SubmissionTest, RefusesBadInputAtOnce) {
  v1::SubmitJob bad = test::SquareJob("a");
  *bad.mutable_input()->mutable_domain()->mutable_segments() = test::Ints({0, 9}, 2);
  EXPECT_EQ(test::ReasonOf(client_.Submit(bad)), "INDEX_OUT_OF_RANGE");
}

TEST_F(SubmissionTest, TakesLargeArraysInChunksAndNothingBeyondAMessage) {
  v1::SubmitJob large = test::SquareJob("large");
  std::vector<double> holes(2 * (kInlineBytesMax / 16 + 1), 0.5);
  *large.mutable_input()->mutable_domain()->mutable_holes() = test::Doubles(holes, 2);
  EXPECT_TRUE(client_.Submit(large).ok());
  v1::SubmitJob beyond = test::SquareJob("beyond");
  beyond.mutable_input()->mutable_domain()->mutable_holes()->set_data(
      std::string(kMessageBytesMax, 'x'));
  EXPECT_EQ(client_.Upload({RequestOf(beyond)}).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

}  // namespace
}  // namespace pliant::server
