#include "core/pliant/boundary_gaps.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/predicates.h"

namespace pliant {
namespace {

/// Rounding must not let a ray slip between two segments that share an end.
constexpr double kOverlap = 1e-9;

}  // namespace

std::vector<BoundaryGaps::Line> BoundaryGaps::LinesOf(const Mesh& mesh) {
  std::vector<Line> lines;
  lines.reserve(mesh.segments().size());
  for (const SegmentRecord& segment : mesh.segments()) {
    if (segment.is_line()) {
      lines.push_back({segment.a, segment.b, mesh.position(segment.a), mesh.position(segment.b)});
    } else {
      lines.push_back({});
    }
  }
  return lines;
}

BoundaryGaps::BoundaryGaps(const Mesh& mesh) : lines_(LinesOf(mesh)) {
  std::vector<BoundingBox> boxes;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    const Line& line = lines_[i];
    if (!line.b.valid()) continue;
    boxed_.push_back(static_cast<std::int32_t>(i));
    boxes.push_back({{std::min(line.from.x, line.to.x), std::min(line.from.y, line.to.y)},
                     {std::max(line.from.x, line.to.x), std::max(line.from.y, line.to.y)}});
  }
  tree_ = BoxTree(boxes);
}

bool BoundaryGaps::IsOf(const Mesh& mesh) const { return lines_ == LinesOf(mesh); }

double BoundaryGaps::WidthAt(const Mesh& mesh, VertexId vertex, double reach) const {
  double width = kNone;
  for (EdgeId id = mesh.vertex(vertex).edge; id.valid();) {
    const EdgeRecord& edge = mesh.edge(id);
    const Line& line = lines_[static_cast<std::size_t>(edge.segment)];
    const Vec2 along = line.to - line.from;
    const double length = Length(along);
    const Vec2 left = {-along.y / length, along.x / length};
    const TriangleRecord& triangle = mesh.triangle(edge.triangle);
    for (int corner = 0; corner < 3; ++corner) {
      const VertexId apex = triangle.vertices[static_cast<std::size_t>(corner)];
      if (apex == edge.vertices[0] || apex == edge.vertices[1]) continue;
      const bool is_left = Orient2d(mesh.position(edge.vertices[0]),
                                    mesh.position(edge.vertices[1]), mesh.position(apex)) > 0;
      const bool both = triangle.neighbors[static_cast<std::size_t>(corner)].valid();
      for (const bool to_left : {true, false}) {
        if (to_left != is_left && !both) continue;
        const Ray ray{mesh.position(vertex), to_left ? left : Vec2{-left.x, -left.y}, reach};
        const double hit = FirstHit(ray, line);
        if (hit < reach) width = std::min(width, std::max(hit, kFloor * reach));
      }
    }
    id = edge.next[edge.vertices[0] == vertex ? 0 : 1];
  }
  return width;
}

double BoundaryGaps::FirstHit(const Ray& ray, const Line& own) const {
  double nearest = ray.length;
  tree_.ForEachNear(ray.origin, [&](std::int32_t box) {
    const Line& line = lines_[static_cast<std::size_t>(boxed_[static_cast<std::size_t>(box)])];
    const bool is_joined = line.a == own.a || line.a == own.b || line.b == own.a || line.b == own.b;
    const Vec2 along = line.to - line.from;
    const double slope = Cross(ray.direction, along);
    if (is_joined || slope == 0) return nearest * nearest;
    const Vec2 start = line.from - ray.origin;
    const double distance = Cross(start, along) / slope;
    const double share = Cross(start, ray.direction) / slope;
    if (distance > 0 && share >= -kOverlap && share <= 1 + kOverlap) {
      nearest = std::min(nearest, distance);
    }
    return nearest * nearest;
  });
  return nearest;
}

}  // namespace pliant
