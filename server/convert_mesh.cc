#include "server/convert_mesh.h"

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "server/convert_array.h"

namespace pliant::server {
namespace {

Status CheckFinite(const std::vector<Vec2>& points, const std::string& field) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!IsFinite(points[i])) {
      return Error{ErrorCode::kNotFinite,
                   field + " row " + std::to_string(i) + " has a NaN or infinite coordinate", field,
                   static_cast<std::int64_t>(i)};
    }
  }
  return {};
}

Result<std::vector<Vec2>> ReadPoints(const v1::Array& array, const std::string& field) {
  PLIANT_ASSIGN_OR_RETURN(std::vector<Vec2> points, ReadRows<Vec2>(array, field));
  PLIANT_RETURN_IF_ERROR(CheckFinite(points, field));
  return points;
}

// Rows of indices below `bound`.
template <std::size_t kColumns>
Result<std::vector<std::array<std::int32_t, kColumns>>> ReadIndices(const v1::Array& array,
                                                                    const std::string& field,
                                                                    std::size_t bound) {
  using Row = std::array<std::int32_t, kColumns>;
  PLIANT_ASSIGN_OR_RETURN(std::vector<Row> rows, ReadRows<Row>(array, field));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (const std::int32_t index : rows[i]) {
      if (index >= 0 && static_cast<std::size_t>(index) < bound) continue;
      return Error{ErrorCode::kIndexOutOfRange,
                   field + " row " + std::to_string(i) + " names point " + std::to_string(index) +
                       "; there are points 0 to " + std::to_string(bound) + ", the last excluded",
                   field, static_cast<std::int64_t>(i)};
    }
  }
  return rows;
}

// Tags of `count` elements; all 0 if the array is absent.
Result<std::vector<std::int32_t>> ReadTags(const v1::Array* array, const std::string& field,
                                           std::size_t count) {
  if (array == nullptr) return std::vector<std::int32_t>(count, 0);
  PLIANT_ASSIGN_OR_RETURN(std::vector<std::int32_t> tags, ReadRows<std::int32_t>(*array, field));
  if (tags.size() != count) {
    return Error{ErrorCode::kArrayLength,
                 field + " has " + std::to_string(tags.size()) + " rows; expected " +
                     std::to_string(count) + ", one for each element",
                 field};
  }
  return tags;
}

Status CheckCount(std::size_t count, std::size_t least, const std::string& field) {
  if (count >= least) return {};
  return Error{ErrorCode::kEmpty,
               field + " has " + std::to_string(count) + " rows; at least " +
                   std::to_string(least) + " are needed",
               field};
}

}  // namespace

Result<Domain> ConvertDomain(const v1::Domain& wire) {
  Domain domain;
  PLIANT_ASSIGN_OR_RETURN(domain.points, ReadPoints(wire.points(), "domain.points"));
  PLIANT_RETURN_IF_ERROR(CheckCount(domain.points.size(), 3, "domain.points"));
  PLIANT_ASSIGN_OR_RETURN(const auto segments,
                          ReadIndices<2>(wire.segments(), "domain.segments", domain.points.size()));
  PLIANT_RETURN_IF_ERROR(CheckCount(segments.size(), 3, "domain.segments"));
  PLIANT_ASSIGN_OR_RETURN(const std::vector<std::int32_t> tags,
                          ReadTags(wire.has_segment_tags() ? &wire.segment_tags() : nullptr,
                                   "domain.segment_tags", segments.size()));
  domain.segments.reserve(segments.size());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    domain.segments.push_back({segments[i][0], segments[i][1], tags[i]});
  }
  PLIANT_ASSIGN_OR_RETURN(domain.holes, ReadPoints(wire.holes(), "domain.holes"));
  PLIANT_ASSIGN_OR_RETURN(const std::vector<Vec2> region_points,
                          ReadPoints(wire.region_points(), "domain.region_points"));
  PLIANT_ASSIGN_OR_RETURN(
      const std::vector<std::int32_t> region_tags,
      ReadTags(&wire.region_tags(), "domain.region_tags", region_points.size()));
  for (std::size_t i = 0; i < region_points.size(); ++i) {
    domain.regions.push_back({region_points[i], region_tags[i]});
  }
  return domain;
}

Result<MeshData> ConvertMesh(const v1::MeshInput& wire, const std::string& path) {
  MeshData mesh;
  PLIANT_ASSIGN_OR_RETURN(mesh.points, ReadPoints(wire.points(), path + ".points"));
  PLIANT_RETURN_IF_ERROR(CheckCount(mesh.points.size(), 3, path + ".points"));
  PLIANT_ASSIGN_OR_RETURN(
      mesh.triangles, ReadIndices<3>(wire.triangles(), path + ".triangles", mesh.points.size()));
  PLIANT_RETURN_IF_ERROR(CheckCount(mesh.triangles.size(), 1, path + ".triangles"));
  PLIANT_ASSIGN_OR_RETURN(mesh.triangle_tags,
                          ReadTags(wire.has_triangle_tags() ? &wire.triangle_tags() : nullptr,
                                   path + ".triangle_tags", mesh.triangles.size()));
  PLIANT_ASSIGN_OR_RETURN(mesh.edges,
                          ReadIndices<2>(wire.edges(), path + ".edges", mesh.points.size()));
  PLIANT_ASSIGN_OR_RETURN(mesh.edge_tags,
                          ReadTags(wire.has_edge_tags() ? &wire.edge_tags() : nullptr,
                                   path + ".edge_tags", mesh.edges.size()));
  return mesh;
}

}  // namespace pliant::server
