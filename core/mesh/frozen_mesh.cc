#include "core/mesh/frozen_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/sort_unique.h"
#include "core/geometry/predicates.h"
#include "core/geometry/triangle_point.h"

namespace pliant {
namespace {

FrozenMesh::Vertex RowOf(const VertexRecord& record) {
  return {.position = record.position, .metric = record.metric, .live = record.live, .log = {}};
}

FrozenMesh::Triangle RowOf(const TriangleRecord& record) {
  return {.vertices = record.vertices, .neighbors = record.neighbors, .live = record.live};
}

bool IsOnBoundary(const FrozenMesh::Triangle& triangle) {
  return triangle.live &&
         std::ranges::any_of(triangle.neighbors, [](TriangleId across) { return !across.valid(); });
}

}  // namespace

FrozenMesh::FrozenMesh(const MeshEdit& edit) : edit_(edit), mesh_(edit.mesh()) {
  // The log has what these were at the last commit, not what they are.
  vertices_.Reserve(edit.log().vertices.size());
  triangles_.Reserve(edit.log().triangles.size());
  for (const auto& [id, old] : edit.log().vertices) {
    vertices_.Insert(id.value(), RowOf(mesh_.vertex(id)));
  }
  for (const auto& [id, old] : edit.log().triangles) {
    triangles_.Insert(id.value(), RowOf(mesh_.triangle(id)));
  }
  seen_vertices_ = edit.log().vertices.size();
  seen_triangles_ = edit.log().triangles.size();
}

void FrozenMesh::CatchUp() {
  const ChangeLog& log = edit_.log();
  for (; seen_vertices_ < log.vertices.size(); ++seen_vertices_) {
    const auto& [id, old] = log.vertices[seen_vertices_];
    if (vertices_.Find(id.value()) == nullptr) vertices_.Insert(id.value(), RowOf(old));
  }
  for (; seen_triangles_ < log.triangles.size(); ++seen_triangles_) {
    const auto& [id, old] = log.triangles[seen_triangles_];
    if (triangles_.Find(id.value()) == nullptr) triangles_.Insert(id.value(), RowOf(old));
  }
}

void FrozenMesh::LogWasEmptied() {
  seen_vertices_ = 0;
  seen_triangles_ = 0;
  outlived_log_ = true;
}

FrozenMesh::Triangle FrozenMesh::triangle(TriangleId id) {
  const TriangleRecord& now = mesh_.triangle(id);
  if (now.touched || outlived_log_) {
    const Triangle* row = triangles_.Find(id.value());
    if (row != nullptr) return *row;
  }
  return RowOf(now);
}

Vec2 FrozenMesh::position(VertexId id) {
  const VertexRecord& now = mesh_.vertex(id);
  if (now.touched || outlived_log_) {
    const Vertex* row = vertices_.Find(id.value());
    if (row != nullptr) return row->position;
  }
  return now.position;
}

LogMetric FrozenMesh::Log(VertexId id) {
  CatchUp();
  if (Vertex* row = vertices_.Find(id.value()); row != nullptr) {
    if (!row->has_log) row->log = pliant::Log(row->metric);
    row->has_log = true;
    return row->log;
  }
  if (const LogMetric* log = logs_.Find(id.value()); log != nullptr) return *log;
  if (logs_.entries().size() >= kLogsMax) logs_.Clear();
  return logs_.Insert(id.value(), pliant::Log(mesh_.metric(id)));
}

void FrozenMesh::SetMetric(VertexId id, const Metric& metric) {
  CatchUp();
  Vertex* row = vertices_.Find(id.value());
  if (row == nullptr) row = &vertices_.Insert(id.value(), RowOf(mesh_.vertex(id)));
  row->metric = metric;
  row->has_log = false;
  cells_.clear();
}

std::array<Vec2, 3> FrozenMesh::PointsOf(const Triangle& triangle) {
  const auto& [a, b, c] = triangle.vertices;
  return {position(a), position(b), position(c)};
}

FrozenMesh::Cell* FrozenMesh::FindCell(std::int32_t slot) {
  if (slot < 0 || slot >= mesh_.triangle_slots()) return nullptr;
  if (cells_.empty()) cells_.resize(kCellCount);
  Cell& cell = cells_[static_cast<std::size_t>(slot) % kCellCount];
  if (cell.slot == slot) return &cell;
  const Triangle here = triangle(TriangleId(slot));
  if (!here.live) return nullptr;
  cell.slot = slot;
  cell.has_logs = false;
  cell.neighbors = here.neighbors;
  cell.vertices = here.vertices;
  cell.points = PointsOf(here);
  return &cell;
}

LogMetric FrozenMesh::LogAt(Vec2 p, std::int32_t& hint) {
  const Location location = Locate(p, hint);
  hint = location.triangle;
  Cell& cell = *FindCell(hint);
  if (!cell.has_logs) {
    for (std::size_t k = 0; k < 3; ++k) cell.logs[k] = Log(cell.vertices[k]);
    cell.has_logs = true;
  }
  LogMetric mean = location.weights[0] * cell.logs[0];
  for (std::size_t k = 1; k < 3; ++k) mean = mean + location.weights[k] * cell.logs[k];
  return mean;
}

/// Where to begin: at the hint or where the last walk ended, whichever is nearer; else anywhere.
std::int32_t FrozenMesh::Start(Vec2 p, std::int32_t hint) {
  const auto squared_distance = [&](const Cell* cell) {
    const Vec2 way = cell == nullptr ? Vec2{} : cell->points[0] - p;
    return cell == nullptr ? std::numeric_limits<double>::infinity() : Dot(way, way);
  };
  const Cell* hinted = FindCell(hint);
  if (hint == last_ && hinted != nullptr) return hint;
  const double from_hint = squared_distance(hinted);
  const Cell* last = FindCell(last_);
  if (hinted == nullptr && last == nullptr) {
    std::int32_t slot = 0;
    while (FindCell(slot) == nullptr) ++slot;
    return slot;
  }
  return squared_distance(last) < from_hint ? last_ : hint;
}

Location FrozenMesh::Locate(Vec2 p, std::int32_t hint) {
  CatchUp();
  Location location = WalkStraight(p, Start(p, hint));
  if (!location.inside) {
    const std::int32_t found = Walk(p, location.triangle);
    location = found >= 0 ? Inside(p, found) : FromBoundary(p);
  }
  last_ = location.triangle;
  return location;
}

/// The usual case without exact arithmetic, as that of TriangleLocator: if p ends up inside a
/// triangle and clear of its sides, that is the answer. Otherwise the answer is not `inside` and
/// has only the triangle where the walk ended.
Location FrozenMesh::WalkStraight(Vec2 p, std::int32_t start) {
  const double steps_max = 64 + 8 * std::sqrt(static_cast<double>(mesh_.triangle_slots()));
  std::int32_t at = start;
  for (int step = 0; step < steps_max; ++step) {
    const Cell& here = *FindCell(at);
    const std::array<Vec2, 3>& corners = here.points;
    const std::array<Vec2, 3> to = {corners[0] - p, corners[1] - p, corners[2] - p};
    const std::array<double, 3> areas = {Cross(to[1], to[2]), Cross(to[2], to[0]),
                                         Cross(to[0], to[1])};
    if (internal::MarginOfOrient2d(corners[1], corners[2], p) > 0 &&
        internal::MarginOfOrient2d(corners[2], corners[0], p) > 0 &&
        internal::MarginOfOrient2d(corners[0], corners[1], p) > 0) {
      return {.triangle = at, .weights = WeightsFromAreas(corners, p, areas), .inside = true};
    }
    std::size_t side = areas[1] < areas[0] ? 1 : 0;
    if (areas[2] < areas[side]) side = 2;
    if (!(areas[side] < 0) || !here.neighbors[side].valid()) break;
    at = here.neighbors[side].value();
  }
  return {.triangle = at, .weights = {}, .inside = false};
}

/// A visibility walk, as that of TriangleLocator. [Devillers2002]
std::int32_t FrozenMesh::Walk(Vec2 p, std::int32_t start) {
  // Across the whole mesh and some way back; a walk that takes longer goes in circles.
  const double steps_max = 64 + 8 * std::sqrt(static_cast<double>(mesh_.triangle_slots()));
  TriangleId from;
  TriangleId at(start);
  for (int step = 0; step < steps_max; ++step) {
    const Triangle here = triangle(at);
    const std::array<Vec2, 3> corners = PointsOf(here);
    bool is_outside = false;
    TriangleId next;
    for (int k = 0; k < 3 && !next.valid(); ++k) {
      const auto side = static_cast<std::size_t>((step + k) % 3);
      if (from.valid() && here.neighbors[side] == from) continue;
      if (Orient2d(corners[(side + 1) % 3], corners[(side + 2) % 3], p) >= 0) continue;
      is_outside = true;
      next = here.neighbors[side];
    }
    if (!next.valid()) return is_outside ? -1 : at.value();
    from = at;
    at = next;
  }
  return -1;
}

/// The answer for a point of a triangle: the same from either triangle at a side. At a corner the
/// weights are 0 and 1, so that it makes no difference which of the triangles there answers.
Location FrozenMesh::Inside(Vec2 p, std::int32_t slot) {
  Triangle here = triangle(TriangleId(slot));
  std::array<int, 3> signs = SideSigns(PointsOf(here), p);
  for (std::size_t i = 0; i < 3; ++i) {
    const TriangleId across = here.neighbors[i];
    if (signs[i] != 0 || !across.valid() || across.value() > slot) continue;
    slot = across.value();
    here = triangle(across);
    signs = SideSigns(PointsOf(here), p);
    break;
  }
  return {.triangle = slot, .weights = InteriorWeights(PointsOf(here), p, signs), .inside = true};
}

/// The answer for a point that no walk reaches: outside, or round a corner.
Location FrozenMesh::FromBoundary(Vec2 p) {
  FindBoundary();
  Location nearest;
  double squared_distance = std::numeric_limits<double>::infinity();
  boundary_tree_->ForEachNear(p, [&](std::int32_t index) {
    const std::int32_t slot = boundary_[static_cast<std::size_t>(index)];
    const Triangle here = triangle(TriangleId(slot));
    for (std::size_t side = 0; side < 3; ++side) {
      if (here.neighbors[side].valid()) continue;
      const BoundaryPoint candidate = NearestOnSide(PointsOf(here), side, p);
      const bool is_tie = candidate.squared_distance == squared_distance;
      if (candidate.squared_distance < squared_distance || nearest.triangle < 0 ||
          (is_tie && slot < nearest.triangle)) {
        squared_distance = candidate.squared_distance;
        nearest = {.triangle = slot, .weights = candidate.weights, .inside = false};
      }
    }
    return squared_distance;
  });
  const std::int32_t around = SearchDisc(p, nearest.triangle, squared_distance);
  return around >= 0 ? Inside(p, around) : nearest;
}

/// The triangle around p, if there is one: then the disc around p up to the nearest point of the
/// boundary lies in the mesh, and the triangles that meet it hang together.
std::int32_t FrozenMesh::SearchDisc(Vec2 p, std::int32_t start, double squared_radius) {
  SlotRows<char> seen;
  std::vector<std::int32_t> waiting = {start};
  seen.Insert(start, 0);
  while (!waiting.empty()) {
    const std::int32_t slot = waiting.back();
    waiting.pop_back();
    const Triangle here = triangle(TriangleId(slot));
    const std::array<Vec2, 3> corners = PointsOf(here);
    if (Contains(corners, p)) return slot;
    for (std::size_t side = 0; side < 3; ++side) {
      const TriangleId across = here.neighbors[side];
      if (!across.valid() || seen.Find(across.value()) != nullptr) continue;
      if (NearestOnSide(corners, side, p).squared_distance > squared_radius) continue;
      seen.Insert(across.value(), 0);
      waiting.push_back(across.value());
    }
  }
  return -1;
}

/// The triangles at the boundary of the frozen mesh: those that are there still, found by the
/// constrained edges, and those that are not.
void FrozenMesh::FindBoundary() {
  if (boundary_tree_) return;
  for (std::int32_t e = 0; e < mesh_.edge_slots(); ++e) {
    const EdgeRecord& edge = mesh_.edge(EdgeId(e));
    if (!edge.live || triangles_.Find(edge.triangle.value()) != nullptr) continue;
    if (IsOnBoundary(triangle(edge.triangle))) boundary_.push_back(edge.triangle.value());
  }
  for (const auto& [slot, row] : triangles_.entries()) {
    if (IsOnBoundary(row)) boundary_.push_back(slot);
  }
  SortUnique(boundary_);
  std::vector<BoundingBox> boxes;
  boxes.reserve(boundary_.size());
  for (const std::int32_t slot : boundary_) {
    boxes.push_back(BoxOf(PointsOf(triangle(TriangleId(slot)))));
  }
  boundary_tree_.emplace(boxes);
}

}  // namespace pliant
