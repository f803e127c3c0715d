#include "core/base/check.h"

#include <string_view>

namespace pliant::internal {

namespace {

/// The path from the repository's root: a compiler that is given relative paths starts from the
/// build folder.
std::string_view FromRoot(std::string_view file) {
  while (file.starts_with("../")) file.remove_prefix(3);
  return file;
}

}  // namespace

void FailCheck(const char* file, int line, const char* condition, const std::string& values) {
  std::ostringstream message;
  message << "invariant violated: " << condition << " at " << FromRoot(file) << ":" << line;
  if (!values.empty()) message << " with " << values;
  throw InvariantViolation(message.str());
}

}  // namespace pliant::internal
