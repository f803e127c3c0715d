#include "core/geometry/segments.h"

#include "core/geometry/predicates.h"

namespace pliant {
namespace {

/// Order along a line: by x, and on vertical lines by y.
bool Precedes(Vec2 a, Vec2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); }

Vec2 First(Vec2 a, Vec2 b) { return Precedes(a, b) ? a : b; }
Vec2 Last(Vec2 a, Vec2 b) { return Precedes(a, b) ? b : a; }

}  // namespace

bool IsInsideSegment(Vec2 a, Vec2 b, Vec2 p) {
  return Precedes(First(a, b), p) && Precedes(p, Last(a, b)) && Orient2d(a, b, p) == 0;
}

bool CrossOrOverlap(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  const int side_c = Orient2d(a, b, c);
  const int side_d = Orient2d(a, b, d);
  if (side_c == 0 && side_d == 0) {
    return Precedes(Last(First(a, b), First(c, d)), First(Last(a, b), Last(c, d)));
  }
  return side_c * side_d < 0 && Orient2d(c, d, a) * Orient2d(c, d, b) < 0;
}

bool IsAhead(Vec2 a, Vec2 b, Vec2 p) { return Precedes(a, b) == Precedes(a, p); }

}  // namespace pliant
