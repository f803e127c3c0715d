#include "core/pliant/refill.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/base/as_index.h"
#include "core/delaunay/metric_flip.h"
#include "core/geometry/predicates.h"
#include "core/mesh/place_map.h"
#include "core/mesh/star.h"
#include "core/metric/metric.h"
#include "core/pliant/insert.h"

namespace pliant {
namespace {

/// Triangles with an edge longer than this are torn open, and have room for a vertex.
constexpr double kTorn = 1.6;

/// A new vertex keeps this distance, in metric length, from the corners around it, and this one
/// from sides that went along or must stay.
constexpr double kRoom = 0.9;
constexpr double kRoomAtRim = 0.8;

/// A place is looked for in so many triangles: it is near the one before.
constexpr int kWalkMax = 32;

class Refiller {
 public:
  Refiller(MeshEdit& edit, const Gap& gap)
      : edit_(edit), mesh_(edit.mesh()), gap_(gap), flipper_(edit) {}

  std::vector<GapVertex> Run() {
    FindRim();
    for (std::size_t next = 0; next < waiting_.size() && made_.size() < gap_.count_max; ++next) {
      Fill(waiting_[next]);
    }
    return std::move(made_);
  }

 private:
  /// Someone who moved, and a vertex near the place that he left.
  struct Left {
    VertexId vertex;
    VertexId near;
  };

  [[nodiscard]] std::optional<Vec2> Before(VertexId vertex) const {
    if (is_made_.At(vertex) != PlaceMap::kNone)
      return std::nullopt;  // Perhaps in a dead one's slot.
    return gap_.before(vertex);
  }

  void Add(const Left& left) {
    if (Before(left.vertex) && seen_.Add(left.vertex, 0)) waiting_.push_back(left);
  }

  /// Adds the corners of torn triangles. Who left a place further inside is found from them, from
  /// neighbour to neighbour.
  void FindRim() {
    for (const TriangleId id : gap_.triangles) {
      const TriangleRecord& triangle = mesh_.triangle(id);
      if (!triangle.live || !IsTorn(triangle)) continue;
      for (const VertexId corner : triangle.vertices) Add({corner, corner});
    }
  }

  [[nodiscard]] bool IsTorn(const TriangleRecord& triangle) const {
    const auto& v = triangle.vertices;
    return std::ranges::any_of(std::array{0, 1, 2}, [&](int corner) {
      const VertexId a = v[AsIndex(corner)];
      const VertexId b = v[AsIndex(NextCorner(corner))];
      return SquaredLength(0.5 * (mesh_.metric(a) + mesh_.metric(b)),
                           mesh_.position(b) - mesh_.position(a)) > kTorn * kTorn;
    });
  }

  /// Puts a vertex where one was, if the place is in the gap and free.
  void Fill(Left left) {
    if (mesh_.vertex(left.vertex).edge.valid()) return;
    const Vec2 place = *Before(left.vertex);
    const std::optional<TriangleId> around = Locate(place, left.near);
    if (!around || !IsOfGap(*around)) return;
    if (const auto vertex = Insert(*around, place); vertex) left.near = *vertex;
    star_.Gather(mesh_, left.vertex);
    for (const VertexId other : star_.ring()) Add({other, left.near});
  }

  /// The triangle around a place, on the way there from a vertex; nothing if a wall is between.
  [[nodiscard]] std::optional<TriangleId> Locate(Vec2 p, VertexId from) const {
    TriangleId id = mesh_.vertex(from).triangle;
    for (int step = 0; step < kWalkMax; ++step) {
      const TriangleRecord& triangle = mesh_.triangle(id);
      const auto& v = triangle.vertices;
      int beyond = -1;
      for (int k = 0; k < 3 && beyond < 0; ++k) {
        const Vec2 a = mesh_.position(v[AsIndex(NextCorner(k))]);
        const Vec2 b = mesh_.position(v[AsIndex(PreviousCorner(k))]);
        if (Orient2d(a, b, p) < 0) beyond = k;
      }
      if (beyond < 0) return id;
      if (triangle.IsConstrained(beyond)) return std::nullopt;
      id = triangle.neighbors[AsIndex(beyond)];
    }
    return std::nullopt;
  }

  /// Not all corners have moved: nobody has brought this triangle along.
  [[nodiscard]] bool IsOfGap(TriangleId id) const {
    const TriangleRecord& triangle = mesh_.triangle(id);
    return !triangle.frozen && !std::ranges::all_of(triangle.vertices, [&](VertexId corner) {
      return Before(corner).has_value();
    });
  }

