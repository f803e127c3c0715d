// Goal: no bytes that arrive as a request crash the decoder, throw, or get past it half checked:
// each becomes a command, or a refusal with a sentence.
// Method: valid requests of every kind, from the tests' own builders, with bits flipped, bytes cut,
// doubled and spliced; what still parses is resolved and converted as a stream would. The
// sanitizers watch. Replay: PLIANT_SEED=17 server_tests --gtest_filter='RequestDecoder.*'
#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

#include "core/base/rng.h"
#include "server/blobs.h"
#include "server/convert.h"
#include "tests/support/edit_corpus.h"
#include "tests/support/pieces.h"
#include "tests/support/seed.h"
#include "tests/support/session_trial.h"
#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

using test::EditCorpus;
using test::FirstSeed;
using test::IsUpdate;
using test::Mutated;

constexpr RequestLimits kDecoderLimits{.vertices_max = 10'000};

/// Protobuf writes a line for every text that is no UTF-8.
class RequestDecoder : public ::testing::Test {
 protected:
  google::protobuf::LogSilencer silencer_;
};

TEST_F(RequestDecoder, EveryEditRequestIsACommandOrARefusal) {
  const std::vector<std::string> corpus = EditCorpus();
  int parsed = 0;
  int refused = 0;
  const std::uint64_t first = FirstSeed();
  for (std::uint64_t seed = first; seed < first + 40'000; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    Rng rng(seed);
    v1::EditRequest request;
    const std::string& one = corpus[rng.Below(corpus.size())];
    const std::string& other = corpus[rng.Below(corpus.size())];
    if (!request.ParseFromString(Mutated(one, other, rng)) || !IsUpdate(request)) continue;
    ++parsed;
    BlobAssembler blobs;
    if (const Status status = blobs.Resolve(request); !status.ok()) {
      EXPECT_FALSE(status.error().message.empty());
      ++refused;
      continue;
    }
    const UpdateCommand command = ConvertUpdate(request, kDecoderLimits);
    EXPECT_EQ(command.update_id, request.update_id());
    if (const auto* bad = std::get_if<BadUpdate>(&command.body)) {
      EXPECT_FALSE(bad->error.message.empty());
      EXPECT_NE(bad->error.code, ErrorCode::kInternal);
      ++refused;
    }
    if (HasFailure()) return;
  }
  EXPECT_GT(parsed, 5'000) << "the mutations destroy too much";
  EXPECT_GT(refused, 500) << "the mutations hardly touch what is checked";
  EXPECT_LT(refused, parsed);
}

TEST_F(RequestDecoder, EveryCreateIsAnInputOrARefusal) {
  const std::vector<std::string> corpus{test::UnitSquare("0.1").SerializeAsString(),
                                        test::TwoTriangles().SerializeAsString()};
  int taken = 0;
  int refused = 0;
  const std::uint64_t first = FirstSeed();
  for (std::uint64_t seed = first; seed < first + 20'000; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    Rng rng(seed);
    v1::CreateSession create;
    if (!create.ParseFromString(Mutated(corpus[rng.Below(2)], corpus[rng.Below(2)], rng))) continue;
    BlobAssembler blobs;
    if (!blobs.Resolve(create).ok()) continue;
    const Result<SessionInput> input = ConvertCreate(create, kDecoderLimits);
    if (input.ok()) {
      ++taken;
      EXPECT_LE(input->engine.options.vertices_max, kDecoderLimits.vertices_max);
    } else {
      ++refused;
      EXPECT_FALSE(input.error().message.empty());
    }
    if (HasFailure()) return;
  }
  EXPECT_GT(taken, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace pliant::server
