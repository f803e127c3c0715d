// Goal: what is written as a file is read again, and no other bytes make a session that is not
// valid, hang or crash.
#include "server/session_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "tests/support/session_file_trial.h"

namespace pliant::server {
namespace {

using test::ExampleFile;
using test::ExampleMemory;
using test::kFileVerticesMax;
using test::ReadFile;

TEST(SessionFile, HoldsASessionButNotItsHistoryNorWhatNobodySaved) {
  const Bytes bytes = ExampleFile();
  EXPECT_EQ(OpenSessionFile(bytes)->labels.at("case"), "7");
  const SessionMemory expected = ExampleMemory();
  const Result<SessionMemory> memory = ReadFile(bytes);
  ASSERT_TRUE(memory.ok()) << memory.error().message;
  EXPECT_EQ(memory->revision, expected.revision);
  EXPECT_EQ(memory->summary, expected.summary);
  EXPECT_EQ(memory->active_count, expected.active_count);
  EXPECT_EQ(memory->undo.saved(), expected.undo.saved());
  EXPECT_EQ(memory->undo.steps().size(), 1u);
  EXPECT_EQ(memory->history.count(), 0u);
  EXPECT_EQ(*memory->engine->Save(), *expected.engine->Save()) << "to the bit";
}

// Goal: what is wrong with a file is said, and that it is the file.
TEST(SessionFile, SaysWhatIsWrong) {
  const Bytes good = ExampleFile();
  const auto error_of = [](const Bytes& bytes) {
    const Result<SessionMemory> memory = ReadFile(bytes);
    EXPECT_FALSE(memory.ok());
    EXPECT_EQ(memory.error().field, "file");
    return memory.error();
  };
  EXPECT_EQ(error_of({}).code, ErrorCode::kDataCorrupt);
  for (const std::size_t size :
       {std::size_t{1}, std::size_t{23}, test::kFileSealBytes, good.size() - 1}) {
    EXPECT_EQ(error_of(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size))).code,
              ErrorCode::kDataCorrupt);
  }
  const Error cut = error_of(Bytes(good.begin(), good.end() - 100));
  EXPECT_NE(cut.message.find("bytes"), std::string::npos) << cut.message;
  Bytes bytes = good;
  bytes.back() ^= std::byte{1};
  EXPECT_NE(error_of(bytes).message.find("checksum"), std::string::npos);
  bytes = good;
  bytes[4] = std::byte{2};
  EXPECT_EQ(error_of(bytes).code, ErrorCode::kDataVersion);
  bytes = good;
  bytes[0] = std::byte{'X'};
  EXPECT_EQ(error_of(bytes).code, ErrorCode::kDataCorrupt);
}

// Goal: a server's limits hold for files too, at the bound and one past it.
TEST(SessionFile, KeepsToTheServersLimitOfVertices) {
  const Bytes bytes = ExampleFile();
  EXPECT_TRUE(ReadFile(bytes, kFileVerticesMax).ok());
  const Result<SessionMemory> refused = ReadFile(bytes, kFileVerticesMax - 1);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
  EXPECT_NE(refused.error().message.find("grow to 100000"), std::string::npos);
  EXPECT_NE(ReadFile(bytes, 10).error().message.find("vertices; this server allows 10"),
            std::string::npos);
}

// Goal: an input that would have to be meshed first is no file's business.
TEST(SessionFile, HasNoInputs) {
  const Bytes input = WriteInput(Bytes(100));
  EXPECT_EQ(
      ReadSessionFile({.labels = {}, .memory = input},
                      {.factory = RemesherFactory(), .loader = RemesherLoader()}, kFileVerticesMax)
          .error()
          .code,
      ErrorCode::kDataCorrupt);
}

// --- Random damage ------------------------------------------------------------------------------

Bytes Damaged(Bytes bytes, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  const std::size_t count = 1 + below(3);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = below(bytes.size());
    switch (below(4)) {
      case 0:
        bytes[at] ^= static_cast<std::byte>(1U << below(8));
        break;
      case 1:
        bytes[at] = static_cast<std::byte>(random());
        break;
      case 2: {  // A number that is somewhere else in it, or an extreme one.
        const std::size_t from = below(bytes.size());
        const std::size_t size = std::min({std::size_t{8}, bytes.size() - at, bytes.size() - from});
        std::memmove(bytes.data() + at, bytes.data() + from, size);
        break;
      }
      default: {
        const std::byte value{below(2) == 0 ? std::uint8_t{0} : std::uint8_t{255}};
        std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                    std::min<std::size_t>(1 + below(8), bytes.size() - at), value);
      }
    }
  }
  return bytes;
}

// Method: a good file with random bytes changed; half of the time with all checksums made right
// again, because no chance would find one. CI takes 4,000 of them, PLIANT_LONG_TESTS=1 200,000.
// Replay one: PLIANT_SEED=17 PLIANT_CASES=1 server_tests --gtest_filter='SessionFile.NoDamage*'
TEST(SessionFile, NoDamageMakesAnInvalidSession) {
  const auto number = [](const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
  };
  const bool is_long = std::getenv("PLIANT_LONG_TESTS") != nullptr;
  const std::uint64_t first = number("PLIANT_SEED", 1);
  const std::uint64_t count = number("PLIANT_CASES", is_long ? 200'000 : 4'000);
  const Bytes good = ExampleFile();
  const std::vector<test::SealAt> seals = test::SealsOf(good);
  ASSERT_EQ(seals.size(), 4u);
  ASSERT_TRUE(ReadFile(good).ok());
  std::uint64_t taken_count = 0;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    SCOPED_TRACE("replay: PLIANT_SEED=" + std::to_string(seed) +
                 " PLIANT_CASES=1 server_tests --gtest_filter='SessionFile.NoDamage*'");
    std::mt19937_64 random(seed);
    Bytes bytes = Damaged(good, random);
    const bool is_sealed = seed % 2 == 0;
    if (is_sealed) test::Reseal(seals, bytes);
    Result<SessionMemory> memory = ReadFile(bytes);
    if (!memory.ok()) {
      EXPECT_TRUE(memory.error().code == ErrorCode::kDataCorrupt ||
                  memory.error().code == ErrorCode::kDataVersion ||
                  memory.error().code == ErrorCode::kTooLarge)
          << memory.error().message;
      continue;
    }
    EXPECT_TRUE(is_sealed || bytes == good) << "a checksum has not seen it";
    ++taken_count;
    ASSERT_EQ(test::WrongWith(std::move(memory).value()), "");
  }
  RecordProperty("taken", std::to_string(taken_count));
  if (count > 1000) {
    EXPECT_GT(taken_count, 0u) << "some damage, to a time say, is none";
  }
}

// Goal: what the fuzzer tries works here too: the example as it is, patched, and as raw bytes.
TEST(SessionFile, TheFuzzersTrialFindsNothing) {
  Bytes raw = ExampleFile();
  raw.insert(raw.begin(), std::byte{1});
  EXPECT_EQ(test::TryImport(raw), "");
  EXPECT_EQ(test::TryImport(Bytes{std::byte{0}}), "");
  std::mt19937_64 random(/*seed=*/5);
  for (int i = 0; i < 300; ++i) {
    Bytes patches(1 + 4 * (1 + random() % 4));
    for (std::byte& byte : patches) byte = static_cast<std::byte>(random());
    ASSERT_EQ(test::TryImport(patches), "") << "number " << i;
  }
}

}  // namespace
}  // namespace pliant::server
