#include "server/jobs/durable_job_store.h"

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <string>

#include "server/store/sqlite_store.h"
#include "tests/support/job_harness.h"
#include "tests/support/memory_store.h"
#include "tests/support/temporary_folder.h"

namespace pliant::server {
namespace {

JobInfo SomeJob(const std::string& id = "a") {
  return {.key = {"tenant", id},
          .number = 7,
          .priority = -2,
          .keep = std::chrono::milliseconds(1234),
          .input_size = 5,
          .create_time = Clock::WallTime(std::chrono::seconds(10))};
}

JobInfo Ended(JobInfo info) {
  info.state = JobState::kDone;
  info.input_size = 0;
  info.mesh_size = 4;
  info.end_time = Clock::WallTime(std::chrono::seconds(20));
  info.outcome = std::make_shared<const Bytes>(BytesOf("good"));
  return info;
}

// A store on a disk, which a test can leave and come back to.
class DurableJobStoreTest : public testing::Test {
 protected:
  DurableJobStoreTest() { Restart(); }
  void Restart() {
    jobs_ = nullptr;
    store_ = nullptr;
    store_ = SqliteStore::Open({.directory = folder_.path(), .vfs = {}}).value();
    jobs_ = std::make_unique<DurableJobStore>(*store_, log_);
  }
  template <class Write>
  Status Do(Write write) {
    std::promise<Status> promise;
    write([&](const Status& status) { promise.set_value(status); });
    return promise.get_future().get();
  }
  Status Create(const JobInfo& info, std::string_view input = "input") {
    return Do([&](auto done) { jobs_->Create(info, BytesOf(input), done); });
  }
  Status End(const JobInfo& info, std::string_view mesh = "mesh") {
    return Do([&](auto done) { jobs_->End(info, BytesOf(mesh), done); });
  }
  Status Delete(const JobKey& key) {
    return Do([&](auto done) { jobs_->Delete(key, done); });
  }

