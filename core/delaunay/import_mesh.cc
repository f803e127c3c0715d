#include "core/delaunay/import_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <tuple>
#include <utility>

#include "core/delaunay/check_boundary.h"
#include "core/delaunay/recover_segments.h"
#include "core/delaunay/triangulate.h"
#include "core/geometry/predicates.h"

namespace pliant {
namespace {

Error MakeError(ErrorCode code, std::string field, std::int64_t index, std::string message) {
  return {code, std::move(message), std::move(field), index};
}

Status CheckArrays(const MeshData& mesh) {
  const auto point_count = static_cast<std::int64_t>(mesh.points.size());
  const auto bad_length = [](const char* field, std::size_t is, std::size_t wanted) {
    return MakeError(ErrorCode::kArrayLength, field, -1,
                     std::string(field) + " has " + std::to_string(is) + " entries; expected " +
                         std::to_string(wanted) + " or none");
  };
  const auto bad_index = [&](const char* field, std::size_t at, std::int32_t value) {
    return MakeError(ErrorCode::kIndexOutOfRange, field, static_cast<std::int64_t>(at),
                     std::string(field) + "[" + std::to_string(at) + "] names point " +
                         std::to_string(value) + "; there are points 0 to " +
                         std::to_string(point_count - 1));
  };
  if (mesh.triangles.empty()) {
    return MakeError(ErrorCode::kEmpty, "mesh.triangles", -1, "the mesh has no triangles");
  }
  if (!mesh.triangle_tags.empty() && mesh.triangle_tags.size() != mesh.triangles.size()) {
    return bad_length("mesh.triangle_tags", mesh.triangle_tags.size(), mesh.triangles.size());
  }
  if (!mesh.edge_tags.empty() && mesh.edge_tags.size() != mesh.edges.size()) {
    return bad_length("mesh.edge_tags", mesh.edge_tags.size(), mesh.edges.size());
  }
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (IsFinite(mesh.points[i])) continue;
    return MakeError(ErrorCode::kNotFinite, "mesh.points", static_cast<std::int64_t>(i),
                     "mesh.points[" + std::to_string(i) + "] is NaN or infinite");
  }
  const auto in_range = [&](std::int32_t i) { return i >= 0 && i < point_count; };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::int32_t i : mesh.triangles[t]) {
      if (!in_range(i)) return bad_index("mesh.triangles", t, i);
    }
  }
  for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
    for (const std::int32_t i : mesh.edges[e]) {
      if (!in_range(i)) return bad_index("mesh.edges", e, i);
    }
  }
  return {};
}

/// Triangles counter-clockwise, or why that cannot be.
Result<std::vector<NewTriangle>> OrientTriangles(const MeshData& mesh) {
  std::vector<NewTriangle> triangles;
  triangles.reserve(mesh.triangles.size());
  const auto orientation = [&](std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    return Orient2d(mesh.points[static_cast<std::size_t>(a)],
                    mesh.points[static_cast<std::size_t>(b)],
                    mesh.points[static_cast<std::size_t>(c)]);
  };
  const int first = orientation(0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto index = static_cast<std::int64_t>(t);
    const int sign = orientation(t);
    if (sign == 0) {
      return MakeError(
          ErrorCode::kTriangleDegenerate, "mesh.triangles", index,
          "triangle " + std::to_string(t) + " has no area; remove it and join its neighbours");
    }
    if (sign != first) {
      return MakeError(ErrorCode::kTriangleOrientation, "mesh.triangles", index,
                       "triangle " + std::to_string(t) + " is " +
                           (sign < 0 ? "clockwise" : "counter-clockwise") +
                           " but triangle 0 is not; give all corners in the same sense");
    }
    const auto& [a, b, c] = mesh.triangles[t];
    const std::int32_t tag = mesh.triangle_tags.empty() ? 0 : mesh.triangle_tags[t];
    triangles.push_back(
        {{VertexId(a), VertexId(sign > 0 ? b : c), VertexId(sign > 0 ? c : b)}, tag});
  }
  return triangles;
}

/// Every point is used, and by a fan or a few that the loop can walk around.
Status CheckPointsUsed(const MeshData& mesh) {
  std::vector<bool> used(mesh.points.size(), false);
  for (const auto& triangle : mesh.triangles) {
    for (const std::int32_t i : triangle) used[static_cast<std::size_t>(i)] = true;
  }
  const auto unused = std::find(used.begin(), used.end(), false);
  if (unused == used.end()) return {};
  const auto index = unused - used.begin();
  return MakeError(
      ErrorCode::kPointOutsideDomain, "mesh.points", index,
      "mesh.points[" + std::to_string(index) + "] belongs to no triangle; remove it or renumber");
}

}  // namespace

Result<MeshPlan> PlanDomain(const Domain& domain) {
  PLIANT_ASSIGN_OR_RETURN(const DomainTriangulation cdt, TriangulateDomain(domain));
  MeshPlan plan;
  plan.positions = domain.points;
  for (const DomainTriangulation::Triangle& triangle : cdt.triangles) {
    const auto& [a, b, c] = triangle.points;
    plan.triangles.push_back({{VertexId(a), VertexId(b), VertexId(c)}, triangle.region});
  }
  for (std::size_t i = 0; i < domain.segments.size(); ++i) {
    const Segment& segment = domain.segments[i];
    const std::array ends{VertexId(segment.a), VertexId(segment.b)};
    plan.edges.push_back({ends, {0, 1}, segment.tag, static_cast<std::int32_t>(i)});
    plan.segments.push_back({ends[0], ends[1]});
  }
  std::vector<bool> on_line(domain.points.size(), false);
  for (const Segment& segment : domain.segments) {
    on_line[static_cast<std::size_t>(segment.a)] = true;
    on_line[static_cast<std::size_t>(segment.b)] = true;
  }
  for (std::size_t i = 0; i < domain.points.size(); ++i) {
    plan.fixed.push_back(VertexId::FromIndex(i));
    if (!on_line[i]) plan.segments.push_back({VertexId::FromIndex(i), VertexId()});
  }
  return plan;
}

Result<MeshPlan> PlanImport(const MeshData& mesh) {
  PLIANT_RETURN_IF_ERROR(CheckArrays(mesh));
  MeshPlan plan;
  plan.positions = mesh.points;
  PLIANT_ASSIGN_OR_RETURN(plan.triangles, OrientTriangles(mesh));
  PLIANT_RETURN_IF_ERROR(CheckPointsUsed(mesh));
  PLIANT_ASSIGN_OR_RETURN(const std::vector<TaggedEdge> edges, CollectEdges(mesh, plan.triangles));
  PLIANT_RETURN_IF_ERROR(CheckBoundary(plan.positions, edges));
  RecoverSegments(edges, plan);
  return plan;
}

void BuildFromPlan(const MeshPlan& plan, MeshEdit& edit) {
  edit.Build(plan.positions, plan.triangles, plan.edges, plan.segments);
  for (const VertexId vertex : plan.fixed) edit.Fix(vertex);
}

}  // namespace pliant
