#include "core/pliant/density.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "core/metric/metric.h"

namespace pliant {
namespace {

constexpr double kIdealArea = 0.43301270189221932;  // sqrt(3) / 4

/// So many edges change their number by one when sizes change by 5 %.
constexpr int kEdgesEachWay = 10;

/// Beyond the length at which one edge more fits as well as one less, in lengths of an edge.
constexpr double kMargin = 0.1;

double AreaOf(const Mesh& mesh, const TriangleRecord& triangle) {
  const VertexRecord& a = mesh.vertex(triangle.vertices[0]);
  const VertexRecord& b = mesh.vertex(triangle.vertices[1]);
  const VertexRecord& c = mesh.vertex(triangle.vertices[2]);
  return NormalizedArea(a.position, a.metric, b.position, b.metric, c.position, c.metric);
}

}  // namespace

double DensityProbe::LackAround(const Star& star) {
  const std::span<const VertexId> ring = star.ring();
  double area = 0;
  int count = 0;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    star_.Gather(mesh_, ring[k]);
    const std::span<const VertexId> before = ring.first(k);
    for (const TriangleId id : star_.triangles()) {
      const TriangleRecord& triangle = mesh_.triangle(id);
      // The first of its corners that are in the ring counts it.
      if (std::ranges::find_first_of(triangle.vertices, before) != triangle.vertices.end())
        continue;
      area += AreaOf(mesh_, triangle);
      ++count;
    }
  }
  return (area / kIdealArea - count) / 2;
}

DensityProbe::Stretch DensityProbe::StretchAround(VertexId node) const {
  Stretch stretch;
  for (std::size_t way = 0; way < 2; ++way) {
    VertexId at = node;
    for (int i = 0; i < kEdgesEachWay; ++i) {
      const EdgeId edge = mesh_.SegmentEdges(at)[way];
      const VertexId next = mesh_.edge(edge).vertices[way];
      const VertexRecord& a = mesh_.vertex(at);
      const VertexRecord& b = mesh_.vertex(next);
      stretch.length += std::sqrt(SquaredEdgeLength(a, b));
      ++stretch.count;
      if (b.fixed) break;
      at = next;
    }
  }
  return stretch;
}

bool DensityProbe::Stretch::lacks() const {
  return length > std::sqrt(count * (count + 1.0)) + kMargin * (1 - 1.0 / count);
}

bool DensityProbe::Stretch::is_crowded() const {
  if (count < 2) return false;
  return length < std::sqrt(count * (count - 1.0)) - kMargin * (1 - 1.0 / (count - 1.0));
}

}  // namespace pliant
