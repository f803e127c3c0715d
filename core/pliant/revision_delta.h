#pragma once

#include <cstddef>
#include <span>

#include "core/base/bytes.h"
#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/mesh/mesh_delta.h"
#include "core/pliant/followed_metric.h"
#include "core/pliant/loop.h"
#include "core/transfer/saved_fields.h"

namespace pliant {

/// What takes a session's whole state from one committed revision to another, forwards or back:
/// the raw records of the mesh, the metric it follows, and where the loop stands. After it every
/// later update gives the bits that it would have given there the first time.
///
/// Costs what differs, in time and memory, and the nodes that wait in the loop's queue. A metric
/// that did not change is shared, not copied. Solution fields are kept whole where any of their
/// values changed: a session that has fields pays for all their values at such a commit.
struct RevisionDelta {
  Revision base = Revision::kNone;      ///< Where it leads from.
  Revision revision = Revision::kNone;  ///< Where it leads to.
  MeshDelta mesh;
  FollowedMetric::State metric;       ///< At `revision`.
  FollowedMetric::State base_metric;  ///< At `base`: what `metric` may share with it.
  RawTensors raw;                     ///< At `revision`, where they differ and limits hold.
  PliantLoop::State loop;             ///< At `revision`.
  SharedFields fields;                ///< At `revision`: all values, unless none changed.
  SharedFields base_fields;           ///< At `base`.

  /// In memory, roughly; what it shares with `base` is not counted.
  [[nodiscard]] std::size_t bytes() const;
};

/// Several deltas, each from where the one before it leads to, as one: a rollback over many
/// revisions. @pre !deltas.empty() @par Cost O(n log k) for k deltas of n records in all
[[nodiscard]] RevisionDelta Merge(std::span<const RevisionDelta* const> deltas);

/// The written form: versioned, little-endian, with a checksum; Remesher::ReadDelta reads it.
/// Errors: kUnimplemented if the metric changed to a field of the caller's own.
[[nodiscard]] Result<Bytes> WriteDelta(const RevisionDelta& delta);

/// The parts of a written state that are not the mesh.
///
/// @param base  what the reader will have; parts that are the same are only named.
[[nodiscard]] Status WriteMetricState(const FollowedMetric::State& state,
                                      const FollowedMetric::State& base, ByteWriter& writer);
[[nodiscard]] FollowedMetric::State ReadMetricState(ByteReader& reader,
                                                    const FollowedMetric::State& base);
void WriteRawTensors(const RawTensors& raw, ByteWriter& writer);
[[nodiscard]] RawTensors ReadRawTensors(ByteReader& reader);
void WriteLoopState(const PliantLoop::State& state, ByteWriter& writer);
/// @param vertex_slots  entries of the queue must be below.
[[nodiscard]] PliantLoop::State ReadLoopState(ByteReader& reader, std::int32_t vertex_slots);

/// Reads what WriteDelta wrote, for a state with this metric and these fields.
/// Errors: kDataCorrupt, kDataVersion.
[[nodiscard]] Result<RevisionDelta> ReadDelta(std::span<const std::byte> bytes,
                                              const FollowedMetric::State& base,
                                              const SharedFields& base_fields);

}  // namespace pliant
