#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// One fan of triangles around a vertex, counter-clockwise: triangle k is (center, ring[k],
/// ring[k+1]). A closed fan has as many ring vertices as triangles, an open one has one more.
///
/// Meant to be kept and gathered again, so that its arrays are allocated once.
class Star {
 public:
  /// The fan of `center` that contains its triangle `start`.
  /// @par Cost O(triangles of the fan)
  void Gather(const Mesh& mesh, VertexId center, TriangleId start) {
    center_ = center;
    const TriangleId first = mesh.FanStart(center, start);
    TriangleId current = first;
    VertexId last;
    std::size_t count = 0;
    do {
      if (count + 1 >= ring_.size()) Grow();
      const TriangleRecord& triangle = mesh.triangle(current);
      const int corner = mesh.CornerOf(current, center);
      const auto next = static_cast<std::size_t>(NextCorner(corner));
      ring_[count] = triangle.vertices[next];
      triangles_[count] = current;
      ++count;
      last = triangle.vertices[static_cast<std::size_t>(PreviousCorner(corner))];
      current = triangle.neighbors[next];
    } while (current.valid() && current != first);
    triangle_count_ = count;
    closed_ = current.valid();
    if (!closed_) ring_[count] = last;
  }
  void Gather(const Mesh& mesh, VertexId center) {
    Gather(mesh, center, mesh.vertex(center).triangle);
  }

  [[nodiscard]] VertexId center() const { return center_; }
  [[nodiscard]] bool closed() const { return closed_; }
  [[nodiscard]] std::span<const VertexId> ring() const {
    return {ring_.data(), triangle_count_ + (closed_ ? 0 : 1)};
  }
  [[nodiscard]] std::span<const TriangleId> triangles() const {
    return {triangles_.data(), triangle_count_};
  }
  /// The ring vertex after triangle k, wrapping around in a closed fan.
  [[nodiscard]] VertexId ring_after(std::size_t k) const {
    return k + 1 == triangle_count_ && closed_ ? ring_.front() : ring_[k + 1];
  }

 private:
  void Grow() {
    ring_.resize(2 * ring_.size());
    triangles_.resize(ring_.size());
  }

  VertexId center_;
  bool closed_ = false;
  std::size_t triangle_count_ = 0;
  std::vector<VertexId> ring_ = std::vector<VertexId>(16);  // Only ring() of it means something.
  std::vector<TriangleId> triangles_ = std::vector<TriangleId>(16);
};

/// One triangle of each fan around a vertex: one fan, but for a pinched vertex.
[[nodiscard]] std::vector<TriangleId> FansOf(const Mesh& mesh, VertexId vertex);

}  // namespace pliant
