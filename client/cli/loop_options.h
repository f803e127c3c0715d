#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>

#include "client/cpp/types.h"
#include "core/pliant/options.h"

namespace pliant::cli {

/// The options that say how the loop works and how long it may.
struct LoopOptions {
  Options options;
  std::int64_t visits_max = 0;  ///< 0: no limit.
  double seconds_max = 0;       ///< 0: no limit.

  [[nodiscard]] client::AdvanceOptions advance() const;
};

void AddLoopOptions(CLI::App& command, LoopOptions& options);

}  // namespace pliant::cli
