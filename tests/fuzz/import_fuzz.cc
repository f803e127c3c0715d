// Goal: no bytes that claim to be a session file crash or hang a server, or make a session that is
// not valid, with right checksums too. Method: libFuzzer under AddressSanitizer and UBSan;
// tests/server/session_file_test.cc replays the same trial.
#include <span>

#include "core/base/check.h"
#include "tests/support/session_file_trial.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string wrong = pliant::test::TryImport(std::as_bytes(std::span(data, size)));
  PLIANT_CHECK(wrong.empty(), "wrong", wrong);
  return 0;
}
