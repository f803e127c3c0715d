// Goal: no sequence of requests, however mangled, breaks a session: each is answered once, no bug
// is met, every diff fits, and the mesh at the end is valid and the mirror's.
// Method: the corpus whole, then with its commands mutated, left out, doubled and swapped; the same
// trial is what tests/fuzz/session_fuzz.cc runs.
// Replay: PLIANT_SEED=17 server_tests --gtest_filter='SessionCommands.*'
#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include "tests/support/edit_corpus.h"
#include "tests/support/seed.h"
#include "tests/support/session_trial.h"

namespace pliant::test {
namespace {

TEST(SessionCommands, TheCorpusIsTaken) {
  SessionTrial trial;
  std::int64_t id = 0;
  for (const Piece& piece : SessionCorpus()) {
    v1::EditRequest request;
    ASSERT_TRUE(request.ParseFromString(piece.bytes));
    request.set_update_id(++id);
    ASSERT_EQ(trial.Run(request), "") << request.ShortDebugString();
    ASSERT_EQ(trial.last_refusal(), "") << request.ShortDebugString();
  }
  EXPECT_EQ(trial.CheckMesh(), "");
  EXPECT_EQ(trial.accepted_count(), static_cast<int>(SessionCorpus().size()));
}

TEST(SessionCommands, NoSequenceBreaksASession) {
  const google::protobuf::LogSilencer silencer;
  const std::uint64_t first = FirstSeed();
  for (std::uint64_t seed = first; seed < first + 1'000; ++seed) {
    Rng rng(seed);
    ASSERT_EQ(TrySession(Join(Mutated(SessionCorpus(), rng))), "") << "seed " << seed;
  }
}

}  // namespace
}  // namespace pliant::test
