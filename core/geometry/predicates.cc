#include "core/geometry/predicates.h"

#include <initializer_list>

#include "core/geometry/expansion.h"
#include "core/geometry/wide_integer.h"

namespace pliant::internal {
namespace {

/// True if no product of four coordinate differences can leave the range of a double, not even in
/// its last bit: zero or in [2^-215, 2^245]. The lowest bit of such a number is at least 2^-267,
/// and four of these multiply to more than the smallest subnormal, 2^-1074; the largest sum of four
/// products stays below 2^988, and TwoProduct may still multiply that by 2^27.
bool FitExpansions(std::initializer_list<Vec2> points) {
  const auto fits = [](double coordinate) {
    const double magnitude = std::fabs(coordinate);
    return magnitude == 0 || (magnitude >= 0x1p-215 && magnitude <= 0x1p245);
  };
  for (Vec2 p : points) {
    if (!fits(p.x) || !fits(p.y)) return false;
  }
  return true;
}

// The predicates as polynomials in offsets from one of the points, over any exact kind of number.
template <class Number>
struct Offset {
  Number x;
  Number y;
};

template <class Number>
auto CrossProduct(const Offset<Number>& p, const Offset<Number>& q) {
  return p.x * q.y - p.y * q.x;
}

template <class Number>
int InCircleSign(const Offset<Number>& p, const Offset<Number>& q, const Offset<Number>& r) {
  const auto lift = [](const auto& o) { return o.x * o.x + o.y * o.y; };
  return (CrossProduct(q, r) * lift(p) + CrossProduct(r, p) * lift(q) +
          CrossProduct(p, q) * lift(r))
      .Sign();
}

Offset<Expansion<2>> ExpansionOffset(Vec2 p, Vec2 origin) {
  return {Difference(p.x, origin.x), Difference(p.y, origin.y)};
}

Offset<WideInteger> WideOffset(Vec2 p, Vec2 origin) {
  return {WideInteger::FromDouble(p.x) - WideInteger::FromDouble(origin.x),
          WideInteger::FromDouble(p.y) - WideInteger::FromDouble(origin.y)};
}

}  // namespace

int ExactOrient2d(Vec2 a, Vec2 b, Vec2 c) {
  if (FitExpansions({a, b, c})) {
    return CrossProduct(ExpansionOffset(a, c), ExpansionOffset(b, c)).Sign();
  }
  return CrossProduct(WideOffset(a, c), WideOffset(b, c)).Sign();
}

int ExactInCircle(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  if (FitExpansions({a, b, c, d})) {
    return InCircleSign(ExpansionOffset(a, d), ExpansionOffset(b, d), ExpansionOffset(c, d));
  }
  return InCircleSign(WideOffset(a, d), WideOffset(b, d), WideOffset(c, d));
}

}  // namespace pliant::internal
