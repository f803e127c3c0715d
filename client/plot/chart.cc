#include "client/plot/chart.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>

#include "client/plot/axis.h"

namespace pliant::plot {
namespace {

constexpr double kLeft = 74;
constexpr double kRight = 34;  // Half a label of the last tick.
constexpr double kTop = 34;
constexpr double kBottom = 46;

Frame MakeFrame(const ChartSize& size) {
  Frame frame;
  frame.x.from = kLeft;
  frame.x.to = size.width - kRight;
  frame.y.from = size.height - kBottom;
  frame.y.to = kTop;
  return frame;
}

void DrawTitle(const std::string& title, const Frame& frame, Drawing& drawing) {
  drawing.items.emplace_back(Text{.at = {0.5 * (frame.x.from + frame.x.to), kTop - 14},
                                  .text = title,
                                  .size = 13,
                                  .anchor = Anchor::kMiddle,
                                  .weight = Weight::kBold});
}

std::vector<Vec2> Positive(const std::vector<Vec2>& points) {
  std::vector<Vec2> positive;
  for (const Vec2 p : points) {
    if (p.x > 0 && p.y > 0 && IsFinite(p)) positive.push_back(p);
  }
  return positive;
}

/// Both axes to the powers of ten around all points.
void SpanPowersOfTen(const std::vector<Series>& series, Frame& frame) {
  frame.x.scaling = frame.y.scaling = Scaling::kLogarithmic;
  frame.x.low = frame.y.low = INFINITY;
  frame.x.high = frame.y.high = 0;
  for (const Series& s : series) {
    for (const Vec2 p : s.points) {
      frame.x.low = std::min(frame.x.low, p.x);
      frame.x.high = std::max(frame.x.high, p.x);
      frame.y.low = std::min(frame.y.low, p.y);
      frame.y.high = std::max(frame.y.high, p.y);
    }
  }
  for (Axis* axis : {&frame.x, &frame.y}) {
    if (axis->high == 0) axis->low = axis->high = 1;
    axis->low = std::pow(10, std::floor(std::log10(axis->low)));
    axis->high = std::pow(10, std::ceil(std::log10(axis->high)));
    if (axis->low >= axis->high) axis->high = 10 * axis->low;
  }
}

std::string ThreeDigits(double value) {
  std::array<char, 32> buffer;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                    std::chars_format::fixed, 2);
  return {buffer.data(), result.ptr};
}

bool HasFit(const std::vector<Vec2>& points) {
  return std::any_of(points.begin(), points.end(),
                     [&points](Vec2 p) { return p.x != points.front().x; });
}

void DrawFit(const std::vector<Vec2>& points, Color color, const Frame& frame, Drawing& drawing) {
  const PowerLaw law = FitPowerLaw(points);
  const auto [first, last] =
      std::minmax_element(points.begin(), points.end(), [](Vec2 a, Vec2 b) { return a.x < b.x; });
  Segments line{.lines = {}, .stroke = {.color = Lighter(color, 0.35), .width = 1.4}};
  const auto at = [&frame, &law](double x) {
    return Vec2{frame.x.Position(x), frame.y.Position(law.factor * std::pow(x, law.slope))};
  };
  line.lines.push_back({at(first->x), at(last->x)});
  drawing.items.emplace_back(line);
}

void DrawPoints(const std::vector<Vec2>& points, Color color, const Frame& frame,
                Drawing& drawing) {
  Shape dots{.path = {}, .fill = color, .stroke = Stroke{.color = {1, 1, 1, 1}, .width = 0.8}};
  for (const Vec2 p : points) {
    dots.path.Ellipse({frame.x.Position(p.x), frame.y.Position(p.y)}, {3.6, 0}, {0, 3.6});
  }
  drawing.items.emplace_back(dots);
}

void DrawLegendLine(const std::string& text, Color color, Vec2 at, Drawing& drawing) {
  Shape dot{.path = {}, .fill = color, .stroke = {}};
  dot.path.Ellipse({at.x, at.y - 4}, {3.6, 0}, {0, 3.6});
  drawing.items.emplace_back(dot);
  drawing.items.emplace_back(Text{.at = {at.x + 10, at.y}, .text = text, .size = 11});
}

}  // namespace

