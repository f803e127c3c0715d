// PliantLoop, the part that wakes nodes.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/pliant/loop.h"

namespace pliant {

void PliantLoop::Wake(VertexId node) {
  if (MarkAwake(node)) state_.queue.Push(node);
}

bool PliantLoop::MarkAwake(VertexId node) {
  VisitState visit = CurrentVisit(node);
  const bool enters = !visit.active;
  visit.age = 0;
  visit.hop = 0;
  visit.cold = false;
  visit.tired = false;
  visit.active = true;
  visit.mended = false;
  visit.drift_x = visit.drift_y = 0;
  if (!(visit == mesh_.vertex(node).visit)) edit_.Visit(node) = visit;
  return enters;
}

template <class SetMetric>
bool PliantLoop::WakeEach(Executor& executor, SetMetric&& set_metric) {
  const Chunks chunks(mesh_.vertex_slots());
  waking_.resize(static_cast<std::size_t>(chunks.count()));
  executor.Run(chunks.count(), [&](std::int32_t chunk) {
    Woken& nodes = waking_[static_cast<std::size_t>(chunk)];
    if (nodes.done) return;
    std::int32_t last_hint = MetricField::kNoHint;
    for (std::int64_t v = chunks.begin(chunk); v < chunks.end(chunk); ++v) {
      const VertexId node(static_cast<std::int32_t>(v));
      const VertexRecord& record = mesh_.vertex(node);
      if (!record.live) continue;
      const bool is_new = record.visit.epoch == 0;
      // Where nobody has asked yet, the vertex before is near.
      if (mesh_.hint(node) == MetricField::kNoHint) edit_.Hint(node) = last_hint;
      set_metric(node);
      last_hint = mesh_.hint(node);
      if (MarkAwake(node)) (is_new ? nodes.new_nodes : nodes.old_nodes).push_back(node);
    }
    nodes.done = true;
  });
  if (executor.stopped()) return false;
  for (const Woken& nodes : waking_) TakeOver(nodes.old_nodes);
  for (const Woken& nodes : waking_) TakeOver(nodes.new_nodes);
  waking_.clear();
  return true;
}

bool PliantLoop::WakeAll(const MetricField& field, Executor& executor) {
  return WakeEach(executor, [&](VertexId node) { RefreshMetric(field, node); });
}

bool PliantLoop::WakeRefined(double growth, Executor& executor) {
  refined_ = true;
  return WakeEach(executor,
                  [&](VertexId node) { edit_.SetMetric(node, growth * mesh_.metric(node)); });
}

void PliantLoop::AskForUnvisited(const MetricField& field) {
  if (!refined_) return;
  for (std::int32_t v = 0; v < mesh_.vertex_slots(); ++v) {
    const VertexRecord& record = mesh_.vertex(VertexId(v));
    if (record.live && record.visit.active && record.visit.age == 0) {
      RefreshMetric(field, VertexId(v));
    }
  }
}

}  // namespace pliant
