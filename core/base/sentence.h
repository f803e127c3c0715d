#pragma once

#include <sstream>
#include <string>

namespace pliant {

/// What `<<` makes of the parts, one after the other.
template <class... Parts>
[[nodiscard]] std::string Sentence(const Parts&... parts) {
  std::ostringstream text;
  (text << ... << parts);
  return text.str();
}

}  // namespace pliant
