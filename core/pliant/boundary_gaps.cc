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

BoundaryGaps::Line BoundaryGaps::LineOf(const Mesh& mesh, const SegmentRecord& segment) {
  if (!segment.is_line()) return {};
  return {segment.a, segment.b, mesh.position(segment.a), mesh.position(segment.b)};
}

BoundaryGaps::BoundaryGaps(const Mesh& mesh) {
  lines_.reserve(mesh.segments().size());
  for (const SegmentRecord& segment : mesh.segments()) lines_.push_back(LineOf(mesh, segment));
}

bool BoundaryGaps::Differs(const Mesh& mesh, std::int32_t segment) const {
  const auto i = static_cast<std::size_t>(segment);
  return i >= lines_.size() || lines_[i] != LineOf(mesh, mesh.segments()[i]);
}

std::optional<BoundingBox> BoundaryGaps::DifferenceTo(const Mesh& mesh) const {
  std::optional<BoundingBox> box;
  const auto grow = [&](const Line& line) {
    if (!line.b.valid()) return;
    if (!box) box = {line.from, line.from};
    box = BoxOf(std::array{box->low, box->high, line.from, line.to});
  };
  const std::size_t count = std::max(lines_.size(), mesh.segments().size());
  for (std::size_t i = 0; i < count; ++i) {
    const Line here = i < lines_.size() ? lines_[i] : Line{};
    const Line there = i < mesh.segments().size() ? LineOf(mesh, mesh.segments()[i]) : Line{};
    if (here == there) continue;
    grow(here);
    grow(there);
  }
  return box;
}

BoundaryGaps::Boxed BoundaryGaps::MakeBoxes() const {
  Boxed boxed;
  std::vector<BoundingBox> boxes;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    if (!lines_[i].b.valid()) continue;
    boxed.segments.push_back(static_cast<std::int32_t>(i));
    boxes.push_back(BoxOf(std::array{lines_[i].from, lines_[i].to}));
  }
  boxed.tree = BoxTree(boxes);
  return boxed;
}

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
  const Boxed& boxed = boxed_.Get([this] { return MakeBoxes(); });
  boxed.tree.ForEachNear(ray.origin, [&](std::int32_t box) {
    const std::int32_t segment = boxed.segments[static_cast<std::size_t>(box)];
    const Line& line = lines_[static_cast<std::size_t>(segment)];
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
