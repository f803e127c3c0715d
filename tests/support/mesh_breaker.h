#pragma once

#include <cstddef>
#include <vector>

#include "core/mesh/mesh.h"

namespace pliant {

/// Writes where only MeshEdit may.
class MeshBreaker {
 public:
  explicit MeshBreaker(Mesh& mesh) : mesh_(mesh) {}
  VertexRecord& vertex(std::size_t i) { return mesh_.vertices_[i]; }
  TriangleRecord& triangle(std::size_t i) { return mesh_.triangles_[i]; }
  EdgeRecord& edge(std::size_t i) { return mesh_.edges_[i]; }
  std::vector<SegmentRecord>& segments() { return mesh_.segments_; }
  SlotAllocator& vertices() { return mesh_.vertex_allocator_; }
  SlotAllocator& triangles() { return mesh_.triangle_allocator_; }
  SlotAllocator& edges() { return mesh_.edge_allocator_; }

 private:
  Mesh& mesh_;
};

}  // namespace pliant
