#include "server/jobs/memory_job_store.h"

#include <gtest/gtest.h>

#include <optional>

namespace pliant::server {
namespace {

TEST(MemoryJobStore, KeepsTheInputUntilTheEndAndTheMeshAfterIt) {
  MemoryJobStore store;
  EXPECT_FALSE(store.durable());
  std::optional<Status> status;
  const auto done = [&](const Status& s) { status = s; };
  JobInfo info{.key = {"t", "a"}, .number = 3};
  store.Create(info, Bytes(5, std::byte{7}), done);
  ASSERT_TRUE(status->ok());
  const SharedBytes input = store.LoadInput(info.key).value();
  EXPECT_EQ(*input, Bytes(5, std::byte{7}));
  EXPECT_EQ(store.LoadMesh(info.key).error().code, ErrorCode::kJobNotFound);

  info.state = JobState::kDone;
  store.End(info, Bytes(2, std::byte{9}), done);
  EXPECT_EQ(*store.LoadMesh(info.key).value(), Bytes(2, std::byte{9}));
  EXPECT_EQ(store.LoadInput(info.key).error().code, ErrorCode::kJobNotFound);
  EXPECT_EQ(input->size(), 5U) << "who has it keeps it";
  ASSERT_EQ(store.List()->size(), 1U);
  EXPECT_EQ(store.List()->front().state, JobState::kDone);

  status.reset();
  store.Delete(info.key, done);
  EXPECT_TRUE(status->ok());
  EXPECT_TRUE(store.List()->empty());
  EXPECT_EQ(store.LoadMesh({"u", "a"}).error().code, ErrorCode::kJobNotFound);
  store.End(info, {}, done);
  EXPECT_TRUE(store.List()->empty()) << "a forgotten job stays forgotten";
}

}  // namespace
}  // namespace pliant::server
