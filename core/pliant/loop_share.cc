// PliantLoop, the part by which several loops share one mesh and one update.

#include <algorithm>
#include <vector>

#include "core/pliant/loop.h"

namespace pliant {

LoopCounts& LoopCounts::operator+=(const LoopCounts& other) {
  visits += other.visits;
  moves += other.moves;
  insertions += other.insertions;
  deletions += other.deletions;
  swaps += other.swaps;
  cooled += other.cooled;
  mended += other.mended;
  refused_at_limit += other.refused_at_limit;
  refused_by_allowance += other.refused_by_allowance;
  return *this;
}

void PliantLoop::Join(const PliantLoop& other) {
  state_.epoch = other.state_.epoch;
  state_.settings = other.state_.settings;
  refined_ = other.refined_;
}

void PliantLoop::TakeOver(std::span<const VertexId> nodes) {
  for (const VertexId node : nodes) state_.queue.Push(node);
}

std::vector<VertexId> PliantLoop::HandOver() {
  std::vector<VertexId> nodes = state_.queue.TakeAll();
  nodes.insert(nodes.end(), aside_.begin(), aside_.end());
  aside_.clear();
  return nodes;
}

void PliantLoop::Add(const LoopCounts& counts) {
  state_.counts += counts;
  state_.visits_in_update += counts.visits;
}

bool PliantLoop::MayVisit(const Territory& territory, VertexId node) {
  if (!territory.HasRoom() || !territory.Owns(node)) return false;
  const auto owns = [&](VertexId vertex) { return territory.Owns(vertex); };
  if (!mesh_.vertex(node).pinched) {
    star_.Gather(mesh_, node);
    return std::ranges::all_of(star_.ring(), owns);
  }
  return std::ranges::all_of(FansOf(mesh_, node), [&](TriangleId fan) {
    star_.Gather(mesh_, node, fan);
    return std::ranges::all_of(star_.ring(), owns);
  });
}

}  // namespace pliant
