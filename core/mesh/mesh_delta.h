#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_diff.h"

namespace pliant {

/// Records of one kind of element that stand in some slots.
template <class IdType, class Record>
struct RecordsAt {
  std::int32_t slots = 0;      ///< Slots in the array at the end.
  std::vector<IdType> ids;     ///< Ascending. Those from `slots` on are dead.
  MeshVector<Record> records;  ///< One per id.
};

/// The same for segments, which are small: without marks of who is dead.
struct SegmentsAt {
  std::int32_t slots = 0;
  std::vector<std::int32_t> indices;  ///< Ascending; all of those that come anew are named.
  std::vector<SegmentRecord> records;
};

/// What takes a mesh from one committed state to another: the raw records of everything that
/// differs, the loop's memory of its nodes included. Unlike a MeshDiff, which tells a client what
/// it can see, it restores every bit that can decide anything later.
///
/// Which slots are free follows from which live, so that the allocators need no word here.
struct MeshDelta {
  RecordsAt<VertexId, VertexRecord> vertices;
  RecordsAt<TriangleId, TriangleRecord> triangles;
  RecordsAt<EdgeId, EdgeRecord> edges;
  SegmentsAt segments;
  MeshSummary base;     ///< Of the mesh that it leads from.
  MeshSummary summary;  ///< Of the mesh that it leads to.

  /// In memory.
  [[nodiscard]] std::size_t bytes() const;
};

/// Two deltas, one after the other, as one. @par Cost O(first + second)
[[nodiscard]] MeshDelta Merge(const MeshDelta& first, const MeshDelta& second);

/// Everything of a committed mesh: records by slot, dead ones included, and segments.
struct MeshState {
  MeshVector<VertexRecord> vertices;
  MeshVector<TriangleRecord> triangles;
  std::vector<EdgeRecord> edges;
  std::vector<SegmentRecord> segments;
};

/// Columns of numbers, one for each part of a record.
void WriteMeshDelta(const MeshDelta& delta, ByteWriter& writer);
void WriteMesh(const Mesh& mesh, ByteWriter& writer);
void WriteSummary(const MeshSummary& summary, ByteWriter& writer);

/// Where the bytes cannot be a delta or a mesh, the reader fails.
///
/// What is read is safe to look at: every id is none or a slot. That it is a valid mesh, Validate
/// says.
[[nodiscard]] MeshDelta ReadMeshDelta(ByteReader& reader);
[[nodiscard]] MeshState ReadMesh(ByteReader& reader);
[[nodiscard]] MeshSummary ReadSummary(ByteReader& reader);

}  // namespace pliant
