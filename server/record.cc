#include "server/record.h"

#include <utility>

#include "core/mesh/mesh_delta.h"
#include "core/metric/saved_spec.h"
#include "server/record_values.h"

namespace pliant::server {
namespace {

constexpr Seal kRecordSeal{.kind = 0x43524c50, .version = 4};  // "PLRC"
constexpr Seal kInfoSeal{.kind = 0x46494c50, .version = 2};    // "PLIF"
constexpr char kRecordName[] = "session record";
constexpr char kInfoName[] = "session head";

// Part of the format.
enum class RecordKind : std::uint8_t { kAnswer = 1, kCommit = 2, kSaved = 3 };

void Put(const AnswerRecord& record, ByteWriter& writer) {
  writer.Put(static_cast<std::uint8_t>(RecordKind::kAnswer));
  writer.Put(static_cast<std::uint8_t>(record.effect));
  PutBytes(record.update, writer);
  writer.Put(static_cast<std::uint8_t>(record.answer.has_value() ? 1 : 0));
  if (record.answer) PutAnswer(*record.answer, writer);
}

AnswerRecord TakeAnswerRecord(ByteReader& reader) {
  AnswerRecord record;
  const auto effect = reader.Take<std::uint8_t>();
  if (effect > static_cast<std::uint8_t>(StageEffect::kPutOff)) reader.Fail();
  record.effect = static_cast<StageEffect>(effect);
  record.update = TakeBytes(reader);
  if (reader.Take<std::uint8_t>() != 0) record.answer = TakeAnswer(reader);
  return record;
}

void Put(const CommitRecord& record, ByteWriter& writer) {
  writer.Put(static_cast<std::uint8_t>(RecordKind::kCommit));
  writer.Put(static_cast<std::int64_t>(record.revision));
  writer.Put(record.update_id);
  writer.Put(record.active_count);
  PutTime(record.time, writer);
  writer.Put(static_cast<std::uint8_t>(record.spec.has_value() ? 1 : 0));
  if (record.spec) PutSpec(record.spec->get(), writer);
  writer.Put(static_cast<std::uint8_t>(record.change.index()));
  std::visit([&](const Bytes& bytes) { PutBytes(bytes, writer); }, record.change);
  writer.Put(static_cast<std::uint8_t>(record.transfer.has_value() ? 1 : 0));
  if (record.transfer) PutTransferRows(*record.transfer, writer);
  PutFields(record.fields, writer);
}

CommitRecord TakeCommitRecord(ByteReader& reader) {
  CommitRecord record;
  record.revision = Revision(reader.Take<std::int64_t>());
  record.update_id = reader.Take<std::int64_t>();
  record.active_count = reader.Take<std::int64_t>();
  record.time = TakeTime(reader);
  if (reader.Take<std::uint8_t>() != 0) record.spec = TakeSharedSpec(reader);
  if (reader.Take<std::uint8_t>() == 0) {
    record.change.emplace<0>(TakeBytes(reader));
  } else {
    record.change.emplace<1>(TakeBytes(reader));
  }
  if (reader.Take<std::uint8_t>() != 0) record.transfer = TakeTransferRows(reader);
  record.fields = TakeFields(reader);
  return record;
}

void Put(const SavedRecord& record, ByteWriter& writer) {
  writer.Put(static_cast<std::uint8_t>(RecordKind::kSaved));
  writer.Put(static_cast<std::uint64_t>(record.revisions.size()));
  for (const std::int64_t revision : record.revisions) writer.Put(revision);
}

}  // namespace

Bytes WriteRecord(const Record& record) {
  ByteWriter writer;
  std::visit([&](const auto& kind) { Put(kind, writer); }, record);
  return SealBytes(kRecordSeal, std::move(writer).Take());
}

Result<Record> ReadRecord(std::span<const std::byte> bytes) {
  PLIANT_ASSIGN_OR_RETURN(const std::span<const std::byte> payload,
                          OpenSeal(bytes, kRecordSeal, kRecordName));
  ByteReader reader(payload);
  Record record;
  switch (static_cast<RecordKind>(reader.Take<std::uint8_t>())) {
    case RecordKind::kAnswer:
      record = TakeAnswerRecord(reader);
      break;
    case RecordKind::kCommit:
      record = TakeCommitRecord(reader);
      break;
    case RecordKind::kSaved:
      record = SavedRecord{reader.TakeColumn<std::int64_t>()};
      break;
    default:
      reader.Fail();
  }
  if (!reader.AtEnd()) {
    return CorruptData(kRecordName, "does not hold what its checksum vouches for");
  }
  return record;
}

Bytes WriteInfo(const StoredInfo& stored) {
  const SessionInfo& info = stored.info;
  ByteWriter writer;
  writer.Put(static_cast<std::uint8_t>(stored.durability));
  writer.Put(static_cast<std::uint32_t>(info.labels.size()));
  for (const auto& [key, value] : info.labels) {
    writer.PutText(key);
    writer.PutText(value);
  }
  writer.Put(static_cast<std::int64_t>(info.revision));
  writer.Put(static_cast<std::uint8_t>(info.summary.has_value() ? 1 : 0));
  WriteSummary(info.summary.value_or(MeshSummary{}), writer);
  writer.Put(info.active_count);
  writer.Put(info.last_update_id);
  writer.PutColumn(info.saved_revisions);
  PutTime(info.create_time, writer);
  writer.Put(static_cast<std::uint8_t>(info.commit_time.has_value() ? 1 : 0));
  PutTime(info.commit_time.value_or(Clock::WallTime{}), writer);
  // It came to the format later: whoever did not ask for anything has nothing there.
  if (info.history_bytes_max) writer.Put(*info.history_bytes_max);
  return SealBytes(kInfoSeal, std::move(writer).Take());
}

Result<StoredInfo> ReadInfo(std::span<const std::byte> bytes) {
  PLIANT_ASSIGN_OR_RETURN(const std::span<const std::byte> payload,
                          OpenSeal(bytes, kInfoSeal, kInfoName));
  ByteReader reader(payload);
  StoredInfo stored;
  SessionInfo& info = stored.info;
  const auto durability = reader.Take<std::uint8_t>();
  if (durability < 1 || durability > 3) reader.Fail();
  stored.durability = static_cast<Durability>(durability);
  const auto label_count = reader.Take<std::uint32_t>();
  for (std::uint32_t i = 0; reader.ok() && i < label_count; ++i) {
    std::string key = reader.TakeText();
    info.labels[std::move(key)] = reader.TakeText();
  }
  info.revision = Revision(reader.Take<std::int64_t>());
  const bool has_summary = reader.Take<std::uint8_t>() != 0;
  const MeshSummary summary = ReadSummary(reader);
  if (has_summary) info.summary = summary;
  info.active_count = reader.Take<std::int64_t>();
  info.last_update_id = reader.Take<std::int64_t>();
  info.saved_revisions = reader.TakeColumn<std::int64_t>();
  info.create_time = TakeTime(reader);
  const bool has_commit = reader.Take<std::uint8_t>() != 0;
  const Clock::WallTime commit_time = TakeTime(reader);
  if (has_commit) info.commit_time = commit_time;
  if (reader.ok() && !reader.AtEnd()) info.history_bytes_max = reader.Take<std::int64_t>();
  if (!reader.AtEnd()) {
    return CorruptData(kInfoName, "does not hold what its checksum vouches for");
  }
  return stored;
}

}  // namespace pliant::server
