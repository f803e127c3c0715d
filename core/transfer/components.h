#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/transfer/overlap.h"

namespace pliant {

/// The pieces of a touched region that have nothing to do with each other: what is conserved is
/// conserved in each of them. Two old or new triangles are in one piece if they overlap, or are
/// joined by what is linked.
///
/// *Invariants*: numbers of pieces depend on the region alone. *Threads*: one at a time.
class OverlapComponents {
 public:
  /// @param region  must outlive this.
  explicit OverlapComponents(const TouchedRegion& region);

  /// Joins triangle `after` with what was found under it, and with the nearest if that is nothing.
  void AddOverlaps(std::int32_t after, const OverlapFinder& found);
  /// Joins the triangles at each vertex of region.after, and the vertices `a` and `b`.
  void LinkCorners();
  void LinkVertices(std::int32_t a, std::int32_t b);

  /// Numbers the pieces. Old triangles under which no new one came to lie, because the boundary
  /// went over them, join their old neighbours, and where none of those is left either, the piece
  /// of the new triangle with the nearest centre.
  void Finish(const RegionLocator& locator);

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::size_t of_before(std::size_t triangle) const { return labels_[triangle]; }
  [[nodiscard]] std::size_t of_after(std::size_t triangle) const {
    return labels_[before_count_ + triangle];
  }
  [[nodiscard]] std::size_t of_vertex(std::size_t vertex) const {
    return labels_[before_count_ + after_count_ + vertex];
  }

 private:
  [[nodiscard]] std::size_t Root(std::size_t node);
  void Join(std::size_t a, std::size_t b);
  void JoinOrphans(const RegionLocator& locator);

  const TouchedRegion& region_;
  std::size_t before_count_ = 0;
  std::size_t after_count_ = 0;
  std::vector<std::size_t> parents_;  // Old triangles, new triangles, new vertices.
  std::vector<bool> met_;             // Per old triangle.
  std::vector<std::size_t> labels_;
  std::size_t count_ = 0;
};

}  // namespace pliant
