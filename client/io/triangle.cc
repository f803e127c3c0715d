#include "client/io/triangle.h"

#include <cstddef>
#include <cstdint>
#include <utility>

#include "client/io/number_reader.h"
#include "client/io/number_writer.h"

namespace pliant::io {
namespace {

struct PointList {
  std::vector<Vec2> points;
  std::int64_t base = 0;  ///< What the file calls the first element: 0 or 1.
};

/// A number of the header's optional tail, such as "2 0 1" after the count of points.
std::int64_t OptionalInteger(NumberReader& reader, std::int64_t otherwise) {
  return reader.AtLineEnd() ? otherwise : reader.Integer();
}

/// Reads the running number of element i and holds it against what it should be.
void ReadNumber(NumberReader& reader, std::size_t i, std::int64_t base) {
  const std::int64_t number = reader.Integer();
  const std::int64_t expected = base + static_cast<std::int64_t>(i);
  if (reader.ok() && number != expected) {
    reader.FailSyntax("expected element number " + std::to_string(expected) + ", found " +
                      std::to_string(number));
  }
}

PointList ReadPoints(NumberReader& reader) {
  PointList list;
  const std::int64_t announced = reader.Integer();
  const std::int64_t dimension = OptionalInteger(reader, 2);
  if (reader.ok() && dimension != 2) {
    reader.Fail(ErrorCode::kFileUnsupported,
                "expected dimension 2, found " + std::to_string(dimension));
  }
  reader.SkipLine();
  list.points.resize(reader.Count(announced, 6));
  for (std::size_t i = 0; i < list.points.size() && reader.ok(); ++i) {
    if (i == 0) {
      list.base = reader.Integer();
      if (reader.ok() && list.base != 0 && list.base != 1) {
        reader.FailSyntax("expected the first point to have number 0 or 1, found " +
                          std::to_string(list.base));
      }
    } else {
      ReadNumber(reader, i, list.base);
    }
    list.points[i].x = reader.Real();
    list.points[i].y = reader.Real();
    // Attributes and the marker of a point have no meaning here.
    reader.SkipLine();
  }
  return list;
}

void ReadSegments(NumberReader& reader, std::int64_t base, Domain& domain) {
  const std::int64_t announced = reader.Integer();
  reader.SkipLine();
  domain.segments.resize(reader.Count(announced, 6));
  for (std::size_t i = 0; i < domain.segments.size() && reader.ok(); ++i) {
    ReadNumber(reader, i, base);
    domain.segments[i].a = reader.Index(base);
    domain.segments[i].b = reader.Index(base);
    if (!reader.AtLineEnd()) domain.segments[i].tag = reader.Tag();
    reader.SkipLine();
  }
}

void ReadSeeds(NumberReader& reader, std::int64_t base, Domain& domain) {
  if (reader.AtEnd()) return;
  const std::int64_t hole_count = reader.Integer();
  reader.SkipLine();
  domain.holes.resize(reader.Count(hole_count, 6));
  for (std::size_t i = 0; i < domain.holes.size() && reader.ok(); ++i) {
    ReadNumber(reader, i, base);
    domain.holes[i].x = reader.Real();
    domain.holes[i].y = reader.Real();
    reader.SkipLine();
  }
  if (reader.AtEnd()) return;
  const std::int64_t region_count = reader.Integer();
  reader.SkipLine();
  domain.regions.resize(reader.Count(region_count, 6));
  for (std::size_t i = 0; i < domain.regions.size() && reader.ok(); ++i) {
    ReadNumber(reader, i, base);
    domain.regions[i].point.x = reader.Real();
    domain.regions[i].point.y = reader.Real();
    if (!reader.AtLineEnd()) domain.regions[i].tag = reader.TagFromReal();
    // What may follow is an area constraint; here sizes come from the metric.
    reader.SkipLine();
  }
}

Status CheckSegments(const Domain& domain) {
  for (std::size_t i = 0; i < domain.segments.size(); ++i) {
    const Segment& s = domain.segments[i];
    const auto count = static_cast<std::int64_t>(domain.points.size());
    if (s.a < count && s.b < count) continue;
    return Error{.code = ErrorCode::kIndexOutOfRange,
                 .message = "segment " + std::to_string(i) + " names point " +
                            std::to_string(s.a < count ? s.b : s.a) +
                            " (both counted from 0), "
                            "but there are " +
                            std::to_string(count) + " points",
                 .field = "segments",
                 .index = static_cast<std::int64_t>(i)};
  }
  return {};
}

void ReadTriangles(NumberReader& reader, std::int64_t base, MeshData& mesh) {
  const std::int64_t announced = reader.Integer();
  const std::int64_t corner_count = OptionalInteger(reader, 3);
  if (reader.ok() && corner_count != 3) {
    reader.Fail(ErrorCode::kFileUnsupported, "expected 3 points per triangle, found " +
                                                 std::to_string(corner_count) +
                                                 "; run triangle without -o2");
  }
  const std::int64_t attribute_count = OptionalInteger(reader, 0);
  reader.SkipLine();
  mesh.triangles.resize(reader.Count(announced, 8));
  if (attribute_count > 0) mesh.triangle_tags.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size() && reader.ok(); ++i) {
    ReadNumber(reader, i, base);
    for (std::int32_t& point : mesh.triangles[i]) point = reader.Index(base);
    if (attribute_count > 0) mesh.triangle_tags[i] = reader.TagFromReal();
    reader.SkipLine();
  }
}

void ReadEdges(NumberReader& reader, std::int64_t base, MeshData& mesh) {
  const std::int64_t announced = reader.Integer();
  const std::int64_t marker_count = OptionalInteger(reader, 0);
  reader.SkipLine();
  const std::size_t count = reader.Count(announced, 6);
  const bool lists_all = 2 * count > 3 * mesh.triangles.size();
  for (std::size_t i = 0; i < count && reader.ok(); ++i) {
    ReadNumber(reader, i, base);
    const std::int32_t a = reader.Index(base);
    const std::int32_t b = reader.Index(base);
    const std::int32_t tag = marker_count > 0 ? reader.Tag() : 0;
    reader.SkipLine();
    if (lists_all && tag == 0) continue;
    mesh.edges.push_back({a, b});
    mesh.edge_tags.push_back(tag);
  }
}

Error InFile(Error error, const char* extension) {
  error.message = std::string(extension) + " " + error.message;
  return error;
}

}  // namespace

