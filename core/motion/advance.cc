#include "core/motion/advance.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/check.h"
#include "core/delaunay/cavity.h"
#include "core/delaunay/clash.h"
#include "core/delaunay/overtaken.h"
#include "core/geometry/predicates.h"
#include "core/pliant/remove.h"

namespace pliant {
namespace {

/// A sub-step is not halved further for a triangle whose corners go less than this, in metric
/// length; what blocks it is removed instead.
constexpr double kShortStep = 0.25;

/// A step this short is no longer halved before a cavity is opened.
constexpr double kTinyStep = 1e-3;

/// A triangle lower than this, in metric length, that gets lower still by half or more in one
/// sub-step, counts as spoiled.
constexpr double kLowHeight = 0.2;
constexpr double kHeightLost = 0.5;

/// Triangles below this quality have their edges looked at after a sub-step.
constexpr double kPoorQuality = 0.4;

/// Where at most this share of the corners of spoiled triangles may be removed, a cavity grows
/// until its rim holds: next to nothing is lost but time.
constexpr double kFewFree = 0.25;

/// Cavities around what blocks a tiny step grow by a ring of triangles at a time, and not beyond
/// this.
constexpr int kCavityRingsMax = 12;
constexpr std::size_t kCavityTrianglesMax = 4000;

/// A sub-step of this share of the motion that still fails ends it.
constexpr double kLeastShare = 1e-9;

/// The same where whoever has nowhere to go is what fails.
constexpr double kShyOfMisplaced = 1e-3;

Metric MeanOf(const Mesh& mesh, const TriangleRecord& triangle) {
  return (1.0 / 3.0) * (mesh.metric(triangle.vertices[0]) + mesh.metric(triangle.vertices[1]) +
                        mesh.metric(triangle.vertices[2]));
}

bool IsPoor(const Mesh& mesh, TriangleId id) {
  const TriangleRecord& triangle = mesh.triangle(id);
  const Metric metric = MeanOf(mesh, triangle);
  const Vec2 a = mesh.position(triangle.vertices[0]);
  const Vec2 ab = mesh.position(triangle.vertices[1]) - a;
  const Vec2 ac = mesh.position(triangle.vertices[2]) - a;
  const double lengths =
      SquaredLength(metric, ab) + SquaredLength(metric, ac) + SquaredLength(metric, ac - ab);
  // 4 sqrt(3) area / sum of squared lengths.
  return 3.4641016151377544 * Cross(ab, ac) * std::sqrt(Determinant(metric)) <
         kPoorQuality * lengths;
}

}  // namespace

Advance::Advance(MeshEdit& edit, const MotionPlan& plan, Observer observer)
    : edit_(edit),
      mesh_(edit.mesh()),
      plan_(plan),
      observer_(std::move(observer)),
      stopped_(plan.stop()),
      flipper_(edit) {
  moving_.reserve(plan.movers().size() + plan.riders().size());
  for (const Mover& mover : plan.movers()) moving_.push_back(mover.vertex);
  for (const Rider& rider : plan.riders()) moving_.push_back(rider.vertex);
  place_of_ = PlaceMap(mesh_.vertex_slots());
  place_of_.Reserve(moving_.size());
  for (std::size_t i = 0; i < moving_.size() && !stopped_(); ++i) {
    place_of_.Add(moving_[i], static_cast<std::int32_t>(i));
  }
  before_.resize(moving_.size());
  near_stamp_.assign(moving_.size(), 0);
  poor_stamp_.assign(moving_.size(), 0);
  in_front_.assign(moving_.size(), false);
  report_.moved_count = static_cast<std::int64_t>(moving_.size());
  FindFront();
}

double Advance::RunTo(double limit) {
  double at = 0;
  double step = limit;
  bool low_allowed = false;
  int accepted_in_a_row = 0;
  while (at < limit && !stopped_()) {
    const double target = std::min(limit, at + step);
    PlaceNear(target);
    CheckFront();
    // Vertices that move alike keep their triangles, but for rounding: looked at once, at the end.
    if (target == limit && !flips()) {
      PlaceRest(target);
      CheckRest();
    }
    if (stopped_()) break;
    const bool turned_over = flips();
    if (!turned_over && (spoiled_.empty() || low_allowed)) {
      Accept(target);
      at = target;
      // Not at every turn: half of all tries would be too long.
      if (++accepted_in_a_row >= 3) step *= 2;
      low_allowed = false;
      continue;
    }
    accepted_in_a_row = 0;
    double longest = 0;
    for (const Spoiled& s : spoiled_) longest = std::max(longest, s.step);
    if (longest > kShortStep && Leap(target)) {
      at = target;
      continue;
    }
    ++report_.rejected_count;
    TakeBack();
    if (misplaced_ && plan_.request().on_impossible == ImpossibleMotion::kRefuse) break;
    if (misplaced_ && target - at < kShyOfMisplaced * limit && MisplacedBlocks()) {
      NoteBlockers();
      break;
    }
    if (longest > kShortStep) {
      step = 0.5 * (target - at);
      continue;
    }
    if (MakeRoom(target)) continue;
    if (!turned_over) {
      low_allowed = true;  // Nothing can be done about low triangles that still are positive.
      continue;
    }
    if (longest > kTinyStep) {
      step = 0.5 * (target - at);
      continue;
    }
    // A longer step than the tiny one that failed: a cavity is opened once, not at every turn.
    bool filled = false;
    for (double share = 64; !filled && share >= 1; share *= 0.25) {
      const double far = std::min(limit, at + share * (target - at));
      filled = Retriangulate(far);
      if (filled) at = far;
    }
    if (filled) continue;
    step = 0.5 * (target - at);
    if (step < kLeastShare * limit) {
      NoteBlockers();
      break;
    }
  }
  return at;
}

bool Advance::IsFree(VertexId vertex) const {
  if (mesh_.vertex(vertex).fixed || mesh_.vertex(vertex).frozen) return false;
  const std::int32_t known = place_of_.At(vertex);
  if (known == PlaceMap::kNone) return true;
  const auto place = static_cast<std::size_t>(known);
  const std::size_t mover_count = plan_.movers().size();
  return place < mover_count ? !plan_.movers()[place].given
                             : !plan_.riders()[place - mover_count].given;
}

bool Advance::flips() const {
  return std::any_of(spoiled_.begin(), spoiled_.end(),
                     [](const Spoiled& spoiled) { return spoiled.flipped; });
}

void Advance::CheckFront() {
  spoiled_.clear();
  poor_.clear();
  ForEachTriangleOfFront([&](TriangleId id) {
    CheckTriangle(id);
    if (!IsPoor(mesh_, id)) return;
    for (const VertexId corner : mesh_.triangle(id).vertices) {
      if (IsInFront(corner)) poor_stamp_[static_cast<std::size_t>(place_of_.At(corner))] = stamp_;
    }
  });
  for (const VertexId vertex : front_) {
    if (poor_stamp_[static_cast<std::size_t>(place_of_.At(vertex))] == stamp_ &&
        mesh_.IsLive(vertex)) {
      poor_.push_back(vertex);
    }
  }
  SortSpoiled();
}

void Advance::CheckRest() {
  for (std::size_t place = 0; place < moving_.size() && !stopped_(); ++place) {
    if (in_front_[place] || !mesh_.IsLive(moving_[place])) continue;
    ForEachTriangleAt(moving_[place], [&](TriangleId id) {
      const auto& v = mesh_.triangle(id).vertices;
      if (Orient2d(mesh_.position(v[0]), mesh_.position(v[1]), mesh_.position(v[2])) <= 0) {
        spoiled_.push_back({id, 0, true});
      }
    });
  }
  SortSpoiled();
}

void Advance::SortSpoiled() {
  const auto before = [](const Spoiled& a, const Spoiled& b) { return a.triangle < b.triangle; };
  const auto same = [](const Spoiled& a, const Spoiled& b) { return a.triangle == b.triangle; };
  std::sort(spoiled_.begin(), spoiled_.end(), before);
  spoiled_.erase(std::unique(spoiled_.begin(), spoiled_.end(), same), spoiled_.end());
}

void Advance::CheckTriangle(TriangleId id) {
  const TriangleRecord& triangle = mesh_.triangle(id);
  const auto& v = triangle.vertices;
  const bool flipped =
      Orient2d(mesh_.position(v[0]), mesh_.position(v[1]), mesh_.position(v[2])) <= 0;
  if (!flipped) {
    const double height = Height(triangle, When::kNow);
    if (height >= kLowHeight || height >= kHeightLost * Height(triangle, When::kBefore)) return;
  }
  double longest = 0;
  for (const VertexId vertex : v) {
    longest = std::max(longest, SquaredLength(mesh_.metric(vertex),
                                              mesh_.position(vertex) - PositionBefore(vertex)));
  }
  spoiled_.push_back({id, std::sqrt(longest), flipped});
}

double Advance::Height(const TriangleRecord& triangle, When when) const {
  const auto at = [&](std::size_t k) {
    const VertexId vertex = triangle.vertices[k];
    return when == When::kBefore ? PositionBefore(vertex) : mesh_.position(vertex);
  };
  const Metric metric = MeanOf(mesh_, triangle);
  const Vec2 a = at(0);
  const Vec2 ab = at(1) - a;
  const Vec2 ac = at(2) - a;
  const double longest = std::max(
      {SquaredLength(metric, ab), SquaredLength(metric, ac), SquaredLength(metric, ac - ab)});
  return Cross(ab, ac) * std::sqrt(Determinant(metric) / longest);
}

Vec2 Advance::PositionBefore(VertexId vertex) const {
  const std::int32_t place = place_of_.At(vertex);
  const bool moved = place != PlaceMap::kNone && IsNear(static_cast<std::size_t>(place));
  return moved ? before_[static_cast<std::size_t>(place)] : mesh_.position(vertex);
}

bool Advance::MakeRoom(double s) {
  bool changed = false;
  const std::vector<Spoiled> spoiled = spoiled_;
  for (const Spoiled& one : spoiled) {
    if (stopped_()) return false;
    // A removal before may have done away with this one.
    if (!mesh_.triangle(one.triangle).live) continue;
    changed = RemoveOne(one.triangle) || changed;
  }
  if (changed) return true;
  for (const Spoiled& one : spoiled) {
    if (one.flipped && SwapOne(one.triangle, s)) return true;
  }
  return false;
}

bool Advance::RemoveOne(TriangleId id) {
  // Interior vertices before those inside segments, vertices that stand still before followers;
  // among these the one nearest to another corner.
  const TriangleRecord& triangle = mesh_.triangle(id);
  const Metric metric = MeanOf(mesh_, triangle);
  std::optional<std::pair<int, double>> best;
  VertexId chosen;
  for (std::size_t k = 0; k < 3; ++k) {
    const VertexId vertex = triangle.vertices[k];
    if (!IsFree(vertex)) continue;
    const int rank = (mesh_.vertex(vertex).edge.valid() ? 2 : 0) +
                     (place_of_.At(vertex) != PlaceMap::kNone ? 1 : 0);
    const Vec2 p = mesh_.position(vertex);
    const double nearest =
        std::min(SquaredLength(metric, mesh_.position(triangle.vertices[(k + 1) % 3]) - p),
                 SquaredLength(metric, mesh_.position(triangle.vertices[(k + 2) % 3]) - p));
    const std::pair<int, double> key{rank, nearest};
    if (!best || key < *best) {
      best = key;
      chosen = vertex;
    }
  }
  return chosen.valid() && Remove(chosen);
}

bool Advance::Remove(VertexId vertex) {
  star_.Gather(mesh_, vertex);
  const std::vector<VertexId> ring(star_.ring().begin(), star_.ring().end());
  const std::optional<std::int32_t> swaps = RemoveNode(edit_, flipper_, star_);
  if (!swaps) return false;
  ++report_.removed_count;
  report_.swap_count += *swaps;
  torn_.insert(torn_.end(), ring.begin(), ring.end());
  for (const VertexId neighbor : ring) JoinFront(neighbor);
  return true;
}

bool Advance::StaysPositive(VertexId a, VertexId b, VertexId c, double s) const {
  return Orient2d(mesh_.position(a), mesh_.position(b), mesh_.position(c)) > 0 &&
         Orient2d(PositionAt(a, s), PositionAt(b, s), PositionAt(c, s)) > 0;
}

bool Advance::SwapOne(TriangleId id, double s) {
  for (int corner = 0; corner < 3; ++corner) {
    const TriangleRecord& t = mesh_.triangle(id);
    const TriangleId other = t.neighbors[static_cast<std::size_t>(corner)];
    if (t.IsConstrained(corner) || !other.valid() || t.frozen) continue;
    const VertexId p = t.vertices[static_cast<std::size_t>(corner)];
    const VertexId a = t.vertices[static_cast<std::size_t>(NextCorner(corner))];
    const VertexId b = t.vertices[static_cast<std::size_t>(PreviousCorner(corner))];
    const VertexId q =
        mesh_.triangle(other).vertices[static_cast<std::size_t>(mesh_.SideTowards(other, id))];
    if (!StaysPositive(p, a, q, s) || !StaysPositive(p, q, b, s)) continue;
    edit_.SwapEdge({id, corner});
    ++report_.swap_count;
    for (const VertexId vertex : {p, a, b, q}) {
      JoinFront(vertex);
      torn_.push_back(vertex);
    }
    return true;
  }
  return false;
}

void Advance::Accept(double s) {
  ++report_.sub_step_count;
  time_ = s;
  PlaceRest(s);
  SwapPoor();
  if (observer_) observer_(s);
}

void Advance::SwapPoor() {
  for (const VertexId vertex : poor_) {
    if (stopped_()) return;
    if (!mesh_.IsLive(vertex)) continue;
    for (const TriangleId fan : FansOf(mesh_, vertex)) {
      star_.Gather(mesh_, vertex, fan);
      const std::int32_t swaps = flipper_.AroundMoved(star_);
      if (swaps == 0) continue;
      report_.swap_count += swaps;
      star_.Gather(mesh_, vertex);
      for (const VertexId neighbor : star_.ring()) {
        JoinFront(neighbor);
        torn_.push_back(neighbor);
      }
      if (mesh_.vertex(vertex).pinched) break;  // The other fans come with the next sub-step.
    }
  }
}

bool Advance::MostAreGiven() const {
  std::size_t free_count = 0;
  for (const Spoiled& one : spoiled_) {
    for (const VertexId vertex : mesh_.triangle(one.triangle).vertices) {
      free_count += IsFree(vertex) ? 1 : 0;
    }
  }
  return static_cast<double>(free_count) <= kFewFree * 3 * static_cast<double>(spoiled_.size());
}

bool Advance::Leap(double s) {
  PlaceRest(s);
  CheckRest();
  if (stopped_()) return false;
  std::vector<TriangleId> cavity;
  for (const Spoiled& one : spoiled_) cavity.push_back(one.triangle);
  const bool most_are_given = MostAreGiven();
  if (!most_are_given) {
    const SuddenMove move{.before = [&](VertexId vertex) { return PositionBefore(vertex); },
                          .is_free = [&](VertexId vertex) { return IsFree(vertex); }};
    const std::vector<TriangleId> spoiled = cavity;
    for (const Overtaking rule : {Overtaking::kStillGo, Overtaking::kAllGo}) {
      cavity = OvertakenCavity(mesh_, spoiled, move, rule, plan_.stop());
      if (stopped_()) return false;
      if (Fill(cavity, s)) return true;
    }
  }
  const bool arrives = s == 1 && plan_.names_inside();
  if (!arrives && !most_are_given) return false;
  AddStarsOfGiven(cavity);
  cavity = WithClashes(
      mesh_, std::move(cavity), [&](VertexId v) { return !IsFree(v); }, plan_.stop());
  if (stopped_()) return false;
  if (Fill(cavity, s)) return true;
  if (arrives && IsOfNamed(fill_error_)) misplaced_ = fill_error_;
  return false;
}

void Advance::AddStarsOfGiven(std::vector<TriangleId>& cavity) {
  const std::size_t count = cavity.size();
  for (std::size_t i = 0; i < count && !stopped_(); ++i) {
    for (const VertexId vertex : mesh_.triangle(cavity[i]).vertices) {
      if (mesh_.vertex(vertex).edge.valid() || IsFree(vertex)) continue;
      ForEachTriangleAt(vertex, [&](TriangleId id) { cavity.push_back(id); });
    }
  }
}

bool Advance::MisplacedBlocks() const {
  return std::ranges::any_of(spoiled_, [&](const Spoiled& spoiled) {
    return std::ranges::any_of(mesh_.triangle(spoiled.triangle).vertices, [&](VertexId vertex) {
      return vertex.value() == misplaced_->index || vertex.value() == misplaced_->other_index;
    });
  });
}

bool Advance::IsOfNamed(const Error& error) const {
  const auto named = [&](std::int64_t index) {
    const VertexId vertex(static_cast<std::int32_t>(index));
    return vertex.valid() && !mesh_.vertex(vertex).edge.valid() &&
           place_of_.At(vertex) != PlaceMap::kNone && !IsFree(vertex);
  };
  return named(error.index) || named(error.other_index);
}

bool Advance::Retriangulate(double s) {
  PlaceNear(s);
  CheckFront();
  PlaceRest(s);
  CheckRest();
  if (stopped_()) return false;
  std::vector<TriangleId> cavity;
  for (const Spoiled& one : spoiled_) {
    if (one.flipped) cavity.push_back(one.triangle);
  }
  if (cavity.empty()) {
    Accept(s);
    return true;
  }
  for (int rings = 0; rings < kCavityRingsMax; ++rings) {
    cavity = WithRing(mesh_, std::move(cavity));
    if (cavity.size() > kCavityTrianglesMax) break;
    if (Fill(cavity, s)) return true;
  }
  TakeBack();
  return false;
}

bool Advance::Fill(const std::vector<TriangleId>& cavity, double s) {
  const bool is_frozen = std::any_of(cavity.begin(), cavity.end(),
                                     [&](TriangleId id) { return mesh_.triangle(id).frozen; });
  if (is_frozen) {
    fill_error_ = {ErrorCode::kFrozen, "a frozen triangle is in the way"};
    return false;
  }
  const auto filled = RetriangulateCavity(
      edit_, cavity, [&](VertexId vertex) { return !IsFree(vertex); }, {}, plan_.stop());
  if (!filled.ok()) {
    fill_error_ = filled.error();
    return false;
  }
  ++report_.retriangulate_count;
  report_.removed_count += static_cast<std::int64_t>(filled->removed.size());
  for (const VertexId vertex : filled->corners) {
    JoinFront(vertex);
    torn_.push_back(vertex);
  }
  poor_.clear();
  Accept(s);
  return true;
}

void Advance::NoteBlockers() {
  std::vector<EdgeId> edges;
  for (const Spoiled& one : spoiled_) {
    for (const VertexId vertex : mesh_.triangle(one.triangle).vertices) {
      if (mesh_.vertex(vertex).edge.valid()) edges.push_back(mesh_.vertex(vertex).edge);
    }
  }
  for (const EdgeId edge : edges) {
    if (!blockers_.first.valid()) {
      blockers_.first = edge;
    } else if (mesh_.edge(edge).segment != mesh_.edge(blockers_.first).segment) {
      blockers_.second = edge;
      return;
    }
  }
}

}  // namespace pliant
