#include "core/base/large_pages.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace pliant::internal {
namespace {

constexpr std::size_t kLargePageSize = std::size_t{1} << 21;

}  // namespace

void* AllocateLargePages(std::size_t size) {
  const std::size_t rounded = (size + kLargePageSize - 1) / kLargePageSize * kLargePageSize;
  void* const block = ::operator new(rounded, std::align_val_t(kLargePageSize));
#ifdef __linux__
  // Only advice: a system that has no large pages goes on with small ones.
  (void)madvise(block, rounded, MADV_HUGEPAGE);
#endif
  return block;
}

void FreeLargePages(void* block) noexcept {
  ::operator delete(block, std::align_val_t(kLargePageSize));
}

}  // namespace pliant::internal
