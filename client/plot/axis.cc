#include "client/plot/axis.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>

namespace pliant::plot {
namespace {

constexpr double kTickSize = 4;
constexpr double kLabelSize = 11;

/// The smallest of 1, 2, 5 times a power of ten that is not below `step`.
double RoundStep(double step) {
  const double power = std::pow(10, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= step) return factor * power;
  }
  return 10 * power;
}

}  // namespace

double Axis::Position(double value) const {
  const double share = scaling == Scaling::kLinear ? (value - low) / (high - low)
                                                   : std::log(value / low) / std::log(high / low);
  return from + share * (to - from);
}

std::vector<double> Axis::Ticks(int count) const {
  std::vector<double> ticks;
  // Room for rounding, so that a tick at the end of the axis is not lost.
  constexpr double kSlack = 1e-9;
  if (scaling == Scaling::kLogarithmic) {
    const double last = std::floor(std::log10(high) + kSlack);
    for (double e = std::ceil(std::log10(low) - kSlack); e <= last; ++e) {
      ticks.push_back(std::pow(10, e));
    }
    return ticks;
  }
  const double step = tick_step > 0 ? tick_step : RoundStep((high - low) / count);
  const double first = std::ceil(low / step - kSlack);
  const double last = std::floor(high / step + kSlack);
  // Adding 0 turns -0 into 0.
  for (double i = first; i <= last; ++i) ticks.push_back(i * step + 0.0);
  return ticks;
}

std::string Label(double value) {
  std::array<char, 64> buffer;
  const double magnitude = std::abs(value);
  const bool is_plain = value == 0 || (magnitude >= 1e-4 && magnitude < 1e9);
  const auto result = is_plain
                          ? std::to_chars(buffer.data(), buffer.data() + buffer.size(),
                                          std::round(value * 1e6) / 1e6, std::chars_format::fixed)
                          : std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                          std::chars_format::general, 3);
  const std::string text(buffer.data(), result.ptr);
  return is_plain && magnitude >= 1000 ? WithThousands(text) : text;
}

std::string WithThousands(std::string_view number) {
  const std::size_t begin = number.starts_with('-') ? 1 : 0;
  const std::size_t end = std::min(number.find('.'), number.size());
  std::string text;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (i > begin && i < end && (end - i) % 3 == 0) text.push_back(',');
    text.push_back(number[i]);
  }
  return text;
}

void DrawGrid(const Frame& frame, Drawing& drawing) {
  Segments grid{.lines = {}, .stroke = {.color = kGridLine, .width = 0.8}};
  for (const double x : frame.x.Ticks(frame.x_tick_count)) {
    const double at = frame.x.Position(x);
    grid.lines.push_back({Vec2{at, frame.y.from}, Vec2{at, frame.y.to}});
  }
  for (const double y : frame.y.Ticks(frame.y_tick_count)) {
    const double at = frame.y.Position(y);
    grid.lines.push_back({Vec2{frame.x.from, at}, Vec2{frame.x.to, at}});
  }
  drawing.items.emplace_back(grid);
}

void DrawFrame(const Frame& frame, Drawing& drawing) {
  Shape box{.path = {}, .fill = {}, .stroke = Stroke{.color = kInk, .width = 0.9}};
  box.path.Rectangle({frame.x.from, frame.y.to}, {frame.x.to, frame.y.from});
  drawing.items.emplace_back(box);
  Segments ticks{.lines = {}, .stroke = {.color = kInk, .width = 0.9}};
  for (const double x : frame.x.Ticks(frame.x_tick_count)) {
    const double at = frame.x.Position(x);
    ticks.lines.push_back({Vec2{at, frame.y.from}, Vec2{at, frame.y.from + kTickSize}});
    drawing.items.emplace_back(Text{.at = {at, frame.y.from + kTickSize + 12},
                                    .text = Label(x),
                                    .size = kLabelSize,
                                    .anchor = Anchor::kMiddle});
  }
  double widest = 0;
  for (const double y : frame.y.Ticks(frame.y_tick_count)) {
    const double at = frame.y.Position(y);
    ticks.lines.push_back({Vec2{frame.x.from, at}, Vec2{frame.x.from - kTickSize, at}});
    const std::string label = Label(y);
    widest = std::max(widest, 0.62 * kLabelSize * static_cast<double>(label.size()));
    drawing.items.emplace_back(Text{.at = {frame.x.from - kTickSize - 4, at + 4},
                                    .text = label,
                                    .size = kLabelSize,
                                    .anchor = Anchor::kEnd});
  }
  drawing.items.emplace_back(ticks);
  drawing.items.emplace_back(Text{.at = {0.5 * (frame.x.from + frame.x.to), frame.y.from + 36},
                                  .text = frame.x_label,
                                  .anchor = Anchor::kMiddle});
  drawing.items.emplace_back(
      Text{.at = {frame.x.from - widest - 16, 0.5 * (frame.y.from + frame.y.to)},
           .text = frame.y_label,
           .anchor = Anchor::kMiddle,
           .rotation_degrees = 90});
}

}  // namespace pliant::plot
