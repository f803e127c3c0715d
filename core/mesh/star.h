#pragma once

#include <cstddef>
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
    ring_.clear();
    triangles_.clear();
    const TriangleId first = mesh.FanStart(center, start);
    TriangleId current = first;
    do {
      const TriangleRecord& triangle = mesh.triangle(current);
      const int corner = mesh.CornerOf(current, center);
      const auto next = static_cast<std::size_t>(NextCorner(corner));
      ring_.push_back(triangle.vertices[next]);
      triangles_.push_back(current);
      last_ = triangle.vertices[static_cast<std::size_t>(PreviousCorner(corner))];
      current = triangle.neighbors[next];
    } while (current.valid() && current != first);
    closed_ = current.valid();
    if (!closed_) ring_.push_back(last_);
  }
  void Gather(const Mesh& mesh, VertexId center) {
    Gather(mesh, center, mesh.vertex(center).triangle);
  }

  [[nodiscard]] VertexId center() const { return center_; }
  [[nodiscard]] bool closed() const { return closed_; }
  [[nodiscard]] const std::vector<VertexId>& ring() const { return ring_; }
  [[nodiscard]] const std::vector<TriangleId>& triangles() const { return triangles_; }
  /// The ring vertex after triangle k, wrapping around in a closed fan.
  [[nodiscard]] VertexId ring_after(std::size_t k) const {
    return k + 1 == ring_.size() ? ring_.front() : ring_[k + 1];
  }

 private:
  VertexId center_;
  VertexId last_;
  bool closed_ = false;
  std::vector<VertexId> ring_;
  std::vector<TriangleId> triangles_;
};

/// One triangle of each fan around a vertex: one fan, but for a pinched vertex.
[[nodiscard]] std::vector<TriangleId> FansOf(const Mesh& mesh, VertexId vertex);

}  // namespace pliant
