#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/large_pages.h"
#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/geometry/locate.h"
#include "core/geometry/vec2.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"
#include "core/metric/metric_spec.h"

namespace pliant {

/// Tensors at the vertices of a triangulation, log-Euclidean in between: the exponential of the
/// barycentric mean of their logarithms. [Arsigny2006]
///
/// Sizes in between are geometric means, so no bound that the vertices keep is broken, and the
/// metric is continuous across edges. Outside, the value at the nearest point holds.
/// *Invariants*: those of MetricField. *Threads*: those of MetricField.
class BackgroundField final : public MetricField {
 public:
  /// Checks mesh and tensors, and bounds the tensors. Errors: those of MakeMetricField.
  /// @param stop  null: nobody; else kCancelled if it asks to.
  [[nodiscard]] static Result<std::unique_ptr<BackgroundField>> Make(
      const BackgroundMetric& metric, const SizeBounds& bounds, const StopSignal* stop = nullptr);

  /// The same of a mesh and positive definite tensors that need no check and no bounds.
  /// @param stop  null: nobody; else nothing comes back if it asks to.
  [[nodiscard]] static std::unique_ptr<BackgroundField> OfValid(LinkedTriangles mesh,
                                                                std::span<const Metric> tensors,
                                                                const StopSignal* stop = nullptr);

  /// The same from the logarithms of bounded tensors, as Save wrote them: nothing is computed anew.
  /// Nothing where the arrays fit no field.
  [[nodiscard]] static std::unique_ptr<BackgroundField> Restore(
      const std::vector<Vec2>& points, const std::vector<std::array<std::int32_t, 3>>& triangles,
      std::span<const LogMetric> logs);

  /// @par Cost  a walk of a few triangles from a good hint, two exponentials.
  [[nodiscard]] Metric At(Vec2 p, std::int32_t& hint) const override;

  void AtEach(std::span<const Vec2> points, std::span<std::int32_t> hints,
              std::span<Metric> metrics) const override;

  /// Nothing outside the box around the mesh: where a point is not in the mesh, the search for the
  /// nearest one makes a tree of boxes first, which takes longer than to follow a new metric.
  [[nodiscard]] std::optional<Metric> Probe(Vec2 p, std::int32_t& hint) const override;

  void ProbeEach(std::span<Question> questions) const override;
  void ProbeLogEach(std::span<LogQuestion> questions) const override;

  void PrefetchHint(std::int32_t hint) const override { locator_.Prefetch(hint); }
  void PrefetchBehindHint(std::int32_t hint) const override;

  [[nodiscard]] Status Save(ByteWriter& writer) const override;
  [[nodiscard]] std::size_t bytes() const override;

  [[nodiscard]] const TriangleLocator& locator() const { return locator_; }
  /// The logarithms of the tensors, one for each point of locator().
  [[nodiscard]] std::span<const LogMetric> logs() const { return logs_; }
  /// The logarithm of the metric where locator() has found a point to lie.
  [[nodiscard]] LogMetric LogIn(const Location& location) const;

 private:
  BackgroundField(TriangleLocator locator, LargeVector<LogMetric> logs)
      : locator_(std::move(locator)), logs_(std::move(logs)) {}

  template <class Answer, class ToAnswers>
  void AnswerEach(std::span<QuestionFor<Answer>> questions, ToAnswers to_answers) const;
  void PrefetchLogs(const Location& location) const;

  TriangleLocator locator_;
  LargeVector<LogMetric> logs_;
};

}  // namespace pliant
