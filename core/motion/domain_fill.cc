#include "core/motion/domain_fill.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "core/base/as_index.h"
#include "core/delaunay/constrain.h"
#include "core/delaunay/delaunay.h"

namespace pliant {
namespace {

using Kind = WallSide::Kind;

/// One part of the plane, as far as no wall is in the way.
struct Part {
  bool open = false;     // It reaches to infinity, or something outside or covered bounds it.
  bool cavity = false;   // A kCavity side bounds it.
  bool named = false;    // A kRegion side bounds it.
  bool clashes = false;  // Two regions do.
  std::int32_t region = 0;
  SideState state;  // The verdict.
};

class Filler {
 public:
  Filler(const Mesh& mesh, const FillRequest& request) : mesh_(mesh), request_(request) {}

  std::optional<Filling> Run() {
    for (const VertexId vertex : request_.points) positions_.push_back(mesh_.position(vertex));
    if (HasTwins()) return std::nullopt;
    hull_ = DelaunayTriangulation(positions_);
    if (hull_.triangles.empty()) return Nothing();
    if (!InsertWalls()) return std::nullopt;
    SplitInParts();
    if (!Judge()) return std::nullopt;
    return Result();
  }

 private:
  [[nodiscard]] bool HasTwins() const {
    std::vector<std::pair<double, double>> sorted;
    for (const Vec2 p : positions_) sorted.emplace_back(p.x, p.y);
    std::sort(sorted.begin(), sorted.end());
    return std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
  }

  /// All points lie on one line: there is no room for a triangle.
  [[nodiscard]] std::optional<Filling> Nothing() const {
    for (const Wall& wall : request_.walls) {
      if (wall.left.kind == Kind::kRegion || wall.right.kind == Kind::kRegion) return std::nullopt;
    }
    Filling filling;
    filling.cavities.resize(request_.walls.size());
    return filling;
  }

  [[nodiscard]] std::int32_t Dense(VertexId vertex) const {
    return static_cast<std::int32_t>(
        std::lower_bound(request_.points.begin(), request_.points.end(), vertex) -
        request_.points.begin());
  }

  bool InsertWalls() {
    Constrainer constrainer(positions_, hull_);
    for (std::size_t i = 0; i < request_.walls.size(); ++i) {
      const Constrainer::Edge edge{static_cast<std::int32_t>(i), Dense(request_.walls[i].from),
                                   Dense(request_.walls[i].to)};
      if (constrainer.Insert(edge) == Constrainer::Outcome::kBlocked) return false;
    }
    return true;
  }

  void SplitInParts() {
    part_of_.assign(hull_.triangles.size(), -1);
    std::vector<std::int32_t> stack;
    for (std::size_t start = 0; start < hull_.triangles.size(); ++start) {
      if (part_of_[start] >= 0) continue;
      const auto number = static_cast<std::int32_t>(parts_.size());
      parts_.emplace_back();
      part_of_[start] = number;
      stack.push_back(static_cast<std::int32_t>(start));
      while (!stack.empty()) {
        const std::int32_t t = stack.back();
        stack.pop_back();
        const HullTriangulation::Triangle& triangle = hull_.triangles[AsIndex(t)];
        if (HullTriangulation::IsGhost(triangle)) parts_.back().open = true;
        for (std::size_t side = 0; side < 3; ++side) {
          if (triangle.segments[side] >= 0) {
            Note(parts_.back(), SideOf(triangle, side));
            continue;
          }
          std::int32_t& next = part_of_[AsIndex(triangle.neighbors[side])];
          if (next < 0) {
            next = number;
            stack.push_back(triangle.neighbors[side]);
          }
        }
      }
    }
  }

  /// True if a counter-clockwise triangle lies on the left of the wall that is its side.
  [[nodiscard]] bool IsLeft(const HullTriangulation::Triangle& triangle, std::size_t side) const {
    const Wall& wall = request_.walls[AsIndex(triangle.segments[side])];
    return triangle.points[(side + 1) % 3] == Dense(wall.from);
  }

  [[nodiscard]] const WallSide& SideOf(const HullTriangulation::Triangle& triangle,
                                       std::size_t side) const {
    const Wall& wall = request_.walls[AsIndex(triangle.segments[side])];
    return IsLeft(triangle, side) ? wall.left : wall.right;
  }

  static void Note(Part& part, const WallSide& side) {
    switch (side.kind) {
      case Kind::kOutside:
      case Kind::kCovered:
        part.open = true;
        return;
      case Kind::kCavity:
        part.cavity = true;
        return;
      case Kind::kRegion:
        part.clashes = part.clashes || (part.named && part.region != side.region);
        part.named = true;
        part.region = side.region;
        return;
    }
  }

  /// Says what each part is. @return false if that is not clear
  bool Judge() {
    for (Part& part : parts_) {
      if (part.clashes || (part.open && part.named)) return false;
      if (part.named) part.state = part.region;
    }
    // A part that only sides of the old mesh bound: one of its vertices knows.
    std::vector<bool> asked(parts_.size(), false);
    std::vector<bool> known(parts_.size(), false);
    for (std::size_t t = 0; t < hull_.triangles.size(); ++t) {
      const auto number = AsIndex(part_of_[t]);
      Part& part = parts_[number];
      if (part.open || part.named || known[number]) continue;
      asked[number] = true;
      for (const std::int32_t point : hull_.triangles[t].points) {
        if (known[number]) break;
        const StateAround around = request_.state_at(request_.points[AsIndex(point)]);
        if (!around.known) continue;
        part.state = around.state;
        known[number] = true;
      }
    }
    return asked == known;
  }

  [[nodiscard]] Filling Result() const {
    Filling filling;
    filling.cavities.resize(request_.walls.size());
    for (std::size_t t = 0; t < hull_.triangles.size(); ++t) {
      const HullTriangulation::Triangle& triangle = hull_.triangles[t];
      const SideState& state = parts_[AsIndex(part_of_[t])].state;
      for (std::size_t side = 0; side < 3; ++side) {
        if (triangle.segments[side] < 0) continue;
        EdgeSides& sides = filling.cavities[AsIndex(triangle.segments[side])];
        (IsLeft(triangle, side) ? sides.left : sides.right) = state;
      }
      if (!state) continue;
      const auto vertex = [&](std::size_t i) {
        return request_.points[AsIndex(triangle.points[i])];
      };
      filling.triangles.push_back({{vertex(0), vertex(1), vertex(2)}, *state});
    }
    return filling;
  }

  const Mesh& mesh_;
  const FillRequest& request_;
  std::vector<Vec2> positions_;
  HullTriangulation hull_;
  std::vector<std::int32_t> part_of_;
  std::vector<Part> parts_;
};

}  // namespace

std::optional<Filling> FillWalls(const Mesh& mesh, const FillRequest& request) {
  return Filler(mesh, request).Run();
}

}  // namespace pliant
