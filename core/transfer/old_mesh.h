#pragma once

#include "core/mesh/change_log.h"
#include "core/mesh/mesh.h"
#include "core/transfer/slot_map.h"

namespace pliant {

/// The mesh of the last commit, read through the change log: what was touched since stands there,
/// everything else in the mesh itself.
///
/// *Threads*: any number of readers, while neither mesh nor log changes.
/// @par Cost  O(changed) to make, O(1) a question.
class OldMesh {
 public:
  /// @param mesh, log  of one MeshEdit, after its first commit; must outlive this.
  OldMesh(const Mesh& mesh, const ChangeLog& log)
      : mesh_(mesh), log_(log), vertices_(log.vertices.size()), triangles_(log.triangles.size()) {
    for (const auto& [id, record] : log.vertices) vertices_.Add(id.value());
    for (const auto& [id, record] : log.triangles) triangles_.Add(id.value());
  }

  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  [[nodiscard]] const ChangeLog& log() const { return log_; }

  /// @pre the slot was in use at the last commit
  [[nodiscard]] const VertexRecord& vertex(VertexId id) const {
    const VertexRecord& now = mesh_.vertex(id);
    return now.touched ? log_.vertices[Index(vertices_, id.value())].second : now;
  }
  [[nodiscard]] const TriangleRecord& triangle(TriangleId id) const {
    const TriangleRecord& now = mesh_.triangle(id);
    return now.touched ? log_.triangles[Index(triangles_, id.value())].second : now;
  }
  [[nodiscard]] Vec2 position(VertexId id) const { return vertex(id).position; }

 private:
  static std::size_t Index(const SlotMap& map, std::int32_t slot) {
    return static_cast<std::size_t>(map.Find(slot));
  }

  const Mesh& mesh_;
  const ChangeLog& log_;
  SlotMap vertices_;  // Positions in the log.
  SlotMap triangles_;
};

}  // namespace pliant
