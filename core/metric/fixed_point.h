#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "core/base/as_index.h"
#include "core/base/large_pages.h"
#include "core/base/stop_signal.h"

namespace pliant {

/// Keeps the solution of a shortest-path problem up to date while the problem changes.
///
/// Every vertex has a value: the best of its own and of what its neighbours' values offer it. An
/// offer is worse than the value it comes from, so there is exactly one solution. A vertex whose
/// value is not the best of what it sees (its rhs) waits in a heap. The best one is settled: a
/// value that was too poor becomes the rhs; one that was too good is withdrawn, and whoever had it
/// from there looks again. Each vertex is settled at most twice, whatever the order in which
/// changes came in. [RamalingamReps1996, sec. 4.4]
///
/// Problem is a class with
///     using Value;                                       equality compares bits
///     static double Key(const Value&);                   smaller is better; infinite for kNone
///     static bool IsBetter(const Value&, const Value&);  a strict order that refines Key
///     static Value None();                               no value at all
///     Value& At(v);                                      where the values are
///     Value Own(v) const;                                what v has without neighbours
///     std::optional<Value> Offer(p_value, p, q) const;   nothing if no better than Own(q)
///     std::span<const std::int32_t> Neighbors(v);        valid until the next call
/// *Invariants*: between calls of Settle nothing waits, unless one was stopped.
template <class Problem>
class FixedPoint {
 public:
  using Value = typename Problem::Value;

  /// Looks again at a vertex: its own value, its neighbours or the edges to them changed.
  void Recheck(Problem& problem, std::int32_t v) { SetAhead(problem, v, BestOf(problem, v)); }

  /// Restores the solution. Calls changed(v) before a value is changed, perhaps twice.
  /// @param stop  null: nobody; else it ends where it is if that asks to, and Clear must follow
  template <class Changed>
  void Settle(Problem& problem, Changed changed, const StopSignal* stop = nullptr);

  /// Forgets who waits: the values will be those of a solution again.
  void Clear();

  /// Values settled so far, over all calls.
  [[nodiscard]] std::int64_t settled_count() const { return settled_count_; }

 private:
  struct Waiting {
    double key;
    std::int32_t vertex;
    friend auto operator<=>(const Waiting&, const Waiting&) = default;
  };
  struct Ahead {
    std::int32_t vertex;
    Value value;
    bool waits;
  };

  /// The best that v sees now.
  static Value BestOf(Problem& problem, std::int32_t v) {
    Value best = problem.Own(v);
    for (const std::int32_t p : problem.Neighbors(v)) {
      const std::optional<Value> offer = problem.Offer(problem.At(p), p, v);
      if (offer && Problem::IsBetter(*offer, best)) best = *offer;
    }
    return best;
  }

  [[nodiscard]] Ahead* FindAhead(std::int32_t v) {
    if (AsIndex(v) >= ahead_of_.size() || ahead_of_[AsIndex(v)] < 0) return nullptr;
    return &ahead_[AsIndex(ahead_of_[AsIndex(v)])];
  }

  /// The rhs of v: what it waits for, or the value that it has.
  [[nodiscard]] Value Rhs(Problem& problem, std::int32_t v) {
    const Ahead* ahead = FindAhead(v);
    return ahead != nullptr && ahead->waits ? ahead->value : problem.At(v);
  }

  void SetAhead(Problem& problem, std::int32_t v, const Value& rhs) {
    Ahead* ahead = FindAhead(v);
    const bool waits = !(rhs == problem.At(v));
    if (ahead == nullptr) {
      if (!waits) return;
      if (AsIndex(v) >= ahead_of_.size()) ahead_of_.resize(AsIndex(v) + 1, -1);
      ahead_of_[AsIndex(v)] = static_cast<std::int32_t>(ahead_.size());
      ahead_.push_back({v, rhs, true});
    } else {
      ahead->value = rhs;
      ahead->waits = waits;
    }
    if (waits) heap_.push({std::min(Problem::Key(rhs), Problem::Key(problem.At(v))), v});
  }

  void Replace(Problem& problem, std::int32_t p, const Value& value);

  LargeVector<Ahead> ahead_;            ///< Vertices that waited since the last Settle.
  std::vector<std::int32_t> ahead_of_;  ///< Per vertex its place in ahead_, or -1.
  std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> heap_;
  std::vector<std::int32_t> ring_;  ///< Scratch.
  std::int64_t settled_count_ = 0;
};

template <class Problem>
template <class Changed>
void FixedPoint<Problem>::Settle(Problem& problem, Changed changed, const StopSignal* stop) {
  StopPoll stopped(stop);
  while (!heap_.empty()) {
    if (stopped()) return;
    const auto [key, v] = heap_.top();
    heap_.pop();
    const Ahead* ahead = FindAhead(v);
    if (ahead == nullptr || !ahead->waits) continue;
    const Value& now = problem.At(v);
    if (key != std::min(Problem::Key(ahead->value), Problem::Key(now))) continue;
    ++settled_count_;
    changed(v);
    if (Problem::IsBetter(ahead->value, now)) {
      const Value value = ahead->value;
      Replace(problem, v, value);
      SetAhead(problem, v, value);
    } else {
      Replace(problem, v, Problem::None());
      SetAhead(problem, v, BestOf(problem, v));
    }
  }
  Clear();
}

template <class Problem>
void FixedPoint<Problem>::Clear() {
  heap_ = {};
  for (const Ahead& ahead : ahead_) ahead_of_[AsIndex(ahead.vertex)] = -1;
  ahead_.clear();
}

/// Gives p another value and tells its neighbours: those for whom it is the best they see now, and
/// those who saw the old one, which may have been better for them.
template <class Problem>
void FixedPoint<Problem>::Replace(Problem& problem, std::int32_t p, const Value& value) {
  const Value old = std::exchange(problem.At(p), value);
  const std::span<const std::int32_t> ring = problem.Neighbors(p);
  ring_.assign(ring.begin(), ring.end());
  for (const std::int32_t q : ring_) {
    const Value rhs = Rhs(problem, q);
    const std::optional<Value> offer = problem.Offer(value, p, q);
    if (offer && Problem::IsBetter(*offer, rhs)) {
      SetAhead(problem, q, *offer);
    } else if (!(offer && *offer == rhs) && problem.Offer(old, p, q) == rhs) {
      SetAhead(problem, q, BestOf(problem, q));
    }
  }
}

}  // namespace pliant
