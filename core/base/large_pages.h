#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

namespace pliant {

/// Allocates large blocks at the boundaries of large pages and asks the system to use such pages,
/// where it has them: a mesh of a million nodes is read all over, and with pages of 4 KiB the
/// processor would spend a good part of its time on finding them. What is freed goes back to the
/// system at once, where malloc may keep tens of megabytes. Small blocks are ordinary ones.
///
/// *Threads*: as std::allocator.
template <class T>
class LargePageAllocator {
 public:
  using value_type = T;

  LargePageAllocator() = default;
  template <class U>
  LargePageAllocator(const LargePageAllocator<U>& /*other*/) {}  // NOLINT: containers convert.

  [[nodiscard]] T* allocate(std::size_t count);
  void deallocate(T* block, std::size_t count) noexcept;

  friend bool operator==(const LargePageAllocator&, const LargePageAllocator&) { return true; }
};

namespace internal {

/// Blocks from this size on, in bytes, lie on large pages.
inline constexpr std::size_t kLargeBlockSize = std::size_t{1} << 22;

/// @return a block of `size` bytes at a boundary of 2 MiB. Throws std::bad_alloc as operator new.
[[nodiscard]] void* AllocateLargePages(std::size_t size);
/// Asks for large pages wherever one fits into a block that somebody else has allocated.
void AskForLargePages(void* block, std::size_t size) noexcept;
/// @param size  as it was allocated.
void FreeLargePages(void* block, std::size_t size) noexcept;

}  // namespace internal

/// A vector that may become large.
template <class T>
using LargeVector = std::vector<T, LargePageAllocator<T>>;

template <class T>
T* LargePageAllocator<T>::allocate(std::size_t count) {
  const std::size_t size = count * sizeof(T);
  if (size >= internal::kLargeBlockSize) {
    return static_cast<T*>(internal::AllocateLargePages(size));
  }
  return static_cast<T*>(::operator new(size, std::align_val_t(alignof(T))));
}

template <class T>
void LargePageAllocator<T>::deallocate(T* block, std::size_t count) noexcept {
  if (count * sizeof(T) >= internal::kLargeBlockSize) {
    internal::FreeLargePages(block, count * sizeof(T));
  } else {
    ::operator delete(block, std::align_val_t(alignof(T)));
  }
}

}  // namespace pliant
