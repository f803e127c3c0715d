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

#include "server/limits.h"

namespace pliant::server {
namespace {

constexpr std::int32_t kVerticesMax = 100'000;
constexpr std::size_t kSealBytes = 24;

MetricUpdate SizeOf(const std::string& size) { return {.source = SizeMetric{size}}; }

// A session with a field, nodes that wait, and a saved revision two commits back.
SessionMemory Example() {
  Domain domain;
  domain.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  domain.segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}};
  Options options;
  options.vertices_max = kVerticesMax;
  SessionMemory memory(kHistoryBytesMax);
  memory.engine =
      StagedEngine::Create(
          {.start = domain, .metric = {.source = SizeMetric{"0.25"}}, .options = options},
          RemesherFactory())
          .value();
  const auto commit = [&](std::int64_t visits_max) {
    memory.active_count = memory.engine->Step({.visits_max = visits_max}).value().active_count;
    const auto diff = std::make_shared<const MeshDiff>(memory.engine->Commit());
    if (std::optional<UndoStep> undo = memory.engine->TakeUndo()) memory.undo.Add(*std::move(undo));
    memory.revision = diff->revision;
    memory.summary = diff->summary;
    memory.history.Add(diff);
  };
  commit(INT64_MAX);
  EXPECT_TRUE(memory.undo.Save(Revision(1), memory.revision).ok());
  EXPECT_TRUE(memory.engine->Stage(SizeOf("0.2 + 0.1*x")).ok());
  commit(INT64_MAX);
  FieldUpdate fields;
  const auto count = static_cast<std::size_t>(memory.engine->engine().vertex_count());
  fields.values.push_back({.name = "u", .values = std::vector<double>(count, 0.5)});
  EXPECT_TRUE(memory.engine->Stage(FieldsUpdate{memory.revision, fields}).ok());
  EXPECT_TRUE(memory.engine->Stage(SizeOf("0.12 + 0.1*y")).ok());
  commit(30);
  EXPECT_GT(memory.active_count, 0);
  return memory;
}

Bytes ExampleFile() { return WriteSessionFile({{"case", "7"}}, Example()).value(); }

Result<SessionMemory> Read(std::span<const std::byte> bytes,
                           std::int32_t vertices_max = kVerticesMax) {
  PLIANT_ASSIGN_OR_RETURN(const SessionFile file, OpenSessionFile(bytes));
  return ReadSessionFile(file, {.factory = RemesherFactory(), .loader = RemesherLoader()},
                         vertices_max);
}

TEST(SessionFile, HoldsASessionButNotItsHistoryNorWhatNobodySaved) {
  const Bytes bytes = ExampleFile();
  EXPECT_EQ(OpenSessionFile(bytes)->labels.at("case"), "7");
  const SessionMemory expected = Example();
  const Result<SessionMemory> memory = Read(bytes);
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
    const Result<SessionMemory> memory = Read(bytes);
    EXPECT_FALSE(memory.ok());
    EXPECT_EQ(memory.error().field, "file");
    return memory.error();
  };
  EXPECT_EQ(error_of({}).code, ErrorCode::kDataCorrupt);
  for (const std::size_t size : {std::size_t{1}, std::size_t{23}, kSealBytes, good.size() - 1}) {
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
  EXPECT_TRUE(Read(bytes, kVerticesMax).ok());
  const Result<SessionMemory> refused = Read(bytes, kVerticesMax - 1);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
  EXPECT_NE(refused.error().message.find("grow to 100000"), std::string::npos);
  EXPECT_NE(Read(bytes, 10).error().message.find("vertices; this server allows 10"),
            std::string::npos);
}

// Goal: an input that would have to be meshed first is no file's business.
TEST(SessionFile, HasNoInputs) {
  const Bytes input = WriteInput(Bytes(100));
  EXPECT_EQ(
      ReadSessionFile({.labels = {}, .memory = input},
                      {.factory = RemesherFactory(), .loader = RemesherLoader()}, kVerticesMax)
          .error()
          .code,
      ErrorCode::kDataCorrupt);
}

