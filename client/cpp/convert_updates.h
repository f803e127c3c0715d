#pragma once

#include <span>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/mesh/mesh_diff.h"
#include "core/motion/motion.h"
#include "core/pliant/frozen.h"
#include "core/pliant/options.h"
#include "core/transfer/field_set.h"
#include "pliant/v1/mesh.pb.h"
#include "pliant/v1/metric.pb.h"
#include "pliant/v1/motion.pb.h"
#include "pliant/v1/options.pb.h"
#include "proto/columns.h"

/// Updates other than the metric, to the wire, and the values that diffs carry, from it; as in
/// convert.h. Elements are those of `revision`.
namespace pliant::client {

/// One visitor of a variant, made of a function for each alternative.
template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

[[nodiscard]] v1::BoundaryUpdate ToWire(const MotionRequest& motion, Revision revision,
                                        wire::ColumnWriter& columns);

/// An empty `vertices` means all live ones, ascending.
struct NodePositions {
  Revision revision = Revision::kNone;
  std::span<const VertexId> vertices;
  std::span<const Vec2> positions;
  ImpossibleMotion on_impossible = ImpossibleMotion::kRefuse;
};
[[nodiscard]] v1::NodeUpdate ToWire(const NodePositions& nodes, wire::ColumnWriter& columns);

[[nodiscard]] v1::MetricDisplacement DisplacementToWire(std::span<const VertexId> vertices,
                                                        std::span<const Vec2> by, Revision revision,
                                                        wire::ColumnWriter& columns);

[[nodiscard]] v1::FieldUpdate ToWire(const FieldUpdate& fields, Revision revision,
                                     wire::ColumnWriter& columns);

[[nodiscard]] v1::ConstraintUpdate ToWire(const Constraints& constraints, Revision revision,
                                          wire::ColumnWriter& columns);

/// All options that an update may change, defaults too; `vertices_max` only if it is not the
/// default, which a server may not allow.
[[nodiscard]] v1::SessionOptions AllToWire(const Options& options);

/// Fields of a diff or snapshot. Errors: those of ColumnReader; kArrayLength.
[[nodiscard]] Result<FieldChanges> FieldsFromWire(
    const google::protobuf::RepeatedPtrField<v1::FieldValues>& fields, wire::ColumnReader& columns);
/// Errors: those of ColumnReader; kArrayLength.
[[nodiscard]] Result<TransferRows> FromWire(const v1::TransferRows& rows,
                                            wire::ColumnReader& columns);

}  // namespace pliant::client
