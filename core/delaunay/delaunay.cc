#include "core/delaunay/delaunay.h"

#include <algorithm>
#include <utility>

#include "core/base/as_index.h"
#include "core/delaunay/insertion_order.h"
#include "core/geometry/predicates.h"
#include "core/geometry/segments.h"

namespace pliant {
namespace {

using Triangle = HullTriangulation::Triangle;
constexpr std::int32_t kGhost = HullTriangulation::kGhost;

/// Inserts points one by one: removes the triangles whose circle holds the point and fills the
/// hole with a fan around it.
class Builder {
 public:
  explicit Builder(std::span<const Vec2> points)
      : points_(points), fan_triangle_(points.size() + 1, -1) {
    triangles_.reserve(2 * points.size() + 2);
    marks_.reserve(2 * points.size() + 2);
  }

  void Start(const std::array<std::int32_t, 3>& corners);
  void Insert(std::int32_t point);
  std::vector<Triangle> Finish() && { return std::move(triangles_); }

 private:
  /// A side of the hole, seen from inside, and the triangle beyond it.
  struct Rim {
    std::int32_t from;
    std::int32_t to;
    std::int32_t beyond;
    std::size_t side;
  };

  [[nodiscard]] Vec2 Point(std::int32_t i) const { return points_[AsIndex(i)]; }
  [[nodiscard]] std::int32_t Find(Vec2 p) const;
  [[nodiscard]] bool InConflict(const Triangle& triangle, Vec2 p) const;
  void CollectHole(std::int32_t start, Vec2 p);
  void FillHole(std::int32_t point);
  std::int32_t NewTriangle();
  /// The fan triangle whose rim starts at a point or at the ghost.
  std::int32_t& FanTriangle(std::int32_t point) { return fan_triangle_[AsIndex(point + 1)]; }

