#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/large_pages.h"
#include "core/base/stop_signal.h"
#include "core/geometry/vec2.h"
#include "core/metric/fixed_point.h"
#include "core/metric/gradation.h"
#include "core/metric/gradation_rule.h"
#include "core/metric/metric.h"
#include "core/metric/tensor_smoothing.h"
#include "core/metric/vertex_rings.h"

namespace pliant {

/// How a limited metric differs from the raw one, over the whole mesh.
struct LimitTotals {
  std::int64_t smoothing_count = 0;  ///< Vertices whose tensor is an average with others.
  std::int64_t geometry_count = 0;   ///< Vertices whose size its cap made smaller.
  std::int64_t rotation_count = 0;   ///< Vertices whose long size the rotation limit shortened.
  std::int64_t gradation_count = 0;  ///< Vertices that a neighbour's size made finer.
  /// Integrals of sqrt(det M) in units of 2^-20, the metric taken as constant around each vertex:
  /// whole numbers, so that a sum which follows its parts has the bits of a new one.
  std::int64_t raw_complexity = 0;
  std::int64_t limited_complexity = 0;

  friend bool operator==(const LimitTotals&, const LimitTotals&) = default;
};

/// What one update of the limits did.
struct LimitChanges {
  /// Vertices whose limited tensor may have changed, ascending; none that is gone.
  std::vector<std::int32_t> vertices;
  double size_ratio_max = 1;      ///< Over `vertices`: largest raw size / limited size.
  std::int32_t worst = -1;        ///< Where that is; -1 if it is 1.
  std::int64_t looked_count = 0;  ///< Work: vertices looked at, and values settled.
  bool stopped = false;           ///< All the rest means nothing, and Rollback must follow.
};

/// LimitMetrics kept up to date: a change of k tensors, places or edges costs what it changes, and
/// the result is the one of limiting everything anew, to the bit.
///
/// Both shortest-path problems are kept solved by FixedPoint; the rotation limits, which do not
/// propagate, are computed again where their inputs changed; so are the averages of
/// TensorSmoothing, which come first. *Invariants*: after Update, Limited(v) for every vertex is
/// LimitMetrics' answer for the raw tensors and the mesh of that moment. *Threads*: one caller at a
/// time.
class MetricLimiter {
 public:
  static constexpr double kNoCap = std::numeric_limits<double>::infinity();

  /// @param options  as for LimitMetrics.
  explicit MetricLimiter(const GradationOptions& options);

  /// Makes room for vertices below this number at once: growing into it moves all rows, again and
  /// again, which takes longer than a cancel may wait.
  void Reserve(std::int32_t slot_count);
  /// A vertex that is new, or whose raw tensor is another one. Takes effect with Update.
  /// @param size_cap  a size that it shall not exceed in any direction, whatever it wants.
  void SetRaw(std::int32_t vertex, const Metric& raw, double size_cap = kNoCap);
  /// A vertex that moved, or gained or lost neighbours. @pre it has a raw tensor
  void Touch(std::int32_t vertex) { touched_.push_back(vertex); }
  /// A vertex that is gone; its former neighbours must be touched.
  void Remove(std::int32_t vertex);

  /// Limits the metric of the mesh as it is now. Every vertex has a raw tensor, and every vertex
  /// that moved or whose ring changed was touched.
  /// @param stop  null: nobody; else it ends where it is if that asks to
  /// @par Cost O(changed log changed): about a microsecond per tensor that changes.
  LimitChanges Update(VertexRings& rings, const StopSignal* stop = nullptr);

  [[nodiscard]] bool Has(std::int32_t vertex) const {
    return static_cast<std::size_t>(vertex) < rows_.size() && row(vertex).live;
  }
  [[nodiscard]] const Metric& Raw(std::int32_t vertex) const { return row(vertex).raw; }
  [[nodiscard]] double SizeCap(std::int32_t vertex) const { return row(vertex).size_cap; }
  [[nodiscard]] Metric Limited(std::int32_t vertex) const;
  [[nodiscard]] const LimitTotals& totals() const { return totals_; }

  /// Vertex numbers are below.
  [[nodiscard]] std::int32_t slot_count() const { return static_cast<std::int32_t>(rows_.size()); }

  /// From now on Rollback returns to here. @par Cost O(changed since the last Commit)
  void Commit();
  /// True if nothing has happened since then.
  [[nodiscard]] bool as_committed() const {
    return log_.empty() && rows_.size() == committed_size_ && touched_.empty() && changed_.empty();
  }
  /// Raw tensors of the last Commit at vertices that have another one now, or none; ascending.
  /// @par Cost O(changed since then)
  [[nodiscard]] std::vector<std::pair<std::int32_t, Metric>> ChangedRaw() const;
  /// Back to the last Commit, to the bit. @par Cost O(changed since then)
  void Rollback();

