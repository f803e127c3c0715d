#pragma once

#include <variant>
#include <vector>

#include "server/config.h"

namespace pliant::server {

/// What pliantd makes of these arguments.
inline Result<std::variant<Config, ExitRequest>> Parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "pliantd");
  return ParseConfig(static_cast<int>(arguments.size()), arguments.data());
}

}  // namespace pliant::server