Drawing PlotHistogram(const Histogram& histogram, const ChartSize& size) {
  Drawing drawing{.width = size.width, .height = size.height, .items = {}};
  Frame frame = MakeFrame(size);
  frame.x_label = histogram.x_label;
  frame.y_label = "count";
  frame.x.low = histogram.low;
  frame.x.high = histogram.high;
  std::int64_t largest = 1;
  for (const std::int64_t count : histogram.counts) largest = std::max(largest, count);
  frame.y.high = 1.08 * static_cast<double>(largest);
  // Multiples of 30 degrees are what people expect on an axis of angles.
  if (histogram.low == 0 && histogram.high == 180) frame.x.tick_step = 30;
  DrawGrid(frame, drawing);

  const auto bin_count = static_cast<double>(std::max<std::size_t>(histogram.counts.size(), 1));
  const double bin_width = (frame.x.to - frame.x.from) / bin_count;
  const double gap = bin_width > 4 ? 0.5 : 0;
  Shape bars{.path = {}, .fill = Lighter(CategoryColor(0), 0.15), .stroke = {}};
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    if (histogram.counts[i] <= 0) continue;
    const double left = frame.x.from + static_cast<double>(i) * bin_width;
    const double top = frame.y.Position(static_cast<double>(histogram.counts[i]));
    bars.path.Rectangle({left + gap, top}, {left + bin_width - gap, frame.y.from});
  }
  drawing.items.emplace_back(bars);
  if (histogram.ideal.has_value()) {
    const double at = frame.x.Position(*histogram.ideal);
    Segments mark{.lines = {}, .stroke = {.color = CategoryColor(1), .width = 1.2}};
    mark.lines.push_back({Vec2{at, frame.y.from}, Vec2{at, frame.y.to}});
    drawing.items.emplace_back(mark);
  }
  DrawFrame(frame, drawing);
  DrawTitle(histogram.title, frame, drawing);
  return drawing;
}

Drawing PlotQuality(const QualityHistograms& histograms, const ChartSize& size) {
  const Histogram angles{.title = "Normalized angle",
                         .x_label = "degrees",
                         .low = 0,
                         .high = 180,
                         .counts = {histograms.angle_counts.begin(), histograms.angle_counts.end()},
                         .ideal = 60};
  const Histogram lengths{
      .title = "Normalized edge length",
      .x_label = "length in the metric",
      .low = 0,
      .high = histograms.length_max,
      .counts = {histograms.length_counts.begin(), histograms.length_counts.end()},
      .ideal = 1};
  return Beside({PlotHistogram(angles, size), PlotHistogram(lengths, size)});
}

PowerLaw FitPowerLaw(std::span<const Vec2> points) {
  const auto n = static_cast<double>(points.size());
  Vec2 mean;
  for (const Vec2 p : points) mean += Vec2{std::log(p.x) / n, std::log(p.y) / n};
  double xx = 0;
  double xy = 0;
  for (const Vec2 p : points) {
    const Vec2 d = Vec2{std::log(p.x), std::log(p.y)} - mean;
    xx += d.x * d.x;
    xy += d.x * d.y;
  }
  const double slope = xy / xx;
  return {.factor = std::exp(mean.y - slope * mean.x), .slope = slope};
}

Drawing PlotScaling(const ScalingChart& chart, const ChartSize& size) {
  Drawing drawing{.width = size.width, .height = size.height, .items = {}};
  std::vector<Series> series = chart.series;
  for (Series& s : series) s.points = Positive(s.points);
  Frame frame = MakeFrame(size);
  frame.x_label = chart.x_label;
  frame.y_label = chart.y_label;
  SpanPowersOfTen(series, frame);
  DrawGrid(frame, drawing);
  // Below the points, because the first and the last often lie on the frame.
  DrawFrame(frame, drawing);
  Vec2 legend = {frame.x.from + 14, frame.y.to + 20};
  for (std::size_t i = 0; i < series.size(); ++i) {
    const Color color = CategoryColor(static_cast<std::int64_t>(i));
    const std::vector<Vec2>& points = series[i].points;
    std::string text = series[i].name;
    if (HasFit(points)) {
      DrawFit(points, color, frame, drawing);
      text += ": slope " + ThreeDigits(FitPowerLaw(points).slope);
    }
    DrawPoints(points, color, frame, drawing);
    DrawLegendLine(text, color, legend, drawing);
    legend.y += 17;
  }
  DrawTitle(chart.title, frame, drawing);
  return drawing;
}

}  // namespace pliant::plot
