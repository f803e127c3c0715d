// FollowedMetric, the part that changes what holds for tensors at vertices.

#include <algorithm>
#include <memory>
#include <utility>

#include "core/pliant/followed_metric.h"

namespace pliant {

Result<WantedTensors> FollowedMetric::SetTensors(std::span<const VertexId> vertices,
                                                 std::span<const Metric> tensors,
                                                 const Terms& terms, const StopSignal* stop) {
  const MetricLimits& limits = terms.limits;
  const bool same_limits = limits == asked_limits();
  if (Holds(terms)) return SetTensors(vertices, tensors, stop);
  PLIANT_ASSIGN_OR_RETURN(WantedTensors raw, RawNow(stop));
  const auto row_of = [&](VertexId vertex) {
    return std::ranges::lower_bound(raw.vertices, vertex) - raw.vertices.begin();
  };
  StopPoll stopped(stop);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (stopped()) return Stopped();
    raw.tensors[static_cast<std::size_t>(row_of(vertices[i]))] = Bound(tensors[i], limits.bounds);
  }
  for (Metric& tensor : raw.tensors) {
    if (stopped()) return Stopped();
    // What is bounded already is not composed again, for the sake of its last bits.
    if (!same_limits) tensor = Bound(tensor, limits.bounds);
  }
  TakeLimits(limits);
  state_.functions = terms.functions;
  state_.limit_rounds_left = state_.limits.any() ? kLimitRounds : 0;
  if (!state_.keeps_raw()) limits_.TurnOff();
  if (!committed() || !state_.keeps_raw()) {
    PLIANT_ASSIGN_OR_RETURN(WantedTensors wanted, FollowTensors(std::move(raw), stop));
    if (!state_.limits.any()) return wanted;
    return Limit();
  }
  if (state_.limits.any()) --state_.limit_rounds_left;
  state_.source = nullptr;
  state_.spec.reset();
  const MeshLimits::Rules rules{state_.limits, state_.functions};
  PLIANT_RETURN_IF_ERROR(limits_.Load(rules, raw.vertices, raw.tensors, stop));
  return LayLimits(stop);
}

/// What every vertex wants where it is now, bounds applied, without limits and functions.
/// @par Cost O(mesh)
Result<WantedTensors> FollowedMetric::RawNow(const StopSignal* stop) {
  if (!committed()) return Evaluate(*state_.source, stop);
  WantedTensors raw{LiveVertices(mesh_), {}};
  raw.tensors.reserve(raw.vertices.size());
  if (limits_.on()) PLIANT_RETURN_IF_ERROR(limits_.Follow(*base_, *RawOfVertices(), stop));
  StopPoll stopped(stop);
  for (const VertexId vertex : raw.vertices) {
    if (stopped()) return Stopped();
    raw.tensors.push_back(limits_.on() ? limits_.Raw(vertex) : mesh_.metric(vertex));
  }
  return raw;
}

Result<WantedTensors> FollowedMetric::Carry(std::span<const VertexId> vertices,
                                            std::span<const Metric> tensors) {
  WantedTensors given{{vertices.begin(), vertices.end()}, {tensors.begin(), tensors.end()}};
  if (limits_.on() && committed()) {
    if (state_.functions != nullptr) given = RawAt(vertices);
    PLIANT_RETURN_IF_ERROR(limits_.Follow(*base_, *RawOfVertices()));
    return LimitTensors(given.vertices, given.tensors, nullptr);
  }
  PLIANT_CHECK(FollowTensors(std::move(given), nullptr).ok());
  if (!state_.limits.any()) return WantedTensors{};
  state_.limit_rounds_left = kLimitRounds;
  return Limit();
}

/// What vertices wanted when the limits were laid last; none that were not there.
WantedTensors FollowedMetric::RawAt(std::span<const VertexId> vertices) const {
  WantedTensors raw;
  for (const VertexId vertex : vertices) {
    if (!limits_.Has(vertex)) continue;
    raw.vertices.push_back(vertex);
    raw.tensors.push_back(limits_.Raw(vertex));
  }
  return raw;
}

}  // namespace pliant
