#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "core/metric/metric_spec.h"
#include "server/clock.h"
#include "server/session_messages.h"

/// What a session's journal holds: all that changes what it will answer. Each record is sealed
/// (core/base/bytes.h) with a version of its own.
namespace pliant::server {

/// What an update did to the stage, besides its answer. Numbers are part of the format.
enum class StageEffect : std::uint8_t {
  kNone = 0,     ///< Nothing, or all that is staged went into a commit.
  kStaged = 1,   ///< It is staged: `update` has it.
  kTainted = 2,  ///< It was refused, and the next advance will be.
  kEmptied = 3,  ///< The stage is empty now.
  kPutOff = 4,   ///< It is on its way to the stage; if it is refused then, so is the next advance.
};

/// A numbered update was answered.
struct AnswerRecord {
  /// Absent where a bug emptied the stage, or an update under a used number was refused.
  std::optional<UpdateAnswer> answer = {};
  StageEffect effect = StageEffect::kNone;
  Bytes update = {};  ///< Staged or put off: as it came; SessionCodec reads it.
};

/// A revision was committed, by an advance or by going back.
struct CommitRecord {
  Revision revision = Revision::kNone;
  std::int64_t update_id = 0;     ///< What it applied.
  std::int64_t active_count = 0;  ///< Vertices that are left active.
  Clock::WallTime time = {};
  /// What the engine follows from now on, which may be null; absent: as before.
  std::optional<std::shared_ptr<const MetricSpec>> spec = {};
  /// One of them: what leads here from the revision before (WriteDelta), or the whole engine
  /// (Engine::Save) where there is none.
  std::variant<Bytes, Bytes> change = {};
  /// Of the diff, what the change does not tell.
  std::optional<TransferRows> transfer = {};
  FieldChanges fields = {};
};

/// The saved revisions are these now.
struct SavedRecord {
  std::vector<std::int64_t> revisions = {};
};

using Record = std::variant<AnswerRecord, CommitRecord, SavedRecord>;

[[nodiscard]] Bytes WriteRecord(const Record& record);
/// Errors: kDataCorrupt, kDataVersion.
[[nodiscard]] Result<Record> ReadRecord(std::span<const std::byte> bytes);

/// What a list shows of a session that is not in memory.
struct StoredInfo {
  SessionInfo info = {};
  Durability durability = Durability::kStrict;
};

[[nodiscard]] Bytes WriteInfo(const StoredInfo& stored);
/// The id is not in it. Errors: kDataCorrupt, kDataVersion.
[[nodiscard]] Result<StoredInfo> ReadInfo(std::span<const std::byte> bytes);

}  // namespace pliant::server