 private:
  /// All that is known of a vertex.
  struct Row {
    Metric raw;
    double size_cap = kNoCap;
    AxisSizes own;         ///< Sizes and axes of `raw`, or of its average with its ring; capped.
    double base_wide = 0;  ///< own.wide after the rotation limit.
    AxisSizes label;       ///< After growth of the thin sizes.
    double cap = 0;        ///< label.wide after the rotation limit.
    double wide = 0;       ///< After growth of the wide sizes.
    std::int64_t raw_complexity = 0;
    std::int64_t limited_complexity = 0;
    bool live = false;
    bool smoothed = false;  ///< `own` is of an average.
    bool capped = false;    ///< `own` is finer for its cap.
    bool is_new = false;    ///< Since the last Update.
    bool changed = false;   ///< In this Update: is in changed_, and not counted.
    bool near = false;      ///< In this Update: is in near_.
    bool logged = false;

    [[nodiscard]] AxisSizes base() const { return {own.thin, base_wide, own.frame}; }
    [[nodiscard]] AxisSizes limited() const { return {label.thin, wide, label.frame}; }
    /// The limits have left it what it wanted.
    [[nodiscard]] bool is_raw() const { return !smoothed && !capped && limited() == own; }
    [[nodiscard]] bool rotated() const { return base_wide < own.wide || cap < label.wide; }
    [[nodiscard]] bool graded() const { return label.thin < own.thin || wide < cap; }
  };

  /// Thin sizes: a label spreads as far as it is the finest, its axes along with it.
  struct ThinProblem {
    using Value = AxisSizes;
    MetricLimiter& limiter;
    VertexRings& rings;

    static double Key(const Value& value) { return value.thin; }
    /// Of two labels of the same thin size any rule serves that looks at nothing but the labels,
    /// for then the numbering of vertices plays no part.
    static bool IsBetter(const Value& a, const Value& b) {
      if (a.thin != b.thin) return a.thin < b.thin;
      if (a.wide != b.wide) return a.wide > b.wide;
      if (a.frame.c != b.frame.c) return a.frame.c > b.frame.c;
      return a.frame.s > b.frame.s;
    }
    static Value None();
    Value& At(std::int32_t v) const { return limiter.rows_[static_cast<std::size_t>(v)].label; }
    Value Own(std::int32_t v) const { return limiter.row(v).base(); }
    std::optional<Value> Offer(const Value& value, std::int32_t p, std::int32_t q) const;
    std::span<const std::int32_t> Neighbors(std::int32_t v) const { return rings.Neighbors(v); }
  };

  /// Wide sizes, with axes and thin sizes final.
  struct WideProblem {
    using Value = double;
    MetricLimiter& limiter;
    VertexRings& rings;

    static double Key(double value) { return value; }
    static bool IsBetter(double a, double b) { return a < b; }
    static double None();
    double& At(std::int32_t v) const { return limiter.rows_[static_cast<std::size_t>(v)].wide; }
    double Own(std::int32_t v) const { return limiter.row(v).cap; }
    std::optional<double> Offer(double value, std::int32_t p, std::int32_t q) const;
    std::span<const std::int32_t> Neighbors(std::int32_t v) const { return rings.Neighbors(v); }
  };

  [[nodiscard]] const Row& row(std::int32_t v) const { return rows_[static_cast<std::size_t>(v)]; }
  /// Writable; the first call since Commit logs what stood there.
  Row& Mutable(std::int32_t v);
  void Count(const Row& row, int sign);
  void Measure(VertexRings& rings, std::int32_t v);
  /// Which of two passes the rotation limit is for.
  enum class RotationOf { kOwn, kLabel };
  [[nodiscard]] const AxisSizes& SizesFor(RotationOf pass, const Row& row) const {
    return pass == RotationOf::kOwn ? row.own : row.label;
  }
  [[nodiscard]] double Rotated(VertexRings& rings, std::int32_t v, RotationOf pass) const;
  void AddNear(std::int32_t v);
  void AddNearRing(VertexRings& rings, std::int32_t v);
  static void SetOwn(Row& row, const Metric& wanted);
  void Smooth(VertexRings& rings, const StopSignal* stop);
  void LookAtTouched(VertexRings& rings, const StopSignal* stop);
  void LimitOwn(VertexRings& rings, std::int32_t v);
  void Grow(VertexRings& rings, const StopSignal* stop);
  LimitChanges Finish(VertexRings& rings, const StopSignal* stop);

  GradationRates rates_;
  bool grows_;
  LargeVector<Row> rows_;
  LimitTotals totals_;
  std::vector<std::int32_t> touched_;
  std::vector<std::int32_t> changed_;  ///< Rows written since the last Update.
  std::vector<std::int32_t> near_;     ///< Vertices that this Update looks at.
  TensorSmoothing smoothing_;
  FixedPoint<ThinProblem> thin_;
  FixedPoint<WideProblem> wide_;

  std::vector<std::pair<std::int32_t, Row>> log_;
  std::size_t committed_size_ = 0;
  LimitTotals committed_totals_;
};

}  // namespace pliant
