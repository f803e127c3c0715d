#include "core/base/large_pages.h"

#ifdef __linux__
#include <sys/mman.h>
#endif

#include <cstdint>

namespace pliant::internal {
namespace {

constexpr std::size_t kLargePageSize = std::size_t{1} << 21;

constexpr std::size_t RoundUp(std::size_t size) {
  return (size + kLargePageSize - 1) / kLargePageSize * kLargePageSize;
}

}  // namespace

#ifdef __linux__

void* AllocateLargePages(std::size_t size) {
  const std::size_t rounded = RoundUp(size);
  // One page more than needed; what lies before and behind the aligned part goes back.
  const std::size_t reserved = rounded + kLargePageSize;
  void* const mapped =
      mmap(nullptr, reserved, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED) throw std::bad_alloc();
  auto* const first = static_cast<char*>(mapped);
  const std::size_t before =
      RoundUp(reinterpret_cast<std::uintptr_t>(mapped)) - reinterpret_cast<std::uintptr_t>(mapped);
  char* const block = first + before;
  if (before > 0) (void)munmap(first, before);
  if (before < kLargePageSize) (void)munmap(block + rounded, kLargePageSize - before);
  // Only advice: a system that has no large pages goes on with small ones.
  (void)madvise(block, rounded, MADV_HUGEPAGE);
  return block;
}

void AskForLargePages(void* block, std::size_t size) noexcept {
  const auto begin = reinterpret_cast<std::uintptr_t>(block);
  const std::uintptr_t first = RoundUp(begin);
  const std::uintptr_t end = (begin + size) / kLargePageSize * kLargePageSize;
  if (first >= end) return;
  (void)madvise(static_cast<char*>(block) + (first - begin), end - first, MADV_HUGEPAGE);
}

void FreeLargePages(void* block, std::size_t size) noexcept { (void)munmap(block, RoundUp(size)); }

#else

void AskForLargePages(void* /*block*/, std::size_t /*size*/) noexcept {}

void* AllocateLargePages(std::size_t size) {
  return ::operator new(RoundUp(size), std::align_val_t(kLargePageSize));
}

void FreeLargePages(void* block, std::size_t /*size*/) noexcept {
  ::operator delete(block, std::align_val_t(kLargePageSize));
}

#endif

}  // namespace pliant::internal
