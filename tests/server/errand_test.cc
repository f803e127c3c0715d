#include "server/errand.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/support/fake_server_parts.h"

namespace pliant::server {
namespace {

TEST(Errand, IsDoneOnceAndThenForgotten) {
  ManualClock clock;
  Scheduler scheduler(/*worker_count=*/0, clock);
  int count = 0;
  const auto held = std::make_shared<int>(0);
  const auto errand = std::make_shared<Errand>([&count, held] { ++count; });
  scheduler.Wake(errand);
  while (scheduler.RunOne()) {
  }
  scheduler.Wake(errand);
  while (scheduler.RunOne()) {
  }
  EXPECT_EQ(count, 1);
  EXPECT_EQ(held.use_count(), 1) << "what it held is free";
}

}  // namespace
}  // namespace pliant::server
