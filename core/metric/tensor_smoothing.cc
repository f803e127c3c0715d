#include "core/metric/tensor_smoothing.h"

#include <algorithm>
#include <tuple>

#include "core/base/as_index.h"
#include "core/base/check.h"

namespace pliant {
LogMetric RingMean(const LogMetric& own, std::span<PlacedLog> ring) {
  std::ranges::sort(ring, {}, [](const PlacedLog& placed) {
    return std::tuple(placed.position.x, placed.position.y);
  });
  // Differences to the own tensor, so that a constant stays one.
  LogMetric sum;
  for (const PlacedLog& placed : ring) sum = sum + (placed.log + -1.0 * own);
  return own + (1 / static_cast<double>(ring.size() + 1)) * sum;
}

TensorSmoothing::TensorSmoothing(std::int32_t pass_count) : pass_count_(pass_count) {
  PLIANT_CHECK(pass_count >= 0 && pass_count <= kPassesMax, "pass_count", pass_count);
}

void TensorSmoothing::Set(std::int32_t vertex, const Metric& raw) {
  if (Row(vertex) >= logs_.size()) {
    logs_.resize(Row(vertex + 1));
    listed_.resize(AsIndex(vertex) + 1);
  }
  Write(vertex, 0, Log(raw));
}

std::vector<std::int32_t> TensorSmoothing::Update(VertexRings& rings,
                                                  std::span<const std::int32_t> touched,
                                                  const StopSignal* stop) {
  StopPoll stopped(stop);
  std::vector<std::int32_t> changed;
  std::vector<std::int32_t> list;
  const auto add_with_ring = [&](std::int32_t v) {
    Add(v, list);
    for (const std::int32_t q : rings.Neighbors(v)) Add(q, list);
  };
  for (std::int32_t pass = 1; pass <= pass_count_; ++pass) {
    list.clear();
    // In every pass these have another ring, or one of another order.
    std::ranges::for_each(touched, add_with_ring);
    std::ranges::for_each(changed, add_with_ring);
    changed.clear();
    for (const std::int32_t v : list) {
      listed_[AsIndex(v)] = 0;
      if (stopped()) continue;
      const LogMetric mean = Mean(rings, v, pass);
      if (logs_[Row(v) + AsIndex(pass)] == mean) continue;
      Write(v, pass, mean);
      changed.push_back(v);
    }
  }
  changed.insert(changed.end(), touched.begin(), touched.end());
  return changed;
}

LogMetric TensorSmoothing::Mean(VertexRings& rings, std::int32_t vertex, std::int32_t pass) {
  const std::size_t before = AsIndex(pass - 1);
  ring_.clear();
  for (const std::int32_t q : rings.Neighbors(vertex)) {
    ring_.push_back({rings.position(q), logs_[Row(q) + before]});
  }
  return RingMean(logs_[Row(vertex) + before], ring_);
}

void TensorSmoothing::Add(std::int32_t vertex, std::vector<std::int32_t>& list) {
  if (listed_[AsIndex(vertex)] != 0) return;
  listed_[AsIndex(vertex)] = 1;
  list.push_back(vertex);
}

bool TensorSmoothing::Differs(std::int32_t vertex) const {
  return logs_[Row(vertex)] != logs_[Row(vertex) + AsIndex(pass_count_)];
}

Metric TensorSmoothing::At(std::int32_t vertex) const {
  return Exp(logs_[Row(vertex) + AsIndex(pass_count_)]);
}

void TensorSmoothing::Write(std::int32_t vertex, std::int32_t pass, const LogMetric& log) {
  const std::size_t index = Row(vertex) + AsIndex(pass);
  // Of rows that the last commit did not have, nothing comes back.
  if (index < committed_size_) undo_.push_back({index, logs_[index]});
  logs_[index] = log;
}

void TensorSmoothing::Commit() {
  undo_.clear();
  committed_size_ = logs_.size();
}

void TensorSmoothing::Rollback() {
  // Backwards: the first value that an entry had is written last.
  for (auto old = undo_.rbegin(); old != undo_.rend(); ++old) logs_[old->index] = old->log;
  undo_.clear();
  logs_.resize(committed_size_);
  listed_.resize(pass_count_ == 0 ? 0 : committed_size_ / AsIndex(pass_count_ + 1));
}

}  // namespace pliant
