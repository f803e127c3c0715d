#pragma once

#include <cstdint>
#include <string>

#include "core/base/ids.h"

namespace pliant::server {

/// The number of a revision, for messages and logs.
[[nodiscard]] inline std::string RevisionText(Revision revision) {
  return std::to_string(static_cast<std::int64_t>(revision));
}

}  // namespace pliant::server
