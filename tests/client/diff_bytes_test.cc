// Goal: whatever a server sends, a client's replica is whole: what it refuses changes nothing.
// Method: messages of a subscription, mutated; the same trial is what tests/fuzz/diff_fuzz.cc runs.
// Replay: PLIANT_SEED=17 client_tests --gtest_filter='DiffBytes.*'
#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/client/fake_server.h"
#include "tests/client/model_mesh.h"
#include "tests/support/diff_trial.h"
#include "tests/support/seed.h"

namespace pliant::client {
namespace {

/// A snapshot and the diffs after it.
std::vector<test::Piece> Corpus(std::uint64_t seed) {
  std::vector<test::Piece> pieces;
  ModelChanger changer(seed);
  ModelMesh model;
  wire::ColumnWriter columns([](v1::BlobChunk) { FAIL() << "the corpus is small"; });
  for (int i = 0; i < 4; ++i) {
    ModelMesh next = changer.Next(model, 12);
    v1::SubscribeResponse response;
    if (i == 0) {
      WriteElements(DiffOf({}, next), columns, *response.mutable_snapshot());
    } else {
      WriteElements(DiffOf(model, next), columns, *response.mutable_diff());
    }
    pieces.push_back({.choice = 0, .bytes = response.SerializeAsString()});
    model = std::move(next);
  }
  return pieces;
}

TEST(DiffBytes, TheCorpusIsTaken) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    test::WriteSeed("diffs" + std::to_string(seed), Corpus(seed));
  }
  MeshReplica replica;
  wire::ColumnReader columns(1 << 20);
  for (const test::Piece& piece : Corpus(1)) {
    v1::SubscribeResponse response;
    ASSERT_TRUE(response.ParseFromString(piece.bytes));
    const Result<MeshDiff> diff = response.has_diff() ? FromWire(response.diff(), columns)
                                                      : FromWire(response.snapshot(), columns);
    ASSERT_TRUE(diff.ok()) << diff.error().message;
    ASSERT_TRUE(replica.Apply(*diff).ok());
    EXPECT_EQ(test::WrongWith(replica), "");
  }
}

// Goal: a server that takes a vertex from under its triangles, and states the hash of that, is a
// seed of the fuzzer, and breaks no replica.
TEST(DiffBytes, ALyingServerBreaksNoReplica) {
  wire::ColumnWriter columns([](v1::BlobChunk) { FAIL() << "the corpus is small"; });
  const ModelMesh model = ModelChanger(/*seed=*/6).Next({}, 12);
  std::vector<test::Piece> pieces;
  v1::SubscribeResponse snapshot;
  WriteElements(DiffOf({}, model), columns, *snapshot.mutable_snapshot());
  pieces.push_back({.choice = 0, .bytes = snapshot.SerializeAsString()});
  ModelMesh lie = model;
  lie.revision = Revision{2};
  lie.vertices.erase(lie.triangles.begin()->second.first[0]);
  v1::SubscribeResponse diff;
  WriteElements(DiffOf(model, lie), columns, *diff.mutable_diff());
  pieces.push_back({.choice = 0, .bytes = diff.SerializeAsString()});
  test::WriteSeed("diff_loses_a_corner", pieces);
  EXPECT_EQ(test::TryDiffs(test::Join(pieces)), "");
}

TEST(DiffBytes, NothingBreaksAReplica) {
  const google::protobuf::LogSilencer silencer;
  const std::uint64_t first = test::FirstSeed();
  for (std::uint64_t seed = first; seed < first + 5'000; ++seed) {
    Rng rng(seed);
    const std::string bytes = test::Join(test::Mutated(Corpus(1 + seed % 5), rng));
    ASSERT_EQ(test::TryDiffs(bytes), "") << "seed " << seed;
  }
}

}  // namespace
}  // namespace pliant::client
