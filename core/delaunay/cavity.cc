#include "core/delaunay/cavity.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "core/base/stoppable_sort.h"
#include "core/delaunay/triangulate.h"
#include "core/geometry/domain.h"
#include "core/mesh/star.h"

namespace pliant {
namespace {

/// A side of a triangle in the direction that has the triangle on its left.
using Directed = std::pair<VertexId, VertexId>;

/// A side that stays, and the region on its left.
struct RimEdge {
  Directed side;
  std::int32_t region = 0;
};

class CavityFiller {
 public:
  CavityFiller(MeshEdit& edit, const std::vector<TriangleId>& cavity,
               const std::function<bool(VertexId)>& keeps, std::span<const VertexId> leaving,
               const StopSignal* stop)
      : edit_(edit),
        mesh_(edit.mesh()),
        cavity_(cavity),
        keeps_(keeps),
        leaving_(leaving),
        stop_(stop),
        stopped_(stop) {
    SortUnlessStopped(cavity_.begin(), cavity_.end(), stop_);
    cavity_.erase(std::unique(cavity_.begin(), cavity_.end()), cavity_.end());
  }

  Result<Retriangulated> Run() {
    FindWalls();
    if (stop_asked()) return Stopped();
    for (std::size_t k = 0; k < leaving_.size(); ++k) TakeOffWall(k);
    FindPoints();
    if (stop_asked()) return Stopped();
    MakeDomain();
    const Result<DomainTriangulation> filled = TriangulateDomain(domain_, stop_);
    if (!filled.ok()) return Named(filled.error());
    std::optional<std::vector<NewTriangle>> triangles = Inside(*filled);
    if (stop_asked()) return Stopped();
    if (!triangles || covered_walls_ != walls_.size()) return WallsCross();
    const auto unused = std::find(used_.begin(), used_.end(), false) - used_.begin();
    if (unused != std::ssize(used_)) return Outside(points_[static_cast<std::size_t>(unused)]);
    for (const VertexId vertex : leaving_) edit_.MergeEdges(vertex);
    edit_.ReplaceCavity(cavity_, *triangles);
    for (const VertexId vertex : gone_) edit_.RemoveVertex(vertex);
    return Retriangulated{gone_, points_};
  }

 private:
  [[nodiscard]] bool stop_asked() const { return stop_ != nullptr && stop_->asked(); }

  /// An error of the domain, in the mesh's ids.
  [[nodiscard]] Error Named(Error error) const {
    const auto name = [&](std::int64_t& index) {
      if (index >= 0) index = points_[static_cast<std::size_t>(index)].value();
    };
    const bool of_points = error.field == "domain.points";
    if (of_points) name(error.index);
    if (!of_points) error.index = -1;
    if (error.code == ErrorCode::kDuplicatePoint) {
      name(error.other_index);
    } else {
      error.other_index = -1;
    }
    return error;
  }
  static Error WallsCross() {
    return {ErrorCode::kCrossingSegments, "the sides of a cavity do not bound it"};
  }
  static Error Outside(VertexId vertex) {
    Error error{ErrorCode::kPointOutsideDomain, "a vertex of a cavity lies outside of it"};
    error.index = vertex.value();
    return error;
  }

  [[nodiscard]] bool InCavity(TriangleId id) const {
    return std::binary_search(cavity_.begin(), cavity_.end(), id);
  }

  /// Every side that stays: the rim, and constrained edges from either side.
  void FindWalls() {
    for (const TriangleId id : cavity_) {
      if (stopped_()) return;
      const TriangleRecord& record = mesh_.triangle(id);
      for (int side = 0; side < 3; ++side) {
        const auto s = static_cast<std::size_t>(side);
        if (!record.IsConstrained(side) && InCavity(record.neighbors[s])) continue;
        walls_.push_back({{record.vertices[static_cast<std::size_t>(NextCorner(side))],
                           record.vertices[static_cast<std::size_t>(PreviousCorner(side))]},
                          record.region});
      }
    }
    SortUnlessStopped(walls_.begin(), walls_.end(), stop_,
                      [](const RimEdge& a, const RimEdge& b) { return a.side < b.side; });
  }

  /// Makes the two edges at the k-th leaving vertex one wall, on each side that the cavity has.
  void TakeOffWall(std::size_t k) {
    const VertexId vertex = leaving_[k];
    const auto has_left = [&](VertexId other) {
      const auto left = leaving_.first(k);
      return std::find(left.begin(), left.end(), other) != left.end();
    };
    VertexId a = vertex;
    VertexId b = vertex;
    do a = mesh_.edge(mesh_.SegmentEdges(a)[0]).vertices[0];
    while (has_left(a));
    do b = mesh_.edge(mesh_.SegmentEdges(b)[1]).vertices[1];
    while (has_left(b));
    for (const auto& [from, to] : {Directed{a, b}, Directed{b, a}}) {
      const RimEdge* const first = FindWall({from, vertex});
      if (first == nullptr) continue;
      const RimEdge wall{{from, to}, first->region};
      for (const Directed& side : {Directed{from, vertex}, Directed{vertex, to}}) {
        walls_.erase(walls_.begin() + (FindWall(side) - walls_.data()));
      }
      walls_.insert(LowerBound(wall.side), wall);
    }
  }

