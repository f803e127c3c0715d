#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/delaunay/delaunay.h"
#include "core/geometry/vec2.h"

namespace pliant {

/// Makes segments edges of a triangulation, one after the other, and keeps it constrained Delaunay.
///
/// *Invariants*: between calls, each segment inserted so far is an edge and carries its number on
/// both sides; every other edge is Delaunay among the points that can see it.
class Constrainer {
 public:
  /// @param points, hull  stay the caller's and must outlive this object.
  Constrainer(std::span<const Vec2> points, HullTriangulation& hull)
      : points_(points), hull_(hull), marks_(hull.triangles.size(), -1) {}

  struct Edge {
    std::int32_t segment;  ///< The number that the edge will carry.
    std::int32_t from;
    std::int32_t to;
  };
  enum class Outcome {
    kInserted,
    kBlocked,  ///< It crosses a segment or runs through a point; nothing was changed.
  };

  /// Removes the triangles that the edge crosses and triangulates the polygons left and right of
  /// it. [Anglada1997]
  ///
  /// @pre edge.from != edge.to, no segment joins them yet, and every number is used once.
  /// @par Cost  the degree of edge.from, and typically k log k, at worst k^2, for k edges crossed.
  [[nodiscard]] Outcome Insert(const Edge& edge);

 private:
  /// A side of a triangle.
  struct Side {
    std::int32_t triangle;
    std::size_t corner;  ///< Opposite the side.
  };
  enum class Way {
    kEdge,      ///< `side` joins the two points already.
    kAcross,    ///< The way leaves the first triangle by `side`.
    kOverPoint  ///< The way runs through a point at once.
  };
  struct Departure {
    Way way;
    Side side;
  };
  /// What is known of one side of an edge while a hole is filled: the triangle there, and the
  /// segment that the edge lies on. Either may be missing (-1).
  struct EdgeRecord {
    std::int32_t lower;
    std::int32_t upper;
    Side side;
    std::int32_t segment;
  };
  /// Points of a chain between two ends, all to the left of the line from the first to the last.
  struct Pocket {
    std::int32_t start;
    std::int32_t end;
    std::size_t first;
    std::size_t count;
  };

  [[nodiscard]] Vec2 Point(std::int32_t i) const { return points_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] HullTriangulation::Triangle& At(std::int32_t t) const {
    return hull_.triangles[static_cast<std::size_t>(t)];
  }
  [[nodiscard]] Departure Depart(const Edge& edge) const;
  void MarkSegment(Side side, std::int32_t segment) const;
  [[nodiscard]] Outcome Cross(const Edge& edge, Side side);
  void Refill(const Edge& edge);
  void RecordRim(std::int32_t triangle);
  void FillPocket(const Pocket& whole, std::span<const std::int32_t> chain);
  [[nodiscard]] std::size_t ChooseApex(const Pocket& pocket,
                                       std::span<const std::int32_t> chain) const;
  void LinkRecords();

  std::span<const Vec2> points_;
  HullTriangulation& hull_;
  std::vector<std::int32_t> marks_;    ///< The last segment that crossed a triangle.
  std::vector<std::int32_t> crossed_;  ///< Triangles to remove, then to be used again.
  std::vector<std::int32_t> left_;     ///< Points left of the edge, from its start to its end.
  std::vector<std::int32_t> right_;
  std::vector<EdgeRecord> records_;
  std::vector<Pocket> pockets_;
};

}  // namespace pliant
