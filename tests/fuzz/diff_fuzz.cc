// Goal: whatever a server sends, a client does not crash, and what it refuses changes nothing.
// Method: libFuzzer under AddressSanitizer and UBSan; tests/client/diff_bytes_test.cc replays a
// corpus through the same trial.
#include "core/base/check.h"
#include "tests/support/diff_trial.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string wrong = pliant::test::TryDiffs({reinterpret_cast<const char*>(data), size});
  PLIANT_CHECK(wrong.empty(), "wrong", wrong);
  return 0;
}
