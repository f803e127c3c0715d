#include "server/store/write_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace pliant::server {
namespace {

using testing::ElementsAre;

TEST(WriteQueue, GivesInOrderAndInGroups) {
  WriteQueue<int> queue(100);
  for (int i = 0; i < 5; ++i) queue.Put(i, 10);
  EXPECT_THAT(queue.Take(3), ElementsAre(0, 1, 2));
  EXPECT_FALSE(queue.empty());
  EXPECT_THAT(queue.Take(3), ElementsAre(3, 4));
  EXPECT_TRUE(queue.empty());
  queue.Put(5, 1000);
  queue.Close();
  EXPECT_THAT(queue.Take(3), ElementsAre(5)) << "what was put before the end";
  EXPECT_TRUE(queue.Take(3).empty());
}

// Goal: at the bound a Put returns, one byte past it it waits until there is room.
TEST(WriteQueue, MakesWritersWaitBeyondTheBound) {
  WriteQueue<int> queue(100);
  queue.Put(0, 60);
  queue.Put(1, 40);
  std::atomic<bool> returned = false;
  std::thread writer([&] {
    queue.Put(2, 1);
    returned = true;
  });
  EXPECT_THAT(queue.Take(1), ElementsAre(0));
  writer.join();
  EXPECT_TRUE(returned);
  EXPECT_THAT(queue.Take(9), ElementsAre(1, 2));

  // It really waits: of two threads the one that takes goes first, whoever is faster.
  queue.Put(3, 100);
  std::atomic<bool> taken = false;
  bool was_taken = false;
  std::thread late([&] {
    queue.Put(4, 1);
    was_taken = taken;
  });
  for (int i = 0; i < 1000; ++i) std::this_thread::yield();
  taken = true;
  EXPECT_THAT(queue.Take(1), ElementsAre(3));
  late.join();
  EXPECT_TRUE(was_taken);
}

}  // namespace
}  // namespace pliant::server
