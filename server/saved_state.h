#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "server/clock.h"
#include "server/diff_history.h"
#include "server/limits.h"
#include "server/staged_engine.h"
#include "server/undo_history.h"
#include "server/update_results.h"

/// A session's memory, written and read again: what it is between two updates, and how the records
/// of its journal bring an older state up to date.
namespace pliant::server {

/// Reads what clients sent, which is kept as it came.
///
/// *Threads*: any.
class SessionCodec {
 public:
  virtual ~SessionCodec() = default;
  /// What a session starts from. Errors: those of ConvertCreate.
  [[nodiscard]] virtual Result<SessionInput> ReadInput(std::span<const std::byte> bytes) const = 0;
  /// A staged update; what is wrong with it becomes its body.
  [[nodiscard]] virtual UpdateCommand ReadUpdate(std::span<const std::byte> bytes) const = 0;
};

/// What makes a session again.
struct SessionMakers {
  EngineFactory factory = {};
  EngineLoader loader = {};
  const SessionCodec* codec = nullptr;
  std::size_t history_bytes_max = kHistoryBytesMax;
};

/// Everything that a session knows besides who uses it.
struct SessionMemory {
  explicit SessionMemory(std::size_t history_bytes_max) : history(history_bytes_max) {}

  std::optional<StagedEngine> engine = {};
  DiffHistory history;
  UndoHistory undo{{.bytes_max = kUndoBytesMax, .saved_max = kSavedRevisionsMax}};
  UpdateResults results{kUpdateResultsMax};
  Revision revision = Revision::kNone;
  std::int64_t applied_update_id = 0;
  std::int64_t active_count = 0;
  std::optional<MeshSummary> summary = {};
  std::optional<Clock::WallTime> commit_time = {};
  std::optional<std::int64_t> history_bytes_max = {};  ///< As SessionInput has it.
};

/// What a session's journal begins with: what its creator sent...
[[nodiscard]] Bytes WriteInput(std::span<const std::byte> input);
/// ...or its memory. Errors: those of Engine::Save; kProtocolOrder while updates are staged.
/// @par Cost O(mesh)
[[nodiscard]] Result<Bytes> WriteMemory(const SessionMemory& memory);

/// A session as its snapshot and the records since left it: the engine gives the bits that it would
/// have given, staged updates are staged.
/// Errors: kDataCorrupt, also where the state hash after a record is not what it was; kDataVersion;
/// those of the makers. @par Cost O(bytes)
[[nodiscard]] Result<SessionMemory> ReadMemory(std::span<const std::byte> snapshot,
                                               std::span<const Bytes> records,
                                               const SessionMakers& makers);

/// Of these records, how many leave nothing staged behind: all up to the last such moment.
/// Errors: kDataCorrupt, kDataVersion.
[[nodiscard]] Result<std::size_t> CountUnstaged(std::span<const Bytes> records);

/// Of these records, how many can be put into a snapshot: all up to the last commit.
/// Errors: kDataCorrupt, kDataVersion.
[[nodiscard]] Result<std::size_t> CountSettled(std::span<const Bytes> records);

}  // namespace pliant::server