  const Log log_{LogLevel::kError, LogFormat::kText};
  test::TemporaryFolder folder_;
  std::unique_ptr<Store> store_;
  std::unique_ptr<DurableJobStore> jobs_;
};

TEST_F(DurableJobStoreTest, FindsAWaitingJobAfterARestart) {
  ASSERT_TRUE(Create(SomeJob()).ok());
  Restart();
  const std::vector<JobInfo> jobs = jobs_->List().value();
  ASSERT_EQ(jobs.size(), 1U);
  EXPECT_EQ(jobs[0].key, (JobKey{"tenant", "a"}));
  EXPECT_EQ(jobs[0].number, 7);
  EXPECT_EQ(jobs[0].state, JobState::kQueued);
  EXPECT_EQ(jobs[0].priority, -2);
  EXPECT_EQ(jobs[0].keep, std::chrono::milliseconds(1234));
  EXPECT_EQ(jobs[0].input_size, 5U);
  EXPECT_EQ(jobs[0].create_time, SomeJob().create_time);
  EXPECT_FALSE(jobs[0].end_time.has_value());
  EXPECT_EQ(TextOf(*jobs_->LoadInput(jobs[0].key).value()), "input");
  EXPECT_EQ(jobs_->LoadMesh(jobs[0].key).error().code, ErrorCode::kJobNotFound);
}

TEST_F(DurableJobStoreTest, FindsAnEndWithItsMeshAfterARestart) {
  ASSERT_TRUE(Create(SomeJob()).ok());
  Restart();  // Another server ends it.
  ASSERT_TRUE(End(Ended(SomeJob())).ok());
  Restart();
  const JobInfo job = jobs_->List().value().at(0);
  EXPECT_EQ(job.state, JobState::kDone);
  EXPECT_EQ(job.mesh_size, 4U);
  EXPECT_EQ(job.end_time, Ended(SomeJob()).end_time);
  EXPECT_EQ(TextOf(*job.outcome), "good");
  EXPECT_EQ(TextOf(*jobs_->LoadMesh(job.key).value()), "mesh");
  EXPECT_EQ(jobs_->LoadInput(job.key).error().code, ErrorCode::kJobNotFound) << "it is dropped";
  ASSERT_TRUE(Delete(job.key).ok());
  ASSERT_TRUE(Delete(job.key).ok()) << "twice is once";
  Restart();
  EXPECT_TRUE(jobs_->List()->empty());
}

TEST_F(DurableJobStoreTest, RefusesAnIdThatIsTaken) {
  ASSERT_TRUE(Create(SomeJob()).ok());
  EXPECT_EQ(Create(SomeJob(), "other").error().code, ErrorCode::kJobExists);
  EXPECT_EQ(TextOf(*jobs_->LoadInput(SomeJob().key).value()), "input");
  ASSERT_TRUE(Delete(SomeJob().key).ok());
  EXPECT_TRUE(Create(SomeJob(), "other").ok());
}

// Goal: a job has ended if and only if its snapshot is there, and a submission counts from the
// moment that its input is. Method: the document as each single write leaves it, made by hand.
TEST_F(DurableJobStoreTest, KnowsWhatACrashBetweenItsWritesLeaves) {
  const StoreKey key{DocumentKind::kJob, "tenant", "a"};
  const auto put_head = [&](const JobInfo& info) {
    const Epoch epoch = store_->Claim(key).value();
    return Do([&](auto done) {
      store_->Append(key, epoch, {.first = 2, .head = WriteJobInfo(info)}, done);
    });
  };
  store_->Create(key, {.head = WriteJobInfo(SomeJob())}, [](const Status&) {});
  Restart();
  EXPECT_TRUE(jobs_->List()->empty()) << "nobody was told of it";
  ASSERT_TRUE(Create(SomeJob()).ok()) << "nor is its id taken";

  ASSERT_TRUE(put_head(Ended(SomeJob())).ok());
  Restart();
  const JobInfo waits = jobs_->List()->at(0);
  EXPECT_EQ(waits.state, JobState::kQueued) << "its mesh is not there";
  EXPECT_FALSE(waits.end_time.has_value() || waits.outcome);
  EXPECT_EQ(TextOf(*jobs_->LoadInput(waits.key).value()), "input");

  ASSERT_TRUE(End(Ended(SomeJob())).ok());
  Restart();
  ASSERT_TRUE(put_head(SomeJob()).ok());
  Restart();
  EXPECT_EQ(jobs_->List()->at(0).state, JobState::kDone);
  EXPECT_EQ(TextOf(*jobs_->List()->at(0).outcome), "good");
}

TEST_F(DurableJobStoreTest, LeavesOutWhatItCannotRead) {
  ASSERT_TRUE(Create(SomeJob("good")).ok());
  const StoreKey key{DocumentKind::kJob, "tenant", "bad"};
  ASSERT_TRUE(Do([&](auto done) {
                store_->Create(key, {.head = BytesOf("not a head")}, [](const Status&) {});
                store_->Append(key, Epoch::kFirst,
                               {.first = 1, .records = {BytesOf("x")}, .head = BytesOf("nor this")},
                               done);
              }).ok());
  const std::vector<JobInfo> jobs = jobs_->List().value();
  ASSERT_EQ(jobs.size(), 1U);
  EXPECT_EQ(jobs[0].key.job_id, "good");
}

TEST(JobInfoBytes, RefuseWhatCannotBe) {
  const JobKey key{"t", "a"};
  const Bytes good = WriteJobInfo(SomeJob());
  ASSERT_TRUE(ReadJobInfo(key, good).ok());
  for (std::size_t i = 0; i < good.size(); ++i) {
    Bytes bad = good;
    bad[i] ^= std::byte{4};
    EXPECT_FALSE(ReadJobInfo(key, bad).ok()) << i;
    EXPECT_FALSE(ReadJobInfo(key, std::span(good).first(i)).ok()) << i;
  }
  JobInfo running = SomeJob();
  running.state = JobState::kRunning;
  EXPECT_EQ(ReadJobInfo(key, WriteJobInfo(running))->state, JobState::kQueued);
  JobInfo endless = Ended(SomeJob());
  endless.end_time.reset();
  EXPECT_EQ(ReadJobInfo(key, WriteJobInfo(endless)).error().code, ErrorCode::kDataCorrupt);
}

}  // namespace
}  // namespace pliant::server
