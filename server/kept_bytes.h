#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "server/limits.h"

/// What a session may keep beside its mesh: about as much as that weighs, within constants. The
/// same for one that works and one that is loaded from its journal, so that both can go back to the
/// same revisions, and a journal that is made anew does not hold what its session has let go.
namespace pliant::server {

/// Of undo data, in bytes. @param vertex_count  of the mesh
[[nodiscard]] constexpr std::size_t UndoBytesMax(std::int64_t vertex_count) {
  const auto vertices = static_cast<std::size_t>(vertex_count);
  return std::min(kUndoBytesMax, std::max(kUndoBytesLeast, vertices * kUndoBytesPerVertex));
}

/// Of diffs for readers, in bytes, where `bytes_max` is the server's limit.
[[nodiscard]] constexpr std::size_t HistoryBytesMax(std::int64_t vertex_count,
                                                    std::size_t bytes_max) {
  const auto vertices = static_cast<std::size_t>(vertex_count);
  return std::min(bytes_max, std::max(kHistoryBytesLeast, vertices * kHistoryBytesPerVertex));
}

}  // namespace pliant::server
