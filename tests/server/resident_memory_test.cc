#include "server/resident_memory.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <cstddef>

namespace pliant::server {
namespace {

// Goal: memory counts when it is used, not when it is asked for, and no more once it is given back.
TEST(ResidentBytes, GrowsWithThePagesThatAreWritten) {
  constexpr std::size_t kSize = std::size_t{64} << 20;
  constexpr std::int64_t kNearly = std::int64_t{60} << 20;
  const std::int64_t before = ResidentBytes();
  ASSERT_GT(before, 0);
  void* const block =
      mmap(nullptr, kSize, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(block, MAP_FAILED);
  EXPECT_LT(ResidentBytes() - before, kNearly);
  auto* const bytes = static_cast<volatile unsigned char*>(block);
  for (std::size_t at = 0; at < kSize; at += 4096) bytes[at] = 1;
  EXPECT_GE(ResidentBytes() - before, kNearly);
  munmap(block, kSize);
  EXPECT_LT(ResidentBytes() - before, kNearly);
}

}  // namespace
}  // namespace pliant::server
