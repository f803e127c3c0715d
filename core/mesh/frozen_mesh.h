#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/box_tree.h"
#include "core/geometry/locate.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/slot_rows.h"
#include "core/metric/metric.h"

namespace pliant {

/// A mesh as it was at one moment, while the mesh itself goes on changing: a triangulation in which
/// points can be found and that carries tensors. Copies nothing but what changes: everything else
/// is read from the mesh, and what changed from the change log.
///
/// *Invariants*: the answers depend on the frozen mesh and the point, never on hints, on earlier
/// questions or on what became of the mesh.
/// *Memory*: what changed, and logarithms of at most kLogsMax vertices more.
/// *Threads*: one at a time, and not while another thread changes the mesh.
class FrozenMesh {
 public:
  struct Vertex {
    Vec2 position;
    Metric metric;
    bool live = false;
    bool has_log = false;
    LogMetric log;  ///< Of `metric`, once it was asked for.
  };
  struct Triangle {
    std::array<VertexId, 3> vertices;
    std::array<TriangleId, 3> neighbors;
    bool live = false;
  };

  /// Freezes the mesh as it is now. @pre it was committed before, so that changes are logged
  /// @par Cost O(changed since the last commit)
  explicit FrozenMesh(const MeshEdit& edit);

  /// Takes over what the log has; to be called before a commit, a rollback or a trial empties it,
  /// and then LogWasEmptied after it. @par Cost O(changed since the last call)
  void CatchUp();
  void LogWasEmptied();

  /// The triangle that holds p, or the nearest point of it: walks from triangle `hint`, any number.
  /// @par Cost tens of ns from a good hint; for a point outside O(log boundary), the first time
  ///           O(boundary).
  [[nodiscard]] Location Locate(Vec2 p, std::int32_t hint);

  /// The logarithm of the metric at p, log-Euclidean within a triangle; moves the hint along.
  [[nodiscard]] LogMetric LogAt(Vec2 p, std::int32_t& hint);

  [[nodiscard]] Triangle triangle(TriangleId id);
  [[nodiscard]] Vec2 position(VertexId id);
  /// Logarithm of the tensor of a vertex; as a rule computed once.
  [[nodiscard]] LogMetric Log(VertexId id);
  /// Another tensor than the vertex had.
  void SetMetric(VertexId id, const Metric& metric);

  /// What may have changed since: superset rows, with what was frozen. @pre CatchUp
  [[nodiscard]] const std::vector<SlotRows<Vertex>::Entry>& vertices() const {
    return vertices_.entries();
  }
  [[nodiscard]] const std::vector<SlotRows<Triangle>::Entry>& triangles() const {
    return triangles_.entries();
  }

 private:
  static constexpr std::size_t kLogsMax = std::size_t{1} << 15;
  static constexpr std::size_t kCellCount = 256;

  /// All that a question in a triangle reads: it comes from many places, and the next question is
  /// near.
  struct Cell {
    std::int32_t slot = -1;
    bool has_logs = false;
    std::array<TriangleId, 3> neighbors;
    std::array<VertexId, 3> vertices;
    std::array<Vec2, 3> points;
    std::array<LogMetric, 3> logs;
  };

  /// The cell of a live triangle; null for any other number. Valid until the next call.
  [[nodiscard]] Cell* FindCell(std::int32_t slot);
  [[nodiscard]] std::array<Vec2, 3> PointsOf(const Triangle& triangle);
  [[nodiscard]] std::int32_t Start(Vec2 p, std::int32_t hint);
  [[nodiscard]] Location WalkStraight(Vec2 p, std::int32_t start);
  [[nodiscard]] std::int32_t Walk(Vec2 p, std::int32_t start);
  [[nodiscard]] Location Inside(Vec2 p, std::int32_t slot);
  [[nodiscard]] Location FromBoundary(Vec2 p);
  [[nodiscard]] std::int32_t SearchDisc(Vec2 p, std::int32_t start, double squared_radius);
  void FindBoundary();

  const MeshEdit& edit_;
  const Mesh& mesh_;
  SlotRows<Vertex> vertices_;
  SlotRows<Triangle> triangles_;
  std::vector<Cell> cells_;        ///< By the last bits of the slot; empty until asked.
  SlotRows<LogMetric> logs_;       ///< Of vertices without a row; forgotten when they are too many.
  std::size_t seen_vertices_ = 0;  ///< Entries of the log that are in vertices_.
  std::size_t seen_triangles_ = 0;  ///< And in triangles_.
  bool outlived_log_ = false;       ///< Rows may belong to elements that are not touched now.
  std::int32_t last_ = 0;           ///< Where the last walk ended.
  std::optional<BoxTree> boundary_tree_;
  std::vector<std::int32_t> boundary_;  ///< Triangles with a side on the boundary, ascending.
};

}  // namespace pliant
