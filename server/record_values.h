#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "core/base/bytes.h"
#include "core/mesh/mesh_diff.h"
#include "core/metric/metric_spec.h"
#include "server/clock.h"
#include "server/session_messages.h"

/// How what a session remembers is written: little-endian numbers, one after the other. Readers
/// fail (ByteReader::Fail) where the bytes cannot be what was written; then the result is of no
/// use.
namespace pliant::server {

/// An answer to a numbered update: accepted, rejected or advanced.
void PutAnswer(const UpdateAnswer& answer, ByteWriter& writer);
/// Also those that were written before there were fingerprints.
[[nodiscard]] UpdateAnswer TakeAnswer(ByteReader& reader);

/// What PutSpec wrote, to be shared; null for none.
[[nodiscard]] std::shared_ptr<const MetricSpec> TakeSharedSpec(ByteReader& reader);

void PutTransferRows(const TransferRows& rows, ByteWriter& writer);
[[nodiscard]] TransferRows TakeTransferRows(ByteReader& reader);

void PutFields(const FieldChanges& fields, ByteWriter& writer);
[[nodiscard]] FieldChanges TakeFields(ByteReader& reader);

/// A diff with all its parts, those that do not travel too.
void PutDiff(const MeshDiff& diff, ByteWriter& writer);
[[nodiscard]] MeshDiff TakeDiff(ByteReader& reader);

/// Bytes with their count.
void PutBytes(std::span<const std::byte> bytes, ByteWriter& writer);
[[nodiscard]] Bytes TakeBytes(ByteReader& reader);

/// A point in time, to the nanosecond.
void PutTime(Clock::WallTime time, ByteWriter& writer);
[[nodiscard]] Clock::WallTime TakeTime(ByteReader& reader);

}  // namespace pliant::server
