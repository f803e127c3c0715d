#include "core/transfer/nodal_projection.h"

#include <algorithm>
#include <cmath>

#include "core/base/as_index.h"
#include "core/mesh/star.h"
#include "core/transfer/exact_sum.h"

namespace pliant {
namespace {

/// A linear function on a triangle whose first corner is at `origin`.
class LinearFunction {
 public:
  explicit LinearFunction(const std::array<Vec2, 3>& corners)
      : origin_(corners[0]),
        first_(corners[1] - corners[0]),
        second_(corners[2] - corners[0]),
        twice_area_(Cross(first_, second_)) {}

  /// False for a triangle so thin that its area is lost in rounding: it has none to integrate over.
  [[nodiscard]] bool usable() const { return twice_area_ > 0; }

  /// Barycentric weights of the second and the third corner.
  [[nodiscard]] std::array<double, 2> WeightsAt(Vec2 p) const {
    return {Cross(p - origin_, second_) / twice_area_, Cross(first_, p - origin_) / twice_area_};
  }

 private:
  Vec2 origin_;
  Vec2 first_;
  Vec2 second_;
  double twice_area_;
};

double ValueAt(const std::array<double, 2>& weights, const std::array<double, 3>& values) {
  return values[0] + (weights[0] * (values[1] - values[0]) + weights[1] * (values[2] - values[0]));
}

}  // namespace

NodalSystem MakeNodalSystem(const Mesh& mesh, const TouchedRegion& region) {
  const RegionMesh& after = region.after;
  NodalSystem system{MassMatrix(after.vertex_ids.size()), {}, OverlapComponents(region)};
  SlotMap unknowns(after.vertex_ids.size());
  for (const VertexId id : after.vertex_ids) unknowns.Add(id.value());
  SlotMap done(after.triangle_ids.size());
  for (std::size_t t = 0; t < after.triangles.size(); ++t) {
    done.Add(after.triangle_ids[t].value());
    system.matrix.AddTriangle(after.triangles[t],
                              AreaOf(CornersOf(after, static_cast<std::int32_t>(t))));
  }
  system.components.LinkCorners();

  Star star;
  for (const VertexId id : after.vertex_ids) {
    for (const TriangleId fan : FansOf(mesh, id)) {
      star.Gather(mesh, id, fan);
      for (const TriangleId triangle : star.triangles()) {
        const std::int32_t known_count = done.count();
        if (done.Add(triangle.value()) < known_count) continue;
        const auto& v = mesh.triangle(triangle).vertices;
        const std::array<std::int32_t, 3> corners{
            unknowns.Find(v[0].value()), unknowns.Find(v[1].value()), unknowns.Find(v[2].value())};
        system.matrix.AddTriangle(
            corners, AreaOf({mesh.position(v[0]), mesh.position(v[1]), mesh.position(v[2])}));
        const std::int32_t first = *std::ranges::max_element(corners);
        for (const std::int32_t corner : corners) {
          if (corner >= 0) system.components.LinkVertices(first, corner);
        }
      }
    }
  }
  system.spread = system.matrix.Solve(system.matrix.lumped());
  return system;
}

NodalProjection::NodalProjection(const Field& field, const TouchedRegion& region,
                                 const TransferRows& rows)
    : field_(field),
      region_(region),
      interpolated_(region.after.vertex_ids.size() * field.column_count),
      residuals_(field.column_count, std::vector<double>(region.after.vertex_ids.size(), 0.0)) {
  for (std::size_t v = 0; v < region.after.vertex_ids.size(); ++v) {
    const VertexId id = region.after.vertex_ids[v];
    const auto moved = std::ranges::lower_bound(rows.vertex_ids, id);
    const bool has_row = moved != rows.vertex_ids.end() && *moved == id;
    for (std::size_t column = 0; column < field.column_count; ++column) {
      const auto old_value = [&](VertexId source) { return field.row(source.index())[column]; };
      interpolated_[v * field.column_count + column] =
          has_row ? ApplyRow(rows.rows[static_cast<std::size_t>(moved - rows.vertex_ids.begin())],
                             old_value)
                  : old_value(id);
    }
  }
}

double NodalProjection::OldValue(std::int32_t before, std::size_t corner,
                                 std::size_t column) const {
  const std::int32_t vertex = region_.before.triangles[AsIndex(before)][corner];
  return field_.row(region_.before.vertex_ids[AsIndex(vertex)].index())[column];
}

void NodalProjection::Add(std::int32_t after, const OverlapFinder& found) {
  for (const Overlap& overlap : found.overlaps()) AddResidual(after, overlap);
}

/// Old function less interpolated one, times each hat function: quadratic, so that the midpoints
/// of the sides integrate it exactly over each triangle of the polygon's fan.
void NodalProjection::AddResidual(std::int32_t after, const Overlap& overlap) {
  const std::array<Vec2, 3> corners = CornersOf(region_.after, after);
  const std::array<Vec2, 3> old_corners = CornersOf(region_.before, overlap.before);
  const Vec2 origin = corners[0];
  const LinearFunction now({Vec2{}, corners[1] - origin, corners[2] - origin});
  const LinearFunction old(
      {old_corners[0] - origin, old_corners[1] - origin, old_corners[2] - origin});
  if (!now.usable() || !old.usable()) return;
  const auto& vertices = region_.after.triangles[AsIndex(after)];
  const ConvexPolygon& polygon = overlap.polygon;
  for (std::size_t i = 2; i < polygon.count; ++i) {
    const std::array<Vec2, 3> fan{polygon.corners[0], polygon.corners[i - 1], polygon.corners[i]};
    const double weight = AreaOf(fan) / 3;
    for (std::size_t side = 0; side < 3; ++side) {
      const Vec2 middle = 0.5 * (fan[side] + fan[(side + 1) % 3]);
      const std::array<double, 2> hats = now.WeightsAt(middle);
      const std::array<double, 2> old_hats = old.WeightsAt(middle);
      for (std::size_t column = 0; column < field_.column_count; ++column) {
        const double difference =
            ValueAt(old_hats,
                    {OldValue(overlap.before, 0, column), OldValue(overlap.before, 1, column),
                     OldValue(overlap.before, 2, column)}) -
            ValueAt(hats, {Interpolated(vertices[0], column), Interpolated(vertices[1], column),
                           Interpolated(vertices[2], column)});
        std::vector<double>& residual = residuals_[column];
        residual[AsIndex(vertices[0])] += weight * difference * (1 - hats[0] - hats[1]);
        residual[AsIndex(vertices[1])] += weight * difference * hats[0];
        residual[AsIndex(vertices[2])] += weight * difference * hats[1];
      }
    }
  }
}

FieldRows NodalProjection::Finish(const NodalSystem& system) {
  const std::size_t count = region_.after.vertex_ids.size();
  for (std::size_t column = 0; column < field_.column_count; ++column) {
    std::vector<double> correction = system.matrix.Solve(residuals_[column]);
    const std::vector<double> multipliers = Multipliers(system, column, correction);
    for (std::size_t v = 0; v < count; ++v) {
      correction[v] += multipliers[system.components.of_vertex(v)] * system.spread[v];
      double& value = interpolated_[v * field_.column_count + column];
      if (correction[v] != 0) value += correction[v];
    }
  }
  std::vector<std::size_t> order(count);
  for (std::size_t v = 0; v < count; ++v) order[v] = v;
  std::ranges::sort(order, {}, [&](std::size_t v) { return region_.after.vertex_ids[v]; });
  FieldRows result;
  for (const std::size_t v : order) {
    result.slots.push_back(region_.after.vertex_ids[v].value());
    for (std::size_t column = 0; column < field_.column_count; ++column) {
      result.values.push_back(Interpolated(static_cast<std::int32_t>(v), column));
    }
  }
  return result;
}

/// By how much of `spread` each piece must be corrected to have the old integral. A piece where
/// interpolation is exact to the bit, and whose domain did not change, is left as it is.
std::vector<double> NodalProjection::Multipliers(const NodalSystem& system, std::size_t column,
                                                 std::span<const double> correction) const {
  struct Balance {
    ExactSum missing;
    double magnitude = 0;
    double spread_integral = 0;
    bool exact = true;
  };
  const OverlapComponents& components = system.components;
  std::vector<Balance> balances(components.count());
  for (std::size_t t = 0; t < region_.before.triangles.size(); ++t) {
    const auto triangle = static_cast<std::int32_t>(t);
    const double third = AreaOf(CornersOf(region_.before, triangle)) / 3;
    Balance& balance = balances[components.of_before(t)];
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const double value = OldValue(triangle, corner, column);
      balance.missing.Add(third, value);
      balance.magnitude += third * std::fabs(value);
    }
  }
  for (std::size_t t = 0; t < region_.after.triangles.size(); ++t) {
    const double third = AreaOf(CornersOf(region_.after, static_cast<std::int32_t>(t))) / 3;
    Balance& balance = balances[components.of_after(t)];
    for (const std::int32_t vertex : region_.after.triangles[t]) {
      balance.missing.Add(-third, Interpolated(vertex, column));
    }
  }
  for (std::size_t v = 0; v < correction.size(); ++v) {
    Balance& balance = balances[components.of_vertex(v)];
    const double lumped = system.matrix.lumped()[v];
    balance.missing.Add(-lumped, correction[v]);
    balance.spread_integral += lumped * system.spread[v];
    balance.exact = balance.exact && residuals_[column][v] == 0;
  }
  std::vector<double> multipliers(components.count(), 0.0);
  for (std::size_t c = 0; c < multipliers.size(); ++c) {
    const Balance& balance = balances[c];
    const double missing = balance.missing.value();
    const bool is_rounding = std::fabs(missing) <= kRoundingShare * balance.magnitude;
    if (balance.spread_integral == 0 || (balance.exact && is_rounding)) continue;
    multipliers[c] = missing / balance.spread_integral;
  }
  return multipliers;
}

}  // namespace pliant
