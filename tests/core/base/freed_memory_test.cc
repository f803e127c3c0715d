#include "core/base/freed_memory.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstddef>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

namespace pliant {
namespace {

/// What the process has in memory, in MiB.
double ResidentMiB() {
  std::ifstream statm("/proc/self/statm");
  double all = 0;
  double resident = 0;
  statm >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

// Goal: what is freed between blocks that stay goes back to the system.
// Method: 64 MiB in pieces that the allocator keeps, because a small one lies behind each.
TEST(ReturnFreedMemory, GivesBackWhatLiesBetweenBlocksInUse) {
  constexpr std::size_t kPiece = std::size_t{1} << 16;
  std::vector<std::unique_ptr<char[]>> freed;
  std::vector<std::unique_ptr<char[]>> kept;
  for (int i = 0; i < 1024; ++i) {
    freed.emplace_back(new char[kPiece]);
    std::memset(freed.back().get(), 1, kPiece);
    kept.emplace_back(new char[64]);
    kept.back()[0] = 'k';
  }
  // Before they are freed: where other tests have left room, some goes back by itself.
  [[maybe_unused]] const double before = ResidentMiB();
  freed.clear();
  ReturnFreedMemory();
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_LT(ResidentMiB(), before - 32);
#endif
  for (const auto& block : kept) EXPECT_EQ(block[0], 'k');
}

}  // namespace
}  // namespace pliant