// --- Random damage ------------------------------------------------------------------------------

// Where a seal begins, and the bytes that it vouches for.
struct SealAt {
  std::size_t begin = 0;
  std::size_t size = 0;
};

// Every seal of a file: the outer one, and those of the memory, the engine and the undo steps in
// it.
std::vector<SealAt> SealsOf(const Bytes& bytes) {
  std::vector<SealAt> seals;
  for (std::size_t at = 0; at + kSealBytes <= bytes.size(); ++at) {
    const std::string kind(reinterpret_cast<const char*>(bytes.data() + at), 4);
    if (kind != "PLSF" && kind != "PLME" && kind != "PLSS" && kind != "PLRD") continue;
    std::uint64_t size = 0;
    std::memcpy(&size, bytes.data() + at + 8, sizeof(size));
    if (size <= bytes.size() - at - kSealBytes) seals.push_back({at, size});
  }
  return seals;
}

// Makes all checksums right again, the inner ones first.
void Reseal(const std::vector<SealAt>& seals, Bytes& bytes) {
  for (auto seal = seals.rbegin(); seal != seals.rend(); ++seal) {
    const std::uint64_t sum =
        Checksum(std::span(bytes).subspan(seal->begin + kSealBytes, seal->size));
    std::memcpy(bytes.data() + seal->begin + 16, &sum, sizeof(sum));
  }
}

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

// What was taken in is valid, wherever it can go back to, and stays so when it goes on.
void ExpectWorks(SessionMemory memory) {
  ASSERT_TRUE(memory.engine->engine().Validate().empty());
  for (const UndoStep& step : memory.undo.steps()) {
    const Result<UndoStep> way = memory.undo.WayTo(step.delta.revision, memory.revision);
    ASSERT_TRUE(way.ok());
    const Result<StagedEngine> there = memory.engine->Fork(&*way);
    ASSERT_TRUE(there.ok());
    ASSERT_TRUE(there->engine().Validate().empty());
  }
  if (!memory.engine->Stage(SizeOf("0.3")).ok()) return;  // Frozen by options, say.
  const Result<Progress> progress = memory.engine->Step({.visits_max = 500});
  if (!progress.ok()) return;
  static_cast<void>(memory.engine->Commit());
  EXPECT_TRUE(memory.engine->engine().Validate().empty());
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
  const std::vector<SealAt> seals = SealsOf(good);
  ASSERT_EQ(seals.size(), 4u);
  ASSERT_TRUE(Read(good).ok());
  std::uint64_t taken_count = 0;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    SCOPED_TRACE("replay: PLIANT_SEED=" + std::to_string(seed) +
                 " PLIANT_CASES=1 server_tests --gtest_filter='SessionFile.NoDamage*'");
    std::mt19937_64 random(seed);
    Bytes bytes = Damaged(good, random);
    const bool is_sealed = seed % 2 == 0;
    if (is_sealed) Reseal(seals, bytes);
    Result<SessionMemory> memory = Read(bytes);
    if (!memory.ok()) {
      EXPECT_TRUE(memory.error().code == ErrorCode::kDataCorrupt ||
                  memory.error().code == ErrorCode::kDataVersion ||
                  memory.error().code == ErrorCode::kTooLarge)
          << memory.error().message;
      continue;
    }
    EXPECT_TRUE(is_sealed || bytes == good) << "a checksum has not seen it";
    ++taken_count;
    ExpectWorks(std::move(memory).value());
    if (testing::Test::HasFatalFailure()) return;
  }
  RecordProperty("taken", std::to_string(taken_count));
  if (count > 1000) {
    EXPECT_GT(taken_count, 0u) << "some damage, to a time say, is none";
  }
}

}  // namespace
}  // namespace pliant::server
