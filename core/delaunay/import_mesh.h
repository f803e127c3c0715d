#pragma once

#include <vector>

#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/geometry/mesh_data.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_edit.h"

namespace pliant {

/// What MeshEdit::Build needs, and which vertices to fix.
struct MeshPlan {
  std::vector<Vec2> positions;
  std::vector<NewTriangle> triangles;
  std::vector<NewEdge> edges;
  std::vector<SegmentRecord> segments;
  std::vector<VertexId> fixed;
};

/// The plan of a domain's constrained Delaunay triangulation: one edge per segment, every point
/// fixed; points on no segment have a segment record without a line, after the others. Errors:
/// those of TriangulateDomain.
[[nodiscard]] Result<MeshPlan> PlanDomain(const Domain& domain);

/// Checks an existing triangulation and recovers its geometry: maximal straight runs of constrained
/// edges with one tag become segments, whose inner vertices may slide; all other vertices on
/// constrained edges are fixed. Edges on the boundary and between regions that are not given are
/// constrained with tag 0, so that regions keep their shape.
///
/// All triangles may be clockwise; then they are turned. Errors, each with the first bad index:
/// kEmpty, kArrayLength, kIndexOutOfRange, kNotFinite ("mesh.points"); kTriangleDegenerate,
/// kTriangleOrientation, kNonManifoldEdge, kNotConforming ("mesh.triangles"); kPointOutsideDomain
/// for a point that no triangle uses; kEdgeNotInMesh, kDuplicateSegment ("mesh.edges").
[[nodiscard]] Result<MeshPlan> PlanImport(const MeshData& mesh);

/// Builds a mesh from its plan.
void BuildFromPlan(const MeshPlan& plan, MeshEdit& edit);

}  // namespace pliant
