#include "client/io/vtu.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace pliant::io {
namespace {

static_assert(std::endian::native == std::endian::little, "binary files are written as they are");

constexpr std::uint8_t kVtkLine = 3;
constexpr std::uint8_t kVtkTriangle = 5;

void AppendBase64(std::string_view bytes, std::string& out) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  out.reserve(out.size() + (bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t byte = i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0;
      group = group << 8 | byte;
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const bool padding = i + k > bytes.size();
      out.push_back(padding ? '=' : kDigits[group >> (18 - 6 * k) & 63]);
    }
  }
}

std::string EscapeXml(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '"') {
      out += "&quot;";
    } else {
      out += static_cast<unsigned char>(c) < ' ' ? '?' : c;
    }
  }
  return out;
}

template <class T>
void AppendArray(std::string_view attributes, const std::vector<T>& values, std::string& out) {
  const std::uint64_t size = values.size() * sizeof(T);
  std::string bytes(sizeof(size) + size, '\0');
  std::memcpy(bytes.data(), &size, sizeof(size));
  if (size > 0) std::memcpy(bytes.data() + sizeof(size), values.data(), size);
  out.append("        <DataArray ").append(attributes).append(" format=\"binary\">");
  AppendBase64(bytes, out);
  out.append("</DataArray>\n");
}

void AppendCells(const MeshData& mesh, std::string& out) {
  std::vector<std::int32_t> connectivity;
  std::vector<std::int64_t> offsets;
  std::vector<std::uint8_t> types(mesh.triangles.size(), kVtkTriangle);
  types.resize(mesh.triangles.size() + mesh.edges.size(), kVtkLine);
  connectivity.reserve(3 * mesh.triangles.size() + 2 * mesh.edges.size());
  offsets.reserve(types.size());
  for (const auto& triangle : mesh.triangles) {
    connectivity.insert(connectivity.end(), triangle.begin(), triangle.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  for (const auto& edge : mesh.edges) {
    connectivity.insert(connectivity.end(), edge.begin(), edge.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  out.append("      <Cells>\n");
  AppendArray("type=\"Int32\" Name=\"connectivity\"", connectivity, out);
  AppendArray("type=\"Int64\" Name=\"offsets\"", offsets, out);
  AppendArray("type=\"UInt8\" Name=\"types\"", types, out);
  out.append("      </Cells>\n");

  std::vector<std::int32_t> tags = mesh.triangle_tags;
  tags.resize(mesh.triangles.size());
  tags.insert(tags.end(), mesh.edge_tags.begin(), mesh.edge_tags.end());
  tags.resize(types.size());
  out.append("      <CellData Scalars=\"tag\">\n");
  AppendArray("type=\"Int32\" Name=\"tag\"", tags, out);
  out.append("      </CellData>\n");
}

void AppendFields(const std::vector<PointField>& fields, std::string& out) {
  out.append("      <PointData>\n");
  for (const PointField& field : fields) {
    const std::string name = "type=\"Float64\" Name=\"" + EscapeXml(field.name) + "\"";
    if (field.component_count == 1) {
      AppendArray(name, field.values, out);
      continue;
    }
    std::vector<double> full;
    full.reserve(3 * field.values.size());
    for (std::size_t i = 0; i + 2 < field.values.size(); i += 3) {
      const double m11 = field.values[i];
      const double m12 = field.values[i + 1];
      const double m22 = field.values[i + 2];
      full.insert(full.end(), {m11, m12, 0, m12, m22, 0, 0, 0, 0});
    }
    AppendArray(name + " NumberOfComponents=\"9\"", full, out);
  }
  out.append("      </PointData>\n");
}

}  // namespace

std::string FormatVtu(const MeshData& mesh, const std::vector<PointField>& fields) {
  std::string out =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n"
      "  <UnstructuredGrid>\n    <Piece NumberOfPoints=\"" +
      std::to_string(mesh.points.size()) + "\" NumberOfCells=\"" +
      std::to_string(mesh.triangles.size() + mesh.edges.size()) + "\">\n";
  std::vector<double> points;
  points.reserve(3 * mesh.points.size());
  for (const Vec2 p : mesh.points) points.insert(points.end(), {p.x, p.y, 0});
  out.append("      <Points>\n");
  AppendArray("type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"", points, out);
  out.append("      </Points>\n");
  AppendCells(mesh, out);
  AppendFields(fields, out);
  out.append("    </Piece>\n  </UnstructuredGrid>\n</VTKFile>\n");
  return out;
}

}  // namespace pliant::io
