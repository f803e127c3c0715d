#include "core/pliant/node_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <vector>

namespace pliant {
namespace {

// Beyond 65,536 entries the queue moves its tail to the front now and then.
TEST(NodeQueue, IsFirstInFirstOutAlsoWhenItCompacts) {
  NodeQueue queue;
  std::deque<VertexId> model;
  Rng rng(9);
  std::int32_t next = 0;
  for (int step = 0; step < 600'000; ++step) {
    if (rng.Below(100) < (step < 300'000 ? 70U : 30U)) {
      queue.Push(VertexId(next));
      model.emplace_back(next++);
    } else if (!model.empty()) {
      ASSERT_EQ(queue.PopFirst(), model.front());
      model.pop_front();
    }
    ASSERT_EQ(queue.size(), model.size());
    ASSERT_EQ(queue.empty(), model.empty());
  }
}

TEST(NodeQueue, SeesWhatComes) {
  NodeQueue queue;
  for (int i = 0; i < 5; ++i) queue.Push(VertexId(i));
  queue.PopFirst();
  EXPECT_EQ(queue.Ahead(0), VertexId(1));
  EXPECT_EQ(queue.Ahead(3), VertexId(4));
  EXPECT_FALSE(queue.Ahead(4).valid());
}

TEST(NodeQueue, TakesEveryEntryOnceAtRandom) {
  NodeQueue queue;
  for (int i = 0; i < 100; ++i) queue.Push(VertexId(i));
  queue.PopFirst();
  Rng rng(1);
  std::vector<int> taken;
  while (!queue.empty()) taken.push_back(queue.PopRandom(rng).value());
  EXPECT_FALSE(std::is_sorted(taken.begin(), taken.end()));
  std::sort(taken.begin(), taken.end());
  ASSERT_EQ(taken.size(), 99U);
  for (int i = 0; i < 99; ++i) EXPECT_EQ(taken[static_cast<std::size_t>(i)], i + 1);
}

TEST(NodeQueue, TransformsWhatIsStillWaiting) {
  NodeQueue queue;
  for (int i = 0; i < 5; ++i) queue.Push(VertexId(i));
  queue.PopFirst();
  queue.Transform([](VertexId id) { return VertexId(10 * id.value()); });
  for (const int expected : {10, 20, 30, 40}) EXPECT_EQ(queue.PopFirst(), VertexId(expected));
}

}  // namespace
}  // namespace pliant
