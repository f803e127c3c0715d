#include "core/transfer/cell_linear.h"

#include <algorithm>

namespace pliant {
namespace {

Vec2 OldCenter(const OldMesh& old, TriangleId id) {
  const auto& corners = old.triangle(id).vertices;
  return CenterOf({old.position(corners[0]), old.position(corners[1]), old.position(corners[2])});
}

/// The old triangles that a value is reconstructed from, besides the one it belongs to.
std::vector<TriangleId> NeighborsOf(const OldMesh& old, TriangleId id) {
  std::vector<TriangleId> found;
  for (const TriangleId neighbor : old.triangle(id).neighbors) {
    if (neighbor.valid()) found.push_back(neighbor);
  }
  if (found.size() == 3) return found;
  const std::size_t first_count = found.size();
  for (std::size_t i = 0; i < first_count; ++i) {
    for (const TriangleId next : old.triangle(found[i]).neighbors) {
      if (next.valid() && next != id && std::ranges::find(found, next) == found.end()) {
        found.push_back(next);
      }
    }
  }
  return found;
}

/// Adds the triangles that follow one around a corner, until a boundary or until that one comes
/// again. @return true if it came
bool AddFan(const OldMesh& old, TriangleId start, VertexId corner, int (*turn)(int),
            std::vector<TriangleId>& found) {
  TriangleId at = start;
  while (true) {
    const TriangleRecord& record = old.triangle(at);
    const auto here = std::ranges::find(record.vertices, corner) - record.vertices.begin();
    at = record.neighbors[static_cast<std::size_t>(turn(static_cast<int>(here)))];
    if (!at.valid() || at == start) return at.valid();
    found.push_back(at);
  }
}

/// The old triangles that share a vertex with one, besides that one; some of them twice. At a
/// vertex where the mesh is pinched only its own fan counts.
std::vector<TriangleId> CornerNeighborsOf(const OldMesh& old, TriangleId id) {
  std::vector<TriangleId> found;
  for (const VertexId corner : old.triangle(id).vertices) {
    if (!AddFan(old, id, corner, &NextCorner, found)) {
      (void)AddFan(old, id, corner, &PreviousCorner, found);
    }
  }
  return found;
}

/// Weights of neighbours' differences: value(at) = value(id) + sum_k weight_k (value_k -
/// value(id)).
std::vector<double> ReconstructionWeights(const OldMesh& old, TriangleId id,
                                          std::span<const TriangleId> neighbors, Vec2 at) {
  const Vec2 center = OldCenter(old, id);
  std::vector<Vec2> ways;
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (const TriangleId neighbor : neighbors) {
    const Vec2 way = OldCenter(old, neighbor) - center;
    const double weight = 1 / Dot(way, way);
    ways.push_back(way);
    xx += weight * way.x * way.x;
    xy += weight * way.x * way.y;
    yy += weight * way.y * way.y;
  }
  std::vector<double> weights(neighbors.size(), 0.0);
  const double determinant = xx * yy - xy * xy;
  // All centres on one line, as in a mesh of one or two triangles: no gradient can be told.
  if (!(determinant > 0)) return weights;
  const Vec2 step = at - center;
  const Vec2 dual{(yy * step.x - xy * step.y) / determinant,
                  (xx * step.y - xy * step.x) / determinant};
  for (std::size_t k = 0; k < ways.size(); ++k) {
    weights[k] = Dot(dual, ways[k]) / Dot(ways[k], ways[k]);
  }
  return weights;
}

/// A value cut to those of a triangle and its neighbours. [ParkYoonKim2010]
double Bounded(double value, const Field& field, std::size_t column, TriangleId id,
               std::span<const TriangleId> neighbors) {
  double low = field.row(id.index())[column];
  double high = low;
  for (const TriangleId neighbor : neighbors) {
    const double other = field.row(neighbor.index())[column];
    low = std::min(low, other);
    high = std::max(high, other);
  }
  return std::clamp(value, low, high);
}

}  // namespace

FieldRows TransferCells(const OldMesh& old, const TouchedRegion& region,
                        const RegionLocator& locator, const Field& field) {
  FieldRows result;
  for (std::size_t t = 0; t < region.after.triangles.size(); ++t) {
    const Vec2 center = CenterOf(CornersOf(region.after, static_cast<std::int32_t>(t)));
    const Location location = locator.Locate(center, region.after.triangles[t][0]);
    const TriangleId id = region.before.triangle_ids[static_cast<std::size_t>(location.triangle)];
    const std::vector<TriangleId> neighbors = NeighborsOf(old, id);
    const std::vector<double> weights = ReconstructionWeights(old, id, neighbors, center);
    const bool bounded = field.transfer == TransferKind::kBounded;
    const std::vector<TriangleId> bounds =
        bounded ? CornerNeighborsOf(old, id) : std::vector<TriangleId>{};
    result.slots.push_back(region.after.triangle_ids[t].value());
    for (std::size_t column = 0; column < field.column_count; ++column) {
      const double own = field.row(id.index())[column];
      double value = own;
      for (std::size_t k = 0; k < neighbors.size(); ++k) {
        value += weights[k] * (field.row(neighbors[k].index())[column] - own);
      }
      if (bounded) value = Bounded(value, field, column, id, bounds);
      result.values.push_back(value);
    }
  }
  return result;
}

}  // namespace pliant
