#pragma once

#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/pliant/remesher.h"

namespace pliant {

/// What became of a mesh when its domain was replaced.
struct DomainReport {
  std::vector<VertexId> vertex_of_point;  ///< The vertex of each point of the new domain.
  std::int64_t kept_segment_count = 0;    ///< Segments that stay as they were.
  std::int64_t removed_vertex_count = 0;  ///< Vertices that the new domain does not contain.
  std::int64_t triangle_count = 0;        ///< Triangles that were made.
};

/// Gives a session's mesh another domain, and wakes what that disturbs; Step and Commit follow as
/// for a metric. The domain is one like at creation; holes may appear, merge and vanish, and parts
/// may come and go.
///
/// Where the new domain contains it, a vertex keeps its slot and its place: points of the new
/// domain with the coordinates of a vertex are that vertex; segments between the same vertices
/// stay, with all their vertices, and take the new tag; a vertex that lies on a new segment becomes
/// one of it; other vertices of segments that go become free. Regions are those of the new domain.
///
/// The metric of new vertices is that of the followed metric there; tensors at vertices go on
/// outside as on the nearest point of the old domain, and so do values of fields (core/transfer).
///
/// Errors, with the session as it was: those of TriangulateDomain; kRevisionNotFound before the
/// first commit; kFrozen if something frozen would change; kCrossingSegments if segments come so
/// close that rounding makes vertices on them cross.
/// @par Cost  O(d log d) for the domain, one pass over the constrained edges, and O(k log k) for k
///            triangles that go or come. Not the size of the mesh.
Result<DomainReport> ReplaceDomain(Remesher& remesher, const Domain& domain);

}  // namespace pliant
