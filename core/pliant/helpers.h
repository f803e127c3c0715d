#pragma once

#include <cstdint>

#include "core/base/executor.h"

namespace pliant {

/// Which meshes the loop works on in blocks, and in how large ones. Part of what decides a mesh, so
/// the same for everyone but tests.
struct BlockRule {
  /// Meshes with at least this many vertices; below, what blocks cost outweighs what threads gain.
  std::int32_t nodes_min = 1 << 15;
  /// About this many vertices in a block: enough blocks for many threads, few nodes at borders.
  std::int32_t nodes_per_block = 1 << 14;
};

/// Who helps a session with large work, and which work is large.
class Helpers {
 public:
  Helpers() = default;
  /// @param executor  not owned; null: the calling thread does everything.
  /// @param rule      part of what decides a mesh; another one than the default is for tests.
  explicit Helpers(Executor* executor, const BlockRule& rule = {})
      : executor_(executor), rule_(rule) {}

  [[nodiscard]] Executor& executor() const { return executor_ ? *executor_ : alone_; }
  [[nodiscard]] const BlockRule& rule() const { return rule_; }

 private:
  Executor* executor_ = nullptr;
  mutable InlineExecutor alone_;
  BlockRule rule_;
};

}  // namespace pliant
