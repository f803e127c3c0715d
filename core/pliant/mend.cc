#include "core/pliant/mend.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/sort_unique.h"
#include "core/geometry/predicates.h"
#include "core/pliant/merit.h"
#include "core/pliant/trouble.h"

namespace pliant {
namespace {

/// A triangle with a node whose metric has changed is bad below this merit, others below 1.
constexpr double kWarmMerit = 1.03;

/// What FindTroubles takes for bad is below this merit.
constexpr double kPoorMerit =
    1e-9 + std::max({kTroubleQuality / kQualityWanted,
                     (kTroubleLengthMin * kTroubleLengthMin) / kSquaredShortest,
                     kSquaredLongest / (kTroubleLengthMax * kTroubleLengthMax)});

/// Steps of the compass search in metric length, tried one after the other, and how often each.
constexpr std::array kSteps = {0.2, 0.1, 0.05, 0.025};
constexpr int kRoundsPerStep = 4;
/// A step of the search is taken if it leaves less than this share.
constexpr double kSearchShare = 0.98;

constexpr double kDiagonal = 0.7071;
constexpr std::array<Vec2, 8> kCompass = {{{1, 0},
                                           {kDiagonal, kDiagonal},
                                           {0, 1},
                                           {-kDiagonal, kDiagonal},
                                           {-1, 0},
                                           {-kDiagonal, -kDiagonal},
                                           {0, -1},
                                           {kDiagonal, -kDiagonal}}};

}  // namespace

bool Mender::Start(std::uint32_t warm_since, std::uint32_t reached_since, Executor& executor) {
  const std::uint32_t warm_before = std::exchange(state_.warm_since, warm_since);
  if (!permissions_.move) return true;
  const Parts parts = edit_.committed() == Revision::kNone
                          ? FindBad(reached_since, executor)
                          : FindBadAmongChanged(reached_since, executor);
  if (executor.stopped()) {
    state_.warm_since = warm_before;
    return false;
  }
  std::vector<VertexId> nodes(state_.waiting.begin() + static_cast<std::ptrdiff_t>(state_.next),
                              state_.waiting.end());
  for (const Part& part : parts) {
    nodes.insert(nodes.end(), part.nodes.begin(), part.nodes.end());
    state_.poor.insert(state_.poor.end(), part.poor.begin(), part.poor.end());
  }
  SortUnique(nodes);
  SortUnique(state_.poor);  // However many updates end before their mending does.
  state_.waiting = std::move(nodes);
  state_.next = 0;
  return true;
}

Mender::Parts Mender::FindBad(std::uint32_t reached_since, Executor& executor) const {
  const Chunks chunks(mesh_.triangle_slots());
  Parts parts(static_cast<std::size_t>(chunks.count()));
  executor.Run(chunks.count(), [&](std::int32_t chunk) {
    Part& part = parts[static_cast<std::size_t>(chunk)];
    for (std::int64_t t = chunks.begin(chunk); t < chunks.end(chunk); ++t) {
      const TriangleId id(static_cast<std::int32_t>(t));
      if (!mesh_.triangle(id).live) continue;
      const bool is_reached = std::ranges::any_of(
          mesh_.triangle(id).vertices, [&](VertexId v) { return IsReached(v, reached_since); });
      if (is_reached) AddCornersIfBad(id, part);
    }
  });
  return parts;
}

Mender::Parts Mender::FindBadAmongChanged(std::uint32_t reached_since, Executor& executor) const {
  const auto is_reached = [&](VertexId id) {
    return mesh_.vertex(id).touched && IsReached(id, reached_since);
  };
  const auto add_bad = [&](const Star& star, Part& part) {
    const VertexId id = star.center();
    for (const TriangleId t : star.triangles()) {
      // Of several that are reached, the first looks at a triangle.
      const auto& v = mesh_.triangle(t).vertices;
      const bool is_first = std::all_of(
          v.begin(), v.end(), [&](VertexId corner) { return corner >= id || !is_reached(corner); });
      if (is_first) AddCornersIfBad(t, part);
    }
  };
  const auto& changed = edit_.log().vertices;
  const Chunks chunks(std::ssize(changed));
  Parts parts(static_cast<std::size_t>(chunks.count()));
  executor.Run(chunks.count(), [&](std::int32_t chunk) {
    Part& part = parts[static_cast<std::size_t>(chunk)];
    Star star;
    for (std::int64_t i = chunks.begin(chunk); i < chunks.end(chunk); ++i) {
      const VertexId id = changed[static_cast<std::size_t>(i)].first;
      if (!mesh_.IsLive(id) || !is_reached(id)) continue;
      if (!mesh_.vertex(id).pinched) {  // Nearly always: no list of fans.
        star.Gather(mesh_, id);
        add_bad(star, part);
        continue;
      }
      for (const TriangleId fan : FansOf(mesh_, id)) {
        star.Gather(mesh_, id, fan);
        add_bad(star, part);
      }
    }
  });
  return parts;
}

Mender::Mended Mender::VisitNext(const MetricField& field) {
  PLIANT_CHECK(!done());
  const VertexId node = state_.waiting[state_.next++];
  Mended mended;
  if (mesh_.IsLive(node) && !mesh_.vertex(node).pinched) {
    star_.Gather(mesh_, node);
    while (permissions_.swap && !is_worn_out() && SwapOne()) {
      ++mended.swaps;
      star_.Gather(mesh_, node);
    }
    const VertexRecord& record = mesh_.vertex(node);
    const bool on_kept_surface = record.edge.valid() && !permissions_.surface;
    if (!record.fixed && !record.frozen && !on_kept_surface && !is_worn_out() && HasBadTriangle()) {
      mended.moves = record.edge.valid() ? Slide(field) : Move(field);
      if (mended.moves == 0 && !record.edge.valid()) mended.insertions = Insert(field);
    }
    if (mended.swaps + mended.moves + mended.insertions > 0) {
      Part part{.nodes = std::move(state_.next_round), .poor = {}};
      for (const TriangleId t : star_.triangles()) AddCornersIfBad(t, part);
      state_.next_round = std::move(part.nodes);
    }
  }
  if (done()) {
    SortUnique(state_.next_round);
    state_.waiting = std::exchange(state_.next_round, {});
    state_.next = 0;
  }
  return mended;
}

std::vector<VertexId> Mender::TakeMoved() {
  SortUnique(state_.moved);
  return std::exchange(state_.moved, {});
}

void Mender::Renumber(std::span<const VertexId> new_ids) {
  const auto renumber = [&](std::vector<VertexId>& nodes) {
    for (VertexId& node : nodes) node = new_ids[node.index()];
    std::erase_if(nodes, [](VertexId node) { return !node.valid(); });
  };
  state_.waiting.erase(state_.waiting.begin(),
                       state_.waiting.begin() + static_cast<std::ptrdiff_t>(state_.next));
  state_.next = 0;
  renumber(state_.waiting);
  renumber(state_.next_round);
  renumber(state_.moved);
  renumber(state_.poor);
}

void Mender::AddCornersIfBad(TriangleId triangle, Part& part) const {
  if (!mesh_.triangle(triangle).live) return;
  const double merit = MeritAt(triangle);
  if (!IsBad(triangle, merit)) return;
  const auto& corners = mesh_.triangle(triangle).vertices;
  part.nodes.insert(part.nodes.end(), corners.begin(), corners.end());
  if (merit < kPoorMerit) part.poor.insert(part.poor.end(), corners.begin(), corners.end());
}

/// Infinite where it is surely good.
double Mender::MeritAt(TriangleId triangle) const {
  const auto& v = mesh_.triangle(triangle).vertices;
  const MeritShape shape = MeritShapeOf(MeritCornerAt(mesh_, v[0]), MeritCornerAt(mesh_, v[1]),
                                        MeritCornerAt(mesh_, v[2]));
  if (IsMeritSurelyAbove(shape, kWarmMerit)) return std::numeric_limits<double>::infinity();
  return MeritOf(shape);
}

bool Mender::IsBad(TriangleId triangle, double merit) const {
  if (merit >= kWarmMerit) return false;
  return merit < 1 || std::ranges::any_of(mesh_.triangle(triangle).vertices,
                                          [&](VertexId corner) { return IsWarm(corner); });
}

bool Mender::IsReached(VertexId node, std::uint32_t since) const {
  return mesh_.vertex(node).visit.epoch >= since;
}

bool Mender::IsWarm(VertexId node) const {
  const VisitState& visit = mesh_.vertex(node).visit;
  return visit.epoch >= state_.warm_since && !visit.cold;
}

bool Mender::HasBadTriangle() const {
  return std::any_of(star_.triangles().begin(), star_.triangles().end(),
                     [&](TriangleId t) { return IsBad(t); });
}

bool Mender::StaysPositive(Vec2 center) const {
  for (std::size_t k = 0; k < star_.triangles().size(); ++k) {
    if (Orient2d(center, mesh_.position(star_.ring()[k]), mesh_.position(star_.ring_after(k))) <=
        0) {
      return false;
    }
  }
  return true;
}

bool Mender::Move(const MetricField& field) {
  const VertexId node = star_.center();
  const std::vector<MeritCorner> ring = RingCorners();
  const Vec2 best = BestPlace(ring, MeritCornerAt(mesh_, node));
  const Arrival arrival = Arrive(ring, field, best);
  if (!arrival.better) return false;
  edit_.MoveVertex(node, best);
  edit_.SetMetric(node, arrival.metric);
  edit_.Hint(node) = arrival.hint;
  edit_.Visit(node).mended = true;
  state_.moved.push_back(node);
  return true;
}

Vec2 Mender::BestPlace(std::span<const MeritCorner> ring, const MeritCorner& start) {
  const Metric& m = start.metric;
  // Two vectors of metric length 1, orthogonal in the metric.
  const double height = std::sqrt(Determinant(m) / m.m11);
  const Vec2 first{1 / std::sqrt(m.m11), 0};
  const Vec2 second{-m.m12 / (m.m11 * height), 1 / height};

  Vec2 best = start.position;
  double least = ShortfallAround(ring, start);
  for (const double step : kSteps) {
    bool better = true;
    for (int round = 0; better && round < kRoundsPerStep; ++round) {
      better = false;
      const Vec2 from = best;
      for (const Vec2 direction : kCompass) {
        const Vec2 target = from + step * (direction.x * first + direction.y * second);
        const double enough = kSearchShare * least;
        const double shortfall = ShortfallAround(ring, {target, m, start.squared_room}, enough);
        if (!(shortfall < enough)) continue;
        least = shortfall;
        best = target;
        better = true;
      }
    }
  }
  return best;
}

std::vector<MeritCorner> Mender::RingCorners() const {
  std::vector<MeritCorner> ring;
  ring.reserve(star_.ring().size() + 1);
  for (const VertexId vertex : star_.ring()) ring.push_back(MeritCornerAt(mesh_, vertex));
  if (star_.closed()) ring.push_back(ring.front());
  return ring;
}

bool Mender::Slide(const MetricField& field) {
  const VertexId node = star_.center();
  const auto [before, after] = mesh_.SegmentEdges(node);
  const EdgeRecord& edge = mesh_.edge(before);
  const SegmentRecord& line = mesh_.segments()[static_cast<std::size_t>(edge.segment)];
  const Metric m = mesh_.metric(node);
  const double unit =
      1 / std::sqrt(SquaredLength(m, mesh_.position(line.b) - mesh_.position(line.a)));
  const double low = edge.parameters[0];
  const double high = mesh_.edge(after).parameters[1];

  const std::vector<MeritCorner> ring = RingCorners();
  double best = edge.parameters[1];
  double least = ShortfallAround(ring, {mesh_.position(node), m});
  for (const double step : kSteps) {
    bool better = true;
    for (int round = 0; better && round < kRoundsPerStep; ++round) {
      better = false;
      const double from = best;
      for (const double t : {from - step * unit, from + step * unit}) {
        if (!(low < t && t < high)) continue;
        const double enough = kSearchShare * least;
        const double shortfall =
            ShortfallAround(ring, {mesh_.PointOnSegment(edge.segment, t), m}, enough);
        if (!(shortfall < enough)) continue;
        least = shortfall;
        best = t;
        better = true;
      }
    }
  }
  const Arrival arrival = Arrive(ring, field, mesh_.PointOnSegment(edge.segment, best));
  if (!arrival.better) return false;
  edit_.SlideVertex(node, best);
  edit_.SetMetric(node, arrival.metric);
  edit_.Hint(node) = arrival.hint;
  edit_.Visit(node).mended = true;
  state_.moved.push_back(node);
  return true;
}

Mender::Arrival Mender::Arrive(std::span<const MeritCorner> ring, const MetricField& field,
                               Vec2 target) const {
  const VertexId node = star_.center();
  Arrival arrival;
  arrival.hint = mesh_.hint(node);
  if (target == mesh_.position(node) || !StaysPositive(target)) return arrival;
  const MeritCorner now = MeritCornerAt(mesh_, node);
  arrival.metric = field.At(target, arrival.hint);
  arrival.better = IsGain(ShortfallAround(ring, now),
                          ShortfallAround(ring, {target, arrival.metric, now.squared_room}));
  return arrival;
}

bool Mender::SwapOne() {
  for (const TriangleId t : star_.triangles()) {
    if (!IsBad(t)) continue;
    for (int corner = 0; corner < 3; ++corner) {
      if (!WantsSwap({t, corner})) continue;
      // It may change who is beside a crowd, which must not go round for ever.
      const auto& v = mesh_.triangle(t).vertices;
      if (std::ranges::any_of(v, [&](VertexId id) { return IsMendedBesideCrowd(mesh_, id); })) {
        state_.moved.push_back(star_.center());
      }
      edit_.SwapEdge({t, corner});
      return true;
    }
  }
  return false;
}

bool Mender::WantsSwap(Side side) const {
  const TriangleRecord& triangle = mesh_.triangle(side.triangle);
  const auto corner = static_cast<std::size_t>(side.corner);
  const TriangleId beyond = triangle.neighbors[corner];
  if (!beyond.valid() || triangle.IsConstrained(side.corner) || triangle.frozen) {
    return false;
  }
  const MeritCorner y = MeritCornerAt(mesh_, triangle.vertices[corner]);
  const MeritCorner z =
      MeritCornerAt(mesh_, triangle.vertices[static_cast<std::size_t>(NextCorner(side.corner))]);
  const MeritCorner x = MeritCornerAt(
      mesh_, triangle.vertices[static_cast<std::size_t>(PreviousCorner(side.corner))]);
  const int far = mesh_.SideTowards(beyond, side.triangle);
  const MeritCorner w =
      MeritCornerAt(mesh_, mesh_.triangle(beyond).vertices[static_cast<std::size_t>(far)]);
  if (Orient2d(y.position, z.position, w.position) <= 0 ||
      Orient2d(w.position, x.position, y.position) <= 0) {
    return false;
  }
  return IsGain(ShortfallOf(x, y, z) + ShortfallOf(z, w, x),
                ShortfallOf(y, z, w) + ShortfallOf(w, x, y));
}

}  // namespace pliant
