#include "server/saved_state.h"

#include <algorithm>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/mesh_delta.h"
#include "core/metric/saved_spec.h"
#include "server/kept_bytes.h"
#include "server/record.h"
#include "server/record_values.h"
#include "server/revision_text.h"

namespace pliant::server {
namespace {

constexpr Seal kInputSeal{.kind = 0x4e494c50, .version = 2};   // "PLIN"
constexpr Seal kMemorySeal{.kind = 0x454d4c50, .version = 4};  // "PLME"
constexpr char kMemoryName[] = "session snapshot";

bool IsInput(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  return reader.Take<std::uint32_t>() == kInputSeal.kind;
}

// --- Undo steps ---------------------------------------------------------------------------------

// A specification is written where it is another one than that of the step after it.
Status PutUndo(const SessionMemory& memory, ByteWriter& writer) {
  const std::deque<UndoStep>& steps = memory.undo.steps();
  writer.Put(static_cast<std::uint32_t>(steps.size()));
  const MetricSpec* known = memory.engine->committed_spec().get();
  for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
    PLIANT_ASSIGN_OR_RETURN(const Bytes delta, WriteDelta(step->delta));
    PutBytes(delta, writer);
    writer.Put(step->active_count);
    const bool is_same = step->spec.get() == known;
    writer.Put(static_cast<std::uint8_t>(is_same ? 0 : 1));
    if (!is_same) PutSpec(step->spec.get(), writer);
    known = step->spec.get();
  }
  writer.PutColumn(memory.undo.saved());
  return {};
}

Status TakeUndo(ByteReader& reader, SessionMemory& memory) {
  std::deque<UndoStep> steps;
  const auto count = reader.Take<std::uint32_t>();
  std::shared_ptr<const MetricSpec> spec = memory.engine->committed_spec();
  for (std::uint32_t i = 0; reader.ok() && i < count; ++i) {
    const Bytes bytes = TakeBytes(reader);
    // The newest leads away from where the engine is, each other one from where the one before it
    // leads to.
    Result<RevisionDelta> delta =
        steps.empty() ? memory.engine->engine().ReadDelta(bytes)
                      : ReadDelta(bytes, steps.front().delta.metric, steps.front().delta.fields);
    if (!delta.ok()) return delta.error();
    const auto active_count = reader.Take<std::int64_t>();
    if (reader.Take<std::uint8_t>() != 0) spec = TakeSharedSpec(reader);
    steps.push_front(UndoStep{std::move(delta).value(), spec, active_count});
  }
  const auto saved = reader.TakeColumn<std::int64_t>();
  if (reader.ok() && !memory.undo.Restore(std::move(steps), saved, memory.revision)) reader.Fail();
  return {};
}

// --- Memory -------------------------------------------------------------------------------------

// As Session::Publish does: what comes next finds the same bounds as it found there.
void BoundByMesh(SessionMemory& memory, const SessionMakers& makers) {
  const std::int64_t vertex_count = memory.summary ? memory.summary->vertex_count : 0;
  const std::optional<std::int64_t> asked = memory.history_bytes_max;
  memory.history.SetBytesMax(HistoryBytesMax(vertex_count, makers.history_bytes_max, asked));
  memory.undo.SetBytesMax(UndoBytesMax(vertex_count, asked));
}

// Then what came to the format later: whoever did not ask for anything has nothing there.
void PutHistory(const SessionMemory& memory, ByteWriter& writer) {
  writer.Put(static_cast<std::uint32_t>(memory.history.count()));
  for (const auto& diff : memory.history.diffs()) PutDiff(*diff, writer);
  if (memory.history_bytes_max) writer.Put(*memory.history_bytes_max);
}

void TakeHistory(ByteReader& reader, SessionMemory& memory, const SessionMakers& makers) {
  std::vector<std::shared_ptr<const MeshDiff>> diffs;
  const auto diff_count = reader.Take<std::uint32_t>();
  for (std::uint32_t i = 0; reader.ok() && i < diff_count; ++i) {
    diffs.push_back(std::make_shared<const MeshDiff>(TakeDiff(reader)));
  }
  if (reader.ok() && !reader.AtEnd()) memory.history_bytes_max = reader.Take<std::int64_t>();
  if (memory.history_bytes_max && *memory.history_bytes_max < 0) reader.Fail();
  if (!reader.ok()) return;
  BoundByMesh(memory, makers);
  for (auto& diff : diffs) memory.history.Add(std::move(diff));
}

Result<SessionMemory> ReadSnapshot(std::span<const std::byte> bytes, const SessionMakers& makers) {
  SessionMemory memory(makers.history_bytes_max);
  if (IsInput(bytes)) {
    PLIANT_ASSIGN_OR_RETURN(const auto input, OpenSeal(bytes, kInputSeal, kMemoryName));
    PLIANT_ASSIGN_OR_RETURN(SessionInput start, makers.codec->ReadInput(input));
    memory.history_bytes_max = start.history_bytes_max;
    PLIANT_ASSIGN_OR_RETURN(memory.engine,
                            StagedEngine::Create(std::move(start.engine), makers.factory));
    memory.active_count = memory.engine->engine().vertex_count();
    return memory;
  }
  PLIANT_ASSIGN_OR_RETURN(const auto payload, OpenSeal(bytes, kMemorySeal, kMemoryName));
  ByteReader reader(payload);
  memory.revision = Revision(reader.Take<std::int64_t>());
  memory.applied_update_id = reader.Take<std::int64_t>();
  memory.active_count = reader.Take<std::int64_t>();
  memory.summary = ReadSummary(reader);
  memory.commit_time = TakeTime(reader);
  // The engine, nearly all of it, is read where it is: a copy would cost as much as the checksums.
  const auto engine_size = reader.Take<std::uint64_t>();
  if (!reader.ok() || engine_size > reader.size_left()) {
    return CorruptData(kMemoryName, "ends too early");
  }
  const std::span<const std::byte> rest = payload.last(reader.size_left());
  const std::span<const std::byte> engine_bytes = rest.first(engine_size);
  reader = ByteReader(rest.subspan(engine_size));
  std::shared_ptr<const MetricSpec> spec = TakeSharedSpec(reader);
  if (!reader.ok()) return CorruptData(kMemoryName, "ends too early");
  PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<Engine> engine, makers.loader(engine_bytes));
  memory.engine = StagedEngine::Adopt(std::move(engine), std::move(spec), makers.factory);
  const auto last_update_id = reader.Take<std::int64_t>();
  const auto answer_count = reader.Take<std::uint32_t>();
  for (std::uint32_t i = 0; reader.ok() && i < answer_count; ++i) {
    const UpdateAnswer answer = TakeAnswer(reader);
    if (answer.event.update_id <= memory.results.last_update_id()) reader.Fail();
    if (reader.ok()) memory.results.Add(answer);
  }
  if (memory.results.last_update_id() != last_update_id) reader.Fail();
  PLIANT_RETURN_IF_ERROR(TakeUndo(reader, memory));
  TakeHistory(reader, memory, makers);
  if (!reader.AtEnd() || memory.engine->revision() != memory.revision) {
    return CorruptData(kMemoryName, "does not hold what its checksum vouches for");
  }
  return memory;
}

