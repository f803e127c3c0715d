#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace pliant {

/// Thrown by a failed PLIANT_CHECK: a bug of this program, never bad input.
///
/// Only the edge of a session catches it: that session goes back to its last good revision and
/// every other session goes on. Nothing in this project calls exit or abort.
class InvariantViolation : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

namespace internal {

[[noreturn]] void FailCheck(const char* file, int line, const char* condition,
                            const std::string& values);

/// Renders "a=1 b=2" from PLIANT_CHECK's trailing arguments: name, value, name, value...
template <class... Values>
std::string DescribeValues(const Values&... values) {
  std::ostringstream out;
  out.precision(17);
  bool is_name = true;
  ((out << values << (is_name ? "=" : " "), is_name = !is_name), ...);
  return out.str();
}

}  // namespace internal
}  // namespace pliant

/// Checks what only a bug can break; stays on in release builds. Optional arguments come in pairs
/// of a name and a value: PLIANT_CHECK(n > 0, "n", n, "vertex", v.value()).
#define PLIANT_CHECK(condition, ...)                                                  \
  do {                                                                                \
    if (!(condition)) [[unlikely]] {                                                  \
      ::pliant::internal::FailCheck(__FILE__, __LINE__, #condition,                   \
                                    ::pliant::internal::DescribeValues(__VA_ARGS__)); \
    }                                                                                 \
  } while (false)

namespace pliant {

/// Builds with PLIANT_VALIDATE_EVERY check the mesh around every operation and the ages of nodes
/// at every visit; the rest of the program is the same.
#ifdef PLIANT_VALIDATE_EVERY
inline constexpr bool kValidateEvery = true;
#else
inline constexpr bool kValidateEvery = false;
#endif

}  // namespace pliant

/// As PLIANT_CHECK, but only in builds without NDEBUG: for checks inside the hot loops.
#ifdef NDEBUG
#define PLIANT_DCHECK(condition, ...) \
  do {                                \
  } while (false)
#else
#define PLIANT_DCHECK(condition, ...) PLIANT_CHECK(condition, __VA_ARGS__)
#endif
