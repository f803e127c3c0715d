#include "core/delaunay/triangulate.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/delaunay/check_domain.h"
#include "core/delaunay/constrain.h"
#include "core/delaunay/delaunay.h"
#include "core/delaunay/flood.h"

namespace pliant {
namespace {

/// Inserts all segments; false if one is blocked.
bool InsertSegments(const Domain& domain, HullTriangulation& hull) {
  std::vector<std::int32_t> end_count(domain.points.size(), 0);
  for (const Segment& s : domain.segments) {
    ++end_count[static_cast<std::size_t>(s.a)];
    ++end_count[static_cast<std::size_t>(s.b)];
  }
  Constrainer constrainer(domain.points, hull);
  for (std::size_t i = 0; i < domain.segments.size(); ++i) {
    std::int32_t from = domain.segments[i].a;
    std::int32_t to = domain.segments[i].b;
    // The search turns around `from`: the hub of a star of many segments is the worse choice.
    if (end_count[static_cast<std::size_t>(from)] > end_count[static_cast<std::size_t>(to)]) {
      std::swap(from, to);
    }
    const Constrainer::Edge edge = {
        .segment = static_cast<std::int32_t>(i), .from = from, .to = to};
    if (constrainer.Insert(edge) == Constrainer::Outcome::kBlocked) return false;
  }
  return true;
}

}  // namespace

Result<DomainTriangulation> TriangulateDomain(const Domain& domain) {
  PLIANT_RETURN_IF_ERROR(CheckArrays(domain));
  HullTriangulation hull = DelaunayTriangulation(domain.points);
  if (hull.triangles.empty()) {
    PLIANT_RETURN_IF_ERROR(CheckSegments(domain));
    return NothingInsideError(domain);
  }
  if (!InsertSegments(domain, hull)) {
    const Status status = CheckSegments(domain);
    PLIANT_CHECK(!status.ok(), "points", domain.points.size());
    return status.error();
  }
  return KeepInside(domain, std::move(hull));
}

}  // namespace pliant
