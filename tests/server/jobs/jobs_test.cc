#include "server/jobs/jobs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "tests/support/job_harness.h"

namespace pliant::server {
namespace {

using std::chrono::hours;

TEST(Jobs, RunsWhatIsSubmittedAndKeepsItsMesh) {
  JobHarness harness;
  const JobInfo submitted = harness.Submit("a", "hello", 4).value();
  EXPECT_EQ(submitted.state, JobState::kQueued);
  EXPECT_EQ(submitted.priority, 4);
  EXPECT_EQ(harness.Get("a").state, JobState::kRunning);
  EXPECT_EQ(harness.Fetch("nobody").error().code, ErrorCode::kJobNotFound);
  harness.RunAll();
  EXPECT_EQ(harness.Get("a").state, JobState::kDone);
  EXPECT_EQ(harness.Get("a").input_size, 0U);
  EXPECT_EQ(harness.OutcomeOf("a"), "revision 1 visits 10 active 0 troubles 1 vertices 3");
  EXPECT_EQ(harness.Fetch("a")->revision, Revision(1));
  EXPECT_EQ(harness.Submit("a").error().code, ErrorCode::kJobExists);
}

TEST(Jobs, RunsOneAfterTheOtherByPriority) {
  JobHarness harness;
  ASSERT_TRUE(harness.Submit("first").ok());
  ASSERT_TRUE(harness.Submit("low", "", -1).ok());
  ASSERT_TRUE(harness.Submit("high", "", 1).ok());
  std::vector<std::string> order;
  while (harness.scheduler->RunOne()) {
    for (const char* id : {"first", "low", "high"}) {
      if (harness.Get(id).state == JobState::kRunning && (order.empty() || order.back() != id)) {
        order.emplace_back(id);
      }
    }
  }
  EXPECT_THAT(order, testing::ElementsAre("first", "high", "low"));
}

TEST(Jobs, RefusesMeshesOfJobsThatAreNotDone) {
  JobHarness harness;
  ASSERT_TRUE(harness.Submit("runs").ok());
  ASSERT_TRUE(harness.Submit("waits").ok());
  for (const char* id : {"runs", "waits"}) {
    const Result<MeshDiff> mesh = [&] {
      std::optional<Result<MeshDiff>> answer;
      harness.jobs->Fetch({"t", id}, [&](const Result<MeshDiff>& m) { answer = m; });
      return answer.value();
    }();
    EXPECT_EQ(mesh.error().code, ErrorCode::kJobNotDone);
  }
  ASSERT_TRUE(harness.Cancel("waits").ok());
  EXPECT_EQ(harness.Fetch("waits").error().code, ErrorCode::kJobNotDone);
}

TEST(Jobs, CancelsWhatWaitsAndWhatRuns) {
  JobHarness harness({.visits_needed = INT64_MAX / 2});
  ASSERT_TRUE(harness.Submit("runs").ok());
  ASSERT_TRUE(harness.Submit("waits").ok());
  for (int i = 0; i < 3; ++i) harness.scheduler->RunOne();
  EXPECT_EQ(harness.Cancel("waits")->state, JobState::kCancelled);
  EXPECT_EQ(harness.Cancel("runs")->state, JobState::kCancelled);
  harness.RunAll();  // Ends: the loop has stopped.
  EXPECT_EQ(harness.Get("runs").state, JobState::kCancelled);
  EXPECT_EQ(harness.script->created_count, 1) << "what waited never began";
  EXPECT_EQ(harness.Cancel("nobody").error().code, ErrorCode::kJobNotFound);
  // The place is free.
  harness.script->visits_needed = 1;
  ASSERT_TRUE(harness.Submit("next").ok());
  harness.RunAll();
  EXPECT_EQ(harness.Get("next").state, JobState::kDone);
  EXPECT_EQ(harness.Cancel("next")->state, JobState::kDone) << "what has ended stays as it is";
}

TEST(Jobs, ForgetsWhatHasExpiredInTheStoreToo) {
  JobHarness harness;
  ASSERT_TRUE(harness.Submit("a").ok());
  harness.RunAll();
  harness.clock.Advance(hours(1) - std::chrono::nanoseconds(1));
  EXPECT_TRUE(harness.Fetch("a").ok());
  harness.clock.Advance(std::chrono::nanoseconds(1));
  EXPECT_EQ(harness.store.kept.List()->size(), 1U);
  harness.jobs->Sweep();
  EXPECT_TRUE(harness.store.kept.List()->empty()) << "without a call";
  EXPECT_EQ(harness.jobs->Get({"t", "a"}).error().code, ErrorCode::kJobNotFound);
  EXPECT_TRUE(harness.store.kept.List()->empty());
  ASSERT_TRUE(harness.Submit("a").ok());
}

// Goal: what jobs use is their tenant's affair, like what its sessions use, at the bound and past
// it. Method: a fake mesh has three vertices; a visit takes a microsecond.
TEST(Jobs, CountInTheirTenantsAccount) {
  JobHarness harness({.visits_needed = 10'000}, /*running_max=*/2);
  harness.Limit({.vertices_max = 5});
  ASSERT_TRUE(harness.Submit("first").ok());
  for (int i = 0; i < 3; ++i) harness.scheduler->RunOne();
  EXPECT_EQ(harness.accounts->Of("t")->usage().vertices, 3);
  ASSERT_TRUE(harness.Submit("second").ok());
  harness.RunAll();
  EXPECT_EQ(harness.Get("first").state, JobState::kDone);
  EXPECT_EQ(harness.Get("second").state, JobState::kFailed) << "six vertices at once";
  EXPECT_TRUE(harness.OutcomeOf("second").starts_with("RESOURCE_EXHAUSTED"));
  EXPECT_EQ(harness.accounts->Of("t")->usage().vertices, 0) << "nothing is left of them";
  EXPECT_EQ(harness.accounts->Of("t")->usage().bytes, 0);
  harness.Limit({.vertices_max = 6});
  ASSERT_TRUE(harness.Submit("third").ok());
  ASSERT_TRUE(harness.Submit("fourth").ok());
  harness.RunAll();
  EXPECT_EQ(harness.Get("third").state, JobState::kDone);
  EXPECT_EQ(harness.Get("fourth").state, JobState::kDone);
}

TEST(Jobs, WaitForComputeTimeLikeAdvances) {
  JobHarness harness({.visits_needed = 10'000});
  harness.Limit({.compute_percent = 50, .compute_burst = std::chrono::milliseconds(1)});
  ASSERT_TRUE(harness.Submit("a").ok());
  harness.RunAll();  // 10 ms, of which 9 are owed.
  EXPECT_EQ(harness.Get("a").state, JobState::kDone) << "what has begun is finished";
  const Result<JobInfo> refused = harness.Submit("b");
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_GT(refused.error().retry_after_ms, 0);
  harness.clock.Advance(std::chrono::milliseconds(refused.error().retry_after_ms));
  EXPECT_TRUE(harness.Submit("b").ok());
}

TEST(Jobs, ACancelledOneLeavesTheAccount) {
  JobHarness harness({.visits_needed = INT64_MAX / 2});
  harness.Limit({.vertices_max = 5});
  ASSERT_TRUE(harness.Submit("a").ok());
  for (int i = 0; i < 3; ++i) harness.scheduler->RunOne();
  EXPECT_EQ(harness.accounts->Of("t")->usage().vertices, 3);
  ASSERT_TRUE(harness.Cancel("a").ok());
  harness.RunAll();
  EXPECT_EQ(harness.accounts->Of("t")->usage().vertices, 0);
}

TEST(Jobs, AnswersASubmissionOnlyIfItIsStored) {
  JobHarness harness;
  harness.store.create_error = Error{ErrorCode::kResourceExhausted, "no space left", {}};
  EXPECT_EQ(harness.Submit("a").error().message, "no space left");
  EXPECT_EQ(harness.jobs->Get({"t", "a"}).error().code, ErrorCode::kJobNotFound);
  harness.store.create_error.reset();
  EXPECT_TRUE(harness.Submit("a").ok()) << "the id and the room are free";
}

TEST(Jobs, FailsAJobWhoseResultCannotBeStored) {
  JobHarness harness;
  harness.store.end_error = Error{ErrorCode::kResourceExhausted, "no space left", "data"};
  ASSERT_TRUE(harness.Submit("a").ok());
  harness.RunAll();
  EXPECT_EQ(harness.Get("a").state, JobState::kFailed);
  EXPECT_EQ(harness.OutcomeOf("a"), "RESOURCE_EXHAUSTED data");
  EXPECT_EQ(harness.Get("a").mesh_size, 0U);
  harness.store.end_error.reset();
  ASSERT_TRUE(harness.Submit("b").ok());
  harness.RunAll();
  EXPECT_EQ(harness.Get("b").state, JobState::kDone) << "its place was given back";
}

// Goal: what was queued or running when a server died is taken up by the next one, in order, and
// what had ended is as it was.
TEST(Jobs, TakesUpWhatItsStoreHas) {
  JobHarness harness;
  ASSERT_TRUE(harness.Submit("done").ok());
  harness.RunAll();
  ASSERT_TRUE(harness.Submit("runs").ok());
  ASSERT_TRUE(harness.Submit("low").ok());
  ASSERT_TRUE(harness.Submit("high", "", 9).ok());
  ASSERT_TRUE(harness.Submit("gone").ok());
  ASSERT_TRUE(harness.Cancel("gone").ok());
  for (int i = 0; i < 2; ++i) harness.scheduler->RunOne();
  EXPECT_EQ(harness.Get("runs").state, JobState::kRunning);

  harness.Restart();
  ASSERT_TRUE(harness.jobs->Load().ok());
  EXPECT_EQ(harness.Get("done").state, JobState::kDone);
  EXPECT_EQ(harness.Get("gone").state, JobState::kCancelled);
  EXPECT_EQ(harness.Get("high").state, JobState::kRunning);
  EXPECT_EQ(harness.Get("low").state, JobState::kQueued);
  harness.RunAll();
  for (const char* id : {"runs", "low", "high"}) {
    EXPECT_EQ(harness.Get(id).state, JobState::kDone) << id;
  }
  EXPECT_TRUE(harness.Fetch("done").ok());
}

TEST(Jobs, DoesNotServeWhatItCannotRead) {
  JobHarness harness;
  harness.store.list_error = Error{ErrorCode::kDataCorrupt, "corrupt", "data"};
  EXPECT_EQ(harness.jobs->Load().error().code, ErrorCode::kDataCorrupt);
}

TEST(Jobs, StopsWithoutEndingWhatRuns) {
  JobHarness harness({.visits_needed = INT64_MAX / 2});
  ASSERT_TRUE(harness.Submit("a").ok());
  for (int i = 0; i < 3; ++i) harness.scheduler->RunOne();
  harness.jobs->Stop();
  harness.RunAll();
  EXPECT_EQ(harness.store.kept.List()->front().state, JobState::kQueued) << "the next server's";
  EXPECT_EQ(harness.Submit("b").error().code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace pliant::server
