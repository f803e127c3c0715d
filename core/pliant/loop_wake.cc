// PliantLoop, the part that wakes nodes.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/pliant/ask.h"
#include "core/pliant/loop.h"

namespace pliant {
namespace {

/// Enough for a field that is asked for all of them together.
constexpr std::int32_t kWokenAtOnce = 64;

}  // namespace

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

template <class Giver>
bool PliantLoop::WakeEach(Executor& executor, const Giver& giver) {
  const Chunks chunks(mesh_.vertex_slots());
  waking_.resize(static_cast<std::size_t>(chunks.count()));
  executor.Run(chunks.count(), [&](std::int32_t chunk) {
    Woken& nodes = waking_[static_cast<std::size_t>(chunk)];
    if (nodes.done) return;
    Giver metrics = giver;
    const auto chunk_end = static_cast<std::int32_t>(chunks.end(chunk));
    for (auto v = static_cast<std::int32_t>(chunks.begin(chunk)); v < chunk_end;) {
      const std::int32_t end = std::min(chunk_end, v + kWokenAtOnce);
      metrics.Prepare(v, end);
      for (; v < end; ++v) {
        const VertexId node(v);
        const VertexRecord& record = mesh_.vertex(node);
        if (!record.live) continue;
        const bool is_new = record.visit.epoch == 0;
        metrics.Give(node);
        if (MarkAwake(node)) (is_new ? nodes.new_nodes : nodes.old_nodes).push_back(node);
      }
    }
    nodes.done = true;
  });
  if (executor.stopped()) return false;
  for (const Woken& nodes : waking_) TakeOver(nodes.old_nodes);
  for (const Woken& nodes : waking_) TakeOver(nodes.new_nodes);
  waking_.clear();
  return true;
}

/// The field's.
struct PliantLoop::AskedMetrics {
  MeshEdit& edit;
  const MetricField& field;
  std::int32_t last_hint = MetricField::kNoHint;
  std::array<Metric, kWokenAtOnce> answers = {};
  std::size_t given = 0;

  void Prepare(std::int32_t begin, std::int32_t end) {
    std::array<VertexId, kWokenAtOnce> live;
    std::size_t count = 0;
    for (std::int32_t v = begin; v < end; ++v) {
      if (edit.mesh().IsLive(VertexId(v))) live[count++] = VertexId(v);
    }
    given = 0;
    if (count == 0) return;
    // Where nobody has asked yet, the vertex before is near.
    if (edit.mesh().hint(live[0]) == MetricField::kNoHint) edit.Hint(live[0]) = last_hint;
    AskAt(edit, field, std::span(live).first(count), std::span(answers).first(count));
    last_hint = edit.mesh().hint(live[count - 1]);
  }
  void Give(VertexId node) { edit.SetMetric(node, answers[given++]); }
};

/// Those that are there, times a constant.
struct PliantLoop::GrownMetrics {
  MeshEdit& edit;
  double growth;

  void Prepare(std::int32_t /*begin*/, std::int32_t /*end*/) {}
  void Give(VertexId node) { edit.SetMetric(node, growth * edit.mesh().metric(node)); }
};

bool PliantLoop::WakeAll(const MetricField& field, Executor& executor) {
  return WakeEach(executor, AskedMetrics{edit_, field});
}

bool PliantLoop::WakeRefined(double growth, Executor& executor) {
  refined_ = true;
  return WakeEach(executor, GrownMetrics{edit_, growth});
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
