// Goal: no CreateSession breaks a server: it is refused with a sentence, or makes a mesh that is
// valid. Method: libFuzzer under AddressSanitizer and UBSan, mutating the corpus message by
// message; tests/server/create_bytes_test.cc replays the same trial.
#include "core/base/check.h"
#include "tests/fuzz/mutate_pieces.h"
#include "tests/support/create_trial.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string wrong = pliant::test::TryCreate({reinterpret_cast<const char*>(data), size});
  PLIANT_CHECK(wrong.empty(), "wrong", wrong);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t size_max, unsigned int seed) {
  return pliant::fuzz::MutatePieces(data, size, size_max, seed, 1, [](pliant::Rng& rng) {
    const auto corpus = pliant::test::CreateCorpus();
    return corpus[rng.Below(corpus.size())];
  });
}
