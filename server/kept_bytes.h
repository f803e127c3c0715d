#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "server/limits.h"

/// What a session may keep beside its mesh: as much as it was created to keep or, where that was
/// left to the server, about as much as its mesh weighs, within constants. The same for one that
/// works and one that is loaded from its journal, so that both can go back to the same revisions,
/// and a journal that is made anew does not hold what its session has let go.
namespace pliant::server {

/// Of undo data, in bytes.
/// @param vertex_count  of the mesh
/// @param asked         SessionOptions.history_bytes_max: undo data and diffs together
[[nodiscard]] constexpr std::size_t UndoBytesMax(std::int64_t vertex_count,
                                                 std::optional<std::int64_t> asked = {}) {
  if (asked) return std::min(kUndoBytesMax, static_cast<std::size_t>(*asked - *asked / 5));
  const auto vertices = static_cast<std::size_t>(vertex_count);
  return std::min(kUndoBytesMax, std::max(kUndoBytesLeast, vertices * kUndoBytesPerVertex));
}

/// Of diffs for readers, in bytes, where `bytes_max` is the server's limit.
[[nodiscard]] constexpr std::size_t HistoryBytesMax(std::int64_t vertex_count,
                                                    std::size_t bytes_max,
                                                    std::optional<std::int64_t> asked = {}) {
  if (asked) return std::min(bytes_max, static_cast<std::size_t>(*asked / 5));
  const auto vertices = static_cast<std::size_t>(vertex_count);
  return std::min(bytes_max, std::max(kHistoryBytesLeast, vertices * kHistoryBytesPerVertex));
}

}  // namespace pliant::server
