// Goal: no bytes that arrive as chunks and arrays crash the reader or are read as rows that nobody
// stated. Method: libFuzzer under AddressSanitizer and UBSan; tests/proto/column_bytes_test.cc
// replays a corpus through the same trial.
#include "core/base/check.h"
#include "tests/support/columns_trial.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string wrong = pliant::test::TryColumns({reinterpret_cast<const char*>(data), size});
  PLIANT_CHECK(wrong.empty(), "wrong", wrong);
  return 0;
}
