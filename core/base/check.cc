#include "core/base/check.h"

namespace pliant::internal {

void FailCheck(const char* file, int line, const char* condition, const std::string& values) {
  std::ostringstream message;
  message << "invariant violated: " << condition << " at " << file << ":" << line;
  if (!values.empty()) message << " with " << values;
  throw InvariantViolation(message.str());
}

}  // namespace pliant::internal
