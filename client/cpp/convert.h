#pragma once

#include <google/protobuf/timestamp.pb.h>

#include <chrono>
#include <cstdint>
#include <span>

#include "client/cpp/types.h"
#include "core/base/result.h"
#include "core/mesh/mesh_diff.h"
#include "core/metric/metric_functions.h"
#include "core/metric/metric_spec.h"
#include "core/pliant/quality.h"
#include "pliant/v1/edit.pb.h"
#include "pliant/v1/mesh.pb.h"
#include "pliant/v1/metric.pb.h"
#include "pliant/v1/options.pb.h"
#include "pliant/v1/quality.pb.h"
#include "pliant/v1/session.pb.h"
#include "proto/columns.h"

/// The one place of the client that sees wire and core types. To the wire: nothing is checked, the
/// server does. From the wire: whatever does not fit the protocol is an error, never a crash.
namespace pliant::client {

/// Indices or tags, a column of one number each.
template <class Id>
[[nodiscard]] v1::Array Numbers(std::span<const Id> rows, wire::ColumnWriter& columns) {
  return columns.Write<std::int32_t, 1>(rows);
}

[[nodiscard]] v1::Domain ToWire(const Domain& domain, wire::ColumnWriter& columns);
[[nodiscard]] v1::MeshInput ToWire(const MeshData& mesh, wire::ColumnWriter& columns);

/// All of them: none stays as it was.
[[nodiscard]] v1::MetricLimits ToWire(const MetricLimits& limits);
/// A whole specification: on the server nothing of an earlier one is left.
[[nodiscard]] v1::MetricUpdate ToWire(const MetricSpec& metric, wire::ColumnWriter& columns);

/// Tensors at vertices of one revision; an empty `vertices` means all live ones.
struct VertexTensors {
  Revision revision = Revision::kNone;
  std::span<const VertexId> vertices = {};
  std::span<const Metric> tensors = {};
  const FunctionsSpec* functions = nullptr;  ///< Beside them; null: nothing is said of them.
  bool none = false;                         ///< An empty `vertices` means none.
};
[[nodiscard]] v1::MetricUpdate ToWire(const VertexTensors& update, wire::ColumnWriter& columns);

[[nodiscard]] v1::Smoothing ToWire(Smoothing smoothing);

/// What is not permitted, as the restrictions of `message`.
template <class Message>
void AddRestrictions(const Permissions& may, Message& message) {
  if (!may.insert) message.add_restrictions(v1::RESTRICTION_NO_INSERT);
  if (!may.swap) message.add_restrictions(v1::RESTRICTION_NO_SWAP);
  if (!may.move) message.add_restrictions(v1::RESTRICTION_NO_MOVE);
  if (!may.surface) message.add_restrictions(v1::RESTRICTION_NO_SURFACE);
}

/// Only what differs from the defaults, so that a server with tighter limits is not asked for more
/// than the user did.
[[nodiscard]] v1::SessionOptions ToWire(const Options& options);

[[nodiscard]] v1::Advance ToWire(const AdvanceOptions& options);

[[nodiscard]] std::chrono::system_clock::time_point FromWire(
    const google::protobuf::Timestamp& time);

[[nodiscard]] Result<MeshDiff> FromWire(const v1::MeshDiff& diff, wire::ColumnReader& columns);
/// As a diff from nothing.
[[nodiscard]] Result<MeshDiff> FromWire(const v1::MeshSnapshot& snapshot,
                                        wire::ColumnReader& columns);
[[nodiscard]] Result<Quality> FromWire(const v1::QualityReport& report);
[[nodiscard]] AdvanceReport FromWire(const v1::AdvanceResult& result);
[[nodiscard]] AdvanceProgress FromWire(const v1::Progress& progress);
[[nodiscard]] SessionInfo FromWire(const v1::Session& session);

}  // namespace pliant::client
