#include <pliant/core/base/result.h>
#include <pliant/core/geometry/domain.h>

#include <iostream>

// Both a header-only type and a function of the library, so that headers and linking are tried.
int main() {
  const pliant::Segment segment{.a = 0, .b = 1, .tag = 7};
  const auto name = pliant::ErrorCodeName(pliant::ErrorCode::kOpenLoop);
  std::cout << name << " " << segment.tag << "\n";
  return name == "OPEN_LOOP" ? 0 : 1;
}
