#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "client/plot/drawing.h"

namespace pliant::plot {

enum class Scaling { kLinear, kLogarithmic };

/// Maps values onto positions along one side of a picture and knows where its ticks go.
struct Axis {
  double low = 0;
  double high = 1;  ///< > low; both > 0 if logarithmic.
  double from = 0;  ///< Position of low, in units of the drawing.
  double to = 1;    ///< Position of high.
  Scaling scaling = Scaling::kLinear;

  double tick_step = 0;  ///< Between ticks; 0: chosen. Linear axes only.

  [[nodiscard]] double Position(double value) const;
  /// Values for about `count` ticks: multiples of 1, 2 or 5 times a power of ten; powers of ten if
  /// logarithmic. All lie within [low, high].
  [[nodiscard]] std::vector<double> Ticks(int count) const;
};

/// A value for people: 1,234 or 0.25 or 2e-06.
[[nodiscard]] std::string Label(double value);

/// The number with commas between thousands.
[[nodiscard]] std::string WithThousands(std::string_view number);

/// The frame around two axes with ticks, their labels and faint grid lines.
struct Frame {
  Axis x;
  Axis y;
  std::string x_label = {};
  std::string y_label = {};
  int x_tick_count = 6;
  int y_tick_count = 5;
};
/// Goes below the data.
void DrawGrid(const Frame& frame, Drawing& drawing);
/// Goes above the data.
void DrawFrame(const Frame& frame, Drawing& drawing);

}  // namespace pliant::plot
