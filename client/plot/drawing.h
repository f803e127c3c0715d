#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/geometry/vec2.h"

namespace pliant::plot {

/// Red, green, blue and opacity, each 0 to 1.
struct Color {
  double r = 0;
  double g = 0;
  double b = 0;
  double a = 1;

  friend bool operator==(const Color&, const Color&) = default;
};

inline constexpr Color kInk = {0.13, 0.14, 0.16, 1};
inline constexpr Color kFaintInk = {0.45, 0.47, 0.5, 1};
inline constexpr Color kGridLine = {0.9, 0.905, 0.91, 1};

/// The i-th of 10 colours that are told apart by most eyes; starts again after the last.
[[nodiscard]] Color CategoryColor(std::int64_t i);
/// `color` mixed with white: 0 is the colour, 1 is white.
[[nodiscard]] Color Lighter(Color color, double share);
/// From poor (0, purple) over green to good (1, yellow): equal steps look equal, also in grey.
[[nodiscard]] Color ScaleColor(double value);

struct Stroke {
  Color color = kInk;
  double width = 1;
};

/// Lines and cubic curves. Verbs: M and L take one point, C three, Z none, as in SVG.
struct Path {
  std::string verbs;
  std::vector<Vec2> points;

  void MoveTo(Vec2 p) { Add('M', p); }
  void LineTo(Vec2 p) { Add('L', p); }
  void CurveTo(Vec2 a, Vec2 b, Vec2 p) {
    verbs.push_back('C');
    points.insert(points.end(), {a, b, p});
  }
  void Close() { verbs.push_back('Z'); }
  /// An axis-parallel rectangle between two corners.
  void Rectangle(Vec2 low, Vec2 high);
  /// The image of the unit circle under p = center + x * u + y * v: any ellipse, as four curves
  /// that are off by less than 0.03 % of its size.
  void Ellipse(Vec2 center, Vec2 u, Vec2 v);

 private:
  void Add(char verb, Vec2 p) {
    verbs.push_back(verb);
    points.push_back(p);
  }
};

/// A path that is filled, stroked or both.
struct Shape {
  Path path;
  std::optional<Color> fill;
  std::optional<Stroke> stroke;
};

/// Many separate straight lines of one look, such as the edges of a mesh.
struct Segments {
  std::vector<std::array<Vec2, 2>> lines;
  Stroke stroke;
};

enum class Anchor { kStart, kMiddle, kEnd };
enum class Weight { kNormal, kBold };

struct Text {
  Vec2 at;  ///< On the base line.
  std::string text;
  double size = 12;
  Anchor anchor = Anchor::kStart;
  Weight weight = Weight::kNormal;
  Color color = kInk;
  double rotation_degrees = 0;  ///< Counter-clockwise about `at`.
};

/// Only what lies in the rectangle shows, until the matching EndClip. Clips nest.
struct BeginClip {
  Vec2 low;
  Vec2 high;
};
struct EndClip {};

using Item = std::variant<Shape, Segments, Text, BeginClip, EndClip>;

/// A picture as a list of things to draw, later ones on top, on white. Units: 1/96 inch; y points
/// down. What SVG and PNG are made from.
struct Drawing {
  double width = 0;
  double height = 0;
  std::vector<Item> items;
};

/// The items of `part`, moved by `offset`, at the end of `drawing`.
void Append(Drawing& drawing, Drawing part, Vec2 offset);

/// Panels in a row, top edges aligned, `gap` between them.
[[nodiscard]] Drawing Beside(std::vector<Drawing> panels, double gap = 24);
/// Panels in a column, centred.
[[nodiscard]] Drawing Below(std::vector<Drawing> panels, double gap = 16);

}  // namespace pliant::plot
