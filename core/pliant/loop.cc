#include "core/pliant/loop.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/geometry/predicates.h"
#include "core/pliant/extent.h"
#include "core/pliant/insert.h"
#include "core/pliant/remove.h"
#include "core/pliant/smooth.h"
#include "core/pliant/snap.h"

namespace pliant {
namespace {

/// A cancel shall take effect within milliseconds; a visit takes well under a microsecond.
constexpr std::int64_t kVisitsBetweenPolls = 256;

/// A vertex is asked for so many visits before its own, about the time that memory takes.
constexpr std::size_t kNodesAhead = 6;

/// A neighbour that sleeps is woken when a node has moved this far since it last was, in metric
/// length: waking it for less lets a disturbance of one node run through a whole mesh.
constexpr double kWakingDrift = 0.15;

/// A node that its last update had to cool gets this many visits until its metric changes: it is
/// not at rest, it was stopped, and a fresh age would let it run again.
constexpr int kVisitsOfTired = 2;

/// A node whose metric did not change has come to rest before: it goes on only for steps this much
/// longer than the thresholds, so that rounding off the last bit of a rest does not travel.
constexpr double kCalmOfCold = 5.0 / 3;

/// Factor on the length from which edges are split. With the threshold of a build, what a front
/// leaves behind that was carried on has 8 % more nodes than its metric asks for.
double InsertAbove(PliantLoop::LeftBehind left_behind) {
  switch (left_behind) {
    case PliantLoop::LeftBehind::kByBody:
      return 1.15;
    case PliantLoop::LeftBehind::kByFront:
      return 1.13;
    case PliantLoop::LeftBehind::kNothing:
      break;
  }
  return 1;
}

/// A node with five neighbours is, beside one with seven, where a row of the lattice ends: without
/// it the row ends one node earlier, and nothing else changes. To delete one with six neighbours
/// tears three such pairs open. So where a metric has become a little coarser, rows that end there
/// are shortened long before a node in the middle of one is too close to the others.
constexpr double kEndOfRow = 1.12;
constexpr std::size_t kNeighborsAtEnd = 5;

/// Far from a front many small changes of the metric reach the tolerance, here and there: a node
/// that has changed is not moved by short steps in so many visits, until its neighbours ask for it.
constexpr int kPatientVisits = 2;

}  // namespace

LoopSettings SettingsOf(const Options& options) {
  const bool paper = options.variant == Variant::kPaper;
  LoopSettings settings;
  settings.alpha = options.step > 0 ? options.step : paper ? 0.2 : 0.3;
  settings.speed_threshold = options.speed_threshold > 0 ? options.speed_threshold
                             : paper                     ? 0.02
                                                         : 0.03;
  settings.neighbor_threshold = settings.speed_threshold;
  settings.age_cooling = options.age_cooling;
  settings.age_max = options.age_max;
  return settings;
}

PliantLoop::PliantLoop(MeshEdit& edit, const Options& options)
    : edit_(edit),
      mesh_(edit.mesh()),
      options_(options),
      flipper_(edit),
      mender_(edit, options.permissions),
      probe_(edit.mesh()) {
  mender_.LimitVertices(options.vertices_max);
  state_.rng = Rng(options.seed);
  state_.settings = SettingsOf(options);
}

void PliantLoop::BeginUpdate(const LoopSettings& settings) {
  ++state_.epoch;
  state_.visits_in_update = 0;
  state_.settings = settings;
  state_.mending = Mending::kNotBegun;
  state_.allowance.BeginUpdate(mesh_);
  waking_.clear();
  refined_ = false;
}

StopReason PliantLoop::Run(const MetricField& field, const Budget& budget) {
  std::int64_t visits = 0;
  const bool paper = options_.variant == Variant::kPaper;
  if constexpr (kValidateEvery) audit_.Sync(mesh_);
  while (!state_.queue.empty() || !mender_.done()) {
    if (visits >= budget.visits_max) return StopReason::kVisitBudget;
    if (budget.stop != nullptr && visits % kVisitsBetweenPolls == 0 && budget.stop->asked()) {
      return StopReason::kCancelled;
    }
    if (paper && state_.visits_in_update / options_.visits_per_vertex_max >=
                     std::int64_t{mesh_.vertex_count()}) {
      return StopReason::kVisitLimit;
    }
    if (state_.queue.empty()) {
      MendNext(field);
      ++visits;
      ++state_.counts.visits;
      continue;
    }
    const VertexId node = paper ? state_.queue.PopRandom(state_.rng) : state_.queue.PopFirst();
    if (!paper) PrefetchAhead(field);
    if (!mesh_.IsLive(node) || !mesh_.vertex(node).visit.active) continue;
    if (edit_.territory() != nullptr && !MayVisit(*edit_.territory(), node)) {
      aside_.push_back(node);
      continue;
    }
    if constexpr (kValidateEvery) {
      VisitAudited(field, node);
    } else {
      VisitNode(field, node);
    }
    ++visits;
    ++state_.counts.visits;
    ++state_.visits_in_update;
  }
  return state_.counts.refused_at_limit > 0 ? StopReason::kVertexLimit : StopReason::kConverged;
}

void PliantLoop::PrefetchAhead(const MetricField& field) const {
  if (const VertexId far = state_.queue.Ahead(kNodesAhead); far.valid()) {
    mesh_.Prefetch(far);
    field.PrefetchHint(mesh_.hint(far));
  }
  if (const VertexId near = state_.queue.Ahead(kNodesAhead / 2); near.valid()) {
    const TriangleId triangle = mesh_.vertex(near).triangle;
    if (triangle.valid()) mesh_.Prefetch(triangle);
    field.PrefetchBehindHint(mesh_.hint(near));
  }
  if (const VertexId next = state_.queue.Ahead(0); next.valid() && mesh_.IsLive(next)) {
    const TriangleRecord& record = mesh_.triangle(mesh_.vertex(next).triangle);
    for (const VertexId corner : record.vertices) mesh_.Prefetch(corner);
    // Of a triangle at a border others may be writing the neighbours just now.
    const Territory* const own = edit_.territory();
    const auto is_own = [&](VertexId corner) { return own->Owns(corner); };
    if (own != nullptr && !std::ranges::all_of(record.vertices, is_own)) return;
    for (const TriangleId neighbor : record.neighbors) {
      if (neighbor.valid()) mesh_.Prefetch(neighbor);
    }
  }
}

PliantLoop::Heat PliantLoop::HeatOf(const VisitState& visit) const {
  const LoopSettings& settings = state_.settings;
  const double insert_above = InsertAbove(left_behind_);
  if (options_.variant == Variant::kPaper || visit.age <= settings.age_cooling) {
    return {.delete_below = 1,
            .delete_end_below = left_behind_ == LeftBehind::kByFront ? kEndOfRow : 1,
            .insert_above = insert_above,
            .alpha = settings.alpha};
  }
  const double x = std::clamp(static_cast<double>(visit.age - settings.age_cooling) /
                                  (settings.age_max - settings.age_cooling),
                              0.0, 1.0);
  return {.delete_below = 1 - x,
          .delete_end_below = 1 - x,
          .insert_above = insert_above + 2 * x,
          .alpha = settings.alpha * (1 - 0.8 * x)};
}

VisitState PliantLoop::CurrentVisit(VertexId node) const {
  VisitState visit = mesh_.vertex(node).visit;
  if (visit.epoch == state_.epoch) return visit;
  visit.epoch = state_.epoch;
  visit.age = 0;
  visit.cold = false;
  // A node that an earlier update left waiting goes on as warm as new and with the reach it has.
  if (visit.active) return visit;
  visit.hop = UINT8_MAX;
  visit.cold = true;
  const LoopSettings& settings = state_.settings;
  const int start = visit.tired
                        ? settings.age_max - kVisitsOfTired
                        : settings.age_cooling + (settings.age_max - settings.age_cooling) / 5;
  visit.age = static_cast<std::uint8_t>(std::max(start, 0));
  return visit;
}

void PliantLoop::Enter(VertexId node, int hop) {
  VisitState visit = CurrentVisit(node);
  visit.hop = static_cast<std::uint8_t>(std::min<int>(visit.hop, hop));
  const bool cools = options_.variant != Variant::kPaper;
  if (cools && visit.hop > options_.hops_max) return;
  const bool resting = cools && visit.age >= state_.settings.age_max;
  const bool enters = !visit.active && !resting;
  if (enters) {
    visit.active = true;
    state_.queue.Push(node);
  }
  if (!(visit == mesh_.vertex(node).visit)) edit_.Visit(node) = visit;
}

void PliantLoop::PushRing(const Star& star, int hop) {
  for (const VertexId neighbor : star.ring()) Push(neighbor, hop);
}

void PliantLoop::VisitNode(const MetricField& field, VertexId node) {
  VisitState& visit = edit_.Visit(node);
  if (visit.epoch != state_.epoch) visit = CurrentVisit(node);
  visit.active = false;
  if (options_.variant != Variant::kPaper) {
    // Before anything else: the proof of termination needs new nodes to see the higher age.
    ++visit.age;
    if (visit.age >= state_.settings.age_max) ++state_.counts.cooled;
    if (visit.age >= state_.settings.age_cooling) visit.tired = true;
  }
  // The loop alone would undo what mending did; if that is needed, mending sees to it again.
  if (visit.mended) return;
  const Heat heat = HeatOf(visit);
  if (Stays(node)) {
    if (OwesQuestion(node)) RefreshMetric(field, node);
    VisitGiven(field, node, heat);
    return;
  }
  if (edit_.territory() == nullptr) star_.Gather(mesh_, node);  // Otherwise MayVisit has.
  if (UsesPatch(node)) {
    VisitPatch(field, heat);
    return;
  }
  const double speed = options_.permissions.move ? Move(field, heat.alpha) : 0;
  if (speed == 0 && OwesQuestion(node)) RefreshMetric(field, node);
  if (options_.permissions.swap && Swap()) star_.Gather(mesh_, node);
  FinishVisit(field, heat, speed);
}

void PliantLoop::VisitAudited(const MetricField& field, VertexId node) {
  if (options_.variant == Variant::kPaper) {  // Has no ages.
    VisitNode(field, node);
    return;
  }
  audit_.Begin(mesh_, node, state_.epoch);
  VisitNode(field, node);
  const std::string fault = audit_.End(mesh_);
  PLIANT_CHECK(fault.empty(), "fault", fault);
}

void PliantLoop::FinishVisit(const MetricField& field, const Heat& heat, double speed) {
  if (options_.permissions.insert) {
    if (options_.variant != Variant::kPaper) crowd_.Measure(mesh_, star_);
    const double extent = NodeExtent(mesh_, star_, crowd_);
    if (ChangeNodes(field, extent, LargestSpokeExtent(mesh_, star_), heat)) return;
  }
  StayActive(speed);
}

void PliantLoop::StayActive(double speed) {
  const VertexId node = star_.center();
  const int hop = mesh_.vertex(node).visit.hop;
  const double calm = mesh_.vertex(node).visit.cold ? kCalmOfCold : 1;
  if (speed > calm * state_.settings.speed_threshold) Push(node, hop);
  if (options_.variant == Variant::kPaper) {
    if (speed > state_.settings.speed_threshold) PushRing(star_, hop + 1);
  } else if (speed > 0) {
    NotifyRing(speed);
  }
}

void PliantLoop::NotifyRing(double speed) {
  const VertexId node = star_.center();
  const VertexRecord& record = mesh_.vertex(node);
  const int hop = record.visit.hop;
  const Vec2 drift{record.visit.drift_x, record.visit.drift_y};
  if (SquaredLength(record.metric, drift) > kWakingDrift * kWakingDrift) {
    VisitState& visit = edit_.Visit(node);
    visit.drift_x = visit.drift_y = 0;
    PushRing(star_, hop + 1);
  } else if (speed > (record.visit.cold ? kCalmOfCold : 1) * state_.settings.neighbor_threshold) {
    for (const VertexId neighbor : star_.ring()) {
      if (mesh_.vertex(neighbor).visit.epoch == state_.epoch) Push(neighbor, hop + 1);
    }
  }
}

void PliantLoop::AddDrift(VertexId node, Vec2 step) {
  VisitState& visit = edit_.Visit(node);
  visit.drift_x += static_cast<float>(step.x);
  visit.drift_y += static_cast<float>(step.y);
}

void PliantLoop::VisitPatch(const MetricField& field, const Heat& heat) {
  patch_.Gather(mesh_, star_);
  const double speed = options_.permissions.move ? MovePatch(field, heat.alpha) : 0;
  if (const VertexId node = star_.center(); speed == 0 && OwesQuestion(node)) {
    RefreshMetric(field, node);
    patch_.MoveCenter(mesh_.position(node), mesh_.metric(node));
  }
  patch_.Measure();
  if (options_.permissions.swap && patch_.WantsSwaps(mesh_, star_) && Swap()) {
    star_.Gather(mesh_, star_.center());
    if (!Patch::Fits(star_)) {
      FinishVisit(field, heat, speed);
      return;
    }
    patch_.Gather(mesh_, star_);
    patch_.Measure();
  }
  if (options_.permissions.insert) {
    const Patch::Extents extents = patch_.MeasureExtents();
    if (ChangeNodes(field, extents.node, {extents.largest_spoke, extents.largest}, heat)) return;
  }
  StayActive(speed);
}

double PliantLoop::MovePatch(const MetricField& field, double alpha) {
  const VertexId node = star_.center();
  const Vec2 step = patch_.Step(alpha);
  const Vec2 target = mesh_.position(node) + step;
  if (!IsFinite(step) || !patch_.StaysPositive(target)) return 0;
  const double speed = std::sqrt(SquaredLength(mesh_.metric(node), step));
  if (IsRest(speed)) return 0;
  edit_.MoveVertex(node, target);
  AddDrift(node, step);
  RefreshMetric(field, node);
  patch_.MoveCenter(target, mesh_.metric(node));
  if (speed > 0) ++state_.counts.moves;
  return speed;
}

bool PliantLoop::UsesPatch(VertexId node) const {
  // The paper's variant may put a node on the boundary, and other smoothing functions are for
  // comparison: both take the general way.
  return options_.variant != Variant::kPaper && options_.smoothing == Smoothing::kPliant &&
         !mesh_.vertex(node).edge.valid() && Patch::Fits(star_);
}

void PliantLoop::VisitGiven(const MetricField& field, VertexId node, const Heat& heat) {
  // A given node neither moves nor goes, but its edges are split like any other's. A pinched one
  // has several fans; each is looked at as if it were alone.
  const std::size_t fan_count = FansOf(mesh_, node).size();
  for (std::size_t fan = 0; fan < fan_count; ++fan) {
    star_.Gather(mesh_, node, FansOf(mesh_, node)[fan]);
    if (options_.permissions.swap && Swap()) {
      star_.Gather(mesh_, node, FansOf(mesh_, node)[fan]);
    }
    // One insertion a visit, as the proof of termination wants it; it wakes this node again.
    if (options_.permissions.insert && TryInsert(field, LargestSpokeExtent(mesh_, star_), heat)) {
      return;
    }
  }
}

double PliantLoop::Move(const MetricField& field, double alpha) {
  const VertexId node = star_.center();
  // The paper's nodes are all alike.
  if (options_.variant != Variant::kPaper) crowd_.Measure(mesh_, star_);
  const Vec2 step =
      SmoothingStep(mesh_, node, star_.ring(), options_.smoothing, alpha, crowd_.weights());
  if (!IsFinite(step)) return 0;
  const double speed =
      mesh_.vertex(node).edge.valid() ? MoveOnSegment(field, step) : MoveFree(field, step);
  if (speed > 0) ++state_.counts.moves;
  return speed;
}

double PliantLoop::MoveFree(const MetricField& field, Vec2 step) {
  const VertexId node = star_.center();
  const Vec2 target = mesh_.position(node) + step;
  const double speed = std::sqrt(SquaredLength(mesh_.metric(node), step));
  if (IsRest(speed)) return 0;
  if (StaysPositive(target)) {
    edit_.MoveVertex(node, target);
  } else if (options_.variant != Variant::kPaper || !options_.permissions.surface ||
             !SnapToCrossedEdge(edit_, star_, target)) {
    return 0;
  } else {
    star_.Gather(mesh_, node);
  }
  AddDrift(node, step);
  RefreshMetric(field, node);
  return speed;
}

double PliantLoop::MoveOnSegment(const MetricField& field, Vec2 step) {
  const VertexId node = star_.center();
  const auto [before, after] = mesh_.SegmentEdges(node);
  const EdgeRecord& edge = mesh_.edge(before);
  const SegmentRecord& line = mesh_.segments()[static_cast<std::size_t>(edge.segment)];
  const Vec2 direction = mesh_.position(line.b) - mesh_.position(line.a);
  const Metric& metric = mesh_.metric(node);
  const double squared = SquaredLength(metric, direction);
  const double t = edge.parameters[1] + InnerProduct(metric, step, direction) / squared;
  if (!(edge.parameters[0] < t && t < mesh_.edge(after).parameters[1])) return 0;
  const double speed = std::fabs(t - edge.parameters[1]) * std::sqrt(squared);
  if (IsRest(speed)) return 0;
  if (!StaysPositive(mesh_.PointOnSegment(edge.segment, t))) return 0;
  AddDrift(node, (t - edge.parameters[1]) * direction);
  edit_.SlideVertex(node, t);
  RefreshMetric(field, node);
  return speed;
}

bool PliantLoop::IsRest(double speed) const {
  if (!IsUpdate()) return false;
  const VisitState& visit = mesh_.vertex(star_.center()).visit;
  const bool patient =
      left_behind_ == LeftBehind::kByFront && !visit.cold && visit.age <= kPatientVisits;
  return (patient ? 1 : 2) * speed <= state_.settings.speed_threshold;
}

bool PliantLoop::StaysPositive(Vec2 center) const {
  for (std::size_t k = 0; k < star_.triangles().size(); ++k) {
    if (Orient2d(center, mesh_.position(star_.ring()[k]), mesh_.position(star_.ring_after(k))) <=
        0) {
      return false;
    }
  }
  return true;
}

void PliantLoop::RefreshMetric(const MetricField& field, VertexId node) {
  edit_.SetMetric(node, field.At(mesh_.position(node), edit_.Hint(node)));
}

bool PliantLoop::Swap() {
  const std::int32_t swaps = flipper_.AroundMoved(star_);
  state_.counts.swaps += swaps;
  return swaps > 0;
}

bool PliantLoop::TryDelete(double extent, const Heat& heat) {
  const bool ends_row =
      star_.ring().size() <= kNeighborsAtEnd && !mesh_.vertex(star_.center()).edge.valid();
  return extent < (ends_row ? heat.delete_end_below : heat.delete_below) && Delete();
}

bool PliantLoop::Delete() {
  const int hop = mesh_.vertex(star_.center()).visit.hop;
  const std::optional<std::int32_t> swaps =
      RemoveNode(edit_, flipper_, star_,
                 options_.permissions.swap ? AfterRemoval::kSwapEdges : AfterRemoval::kLeaveEdges);
  if (!swaps) return false;
  state_.counts.swaps += *swaps;
  ++state_.counts.deletions;
  PushRing(star_, hop + 1);
  return true;
}

bool PliantLoop::TryInsert(const MetricField& field, const SpokeExtent& longest, const Heat& heat) {
  if (!(longest.extent > heat.insert_above)) return false;
  SpokeExtent largest = longest;
  if (!MaySplit(mesh_, star_, largest.spoke, options_.permissions)) {
    largest = LargestFreeSpokeExtent(mesh_, star_, options_.permissions);
    if (!(largest.extent > heat.insert_above)) return false;
  }
  return Insert(field, largest.spoke);
}

bool PliantLoop::Insert(const MetricField& field, std::size_t spoke) {
  if (mesh_.vertex_count() >= options_.vertices_max) {
    ++state_.counts.refused_at_limit;
    return false;
  }
  // What a territory may insert is bounded by the slots it was lent.
  const bool bounded = options_.variant == Variant::kPaper || edit_.territory() != nullptr;
  if (!bounded && !state_.allowance.Take(mesh_)) {
    ++state_.counts.refused_by_allowance;
    return false;
  }
  const VertexId node = star_.center();
  const VisitState visit = mesh_.vertex(node).visit;
  const VisitState far = CurrentVisit(star_.ring()[spoke]);
  const std::optional<Insertion> made = InsertOnSpoke(
      edit_, flipper_, field, star_, spoke,
      options_.permissions.swap ? AfterInsertion::kSwapEdges : AfterInsertion::kLeaveEdges);
  if (!made) return false;
  ++state_.counts.insertions;
  state_.counts.swaps += made->swaps;
  VisitState& born = edit_.Visit(made->vertex);
  born.epoch = visit.epoch;
  // A cold end began old, not grew old: its age must not stop a refinement before it is done. The
  // proof of termination needs no more than the age of the node that is being visited.
  born.age = far.cold ? visit.age : std::max(visit.age, far.age);
  born.cold = visit.cold;
  born.hop = visit.hop;
  born.tired = visit.tired && far.tired;
  PLIANT_DCHECK(options_.variant == Variant::kPaper || born.age > visit.age - 1);
  Push(made->vertex, visit.hop);
  star_.Gather(mesh_, made->vertex);
  PushRing(star_, visit.hop + 1);
  star_.Gather(mesh_, node);
  return true;
}

}  // namespace pliant