  [[nodiscard]] std::vector<RimEdge>::const_iterator LowerBound(const Directed& side) const {
    return std::lower_bound(walls_.begin(), walls_.end(), side,
                            [](const RimEdge& wall, const Directed& to) { return wall.side < to; });
  }
  /// Null if there is none.
  [[nodiscard]] const RimEdge* FindWall(const Directed& side) const {
    const auto wall = LowerBound(side);
    return wall != walls_.end() && wall->side == side ? &*wall : nullptr;
  }

  void FindPoints() {
    std::vector<VertexId> corners;
    for (const TriangleId id : cavity_) {
      const auto& v = mesh_.triangle(id).vertices;
      corners.insert(corners.end(), v.begin(), v.end());
    }
    SortUnlessStopped(corners.begin(), corners.end(), stop_);
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    std::vector<VertexId> on_walls;
    for (const RimEdge& wall : walls_) {
      on_walls.push_back(wall.side.first);
      on_walls.push_back(wall.side.second);
    }
    SortUnlessStopped(on_walls.begin(), on_walls.end(), stop_);
    for (const VertexId vertex : corners) {
      if (stopped_()) return;
      const bool leaves = std::find(leaving_.begin(), leaving_.end(), vertex) != leaving_.end();
      const bool stays =
          !leaves && (std::binary_search(on_walls.begin(), on_walls.end(), vertex) ||
                      mesh_.vertex(vertex).fixed || mesh_.vertex(vertex).frozen || keeps_(vertex));
      (stays ? points_ : gone_).push_back(vertex);
    }
  }

  [[nodiscard]] std::int32_t Dense(VertexId vertex) const {
    return static_cast<std::int32_t>(std::lower_bound(points_.begin(), points_.end(), vertex) -
                                     points_.begin());
  }

  void MakeDomain() {
    for (const VertexId vertex : points_) domain_.points.push_back(mesh_.position(vertex));
    for (const RimEdge& wall : walls_) {
      const auto [a, b] = wall.side;
      if (b < a && FindWall({b, a}) != nullptr) continue;  // A constrained edge has two sides.
      domain_.segments.push_back({Dense(a), Dense(b), 0});
    }
  }

  /// The triangles left of the walls, with the regions that were there; the others fill holes of
  /// the cavity. Nothing if a part has no wall or walls that disagree.
  [[nodiscard]] std::optional<std::vector<NewTriangle>> Inside(const DomainTriangulation& filled) {
    used_.assign(points_.size(), false);
    enum class Part : std::uint8_t { kUnknown, kInside, kOutside };
    const std::size_t count = filled.triangles.size();
    std::vector<bool> seen(count, false);
    std::vector<NewTriangle> inside;
    std::vector<std::size_t> stack;
    std::vector<std::size_t> members;
    for (std::size_t start = 0; start < count; ++start) {
      if (seen[start]) continue;
      Part part = Part::kUnknown;
      std::int32_t region = 0;
      std::size_t wall_count = 0;
      members.clear();
      stack = {start};
      seen[start] = true;
      while (!stack.empty()) {
        if (stopped_()) return std::nullopt;
        const std::size_t t = stack.back();
        stack.pop_back();
        members.push_back(t);
        const auto& triangle = filled.triangles[t];
        for (std::size_t side = 0; side < 3; ++side) {
          if (triangle.segments[side] < 0) {
            const std::int32_t next = triangle.neighbors[side];
            if (next < 0) return std::nullopt;
            if (seen[static_cast<std::size_t>(next)]) continue;
            seen[static_cast<std::size_t>(next)] = true;
            stack.push_back(static_cast<std::size_t>(next));
            continue;
          }
          const RimEdge* const wall = FindWall(
              {PointOf(triangle.points[(side + 1) % 3]), PointOf(triangle.points[(side + 2) % 3])});
          const Part found = wall == nullptr ? Part::kOutside : Part::kInside;
          const bool differs = part == Part::kInside && found == part && wall->region != region;
          if ((part != Part::kUnknown && part != found) || differs) return std::nullopt;
          part = found;
          ++wall_count;
          if (found == Part::kInside) region = wall->region;
        }
      }
      if (part != Part::kInside) continue;
      covered_walls_ += wall_count;
      for (const std::size_t t : members) {
        const auto& p = filled.triangles[t].points;
        for (const std::int32_t point : p) used_[static_cast<std::size_t>(point)] = true;
        inside.push_back({{PointOf(p[0]), PointOf(p[1]), PointOf(p[2])}, region});
      }
    }
    return inside;
  }

  [[nodiscard]] VertexId PointOf(std::int32_t dense) const {
    return points_[static_cast<std::size_t>(dense)];
  }

  MeshEdit& edit_;
  const Mesh& mesh_;
  std::vector<TriangleId> cavity_;
  const std::function<bool(VertexId)>& keeps_;
  const std::span<const VertexId> leaving_;
  const StopSignal* const stop_;
  StopPoll stopped_;
  std::vector<RimEdge> walls_;  // By side.
  std::vector<VertexId> points_;
  std::vector<VertexId> gone_;
  std::vector<bool> used_;  // By place in points_: has a new triangle.
  std::size_t covered_walls_ = 0;
  Domain domain_;
};

}  // namespace

Result<Retriangulated> RetriangulateCavity(MeshEdit& edit, const std::vector<TriangleId>& cavity,
                                           const std::function<bool(VertexId)>& keeps,
                                           std::span<const VertexId> leaving,
                                           const StopSignal* stop) {
  return CavityFiller(edit, cavity, keeps, leaving, stop).Run();
}

}  // namespace pliant
