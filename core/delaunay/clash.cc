#include "core/delaunay/clash.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/geometry/bounding_box.h"
#include "core/geometry/box_tree.h"
#include "core/geometry/predicates.h"
#include "core/mesh/id_bits.h"

namespace pliant {
namespace {

/// A chain of clashes that is longer than this leads everywhere.
constexpr int kGrowthsMax = 32;

/// A vertex that stays, twice, or a wall between two.
using Piece = std::array<VertexId, 2>;

class ClashFinder {
 public:
  ClashFinder(const Mesh& mesh, std::vector<TriangleId> cavity,
              const std::function<bool(VertexId)>& keeps, const StopSignal* stop)
      : mesh_(mesh),
        keeps_(keeps),
        stopped_(stop),
        in_cavity_(mesh.triangle_slots()),
        seen_(mesh.vertex_slots()),
        fresh_(std::move(cavity)) {
    for (const TriangleId id : fresh_) in_cavity_.Add(id);
  }

  std::vector<TriangleId> Run() {
    for (int round = 0; !fresh_.empty() && !stopped_(); ++round) {
      FindPieces();
      fresh_.clear();
      FindClashes(round < kGrowthsMax);
    }
    return in_cavity_.Ascending();
  }

 private:
  /// What the triangles that came last bring along. Walls between two of them are none any more.
  void FindPieces() {
    pieces_.clear();
    for (const TriangleId id : fresh_) {
      if (stopped_()) return;
      const TriangleRecord& record = mesh_.triangle(id);
      for (std::size_t side = 0; side < 3; ++side) {
        const VertexId a = record.vertices[side];
        const VertexId b = record.vertices[(side + 1) % 3];
        const std::size_t beyond = (side + 2) % 3;
        const bool is_wall =
            record.IsConstrained(beyond) || !in_cavity_.Has(record.neighbors[beyond]);
        if (is_wall) pieces_.push_back({a, b});
        if (!seen_.Has(a) && Stays(a)) pieces_.push_back({a, a});
        seen_.Add(a);
      }
    }
    boxes_.clear();
    for (const auto& [a, b] : pieces_) {
      boxes_.push_back(BoxOf(std::array{mesh_.position(a), mesh_.position(b)}));
    }
  }

  [[nodiscard]] bool Stays(VertexId vertex) const {
    const VertexRecord& record = mesh_.vertex(vertex);
    return record.edge.valid() || record.fixed || record.frozen || keeps_(vertex);
  }

  /// @param look  false: everything counts as a clash
  void FindClashes(bool look) {
    const BoxTree tree(boxes_);
    for (std::int32_t slot = 0; slot < mesh_.triangle_slots(); ++slot) {
      if (stopped_()) return;
      const TriangleId id(slot);
      if (!mesh_.triangle(id).live || in_cavity_.Has(id)) continue;
      if (look && !Clashes(id, tree)) continue;
      in_cavity_.Add(id);
      fresh_.push_back(id);
    }
  }

  [[nodiscard]] bool Clashes(TriangleId id, const BoxTree& tree) const {
    const auto& v = mesh_.triangle(id).vertices;
    const std::array corners = {mesh_.position(v[0]), mesh_.position(v[1]), mesh_.position(v[2])};
    bool clashes = false;
    tree.ForEachMeeting(BoxOf(corners), [&](std::int32_t index) {
      const auto& [a, b] = pieces_[static_cast<std::size_t>(index)];
      const bool has_a = std::find(v.begin(), v.end(), a) != v.end();
      const bool has_b = std::find(v.begin(), v.end(), b) != v.end();
      if (has_a != has_b) {
        const VertexId corner = has_a ? a : b;
        clashes = RunsInto(corners, static_cast<std::size_t>(mesh_.CornerOf(id, corner)),
                           mesh_.position(has_a ? b : a));
      } else if (!has_a) {
        clashes = Meets(corners, mesh_.position(a), mesh_.position(b));
      }
      return !clashes;
    });
    return clashes;
  }

  /// True if the way from a corner to p begins within the triangle or along a side of it.
  static bool RunsInto(const std::array<Vec2, 3>& corners, std::size_t corner, Vec2 p) {
    const Vec2 at = corners[corner];
    return Orient2d(at, corners[(corner + 1) % 3], p) >= 0 &&
           Orient2d(at, corners[(corner + 2) % 3], p) <= 0;
  }

  /// True if a segment, or a point, has a point in common with the triangle: no line along a side
  /// or along the segment has one on either side of it.
  static bool Meets(const std::array<Vec2, 3>& corners, Vec2 p, Vec2 q) {
    for (std::size_t side = 0; side < 3; ++side) {
      const Vec2 a = corners[side];
      const Vec2 b = corners[(side + 1) % 3];
      if (Orient2d(a, b, p) < 0 && Orient2d(a, b, q) < 0) return false;
    }
    if (p == q) return true;
    const std::array sides = {Orient2d(p, q, corners[0]), Orient2d(p, q, corners[1]),
                              Orient2d(p, q, corners[2])};
    return *std::min_element(sides.begin(), sides.end()) <= 0 &&
           *std::max_element(sides.begin(), sides.end()) >= 0;
  }

  const Mesh& mesh_;
  const std::function<bool(VertexId)>& keeps_;
  StopPoll stopped_;
  IdBits<TriangleId> in_cavity_;
  IdBits<VertexId> seen_;
  std::vector<TriangleId> fresh_;  ///< Those that came in the last round.
  std::vector<Piece> pieces_;
  std::vector<BoundingBox> boxes_;
};

}  // namespace

std::vector<TriangleId> WithClashes(const Mesh& mesh, std::vector<TriangleId> cavity,
                                    const std::function<bool(VertexId)>& keeps,
                                    const StopSignal* stop) {
  return ClashFinder(mesh, std::move(cavity), keeps, stop).Run();
}

}  // namespace pliant