bool PolyRefersToNodeFile(std::string_view poly) {
  NumberReader reader(poly);
  return reader.Integer() == 0 && reader.ok();
}

Result<Domain> ParsePoly(std::string_view poly, std::string_view node) {
  NumberReader reader(poly);
  PointList list = ReadPoints(reader);
  PLIANT_RETURN_IF_ERROR(reader.status());
  if (list.points.empty() && !node.empty()) {
    NumberReader node_reader(node);
    list = ReadPoints(node_reader);
    if (!node_reader.ok()) return InFile(node_reader.status().error(), ".node");
  }
  Domain domain;
  domain.points = std::move(list.points);
  ReadSegments(reader, list.base, domain);
  ReadSeeds(reader, list.base, domain);
  PLIANT_RETURN_IF_ERROR(reader.status());
  PLIANT_RETURN_IF_ERROR(CheckSegments(domain));
  return domain;
}

std::string FormatPoly(const Domain& domain) {
  NumberWriter out;
  out << domain.points.size() << " 2 0 0\n";
  for (std::size_t i = 0; i < domain.points.size(); ++i) {
    out << i + 1 << ' ' << domain.points[i].x << ' ' << domain.points[i].y << '\n';
  }
  out << domain.segments.size() << " 1\n";
  for (std::size_t i = 0; i < domain.segments.size(); ++i) {
    const Segment& s = domain.segments[i];
    out << i + 1 << ' ' << std::int64_t{s.a} + 1 << ' ' << std::int64_t{s.b} + 1 << ' ' << s.tag
        << '\n';
  }
  out << domain.holes.size() << '\n';
  for (std::size_t i = 0; i < domain.holes.size(); ++i) {
    out << i + 1 << ' ' << domain.holes[i].x << ' ' << domain.holes[i].y << '\n';
  }
  out << domain.regions.size() << '\n';
  for (std::size_t i = 0; i < domain.regions.size(); ++i) {
    const RegionSeed& r = domain.regions[i];
    // -1: no area constraint.
    out << i + 1 << ' ' << r.point.x << ' ' << r.point.y << ' ' << r.tag << " -1\n";
  }
  return std::move(out).text();
}

Result<MeshData> ParseTriangleMesh(const TriangleFiles& files) {
  NumberReader node(files.node);
  PointList list = ReadPoints(node);
  if (!node.ok()) return InFile(node.status().error(), ".node");
  MeshData mesh;
  mesh.points = std::move(list.points);
  NumberReader ele(files.ele);
  ReadTriangles(ele, list.base, mesh);
  if (!ele.ok()) return InFile(ele.status().error(), ".ele");
  if (files.edge.has_value()) {
    NumberReader edge(*files.edge);
    ReadEdges(edge, list.base, mesh);
    if (!edge.ok()) return InFile(edge.status().error(), ".edge");
  }
  PLIANT_RETURN_IF_ERROR(CheckIndices(mesh));
  return mesh;
}

TriangleFiles FormatTriangleMesh(const MeshData& mesh) {
  NumberWriter node;
  node << mesh.points.size() << " 2 0 0\n";
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    node << i + 1 << ' ' << mesh.points[i].x << ' ' << mesh.points[i].y << '\n';
  }
  NumberWriter ele;
  ele << mesh.triangles.size() << " 3 1\n";
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    ele << i + 1;
    for (const std::int32_t point : mesh.triangles[i]) ele << ' ' << std::int64_t{point} + 1;
    ele << ' ' << (mesh.triangle_tags.empty() ? 0 : mesh.triangle_tags[i]) << '\n';
  }
  NumberWriter edge;
  edge << mesh.edges.size() << " 1\n";
  for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
    edge << i + 1 << ' ' << std::int64_t{mesh.edges[i][0]} + 1 << ' '
         << std::int64_t{mesh.edges[i][1]} + 1 << ' '
         << (mesh.edge_tags.empty() ? 0 : mesh.edge_tags[i]) << '\n';
  }
  return {
      .node = std::move(node).text(), .ele = std::move(ele).text(), .edge = std::move(edge).text()};
}

}  // namespace pliant::io
