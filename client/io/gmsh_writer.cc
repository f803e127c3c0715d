#include "client/io/gmsh_writer.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "client/io/gmsh_elements.h"
#include "client/io/number_writer.h"
#include "core/base/sort_unique.h"

namespace pliant::io {
namespace {

/// The distinct tags of elements, in ascending order; entity i + 1 of the model has tags[i].
std::vector<std::int32_t> DistinctTags(std::vector<std::int32_t> tags, std::size_t element_count) {
  if (tags.empty() && element_count > 0) tags.push_back(0);
  SortUnique(tags);
  return tags;
}

std::int64_t EntityOf(const std::vector<std::int32_t>& distinct_tags, std::int32_t tag) {
  return std::lower_bound(distinct_tags.begin(), distinct_tags.end(), tag) - distinct_tags.begin() +
         1;
}

std::int32_t TagOf(const std::vector<std::int32_t>& tags, std::size_t i) {
  return tags.empty() ? 0 : tags[i];
}

void WriteFields(NumberWriter& out, const std::vector<PointField>& fields) {
  for (const PointField& field : fields) {
    const auto components = static_cast<std::size_t>(field.component_count);
    const std::size_t count = field.values.size() / components;
    std::string name = field.name;
    std::replace(name.begin(), name.end(), '"', '\'');
    std::replace(name.begin(), name.end(), '\n', ' ');
    out << "$NodeData\n1\n\"" << name << "\"\n1\n0\n3\n0\n"
        << (components == 1 ? 1 : 9) << '\n'
        << count << '\n';
    for (std::size_t i = 0; i < count; ++i) {
      const double* v = field.values.data() + i * components;
      out << i + 1 << ' ' << v[0];
      if (components == 3) {
        out << ' ' << v[1] << " 0 " << v[1] << ' ' << v[2] << " 0 0 0 0";
      }
      out << '\n';
    }
    out << "$EndNodeData\n";
  }
}

template <std::size_t kCorners>
void WriteElements22(NumberWriter& out, std::size_t number,
                     const std::vector<std::array<std::int32_t, kCorners>>& elements,
                     const std::vector<std::int32_t>& tags) {
  const std::vector<std::int32_t> distinct_tags = DistinctTags(tags, elements.size());
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const std::int32_t tag = TagOf(tags, i);
    out << number + i << ' ' << (kCorners == 2 ? kGmshLine : kGmshTriangle) << " 2 " << tag << ' '
        << EntityOf(distinct_tags, tag);
    for (const std::int32_t point : elements[i]) out << ' ' << std::int64_t{point} + 1;
    out << '\n';
  }
}

void WriteEntities(NumberWriter& out, const MeshData& mesh,
                   const std::vector<std::int32_t>& curve_tags,
                   const std::vector<std::int32_t>& surface_tags) {
  Vec2 low = mesh.points.empty() ? Vec2{} : mesh.points.front();
  Vec2 high = low;
  for (const Vec2 p : mesh.points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  out << "$Entities\n0 " << curve_tags.size() << ' ' << surface_tags.size() << " 0\n";
  for (const std::vector<std::int32_t>* tags : {&curve_tags, &surface_tags}) {
    for (std::size_t i = 0; i < tags->size(); ++i) {
      out << i + 1 << ' ' << low.x << ' ' << low.y << " 0 " << high.x << ' ' << high.y << " 0 ";
      if ((*tags)[i] == 0) {
        out << "0 0\n";
      } else {
        out << "1 " << (*tags)[i] << " 0\n";
      }
    }
  }
  out << "$EndEntities\n";
}

/// The place after the last element of the run of equal tags that starts at i.
std::size_t EndOfRun(const std::vector<std::int32_t>& tags, std::size_t i, std::size_t size) {
  if (tags.empty()) return size;
  std::size_t end = i + 1;
  while (end < size && tags[end] == tags[i]) ++end;
  return end;
}

std::size_t RunCount(const std::vector<std::int32_t>& tags, std::size_t size) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < size; i = EndOfRun(tags, i, size)) ++count;
  return count;
}

template <std::size_t kCorners>
void WriteElements41(NumberWriter& out, std::size_t number,
                     const std::vector<std::array<std::int32_t, kCorners>>& elements,
                     const std::vector<std::int32_t>& tags) {
  const std::vector<std::int32_t> distinct_tags = DistinctTags(tags, elements.size());
  const std::size_t size = elements.size();
  for (std::size_t begin = 0; begin < size;) {
    const std::size_t end = EndOfRun(tags, begin, size);
    out << kCorners - 1 << ' ' << EntityOf(distinct_tags, TagOf(tags, begin)) << ' '
        << (kCorners == 2 ? kGmshLine : kGmshTriangle) << ' ' << end - begin << '\n';
    for (std::size_t i = begin; i < end; ++i) {
      out << number + i;
      for (const std::int32_t point : elements[i]) out << ' ' << std::int64_t{point} + 1;
      out << '\n';
    }
    begin = end;
  }
}

}  // namespace

std::string FormatGmsh22(const MeshData& mesh, const std::vector<PointField>& fields) {
  NumberWriter out;
  out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << mesh.points.size() << '\n';
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    out << i + 1 << ' ' << mesh.points[i].x << ' ' << mesh.points[i].y << " 0\n";
  }
  out << "$EndNodes\n$Elements\n" << mesh.edges.size() + mesh.triangles.size() << '\n';
  WriteElements22(out, 1, mesh.edges, mesh.edge_tags);
  WriteElements22(out, mesh.edges.size() + 1, mesh.triangles, mesh.triangle_tags);
  out << "$EndElements\n";
  WriteFields(out, fields);
  return std::move(out).text();
}

std::string FormatGmsh41(const MeshData& mesh, const std::vector<PointField>& fields) {
  const std::size_t point_count = mesh.points.size();
  const std::size_t element_count = mesh.edges.size() + mesh.triangles.size();
  const auto surface_tags = DistinctTags(mesh.triangle_tags, mesh.triangles.size());
  NumberWriter out;
  out << "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
  WriteEntities(out, mesh, DistinctTags(mesh.edge_tags, mesh.edges.size()), surface_tags);
  // All nodes are said to lie on the first surface: to which entity a node belongs means nothing
  // to a reader of the mesh.
  out << "$Nodes\n1 " << point_count << " 1 " << point_count << '\n'
      << (surface_tags.empty() ? 1 : 2) << " 1 0 " << point_count << '\n';
  for (std::size_t i = 0; i < point_count; ++i) out << i + 1 << '\n';
  for (const Vec2 p : mesh.points) out << p.x << ' ' << p.y << " 0\n";
  out << "$EndNodes\n$Elements\n"
      << RunCount(mesh.edge_tags, mesh.edges.size()) +
             RunCount(mesh.triangle_tags, mesh.triangles.size())
      << ' ' << element_count << " 1 " << element_count << '\n';
  WriteElements41(out, 1, mesh.edges, mesh.edge_tags);
  WriteElements41(out, mesh.edges.size() + 1, mesh.triangles, mesh.triangle_tags);
  out << "$EndElements\n";
  WriteFields(out, fields);
  return std::move(out).text();
}

}  // namespace pliant::io
