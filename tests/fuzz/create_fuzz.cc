// Goal: no CreateSession breaks a server: it is refused with a sentence, or makes a mesh that is
// valid. Method: libFuzzer under AddressSanitizer and UBSan, mutating the corpus message by
// message; tests/server/create_bytes_test.cc replays the same trial.
#include <algorithm>
#include <cstring>

#include "core/base/check.h"
#include "tests/support/create_trial.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string wrong = pliant::test::TryCreate({reinterpret_cast<const char*>(data), size});
  PLIANT_CHECK(wrong.empty(), "wrong", wrong);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t size_max, unsigned int seed) {
  pliant::Rng rng(seed);
  std::vector<pliant::test::Piece> pieces =
      pliant::test::Cut({reinterpret_cast<const char*>(data), size});
  if (pieces.empty() || rng.Below(16) == 0) {
    const auto corpus = pliant::test::CreateCorpus();
    pieces = corpus[rng.Below(corpus.size())];
  }
  const std::string bytes = pliant::test::Join(pliant::test::Mutated(std::move(pieces), rng));
  const std::size_t count = std::min(bytes.size(), size_max);
  std::memcpy(data, bytes.data(), count);
  return count;
}