  std::optional<VertexId> Insert(TriangleId id, Vec2 p) {
    const std::array<double, 3> shares = SharesOf(id, p);
    const Metric metric = Between(id, shares);
    if (!HasRoom(id, p, metric)) return std::nullopt;
    const Side side = SideToSplit(id, p);
    if (!side.triangle.valid()) return std::nullopt;
    const std::array<VertexId, 3> corners = mesh_.triangle(id).vertices;
    const std::int32_t hint = mesh_.hint(corners[0]);
    const VertexId vertex = edit_.SplitEdge(side, p, 0);
    edit_.SetMetric(vertex, metric);
    edit_.Hint(vertex) = hint;
    flipper_.AroundInserted(vertex);
    made_.push_back({vertex, corners, shares});
    is_made_.Add(vertex, 0);
    return vertex;
  }

  [[nodiscard]] std::array<Vec2, 3> CornersOf(TriangleId id) const {
    const auto& v = mesh_.triangle(id).vertices;
    return {mesh_.position(v[0]), mesh_.position(v[1]), mesh_.position(v[2])};
  }

  /// Barycentric weights.
  [[nodiscard]] std::array<double, 3> SharesOf(TriangleId id, Vec2 p) const {
    const auto [a, b, c] = CornersOf(id);
    const double area = Cross(b - a, c - a);
    return {Cross(b - p, c - p) / area, Cross(c - p, a - p) / area, Cross(a - p, b - p) / area};
  }

  [[nodiscard]] Metric Between(TriangleId id, const std::array<double, 3>& shares) const {
    const auto& v = mesh_.triangle(id).vertices;
    return Exp(shares[0] * Log(mesh_.metric(v[0])) + shares[1] * Log(mesh_.metric(v[1])) +
               shares[2] * Log(mesh_.metric(v[2])));
  }

  [[nodiscard]] bool HasRoom(TriangleId id, Vec2 p, const Metric& metric) const {
    const TriangleRecord& triangle = mesh_.triangle(id);
    const std::array<Vec2, 3> corners = CornersOf(id);
    for (int k = 0; k < 3; ++k) {
      if (SquaredLength(metric, corners[AsIndex(k)] - p) < kRoom * kRoom) return false;
      if (const TriangleId beyond = triangle.neighbors[AsIndex(k)]; beyond.valid()) {
        const VertexId far =
            mesh_.triangle(beyond).vertices[AsIndex(mesh_.SideTowards(beyond, id))];
        if (SquaredLength(metric, mesh_.position(far) - p) < kRoom * kRoom) return false;
      }
      const bool is_rim =
          triangle.IsConstrained(k) || (Before(triangle.vertices[AsIndex(NextCorner(k))]) &&
                                        Before(triangle.vertices[AsIndex(PreviousCorner(k))]));
      if (is_rim && HeightOver(corners[AsIndex(NextCorner(k))], corners[AsIndex(PreviousCorner(k))],
                               p, metric) < kRoomAtRim) {
        return false;
      }
    }
    return true;
  }

  [[nodiscard]] static double HeightOver(Vec2 a, Vec2 b, Vec2 p, const Metric& metric) {
    return Cross(b - a, p - a) * std::sqrt(Determinant(metric) / SquaredLength(metric, b - a));
  }

  /// Of the sides of a triangle that may be split at a place within, the nearest; else none.
  [[nodiscard]] Side SideToSplit(TriangleId id, Vec2 p) const {
    const TriangleRecord& triangle = mesh_.triangle(id);
    const std::array<Vec2, 3> corners = CornersOf(id);
    Side nearest;
    double least = 0;
    for (int k = 0; k < 3; ++k) {
      if (triangle.IsConstrained(k)) continue;
      const TriangleId beyond = triangle.neighbors[AsIndex(k)];
      if (mesh_.triangle(beyond).frozen || !SplitsWell(mesh_, {id, k}, p)) continue;
      const double height =
          HeightOver(corners[AsIndex(NextCorner(k))], corners[AsIndex(PreviousCorner(k))], p,
                     mesh_.metric(triangle.vertices[0]));
      if (nearest.triangle.valid() && !(height < least)) continue;
      least = height;
      nearest = id < beyond ? Side{id, k} : Side{beyond, mesh_.SideTowards(beyond, id)};
    }
    return nearest;
  }

  MeshEdit& edit_;
  const Mesh& mesh_;
  const Gap& gap_;
  MetricFlipper flipper_;
  Star star_;
  std::vector<Left> waiting_;
  PlaceMap seen_;
  std::vector<GapVertex> made_;
  PlaceMap is_made_;
};

}  // namespace

std::vector<GapVertex> RefillGap(MeshEdit& edit, const Gap& gap) {
  return Refiller(edit, gap).Run();
}

}  // namespace pliant
