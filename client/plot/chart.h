#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/plot/drawing.h"

namespace pliant::plot {

/// Counts in bins of equal width from `low` to `high`.
struct Histogram {
  std::string title = {};
  std::string x_label = {};
  double low = 0;
  double high = 1;
  std::vector<std::int64_t> counts = {};
  std::optional<double> ideal = {};  ///< Marked by a line: 60 degrees, length 1.
};

struct ChartSize {
  double width = 420;
  double height = 280;
};

[[nodiscard]] Drawing PlotHistogram(const Histogram& histogram, const ChartSize& size = {});

/// The two panels of the paper's figures 11 and 13: normalized angles from 0 to 180 degrees and
/// normalized edge lengths from 0 to `length_max`.
struct QualityHistograms {
  std::span<const std::int64_t> angle_counts = {};
  std::span<const std::int64_t> length_counts = {};
  double length_max = 2;
};
[[nodiscard]] Drawing PlotQuality(const QualityHistograms& histograms, const ChartSize& size = {});

/// One line of a chart: points (x, y), both > 0.
struct Series {
  std::string name = {};
  std::vector<Vec2> points = {};
};
struct ScalingChart {
  std::string title = {};
  std::string x_label = {};
  std::string y_label = {};
  std::vector<Series> series = {};
};

/// The least-squares line log y = log factor + slope log x.
struct PowerLaw {
  double factor = 1;
  double slope = 1;
};
/// @pre points.size() >= 2 with different x, all coordinates > 0
[[nodiscard]] PowerLaw FitPowerLaw(std::span<const Vec2> points);

/// Both axes logarithmic; points, the fitted power law and its slope in the legend (figure 12).
/// Points that are not positive have no place and are left out.
[[nodiscard]] Drawing PlotScaling(const ScalingChart& chart, const ChartSize& size = {});

}  // namespace pliant::plot
