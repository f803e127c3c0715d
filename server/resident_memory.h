#pragma once

#include <cstdint>

namespace pliant::server {

/// Main memory that this process holds now, shared pages included, in bytes; 0 where the system
/// does not say. @par Cost some microseconds
[[nodiscard]] std::int64_t ResidentBytes();

}  // namespace pliant::server
