// PliantLoop, the part that chooses who comes and goes where a metric changes by little, again and
// again.

#include <cmath>
#include <cstddef>

#include "core/pliant/density.h"
#include "core/pliant/extent.h"
#include "core/pliant/loop.h"

namespace pliant {
namespace {

/// Where a row of the lattice ends it grows or shrinks by a node when so many are missing, or too
/// many, among the 12 around: no new defect is made. It does so in a node's first visits, each of
/// which has evened out a little of what the one before did.
constexpr double kRowLack = 0.4;
constexpr int kRowVisits = 8;

/// In the middle of the lattice an insertion or a deletion makes defects, at which rows end: they
/// need more of a reason, and only nodes that have not moved yet show where nodes are missing.
constexpr double kLatticeLack = 1.2;
constexpr int kLatticeVisits = 1;
constexpr std::size_t kLatticeNeighbors = 6;

/// Where its triangles are as large as they should be, up to this share, nothing is missing around
/// a node, most likely. 2.3 / sqrt(24) times six equilateral unit triangles is the extent then.
constexpr double kShareOfStar = 0.05;
constexpr double kIdealExtent = 1.2197466;

/// An edge is split above this extent, less by kExtentPerLack for each node that is missing: what a
/// deletion leaves behind is mostly closed by moving.
constexpr double kInsertAbove = 1.13;
constexpr double kExtentPerLack = 0.2;

/// Beyond this it is no slow change, and extents say it all.
constexpr double kLackMax = 3;

/// On a segment, extents by which a node is deleted and an edge split whatever is beside them.
constexpr double kCrushedExtent = 0.25;
constexpr double kTornExtent = 2;

}  // namespace

void PliantLoop::Drift(VertexId node) {
  if (!IsUpdate()) return;
  if (node.index() >= drifting_.size()) {
    drifting_.resize(static_cast<std::size_t>(mesh_.vertex_slots()));
  }
  drifting_[node.index()] = true;
}

bool PliantLoop::Drifts(VertexId node) const {
  if (left_behind_ != LeftBehind::kNothing) return false;
  if (node.index() >= drifting_.size() || !drifting_[node.index()]) return false;
  const VisitState& visit = mesh_.vertex(node).visit;
  return !visit.cold && visit.age <= state_.settings.age_cooling;
}

bool PliantLoop::ChangeNodes(const MetricField& field, double extent, const SpokeExtent& longest,
                             const Heat& heat) {
  if (Drifts(star_.center())) return EvenOut(field, extent, longest, heat);
  if (TryDelete(extent, heat)) return true;
  (void)TryInsert(field, longest, heat);
  return false;
}

bool PliantLoop::EvenOut(const MetricField& field, double extent, const SpokeExtent& longest,
                         const Heat& heat) {
  const VertexId node = star_.center();
  if (mesh_.vertex(node).edge.valid()) return EvenOutOnSegment(field, extent, longest, heat);
  if (TryDelete(extent, heat)) return true;
  const std::size_t neighbor_count = star_.ring().size();
  const int age = mesh_.vertex(node).visit.age;
  const bool ends_row = neighbor_count != kLatticeNeighbors;
  const bool may_even_out = ends_row ? age <= kRowVisits
                                     : age <= kLatticeVisits && std::fabs(extent - kIdealExtent) >=
                                                                    kShareOfStar * kIdealExtent;
  const bool is_long = longest.extent > heat.insert_above;
  if (!is_long && !may_even_out) return false;
  const double lack = probe_.LackAround(star_);
  if (is_long &&
      (std::fabs(lack) > kLackMax || longest.extent > kInsertAbove - kExtentPerLack * lack)) {
    (void)TryInsert(field, longest, heat);
    return false;
  }
  if (!may_even_out || std::fabs(lack) > kLackMax) return false;
  if (lack > (neighbor_count > kLatticeNeighbors ? kRowLack : kLatticeLack)) {
    InsertIfFree(field, longest.spoke);
    return false;
  }
  return -lack > (neighbor_count < kLatticeNeighbors ? kRowLack : kLatticeLack) && Delete();
}

bool PliantLoop::EvenOutOnSegment(const MetricField& field, double extent,
                                  const SpokeExtent& longest, const Heat& heat) {
  const VertexId node = star_.center();
  const DensityProbe::Stretch stretch = probe_.StretchAround(node);
  if (stretch.is_crowded() || extent < kCrushedExtent) return Delete();
  const VertexId far = star_.ring()[longest.spoke];
  if (!mesh_.FindEdge(node, far).valid() || longest.extent > kTornExtent) {
    (void)TryInsert(field, longest, heat);
    return false;
  }
  if (!stretch.lacks()) return false;
  InsertIfFree(field, longest.spoke);
  return false;
}

void PliantLoop::InsertIfFree(const MetricField& field, std::size_t spoke) {
  if (MaySplit(mesh_, star_, spoke, options_.permissions)) (void)Insert(field, spoke);
}

}  // namespace pliant
