#include "server/jobs/job_board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/fake_server_parts.h"

namespace pliant::server {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;

constexpr JobBoard::Bounds kRoomy = {.jobs_max = 100,
                                     .jobs_per_tenant_max = 100,
                                     .bytes_max = 1000,
                                     .bytes_per_tenant_max = 1000,
                                     .running_max = 1};

class JobBoardTest : public testing::Test {
 protected:
  void Use(const JobBoard::Bounds& bounds) {
    board_ = std::make_unique<JobBoard>(bounds, 7, clock_);
  }
  Result<JobInfo> TrySubmit(JobDraft draft) {
    Result<JobInfo> job = board_->Reserve(draft);
    if (job.ok()) board_->Publish(job->number);
    return job;
  }
  JobInfo Submit(const std::string& id, std::int32_t priority = 0,
                 const std::string& tenant = "t") {
    return TrySubmit({.key = {tenant, id}, .priority = priority, .keep = milliseconds(50)}).value();
  }
  // Runs the next job and ends it; its id, "-" if there is none.
  std::string RunOne() {
    const std::optional<JobBoard::Start> start = board_->TakeNext();
    if (!start) return "-";
    Finish(start->info.number);
    return start->info.key.job_id;
  }
  void Finish(std::int64_t number, std::size_t mesh_size = 3) {
    const auto ended = board_->BeginEnd(
        number, {.state = JobState::kDone, .outcome = Bytes(2), .mesh = Bytes(mesh_size)});
    ASSERT_TRUE(ended.has_value());
    board_->FinishEnd(*ended);
  }
  JobState StateOf(const std::string& id) { return board_->Find({"t", id}).value().state; }
  std::vector<std::string> Ids(const JobBoard::Page& page) {
    std::vector<std::string> ids;
    for (const JobInfo& job : page.jobs) ids.push_back(job.key.job_id);
    return ids;
  }