// --- Records ------------------------------------------------------------------------------------

Status Corrupt(Revision revision, const std::string& what) {
  return CorruptData("session journal", "at revision " + RevisionText(revision) + " " + what);
}

Status Restage(SessionMemory& memory, const AnswerRecord& record, const SessionMakers& makers) {
  const UpdateCommand command = makers.codec->ReadUpdate(record.update);
  const Status status = memory.engine->StageCommand(command);
  if (status.ok()) return {};
  return Corrupt(memory.revision,
                 "holds a staged update that is refused now: " + status.error().message);
}

/// Nobody had staged it yet when it was written, so what comes of it was not known.
Status StagePutOff(SessionMemory& memory, const AnswerRecord& record, const SessionMakers& makers) {
  StagedEngine& engine = *memory.engine;
  if (!record.answer) return Corrupt(memory.revision, "holds an update without its number");
  if (engine.late_refusal()) return {};  // It was dropped with the one before it.
  const std::int64_t update_id = record.answer->event.update_id;
  Status status;
  try {
    status = engine.StageCommand(makers.codec->ReadUpdate(record.update));
  } catch (const std::exception& exception) {
    PLIANT_RETURN_IF_ERROR(engine.Discard());
    status = Error{ErrorCode::kInternal, exception.what(), {}};
  }
  if (!status.ok()) engine.TaintLate(update_id, status.error());
  return {};
}

Status Replay(SessionMemory& memory, const AnswerRecord& record, const SessionMakers& makers) {
  switch (record.effect) {
    case StageEffect::kNone:
      break;
    case StageEffect::kStaged:
      PLIANT_RETURN_IF_ERROR(Restage(memory, record, makers));
      break;
    case StageEffect::kPutOff:
      PLIANT_RETURN_IF_ERROR(StagePutOff(memory, record, makers));
      break;
    case StageEffect::kTainted:
      memory.engine->Taint();
      break;
    case StageEffect::kEmptied:
      PLIANT_RETURN_IF_ERROR(memory.engine->Discard());
      break;
  }
  if (!record.answer) return {};
  if (record.answer->event.update_id <= memory.results.last_update_id()) {
    return Corrupt(memory.revision, "answers an update twice");
  }
  memory.results.Add(*record.answer);
  return {};
}

Status ReplayWhole(SessionMemory& memory, const CommitRecord& record, const SessionMakers& makers) {
  PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<Engine> engine,
                          makers.loader(std::get<1>(record.change)));
  memory.engine = StagedEngine::Adopt(
      std::move(engine), record.spec ? *record.spec : memory.engine->spec(), makers.factory);
  memory.undo.Clear();
  memory.history = DiffHistory(makers.history_bytes_max);
  memory.summary = memory.engine->engine().Snapshot().summary;
  BoundByMesh(memory, makers);
  return {};
}