  std::span<const Vec2> points_;
  std::vector<Triangle> triangles_;
  std::vector<std::int32_t> marks_;  ///< The last point whose hole a triangle belonged to.
  std::vector<std::int32_t> fan_triangle_;
  std::vector<std::int32_t> hole_;
  std::vector<Rim> rims_;
  std::int32_t last_ = 0;  ///< Where the next search begins: not a ghost.
};

/// The first triangle and the three ghosts around it.
void Builder::Start(const std::array<std::int32_t, 3>& corners) {
  const auto [a, b, c] = corners;
  triangles_ = {{.points = {a, b, c}, .neighbors = {1, 2, 3}, .segments = {-1, -1, -1}},
                {.points = {kGhost, c, b}, .neighbors = {0, 3, 2}, .segments = {-1, -1, -1}},
                {.points = {kGhost, a, c}, .neighbors = {0, 1, 3}, .segments = {-1, -1, -1}},
                {.points = {kGhost, b, a}, .neighbors = {0, 2, 1}, .segments = {-1, -1, -1}}};
  marks_.assign(4, -1);
}

void Builder::Insert(std::int32_t point) {
  const Vec2 p = Point(point);
  const std::int32_t start = Find(p);
  marks_[AsIndex(start)] = point;
  hole_.assign(1, start);
  rims_.clear();
  CollectHole(start, p);
  FillHole(point);
}

/// A visibility walk, which ends in every Delaunay triangulation whatever side it tries first
/// [Devillers2002]. A ghost that it reaches has p beyond its edge of the hull.
std::int32_t Builder::Find(Vec2 p) const {
  std::int32_t from = -1;
  std::int32_t at = last_;
  for (;;) {
    const Triangle& triangle = triangles_[AsIndex(at)];
    if (HullTriangulation::IsGhost(triangle)) return at;
    std::int32_t next = -1;
    for (std::size_t i = 0; i < 3 && next < 0; ++i) {
      if (triangle.neighbors[i] == from) continue;
      const Vec2 a = Point(triangle.points[NextCorner(i)]);
      const Vec2 b = Point(triangle.points[LastCorner(i)]);
      if (Orient2d(a, b, p) < 0) next = triangle.neighbors[i];
    }
    if (next < 0) return at;
    from = at;
    at = next;
  }
}

/// True if p lies strictly inside the circle of the triangle. The circle of a ghost is the open
/// half plane beyond its edge of the hull, and the inside of that edge.
bool Builder::InConflict(const Triangle& triangle, Vec2 p) const {
  const std::size_t ghost = HullTriangulation::CornerAt(triangle, kGhost);
  if (ghost == 3) {
    return InCircle(Point(triangle.points[0]), Point(triangle.points[1]), Point(triangle.points[2]),
                    p) > 0;
  }
  const Vec2 a = Point(triangle.points[NextCorner(ghost)]);
  const Vec2 b = Point(triangle.points[LastCorner(ghost)]);
  const int side = Orient2d(a, b, p);
  return side > 0 || (side == 0 && IsInsideSegment(a, b, p));
}

/// Gathers the triangles in conflict with p, which are connected, and the rim around them.
void Builder::CollectHole(std::int32_t start, Vec2 p) {
  const std::int32_t mark = marks_[AsIndex(start)];
  for (std::size_t k = 0; k < hole_.size(); ++k) {
    const std::int32_t at = hole_[k];
    const Triangle& triangle = triangles_[AsIndex(at)];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t beyond = triangle.neighbors[i];
      if (marks_[AsIndex(beyond)] == mark) continue;
      const Triangle& other = triangles_[AsIndex(beyond)];
      if (InConflict(other, p)) {
        marks_[AsIndex(beyond)] = mark;
        hole_.push_back(beyond);
      } else {
        rims_.push_back({.from = triangle.points[NextCorner(i)],
                         .to = triangle.points[LastCorner(i)],
                         .beyond = beyond,
                         .side = HullTriangulation::CornerOpposite(other, at)});
      }
    }
  }
}

void Builder::FillHole(std::int32_t point) {
  std::size_t reused = 0;
  for (const Rim& rim : rims_) {
    const std::int32_t slot = reused < hole_.size() ? hole_[reused++] : NewTriangle();
    triangles_[AsIndex(slot)] = {.points = {point, rim.from, rim.to},
                                 .neighbors = {rim.beyond, -1, -1},
                                 .segments = {-1, -1, -1}};
    triangles_[AsIndex(rim.beyond)].neighbors[rim.side] = slot;
    FanTriangle(rim.from) = slot;
    if (rim.from != kGhost && rim.to != kGhost) last_ = slot;
  }
  for (const Rim& rim : rims_) {
    const std::int32_t slot = FanTriangle(rim.from);
    const std::int32_t next = FanTriangle(rim.to);
    triangles_[AsIndex(slot)].neighbors[1] = next;
    triangles_[AsIndex(next)].neighbors[2] = slot;
  }
}

std::int32_t Builder::NewTriangle() {
  triangles_.emplace_back();
  marks_.push_back(-1);
  return static_cast<std::int32_t>(triangles_.size() - 1);
}

/// Moves three points that are not collinear to the front, counter-clockwise.
bool PutTriangleFirst(std::vector<std::int32_t>& order, std::span<const Vec2> points) {
  if (order.size() < 3) return false;
  const auto side = [&](std::int32_t c) {
    return Orient2d(points[AsIndex(order[0])], points[AsIndex(order[1])], points[AsIndex(c)]);
  };
  const auto third =
      std::find_if(order.begin() + 2, order.end(), [&](std::int32_t c) { return side(c) != 0; });
  if (third == order.end()) return false;
  std::rotate(order.begin() + 2, third, third + 1);
  if (side(order[2]) < 0) std::swap(order[0], order[1]);
  return true;
}

}  // namespace

std::size_t HullTriangulation::CornerAt(const Triangle& triangle, std::int32_t point) {
  std::size_t i = 0;
  while (i < 3 && triangle.points[i] != point) ++i;
  return i;
}

std::size_t HullTriangulation::CornerOpposite(const Triangle& triangle, std::int32_t neighbor) {
  std::size_t i = 0;
  while (i < 3 && triangle.neighbors[i] != neighbor) ++i;
  return i;
}

HullTriangulation DelaunayTriangulation(std::span<const Vec2> points, const StopSignal* stop) {
  HullTriangulation result;
  std::vector<std::int32_t> order = InsertionOrder(points, stop);
  if (!PutTriangleFirst(order, points)) return result;
  Builder builder(points);
  builder.Start({order[0], order[1], order[2]});
  StopPoll stopped(stop);
  for (std::size_t k = 3; k < order.size() && !stopped(); ++k) builder.Insert(order[k]);
  result.triangles = std::move(builder).Finish();
  result.triangle_of_point.assign(points.size(), -1);
  for (std::size_t t = 0; t < result.triangles.size(); ++t) {
    if (HullTriangulation::IsGhost(result.triangles[t])) continue;
    for (std::int32_t point : result.triangles[t].points) {
      result.triangle_of_point[AsIndex(point)] = static_cast<std::int32_t>(t);
    }
  }
  return result;
}

}  // namespace pliant
