#pragma once

#include <cstddef>
#include <span>

#include "core/base/bytes.h"
#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/geometry/bounding_box.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_delta.h"
#include "core/mesh/mesh_diff.h"
#include "core/pliant/followed_metric.h"
#include "core/pliant/loop.h"
#include "core/transfer/saved_fields.h"

namespace pliant {

/// A committed session, whole: what Remesher::Load starts from.
struct SavedSession {
  BoundingBox box;  ///< Of the points that the session began with.
  Revision revision = Revision::kNone;
  MeshSummary summary;
  MeshState mesh;
  FollowedMetric::State metric;
  RawTensors raw;  ///< Of all vertices, where limits hold.
  PliantLoop::State loop;
  SharedFields fields;
};

/// The same by reference, to be written.
struct SnapshotParts {
  BoundingBox box;
  Revision revision = Revision::kNone;
  const MeshSummary& summary;
  const Mesh& mesh;
  const FollowedMetric::State& metric;
  const RawTensors& raw;
  const PliantLoop::State& loop;
  SharedFields fields;
};

/// Errors: kUnimplemented for a metric that has no written form.
[[nodiscard]] Result<Bytes> WriteSnapshot(const SnapshotParts& parts);

/// Errors: kDataCorrupt, kDataVersion.
[[nodiscard]] Result<SavedSession> ReadSnapshot(std::span<const std::byte> bytes);

}  // namespace pliant
