#pragma once

namespace pliant {

/// Tells the processor that the cache line of `address` will be read soon, so that it is there by
/// then. A hint: wrong or missing it costs time, nothing else; `address` need not be valid.
inline void PrefetchToRead(const void* address) {
#if defined(__GNUC__)
  __builtin_prefetch(address, 0, 3);
#else
  (void)address;
#endif
}

}  // namespace pliant
