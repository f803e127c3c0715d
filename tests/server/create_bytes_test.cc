// Goal: no CreateSession breaks a server: it is refused with a sentence, or makes a mesh that is
// valid. Method: inputs of every kind, mutated; the same trial is what tests/fuzz/create_fuzz.cc
// runs. PLIANT_LONG_TESTS=1 takes 100,000. Replay: PLIANT_SEED=17 server_tests
// --gtest_filter='CreateBytes.NothingBreaks*'
#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/base/rng.h"
#include "tests/support/create_trial.h"
#include "tests/support/seed.h"

namespace pliant::server {
namespace {

TEST(CreateBytes, TheCorpusIsMeshed) {
  const auto corpus = test::CreateCorpus();
  for (std::size_t i = 0; i < corpus.size(); ++i) {
    test::WriteSeed("create" + std::to_string(i), corpus[i]);
    auto end = test::CreateEnd::kNotParsed;
    EXPECT_EQ(test::TryCreate(test::Join(corpus[i]), &end), "");
    EXPECT_EQ(end, test::CreateEnd::kMeshed) << "number " << i;
  }
}

TEST(CreateBytes, NothingBreaksAServer) {
  const google::protobuf::LogSilencer silencer;
  const auto corpus = test::CreateCorpus();
  int meshed = 0;
  int refused = 0;
  const std::vector<std::uint64_t> seeds =
      test::Seeds{.count = 3'000, .long_count = 100'000}.OfPart(0);
  for (const std::uint64_t seed : seeds) {
    Rng rng(seed);
    const std::string bytes = test::Join(test::Mutated(corpus[rng.Below(corpus.size())], rng));
    auto end = test::CreateEnd::kNotParsed;
    ASSERT_EQ(test::TryCreate(bytes, &end), "")
        << test::Replay(seed, "server_tests", "CreateBytes.NothingBreaks*");
    meshed += end == test::CreateEnd::kMeshed;
    refused += end == test::CreateEnd::kRefused;
  }
  if (seeds.size() > 1) {
    EXPECT_GT(meshed, 100) << "the mutations destroy too much";
    EXPECT_GT(refused, 100) << "the mutations hardly touch what is checked";
  }
}

}  // namespace
}  // namespace pliant::server
