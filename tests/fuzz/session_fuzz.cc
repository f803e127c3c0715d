// Goal: no sequence of requests breaks a session: each is answered once, no bug is met, the mesh
// stays valid. Method: libFuzzer under AddressSanitizer and UBSan, mutating the corpus piece by
// piece: bytes alone would hardly ever be a command. tests/server/session_commands_test.cc replays
// the same trial.
#include "core/base/check.h"
#include "tests/fuzz/mutate_pieces.h"
#include "tests/support/edit_corpus.h"
#include "tests/support/session_trial.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string wrong = pliant::test::TrySession({reinterpret_cast<const char*>(data), size});
  PLIANT_CHECK(wrong.empty(), "wrong", wrong);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t size_max, unsigned int seed) {
  return pliant::fuzz::MutatePieces(data, size, size_max, seed, 3,
                                    [](pliant::Rng&) { return pliant::test::SessionCorpus(); });
}
