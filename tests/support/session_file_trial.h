#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/check.h"
#include "server/limits.h"
#include "server/session_file.h"

/// A session file, and what is done with bytes that claim to be one, as server/importing.cc does.
namespace pliant::test {

inline constexpr std::int32_t kFileVerticesMax = 100'000;
inline constexpr std::size_t kFileSealBytes = 24;

/// A session with a field, nodes that wait, and a saved revision two commits back.
inline server::SessionMemory ExampleMemory() {
  using server::MetricUpdate;
  Domain domain;
  domain.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  domain.segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}};
  Options options;
  options.vertices_max = kFileVerticesMax;
  server::SessionMemory memory(server::kHistoryBytesMax);
  memory.engine =
      server::StagedEngine::Create(
          {.start = domain, .metric = {.source = SizeMetric{"0.25"}}, .options = options},
          server::RemesherFactory())
          .value();
  const auto commit = [&](std::int64_t visits_max) {
    memory.active_count = memory.engine->Step({.visits_max = visits_max}).value().active_count;
    const auto diff = std::make_shared<const MeshDiff>(memory.engine->Commit());
    if (auto undo = memory.engine->TakeUndo()) memory.undo.Add(*std::move(undo));
    memory.revision = diff->revision;
    memory.summary = diff->summary;
    memory.history.Add(diff);
  };
  commit(INT64_MAX);
  PLIANT_CHECK(memory.undo.Save(Revision(1), memory.revision).ok());
  PLIANT_CHECK(memory.engine->Stage(MetricUpdate{.source = SizeMetric{"0.2 + 0.1*x"}}).ok());
  commit(INT64_MAX);
  FieldUpdate fields;
  const auto count = static_cast<std::size_t>(memory.engine->engine().vertex_count());
  fields.values.push_back({.name = "u", .values = std::vector<double>(count, 0.5)});
  PLIANT_CHECK(memory.engine->Stage(server::FieldsUpdate{memory.revision, fields}).ok());
  PLIANT_CHECK(memory.engine->Stage(MetricUpdate{.source = SizeMetric{"0.12 + 0.1*y"}}).ok());
  commit(30);
  PLIANT_CHECK(memory.active_count > 0);
  return memory;
}

inline Bytes ExampleFile() {
  return server::WriteSessionFile({{"case", "7"}}, ExampleMemory()).value();
}

inline Result<server::SessionMemory> ReadFile(std::span<const std::byte> bytes,
                                              std::int32_t vertices_max = kFileVerticesMax) {
  PLIANT_ASSIGN_OR_RETURN(const server::SessionFile file, server::OpenSessionFile(bytes));
  return server::ReadSessionFile(
      file, {.factory = server::RemesherFactory(), .loader = server::RemesherLoader()},
      vertices_max);
}

/// Where a seal begins, and the bytes that it vouches for.
struct SealAt {
  std::size_t begin = 0;
  std::size_t size = 0;
};

/// Every seal of a file: the outer one, and those of the memory, the engine and the undo steps in
/// it.
inline std::vector<SealAt> SealsOf(const Bytes& bytes) {
  std::vector<SealAt> seals;
  for (std::size_t at = 0; at + kFileSealBytes <= bytes.size(); ++at) {
    const std::string kind(reinterpret_cast<const char*>(bytes.data() + at), 4);
    if (kind != "PLSF" && kind != "PLME" && kind != "PLSS" && kind != "PLRD") continue;
    std::uint64_t size = 0;
    std::memcpy(&size, bytes.data() + at + 8, sizeof(size));
    if (size <= bytes.size() - at - kFileSealBytes) seals.push_back({at, size});
  }
  return seals;
}

/// Makes all checksums right again, the inner ones first: no chance would find one.
inline void Reseal(const std::vector<SealAt>& seals, Bytes& bytes) {
  for (auto seal = seals.rbegin(); seal != seals.rend(); ++seal) {
    const std::uint64_t sum =
        Checksum(std::span(bytes).subspan(seal->begin + kFileSealBytes, seal->size));
    std::memcpy(bytes.data() + seal->begin + 16, &sum, sizeof(sum));
  }
}

/// What is wrong with a session that was taken in, wherever it can go back to and when it goes on.
inline std::string WrongWith(server::SessionMemory memory) {
  const auto fault_of = [](const server::Engine& engine) {
    const std::vector<std::string> faults = engine.Validate();
    return faults.empty() ? std::string() : faults.front();
  };
  if (std::string fault = fault_of(memory.engine->engine()); !fault.empty()) return fault;
  for (const server::UndoStep& step : memory.undo.steps()) {
    const auto way = memory.undo.WayTo(step.delta.revision, memory.revision);
    if (!way.ok()) return "there is no way to a saved revision";
    const Result<server::StagedEngine> there = memory.engine->Fork(&*way);
    if (!there.ok()) return "a saved revision cannot be forked";
    if (std::string fault = fault_of(there->engine()); !fault.empty()) return fault;
  }
  // It may be frozen by its options, say.
  if (!memory.engine->Stage(server::MetricUpdate{.source = SizeMetric{"0.3"}}).ok()) return "";
  const Result<Progress> progress = memory.engine->Step({.visits_max = 500});
  if (!progress.ok()) return "";
  static_cast<void>(memory.engine->Commit());
  return fault_of(memory.engine->engine());
}

/// Bytes from outside: a file as they stand, or where the first one is even, the example with
/// others written over it, in pairs of a position (three bytes) and a value, all checksums right.
/// @return what is wrong, or nothing
inline std::string TryImport(std::span<const std::byte> bytes) {
  if (bytes.empty()) return "";
  Bytes file(bytes.begin() + 1, bytes.end());
  if (std::to_integer<int>(bytes[0]) % 2 == 0) {
    static const Bytes kGood = ExampleFile();
    static const std::vector<SealAt> kSeals = SealsOf(kGood);
    const auto number = [&](std::size_t i) { return std::to_integer<std::size_t>(bytes[i]); };
    file = kGood;
    for (std::size_t i = 1; i + 3 < bytes.size(); i += 4) {
      file[(number(i) + 256 * number(i + 1) + 65'536 * number(i + 2)) % file.size()] = bytes[i + 3];
    }
    Reseal(kSeals, file);
  }
  Result<server::SessionMemory> memory = ReadFile(file);
  if (memory.ok()) return WrongWith(std::move(memory).value());
  const Error& error = memory.error();
  if (error.message.empty() || error.field != "file") return "a refusal does not say what it is";
  const bool is_known = error.code == ErrorCode::kDataCorrupt ||
                        error.code == ErrorCode::kDataVersion || error.code == ErrorCode::kTooLarge;
  return is_known ? "" : "refused with another code: " + error.message;
}

}  // namespace pliant::test
