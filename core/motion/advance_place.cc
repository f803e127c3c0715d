// Advance, the part that puts vertices where they are at a time.

#include <algorithm>

#include "core/motion/advance.h"

namespace pliant {
namespace {

/// From one in so many on, looking at everybody in order is cheaper than sorting a list.
constexpr std::size_t kFewNear = 8;

}  // namespace

Vec2 Advance::PositionAt(VertexId vertex, double s) const {
  const std::int32_t known = place_of_.At(vertex);
  if (known == PlaceMap::kNone) return mesh_.position(vertex);
  const auto place = static_cast<std::size_t>(known);
  if (place < plan_.movers().size()) return plan_.At(plan_.movers()[place], s);
  const Rider& rider = plan_.riders()[place - plan_.movers().size()];
  const SegmentRecord& segment = mesh_.segments()[static_cast<std::size_t>(rider.segment)];
  const Vec2 a = PositionAt(segment.a, s);
  return a + MotionPlan::ParameterAt(rider, s) * (PositionAt(segment.b, s) - a);
}

void Advance::GatherNear() {
  ++stamp_;
  near_.clear();
  const auto add = [&](VertexId vertex) {
    const std::int32_t known = place_of_.At(vertex);
    if (known == PlaceMap::kNone) return;
    const auto place = static_cast<std::size_t>(known);
    if (IsNear(place)) return;
    near_stamp_[place] = stamp_;
    near_.push_back(place);
  };
  ForEachTriangleOfFront([&](TriangleId id) {
    for (const VertexId corner : mesh_.triangle(id).vertices) add(corner);
  });
  // The ends of a segment before those that ride on it: movers have the lower places.
  if (kFewNear * near_.size() < moving_.size()) {
    std::sort(near_.begin(), near_.end());
    return;
  }
  near_.clear();
  for (std::size_t place = 0; place < moving_.size(); ++place) {
    if (IsNear(place)) near_.push_back(place);
  }
}

void Advance::Place(std::size_t place, double s) {
  const VertexId vertex = moving_[place];
  if (!mesh_.IsLive(vertex)) return;
  before_[place] = mesh_.position(vertex);
  if (place < plan_.movers().size()) {
    edit_.PlaceVertex(vertex, plan_.At(plan_.movers()[place], s));
  } else {
    PlaceRider(plan_.riders()[place - plan_.movers().size()], s);
  }
}

void Advance::PlaceNear(double s) {
  GatherNear();
  for (const std::size_t place : near_) {
    if (stopped_()) return;
    Place(place, s);
  }
}

void Advance::PlaceRest(double s) {
  for (std::size_t place = 0; place < moving_.size() && !stopped_(); ++place) {
    if (IsNear(place)) continue;
    near_stamp_[place] = stamp_;
    near_.push_back(place);
    Place(place, s);
  }
}

void Advance::PlaceRider(const Rider& rider, double s) {
  const double t = MotionPlan::ParameterAt(rider, s);
  if (rider.t_end != rider.t) edit_.SetParameter(rider.vertex, t);
  edit_.PlaceVertex(rider.vertex, s == 1 && rider.given ? rider.to : PositionAt(rider.vertex, s));
}

void Advance::TakeBack() {
  for (const std::size_t place : near_) {
    if (!mesh_.IsLive(moving_[place])) continue;
    edit_.PlaceVertex(moving_[place], before_[place]);
    if (place < plan_.movers().size()) continue;
    const Rider& rider = plan_.riders()[place - plan_.movers().size()];
    if (rider.t_end != rider.t) {
      edit_.SetParameter(rider.vertex, MotionPlan::ParameterAt(rider, time_));
    }
  }
}

}  // namespace pliant
