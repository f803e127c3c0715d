// Advance, the part that tells who moves against a neighbour, and whose surroundings have changed.

#include <algorithm>

#include "core/mesh/id_bits.h"
#include "core/motion/advance.h"

namespace pliant {
namespace {

constexpr std::int32_t kAlone = -1;
constexpr std::int32_t kStill = -2;

}  // namespace

std::int32_t Advance::GroupOf(VertexId vertex) const {
  const std::int32_t known = place_of_.At(vertex);
  if (known == PlaceMap::kNone) return kStill;
  const auto place = static_cast<std::size_t>(known);
  if (place < plan_.movers().size()) return plan_.movers()[place].shape;
  const Rider& rider = plan_.riders()[place - plan_.movers().size()];
  const SegmentRecord& segment = mesh_.segments()[static_cast<std::size_t>(rider.segment)];
  const std::int32_t a = GroupOf(segment.a);
  return a >= 0 && a == GroupOf(segment.b) ? a : kAlone;
}

void Advance::FindFront() {
  std::vector<std::int32_t> groups;
  groups.reserve(moving_.size());
  for (std::size_t i = 0; i < moving_.size() && !stopped_(); ++i) {
    groups.push_back(GroupOf(moving_[i]));
  }
  const auto group_of = [&](VertexId vertex) {
    const std::int32_t place = place_of_.At(vertex);
    return place == PlaceMap::kNone ? kStill : groups[static_cast<std::size_t>(place)];
  };
  for (std::size_t place = 0; place < moving_.size() && !stopped_(); ++place) {
    bool alike = groups[place] >= 0;
    if (alike) {
      ForEachTriangleAt(moving_[place], [&](TriangleId id) {
        for (const VertexId corner : mesh_.triangle(id).vertices) {
          alike = alike && group_of(corner) == groups[place];
        }
      });
    }
    if (!alike) JoinFront(moving_[place]);
  }
}

void Advance::JoinFront(VertexId vertex) {
  const std::int32_t place = place_of_.At(vertex);
  if (place == PlaceMap::kNone || in_front_[static_cast<std::size_t>(place)]) return;
  in_front_[static_cast<std::size_t>(place)] = true;
  front_.push_back(vertex);
}

Advance::Disturbance Advance::Disturbed() {
  IdBits<VertexId> all(mesh_.vertex_slots());
  IdBits<VertexId> not_strained(mesh_.vertex_slots());
  const auto add = [&](VertexId vertex) {
    if (mesh_.IsLive(vertex)) all.Add(vertex);
  };
  for (const VertexId vertex : torn_) {
    add(vertex);
    not_strained.Add(vertex);
  }
  ForEachTriangleOfFront([&](TriangleId id) {
    const auto& corners = mesh_.triangle(id).vertices;
    std::ranges::for_each(corners, add);
    // Where some stand still, as around a body that turns, a step is no part of a slow flow.
    const bool flows = std::ranges::all_of(
        corners, [&](VertexId corner) { return place_of_.At(corner) != PlaceMap::kNone; });
    if (flows) return;
    for (const VertexId corner : corners) not_strained.Add(corner);
  });
  // Those that move alike keep their surroundings only if these keep their shape.
  for (std::size_t place = 0; place < moving_.size(); ++place) {
    if (stopped_()) return {};
    const std::int32_t group = in_front_[place] ? kAlone : GroupOf(moving_[place]);
    if (group >= 0 && plan_.Distorts(group, time_)) add(moving_[place]);
  }
  Disturbance disturbance{.all = all.Ascending(), .strained = {}};
  for (const VertexId vertex : disturbance.all) {
    if (!not_strained.Has(vertex)) disturbance.strained.push_back(vertex);
  }
  return disturbance;
}

}  // namespace pliant
