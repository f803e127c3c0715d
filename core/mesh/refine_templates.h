#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace pliant {

/// What a triangle becomes when some of its sides are split: two, three or four triangles.
///
/// The six points of the parent are its corners, 0 to 2, and the middles of the sides opposite
/// them, 3 to 5. A side runs counter-clockwise, from corner s + 1 to corner s + 2; the half of it
/// that begins at corner s + 1, or the whole side where it is not split, is half 0.
struct RefineTemplate {
  /// Counts of sides and bits: bit i of a code is set if side i is split; this bit chooses, where
  /// two sides are, the diagonal that begins at the corner behind the whole side's first end.
  static constexpr std::size_t kOtherDiagonal = 8;
  static constexpr std::size_t kCodeCount = 16;

  /// What lies behind a side of a child: another child, by its number, or a half of a parent's
  /// side, as kOutside + 2 * side + half.
  static constexpr std::uint8_t kOutside = 4;

  std::size_t count = 0;                                  ///< Children.
  std::array<std::array<std::uint8_t, 3>, 4> points{};    ///< Of each child, counter-clockwise.
  std::array<std::array<std::uint8_t, 3>, 4> behind{};    ///< Each side of each child.
  std::array<std::array<std::uint8_t, 2>, 3> child_at{};  ///< The child at each half of each side.
  std::array<std::uint8_t, 6> child_of_point{};           ///< One that has the point.
};

namespace internal {

constexpr RefineTemplate MakeRefineTemplate(std::size_t code) {
  RefineTemplate result;
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    result.points[result.count++] = {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b),
                                     static_cast<std::uint8_t>(c)};
  };
  const auto is_split = [code](std::size_t side) { return ((code >> side) & 1) != 0; };
  const int split_count = is_split(0) + is_split(1) + is_split(2);
  // The odd side out: the only split one, or the only whole one.
  std::size_t i = 0;
  while (i < 2 && is_split(i) != (split_count == 1)) ++i;
  const std::size_t j = (i + 1) % 3;
  const std::size_t k = (i + 2) % 3;
  if (split_count == 0) {
    add(0, 1, 2);
  } else if (split_count == 1) {
    add(i, j, 3 + i);
    add(i, 3 + i, k);
  } else if (split_count == 3) {
    add(0, 5, 4);
    add(5, 1, 3);
    add(4, 3, 2);
    add(3, 4, 5);
  } else {
    add(i, 3 + k, 3 + j);
    if ((code & RefineTemplate::kOtherDiagonal) == 0) {
      add(3 + k, j, k);
      add(3 + k, k, 3 + j);
    } else {
      add(3 + k, j, 3 + j);
      add(j, k, 3 + j);
    }
  }
  return result;
}

/// The parent's side along which a child's side lies, as RefineTemplate::behind has it; 0 for a
/// side between children.
constexpr std::uint8_t OutsideOf(std::size_t code, std::size_t from, std::size_t to) {
  for (std::size_t s = 0; s < 3; ++s) {
    const std::size_t a = (s + 1) % 3;
    const std::size_t b = (s + 2) % 3;
    const auto half = [s](std::size_t h) {
      return static_cast<std::uint8_t>(RefineTemplate::kOutside + 2 * s + h);
    };
    if (((code >> s) & 1) == 0) {
      if (from == a && to == b) return half(0);
    } else {
      if (from == a && to == 3 + s) return half(0);
      if (from == 3 + s && to == b) return half(1);
    }
  }
  return 0;
}

constexpr void LinkRefineTemplate(std::size_t code, RefineTemplate& result) {
  for (std::size_t c = 0; c < result.count; ++c) {
    for (std::size_t side = 0; side < 3; ++side) {
      const auto from = result.points[c][(side + 1) % 3];
      const auto to = result.points[c][(side + 2) % 3];
      result.child_of_point[result.points[c][side]] = static_cast<std::uint8_t>(c);
      const std::uint8_t outside = OutsideOf(code, from, to);
      if (outside != 0) {
        const std::size_t half = outside - RefineTemplate::kOutside;
        result.behind[c][side] = outside;
        result.child_at[half / 2][half % 2] = static_cast<std::uint8_t>(c);
        continue;
      }
      for (std::size_t d = 0; d < result.count; ++d) {
        for (std::size_t k = 0; k < 3; ++k) {
          if (result.points[d][(k + 1) % 3] == to && result.points[d][(k + 2) % 3] == from) {
            result.behind[c][side] = static_cast<std::uint8_t>(d);
          }
        }
      }
    }
  }
}

constexpr std::array<RefineTemplate, RefineTemplate::kCodeCount> MakeRefineTemplates() {
  std::array<RefineTemplate, RefineTemplate::kCodeCount> templates;
  for (std::size_t code = 0; code < templates.size(); ++code) {
    templates[code] = MakeRefineTemplate(code);
    LinkRefineTemplate(code, templates[code]);
  }
  return templates;
}

}  // namespace internal

inline constexpr std::array<RefineTemplate, RefineTemplate::kCodeCount> kRefineTemplates =
    internal::MakeRefineTemplates();

}  // namespace pliant
