#include "core/delaunay/triangulate.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/delaunay/check_domain.h"
#include "core/delaunay/constrain.h"
#include "core/delaunay/delaunay.h"
#include "core/delaunay/flood.h"

namespace pliant {
namespace {

/// Inserts all segments, in their order. @return the first that is blocked
std::optional<std::int32_t> InsertSegments(const Domain& domain, HullTriangulation& hull,
                                           StopPoll& stopped) {
  std::vector<std::int32_t> end_count(domain.points.size(), 0);
  for (const Segment& s : domain.segments) {
    ++end_count[static_cast<std::size_t>(s.a)];
    ++end_count[static_cast<std::size_t>(s.b)];
  }
  Constrainer constrainer(domain.points, hull);
  for (std::size_t i = 0; i < domain.segments.size() && !stopped(); ++i) {
    std::int32_t from = domain.segments[i].a;
    std::int32_t to = domain.segments[i].b;
    // The search turns around `from`: the hub of a star of many segments is the worse choice.
    if (end_count[static_cast<std::size_t>(from)] > end_count[static_cast<std::size_t>(to)]) {
      std::swap(from, to);
    }
    const auto segment = static_cast<std::int32_t>(i);
    const Constrainer::Edge edge = {.segment = segment, .from = from, .to = to};
    if (constrainer.Insert(edge) == Constrainer::Outcome::kBlocked) return segment;
  }
  return std::nullopt;
}

}  // namespace

Result<DomainTriangulation> TriangulateDomain(const Domain& domain, const StopSignal* stop) {
  StopPoll stopped(stop);
  const Status arrays = CheckArrays(domain, stop);
  if (stop != nullptr && stop->asked()) return Stopped();
  if (!arrays.ok()) return arrays.error();
  HullTriangulation hull = DelaunayTriangulation(domain.points, stop);
  if (stop != nullptr && stop->asked()) return Stopped();
  if (hull.triangles.empty()) {
    PLIANT_RETURN_IF_ERROR(CheckSegments(domain));
    return NothingInsideError(domain);
  }
  if (const auto blocked = InsertSegments(domain, hull, stopped)) {
    const Status status = CheckSegment(domain, *blocked);
    PLIANT_CHECK(!status.ok(), "points", domain.points.size(), "segment", *blocked);
    return status.error();
  }
  if (stop != nullptr && stop->asked()) return Stopped();
  return KeepInside(domain, std::move(hull), stop);
}

}  // namespace pliant