  ManualClock clock_;
  std::unique_ptr<JobBoard> board_ = std::make_unique<JobBoard>(kRoomy, 7, clock_);
};

TEST_F(JobBoardTest, RunsByPriorityAndThenByAge) {
  Submit("a");
  Submit("b", 5);
  Submit("c", -1);
  Submit("d", 5);
  Submit("e");
  std::vector<std::string> order;
  for (int i = 0; i < 6; ++i) order.push_back(RunOne());
  EXPECT_THAT(order, ElementsAre("b", "d", "a", "e", "c", "-"));
}

// Goal: promise Isolated. A hundred urgent jobs of one tenant hold up another's by one at most.
TEST_F(JobBoardTest, GivesTenantsTheirTurns) {
  for (int i = 0; i < 4; ++i) Submit(std::string("a").append(std::to_string(i)), 1000, "a");
  Submit("b0", -1000, "b");
  Submit("b1", -1000, "b");
  std::vector<std::string> order;
  for (int i = 0; i < 6; ++i) order.push_back(RunOne());
  EXPECT_THAT(order, ElementsAre("a0", "b0", "a1", "b1", "a2", "a3"));
}

TEST_F(JobBoardTest, CountsRunningJobsOfATenantAgainstIt) {
  JobBoard::Bounds bounds = kRoomy;
  bounds.running_max = 3;
  Use(bounds);
  for (int i = 0; i < 3; ++i) Submit(std::string("a").append(std::to_string(i)), 9, "a");
  EXPECT_EQ(board_->TakeNext()->info.key.job_id, "a0");
  EXPECT_EQ(board_->TakeNext()->info.key.job_id, "a1");
  Submit("b0", 0, "b");
  EXPECT_EQ(board_->TakeNext()->info.key.job_id, "b0");
  EXPECT_FALSE(board_->TakeNext().has_value()) << "three run";
}

TEST_F(JobBoardTest, HoldsAsManyJobsAsItMay) {
  JobBoard::Bounds bounds = kRoomy;
  bounds.jobs_max = 3;
  bounds.jobs_per_tenant_max = 2;
  Use(bounds);
  Submit("a");
  Submit("b");
  EXPECT_EQ(TrySubmit({.key = {"t", "c"}}).error().code, ErrorCode::kResourceExhausted)
      << "the tenant's";
  EXPECT_GT(TrySubmit({.key = {"t", "c"}}).error().retry_after_ms, 0) << "jobs expire";
  Submit("a", 0, "u");
  EXPECT_EQ(TrySubmit({.key = {"v", "c"}}).error().code, ErrorCode::kResourceExhausted)
      << "the server's";
  // A withdrawn reservation leaves its room and its id to others.
  Use(bounds);
  const JobInfo reserved = board_->Reserve({.key = {"t", "a"}}).value();
  EXPECT_EQ(board_->Reserve({.key = {"t", "a"}}).error().code, ErrorCode::kJobExists);
  EXPECT_EQ(board_->Find({"t", "a"}).error().code, ErrorCode::kJobNotFound) << "not published";
  EXPECT_FALSE(board_->TakeNext().has_value());
  board_->Withdraw(reserved.number);
  Submit("a");
  Submit("b");
}

TEST_F(JobBoardTest, CountsTheBytesOfInputsAndResults) {
  JobBoard::Bounds bounds = kRoomy;
  bounds.bytes_max = 20;
  bounds.bytes_per_tenant_max = 10;
  Use(bounds);
  const auto submit = [&](const std::string& tenant, std::size_t input_size) {
    return TrySubmit({.key = {tenant, ""}, .keep = milliseconds(50), .input_size = input_size});
  };
  ASSERT_TRUE(submit("t", 9).ok());
  ASSERT_TRUE(submit("t", 9).ok()) << "below the bound, whatever comes";
  EXPECT_EQ(submit("t", 0).error().code, ErrorCode::kResourceExhausted);
  ASSERT_TRUE(submit("u", 2).ok());
  EXPECT_EQ(submit("v", 0).error().code, ErrorCode::kResourceExhausted) << "20 of 20 in all";
  // The end frees the input and adds the mesh; the time's end frees that.
  Finish(board_->TakeNext()->info.number, /*mesh_size=*/0);
  ASSERT_TRUE(submit("t", 1).ok()) << "9 of 10";
  EXPECT_EQ(submit("t", 0).error().code, ErrorCode::kResourceExhausted) << "10 of 10";
  Finish(board_->TakeNext()->info.number, /*mesh_size=*/100);
  EXPECT_EQ(submit("v", 0).error().code, ErrorCode::kResourceExhausted);
  clock_.Advance(milliseconds(50));
  EXPECT_EQ(board_->TakeExpired().size(), 2U);
  ASSERT_TRUE(submit("v", 0).ok());
}

TEST_F(JobBoardTest, DropsAJobWhenItsTimeIsOverAndNotBefore) {
  Submit("a");
  Submit("waits");
  EXPECT_EQ(RunOne(), "a");
  const JobInfo done = board_->Find({"t", "a"}).value();
  EXPECT_EQ(*done.expire_time() - *done.end_time, milliseconds(50));
  clock_.Advance(milliseconds(49));
  EXPECT_TRUE(board_->TakeExpired().empty());
  EXPECT_EQ(StateOf("a"), JobState::kDone);
  clock_.Advance(milliseconds(1));
  EXPECT_EQ(board_->Find({"t", "a"}).error().code, ErrorCode::kJobNotFound) << "before the sweep";
  EXPECT_EQ(board_->Cancel({"t", "a"}).error().code, ErrorCode::kJobNotFound);
  EXPECT_THAT(Ids(board_->List("t", 0, 9)), ElementsAre("waits"));
  EXPECT_THAT(board_->TakeExpired(), ElementsAre(JobKey{"t", "a"}));
  EXPECT_TRUE(board_->TakeExpired().empty());
  Submit("a");  // The id is free.
}

TEST_F(JobBoardTest, CancelsAtOnceWhatWaitsAndKeepsThePlaceOfWhatRuns) {
  Submit("a");
  Submit("b");
  Submit("c");
  const JobBoard::Start start = board_->TakeNext().value();
  EXPECT_TRUE(board_->Cancel({"t", "b"}).value().changed);
  EXPECT_EQ(StateOf("b"), JobState::kCancelled);
  EXPECT_FALSE(start.stop->asked());
  const JobBoard::Cancelled cancelled = board_->Cancel({"t", "a"}).value();
  EXPECT_TRUE(cancelled.changed);
  EXPECT_EQ(cancelled.info.state, JobState::kCancelled);
  EXPECT_TRUE(start.stop->asked());
  EXPECT_FALSE(board_->Cancel({"t", "a"}).value().changed) << "the second time";
  EXPECT_FALSE(board_->TakeNext().has_value()) << "its work has not stopped";
  EXPECT_FALSE(board_->BeginEnd(start.info.number, {}).has_value()) << "it stays cancelled";
  board_->GiveBack(start.info.number);
  board_->GiveBack(start.info.number);  // Harmless.
  EXPECT_EQ(RunOne(), "c") << "b was cancelled";
  EXPECT_EQ(RunOne(), "-");
}

TEST_F(JobBoardTest, ForgetsACancelledJobWhoseWorkStillRuns) {
  Submit("a");
  const std::int64_t number = board_->TakeNext()->info.number;
  ASSERT_TRUE(board_->Cancel({"t", "a"}).ok());
  clock_.Advance(milliseconds(50));
  EXPECT_EQ(board_->TakeExpired().size(), 1U);
  board_->Tell(number, {});
  EXPECT_FALSE(board_->BeginEnd(number, {}).has_value());
  Submit("a");
  EXPECT_FALSE(board_->TakeNext().has_value());
  board_->GiveBack(number);
  EXPECT_EQ(RunOne(), "a");
}

TEST_F(JobBoardTest, DoesNotCancelWhatIsBeingStoredAsDone) {
  Submit("a");
  const std::int64_t number = board_->TakeNext()->info.number;
  const auto ended = board_->BeginEnd(number, {.state = JobState::kDone, .mesh = Bytes(5)});
  EXPECT_EQ(StateOf("a"), JobState::kRunning) << "nobody sees an end that may be lost";
  const JobBoard::Cancelled cancelled = board_->Cancel({"t", "a"}).value();
  EXPECT_FALSE(cancelled.changed);
  board_->FinishEnd(*ended);
  EXPECT_EQ(StateOf("a"), JobState::kDone);
  EXPECT_EQ(board_->Find({"t", "a"})->mesh_size, 5U);
}

TEST_F(JobBoardTest, ListsATenantsJobsNewestFirstInPages) {
  for (const char* id : {"a", "b", "c", "d"}) Submit(id);
  Submit("x", 0, "u");
  const JobBoard::Page first = board_->List("t", 0, 3);
  EXPECT_THAT(Ids(first), ElementsAre("d", "c", "b"));
  const JobBoard::Page second = board_->List("t", first.next, 3);
  EXPECT_THAT(Ids(second), ElementsAre("a"));
  EXPECT_EQ(second.next, 0);
  EXPECT_EQ(board_->List("t", 0, 4).next, 0) << "a full last page";
  EXPECT_THAT(Ids(board_->List("nobody", 0, 3)), ElementsAre());
}

TEST_F(JobBoardTest, ShowsTheProgressOfWhatRuns) {
  const std::int64_t number = Submit("a").number;
  EXPECT_FALSE(board_->Find({"t", "a"})->progress.has_value());
  (void)board_->TakeNext();
  board_->Tell(number, {.vertex_count = 17});
  EXPECT_EQ(board_->Find({"t", "a"})->progress->vertex_count, 17);
  Finish(number);
  EXPECT_FALSE(board_->Find({"t", "a"})->progress.has_value());
}

TEST_F(JobBoardTest, TakesUpWhatWasStored) {
  JobInfo waits{.key = {"t", "waits"}, .number = 7, .state = JobState::kRunning, .input_size = 999};
  JobInfo done{.key = {"t", "done"},
               .number = 4,
               .state = JobState::kDone,
               .keep = milliseconds(50),
               .mesh_size = 1,
               .end_time = clock_.WallNow()};
  board_->Restore(waits);
  board_->Restore(done);
  EXPECT_EQ(TrySubmit({.key = {"t", "x"}}).error().code, ErrorCode::kResourceExhausted)
      << "1000 of 1000 bytes";
  EXPECT_EQ(StateOf("waits"), JobState::kQueued);
  EXPECT_EQ(StateOf("done"), JobState::kDone);
  EXPECT_EQ(RunOne(), "waits");
  EXPECT_GT(Submit("new").number, 7);
  clock_.Advance(milliseconds(50));
  EXPECT_EQ(board_->TakeExpired().size(), 2U);
}

TEST_F(JobBoardTest, StopsEverythingAtShutdown) {
  Submit("a");
  Submit("b");
  const JobBoard::Start start = board_->TakeNext().value();
  const JobBoard::Unfinished unfinished = board_->StopAll();
  EXPECT_EQ(unfinished.queued, 1U);
  EXPECT_EQ(unfinished.running, 1U);
  EXPECT_TRUE(start.stop->asked());
  board_->GiveBack(start.info.number);
  EXPECT_FALSE(board_->TakeNext().has_value());
  EXPECT_EQ(TrySubmit({.key = {"t", "c"}}).error().code, ErrorCode::kUnavailable);
}

TEST_F(JobBoardTest, MakesUpIdsThatAreFree) {
  const JobInfo a = TrySubmit({.key = {"t", ""}}).value();
  const JobInfo b = TrySubmit({.key = {"t", ""}}).value();
  EXPECT_THAT(a.key.job_id, testing::MatchesRegex("j-[0-9a-f]{12}"));
  EXPECT_NE(a.key.job_id, b.key.job_id);
}

}  // namespace
}  // namespace pliant::server
