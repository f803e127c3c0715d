#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/base/ids.h"
#include "core/delaunay/triangulate.h"
#include "core/geometry/domain.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// What lies on one side of an edge: the tag of the region there, or nothing where it is outside.
using SideState = std::optional<std::int32_t>;

/// Both sides of an edge, seen along it.
struct EdgeSides {
  SideState left;
  SideState right;

  [[nodiscard]] EdgeSides Reversed() const { return {right, left}; }
};

/// A vertex on a segment of the new domain.
struct ChainVertex {
  VertexId vertex;  ///< None for a point of the domain that no vertex is known for yet.
  double t = 0;     ///< Where it lies on the segment: 0 and 1 at the ends, ascending between.
};

/// A segment of the new domain, and what of the mesh it takes over.
struct NewSegment {
  std::int32_t old = -1;  ///< The segment of the mesh that stays as it is; -1 for a new one.
  bool reversed = false;  ///< The old one runs the other way.
  EdgeSides sides;
  std::vector<ChainVertex> chain;  ///< Of a new one: its ends, and old vertices that lie on it.
};

/// A constrained edge that stays, but on another segment.
struct ReusedEdge {
  std::int32_t segment = 0;  ///< Of the new domain.
  std::size_t place = 0;     ///< It joins chain[place] and chain[place + 1].
  bool reversed = false;     ///< Its vertices stand the other way round.
};

/// How the constraints of a mesh become those of a new domain.
///
/// Points of the domain that have the coordinates of a given vertex, or of a vertex on a segment
/// that goes, are that vertex. Segments between the same vertices stay. Vertices of segments that
/// go and that lie on new ones, up to the rounding of their coordinates, become vertices of those.
struct DomainMatch {
  std::vector<VertexId> vertex_of_point;  ///< None where no vertex is known yet.
  std::vector<NewSegment> segments;       ///< In the order of the domain's.
  std::vector<std::int32_t> new_of_old;   ///< By segment of the mesh: the new one; -1 if it goes.
  std::vector<std::int32_t> gone;         ///< Segments of the mesh that go, given points too.
  std::map<EdgeId, ReusedEdge> reused;
  std::vector<EdgeId> dropped;            ///< Edges of `gone` that no new segment takes over.
  std::vector<VertexId> no_longer_given;  ///< Given vertices that are no points of the new domain.

  /// What the new domain has on the sides of an edge of the mesh, seen along it; nothing for one
  /// that is dropped.
  [[nodiscard]] std::optional<EdgeSides> SidesOf(const Mesh& mesh, EdgeId edge) const;
};

/// @param inside  TriangulateDomain(domain).
/// @par Cost O(d log d) for d segments of both domains, and the edges of those that go.
[[nodiscard]] DomainMatch MatchDomain(const Mesh& mesh, const Domain& domain,
                                      const DomainTriangulation& inside);

}  // namespace pliant
