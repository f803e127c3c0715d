#include "server/session_file.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "server/limits.h"
#include "server/record_values.h"

namespace pliant::server {
namespace {

constexpr Seal kFileSeal{.kind = 0x46534c50, .version = 1};  // "PLSF"
constexpr char kFileName[] = "session file";
constexpr char kField[] = "file";

/// Beyond it a session could not count on for long.
constexpr Revision kRevisionMax{std::int64_t{1} << 62};

/// Whatever was wrong inside, to whoever sent it it is the file.
Error InFile(Error error) {
  const bool is_sound = error.code == ErrorCode::kDataVersion || error.code == ErrorCode::kTooLarge;
  if (!is_sound) error.code = ErrorCode::kDataCorrupt;
  error.field = kField;
  return error;
}

Error Corrupt(const std::string& what) { return InFile(CorruptData(kFileName, what)); }

/// A file holds memory, never what somebody would have to mesh first.
class NoInput final : public SessionCodec {
 public:
  Result<SessionInput> ReadInput(std::span<const std::byte>) const override {
    return CorruptData(kFileName, "has no mesh");
  }
  UpdateCommand ReadUpdate(std::span<const std::byte>) const override { return {}; }
};

Status CheckEngine(const Engine& engine, std::int32_t vertices_max) {
  if (const std::vector<std::string> faults = engine.Validate(); !faults.empty()) {
    return Corrupt("holds a mesh that is not valid: " + faults.front());
  }
  if (engine.vertex_count() > vertices_max) {
    return Error{ErrorCode::kTooLarge,
                 "the session has " + std::to_string(engine.vertex_count()) +
                     " vertices; this server allows " + std::to_string(vertices_max),
                 kField};
  }
  if (engine.options().vertices_max > vertices_max) {
    return Error{ErrorCode::kTooLarge,
                 "the session may grow to " + std::to_string(engine.options().vertices_max) +
                     " vertices; this server allows " + std::to_string(vertices_max) +
                     ": lower options.vertices_max where the session is, and export it again",
                 kField};
  }
  return {};
}

/// Every revision that somebody could go back to.
Status CheckSaved(const SessionMemory& memory, std::int32_t vertices_max) {
  const std::vector<std::int64_t> saved = memory.undo.saved();
  for (const UndoStep& step : memory.undo.steps()) {
    const Revision revision = step.delta.revision;
    if (!std::binary_search(saved.begin(), saved.end(), static_cast<std::int64_t>(revision))) {
      return Corrupt("leads back to a revision that is not saved");
    }
    PLIANT_ASSIGN_OR_RETURN(const UndoStep way, memory.undo.WayTo(revision, memory.revision));
    PLIANT_ASSIGN_OR_RETURN(const StagedEngine there, memory.engine->Fork(&way));
    PLIANT_RETURN_IF_ERROR(CheckEngine(there.engine(), vertices_max));
    if (step.active_count < 0 || step.active_count > there.engine().vertex_count()) {
      return Corrupt("has more active vertices than vertices");
    }
  }
  return {};
}

Status Check(const SessionMemory& memory, std::int32_t vertices_max) {
  const Engine& engine = memory.engine->engine();
  PLIANT_RETURN_IF_ERROR(CheckEngine(engine, vertices_max));
  if (memory.revision > kRevisionMax) return Corrupt("has an impossible revision");
  if (memory.results.last_update_id() > kUpdateIdMax) return Corrupt("has an impossible update");
  if (memory.summary != engine.Snapshot().summary) return Corrupt("has another mesh than it says");
  if (memory.active_count < 0 || memory.active_count > engine.vertex_count()) {
    return Corrupt("has more active vertices than vertices");
  }
  return CheckSaved(memory, vertices_max);
}

}  // namespace

Result<Bytes> WriteSessionFile(const std::map<std::string, std::string>& labels,
                               SessionMemory memory) {
  memory.undo.KeepSavedOnly();
  memory.history = DiffHistory(0);
  PLIANT_ASSIGN_OR_RETURN(const Bytes bytes, WriteMemory(memory));
  ByteWriter writer;
  writer.Put(static_cast<std::uint32_t>(labels.size()));
  for (const auto& [key, value] : labels) {
    writer.PutText(key);
    writer.PutText(value);
  }
  PutBytes(bytes, writer);
  Bytes file = SealBytes(kFileSeal, std::move(writer).Take());
  if (file.size() > kUploadBytesMax) {
    return Error{ErrorCode::kTooLarge,
                 "the session's file would have " + std::to_string(file.size()) +
                     " bytes, and no more than " + std::to_string(kUploadBytesMax) +
                     " can be imported",
                 kField};
  }
  return file;
}

Result<SessionFile> OpenSessionFile(std::span<const std::byte> bytes) {
  const auto payload = OpenSeal(bytes, kFileSeal, kFileName);
  if (!payload.ok()) return InFile(payload.error());
  ByteReader reader(*payload);
  SessionFile file;
  const auto count = reader.Take<std::uint32_t>();
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    std::string key = reader.TakeText();
    file.labels[std::move(key)] = reader.TakeText();
  }
  // The rest, without a copy of it.
  const auto size = reader.Take<std::uint64_t>();
  if (!reader.ok() || size != reader.size_left()) {
    return Corrupt("does not hold what its checksum vouches for");
  }
  file.memory = payload->last(static_cast<std::size_t>(size));
  return file;
}

Result<SessionMemory> ReadSessionFile(const SessionFile& file, const SessionMakers& makers,
                                      std::int32_t vertices_max) {
  static const NoInput kNoInput;
  SessionMakers own = makers;
  own.codec = &kNoInput;
  Result<SessionMemory> memory = ReadMemory(file.memory, {}, own);
  if (!memory.ok()) return InFile(memory.error());
  memory->history = DiffHistory(makers.history_bytes_max);
  if (const Status status = Check(*memory, vertices_max); !status.ok()) {
    return InFile(status.error());
  }
  return memory;
}

}  // namespace pliant::server