Status ReplayDelta(SessionMemory& memory, const CommitRecord& record, const SessionMakers& makers) {
  StagedEngine& engine = *memory.engine;
  PLIANT_ASSIGN_OR_RETURN(RevisionDelta delta,
                          engine.engine().ReadDelta(std::get<0>(record.change)));
  const std::shared_ptr<const MetricSpec> spec =
      record.spec ? *record.spec : engine.committed_spec();
  PLIANT_ASSIGN_OR_RETURN(
      auto gone,
      engine.GoTo(UndoStep{std::move(delta), spec, record.active_count}, record.revision));
  gone.second.active_count = memory.active_count;
  memory.undo.Add(std::move(gone.second));
  MeshDiff& diff = gone.first;
  diff.transfer = record.transfer;
  diff.fields = record.fields;
  memory.summary = diff.summary;
  BoundByMesh(memory, makers);
  memory.history.Add(std::make_shared<const MeshDiff>(std::move(diff)));
  return {};
}

Status Replay(SessionMemory& memory, const CommitRecord& record, const SessionMakers& makers) {
  if (record.change.index() == 1) {
    PLIANT_RETURN_IF_ERROR(ReplayWhole(memory, record, makers));
  } else {
    // What was staged is in the commit.
    PLIANT_RETURN_IF_ERROR(memory.engine->Discard());
    PLIANT_RETURN_IF_ERROR(ReplayDelta(memory, record, makers));
  }
  if (memory.engine->revision() != record.revision) return Corrupt(record.revision, "has a gap");
  memory.revision = record.revision;
  memory.applied_update_id = record.update_id;
  memory.active_count = record.active_count;
  memory.commit_time = record.time;
  return {};
}

Status Replay(SessionMemory& memory, const SavedRecord& record, const SessionMakers&) {
  std::vector<std::int64_t> released;
  for (const std::int64_t revision : memory.undo.saved()) {
    if (std::find(record.revisions.begin(), record.revisions.end(), revision) ==
        record.revisions.end()) {
      released.push_back(revision);
    }
  }
  PLIANT_RETURN_IF_ERROR(memory.undo.Release(released));
  for (const std::int64_t revision : record.revisions) {
    PLIANT_RETURN_IF_ERROR(memory.undo.Save(Revision(revision), memory.revision));
  }
  return {};
}

}  // namespace

Bytes WriteInput(std::span<const std::byte> input) { return SealBytes(kInputSeal, input); }

Result<Bytes> WriteMemory(const SessionMemory& memory) {
  PLIANT_ASSIGN_OR_RETURN(const Bytes engine, memory.engine->Save());
  ByteWriter writer;
  writer.Put(static_cast<std::int64_t>(memory.revision));
  writer.Put(memory.applied_update_id);
  writer.Put(memory.active_count);
  WriteSummary(memory.summary.value_or(MeshSummary{}), writer);
  PutTime(memory.commit_time.value_or(Clock::WallTime{}), writer);
  PutBytes(engine, writer);
  PutSpec(memory.engine->committed_spec().get(), writer);
  writer.Put(memory.results.last_update_id());
  writer.Put(static_cast<std::uint32_t>(memory.results.count()));
  for (std::size_t i = 0; i < memory.results.count(); ++i) PutAnswer(memory.results.At(i), writer);
  PLIANT_RETURN_IF_ERROR(PutUndo(memory, writer));
  PutHistory(memory, writer);
  return SealBytes(kMemorySeal, std::move(writer).Take());
}

Result<SessionMemory> ReadMemory(std::span<const std::byte> snapshot,
                                 std::span<const Bytes> records, const SessionMakers& makers) {
  PLIANT_ASSIGN_OR_RETURN(SessionMemory memory, ReadSnapshot(snapshot, makers));
  for (const Bytes& bytes : records) {
    PLIANT_ASSIGN_OR_RETURN(const Record record, ReadRecord(bytes));
    PLIANT_RETURN_IF_ERROR(
        std::visit([&](const auto& kind) { return Replay(memory, kind, makers); }, record));
  }
  return memory;
}

Result<std::size_t> CountUnstaged(std::span<const Bytes> records) {
  std::size_t count = 0;
  bool is_staged = false;
  for (std::size_t i = 0; i < records.size(); ++i) {
    PLIANT_ASSIGN_OR_RETURN(const Record record, ReadRecord(records[i]));
    if (std::holds_alternative<CommitRecord>(record)) {
      is_staged = false;
    } else if (const auto* answer = std::get_if<AnswerRecord>(&record)) {
      is_staged = answer->effect == StageEffect::kStaged ||
                  answer->effect == StageEffect::kPutOff ||
                  answer->effect == StageEffect::kTainted ||
                  (is_staged && answer->effect == StageEffect::kNone);
    }
    if (!is_staged) count = i + 1;
  }
  return count;
}

Result<std::size_t> CountSettled(std::span<const Bytes> records) {
  for (std::size_t count = records.size(); count > 0; --count) {
    PLIANT_ASSIGN_OR_RETURN(const Record record, ReadRecord(records[count - 1]));
    if (std::holds_alternative<CommitRecord>(record)) return count;
  }
  return std::size_t{0};
}

}  // namespace pliant::server
