#include "client/plot/drawing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

namespace pliant::plot {
namespace {

constexpr Color FromHex(std::uint32_t rgb) {
  return {static_cast<double>(rgb >> 16 & 255) / 255, static_cast<double>(rgb >> 8 & 255) / 255,
          static_cast<double>(rgb & 255) / 255, 1};
}

struct Mover {
  Vec2 offset;

  void operator()(Shape& shape) const {
    for (Vec2& p : shape.path.points) p += offset;
  }
  void operator()(Segments& segments) const {
    for (auto& line : segments.lines) {
      line[0] += offset;
      line[1] += offset;
    }
  }
  void operator()(Text& text) const { text.at += offset; }
  void operator()(BeginClip& clip) const {
    clip.low += offset;
    clip.high += offset;
  }
  void operator()(EndClip&) const {}
};

}  // namespace

Color CategoryColor(std::int64_t i) {
  constexpr std::array<std::uint32_t, 10> kColors = {0x2f6db5, 0xd1495b, 0x2e8b57, 0xe08e1b,
                                                     0x7b52ab, 0x17a2a2, 0x8c5a3c, 0xd66fa8,
                                                     0x6b7a2a, 0x5a6472};
  constexpr std::int64_t kCount = kColors.size();
  return FromHex(kColors[static_cast<std::size_t>(((i % kCount) + kCount) % kCount)]);
}

Color Lighter(Color color, double share) {
  const auto mix = [share](double c) { return c + (1 - c) * share; };
  return {mix(color.r), mix(color.g), mix(color.b), color.a};
}

Color ScaleColor(double value) {
  // Samples of the colour map "viridis", which is in the public domain (CC0).
  constexpr std::array<std::uint32_t, 6> kSamples = {0x440154, 0x414487, 0x2a788e,
                                                     0x22a884, 0x7ad151, 0xfde725};
  const double place = std::clamp(value, 0.0, 1.0) * (kSamples.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(place), kSamples.size() - 2);
  const double t = place - static_cast<double>(i);
  const Color a = FromHex(kSamples[i]);
  const Color b = FromHex(kSamples[i + 1]);
  return {a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b), 1};
}

void Path::Rectangle(Vec2 low, Vec2 high) {
  MoveTo(low);
  LineTo({high.x, low.y});
  LineTo(high);
  LineTo({low.x, high.y});
  Close();
}

void Path::Ellipse(Vec2 center, Vec2 u, Vec2 v) {
  // The handle length that makes the middle of each quarter lie on the circle.
  const double k = 4.0 / 3 * (std::sqrt(2.0) - 1);
  MoveTo(center + u);
  CurveTo(center + u + k * v, center + v + k * u, center + v);
  CurveTo(center + v - k * u, center - u + k * v, center - u);
  CurveTo(center - u - k * v, center - v - k * u, center - v);
  CurveTo(center - v + k * u, center + u - k * v, center + u);
  Close();
}

void Append(Drawing& drawing, Drawing part, Vec2 offset) {
  for (Item& item : part.items) std::visit(Mover{offset}, item);
  std::move(part.items.begin(), part.items.end(), std::back_inserter(drawing.items));
}

Drawing Beside(std::vector<Drawing> panels, double gap) {
  Drawing row;
  for (Drawing& panel : panels) {
    const double left = row.width > 0 ? row.width + gap : 0;
    row.width = left + panel.width;
    row.height = std::max(row.height, panel.height);
    Append(row, std::move(panel), {left, 0});
  }
  return row;
}

Drawing Below(std::vector<Drawing> panels, double gap) {
  Drawing column;
  for (const Drawing& panel : panels) column.width = std::max(column.width, panel.width);
  for (Drawing& panel : panels) {
    const double top = column.height > 0 ? column.height + gap : 0;
    const double left = 0.5 * (column.width - panel.width);
    column.height = top + panel.height;
    Append(column, std::move(panel), {left, top});
  }
  return column;
}

}  // namespace pliant::plot
