#include "client/io/medit.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "client/io/medit_sections.h"
#include "client/io/number_writer.h"

namespace pliant::io {
namespace {

static_assert(std::endian::native == std::endian::little, "binary files are written as they are");

void ReadVertices(MeditSections& sections, MeshData& mesh) {
  NumberReader& reader = sections.reader();
  const std::int64_t dimension = sections.dimension();
  if (dimension == 0) return reader.FailSyntax("expected Dimension before Vertices");
  if (!mesh.points.empty()) return reader.FailSyntax("a second section Vertices");
  mesh.points.resize(sections.Count(static_cast<std::size_t>(dimension) + 1));
  double plane = 0;
  for (std::size_t i = 0; i < mesh.points.size() && reader.ok(); ++i) {
    mesh.points[i].x = reader.Real();
    mesh.points[i].y = reader.Real();
    if (dimension == 3) {
      const double z = reader.Real();
      if (i == 0) plane = z;
      if (z != plane) {
        reader.Fail(ErrorCode::kFileUnsupported,
                    "the vertices do not lie in a plane z = constant; only plane meshes are read");
      }
    }
    reader.Integer();
  }
}

template <std::size_t kCorners>
void ReadElements(MeditSections& sections,
                  std::vector<std::array<std::int32_t, kCorners>>& elements,
                  std::vector<std::int32_t>& tags) {
  NumberReader& reader = sections.reader();
  if (!elements.empty()) return reader.FailSyntax("a second section of the same kind");
  elements.resize(sections.Count(kCorners + 1));
  tags.resize(elements.size());
  for (std::size_t i = 0; i < elements.size() && reader.ok(); ++i) {
    for (std::int32_t& point : elements[i]) point = reader.Index(1);
    tags[i] = reader.Tag();
  }
}

void RefuseElements(MeditSections& sections, std::string_view keyword) {
  if (sections.Count(1) == 0) return;
  sections.reader().Fail(ErrorCode::kFileUnsupported, "the file holds " + std::string(keyword) +
                                                          "; only meshes of triangles are read");
}

template <std::size_t kCorners>
void WriteElements(NumberWriter& out, const char* keyword,
                   const std::vector<std::array<std::int32_t, kCorners>>& elements,
                   const std::vector<std::int32_t>& tags) {
  if (elements.empty()) return;
  out << keyword << '\n' << elements.size() << '\n';
  for (std::size_t i = 0; i < elements.size(); ++i) {
    for (const std::int32_t point : elements[i]) out << std::int64_t{point} + 1 << ' ';
    out << (tags.empty() ? 0 : tags[i]) << '\n';
  }
}

/// Appends numbers as they lie in memory.
class BinaryWriter {
 public:
  template <class T>
  void Put(T value) {
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof(T));
    bytes_.append(raw.data(), raw.size());
  }
  /// Starts a section whose body has `body_size` bytes.
  void Keyword(std::int32_t number, std::size_t body_size) {
    Put(number);
    Put(static_cast<std::int64_t>(bytes_.size() + sizeof(std::int64_t) + body_size));
  }
  template <std::size_t kCorners>
  void Elements(std::int32_t number,
                const std::vector<std::array<std::int32_t, kCorners>>& elements,
                const std::vector<std::int32_t>& tags) {
    if (elements.empty()) return;
    Keyword(number, 4 + elements.size() * (kCorners + 1) * 4);
    Put(static_cast<std::int32_t>(elements.size()));
    for (std::size_t i = 0; i < elements.size(); ++i) {
      for (const std::int32_t point : elements[i]) Put(point + 1);
      Put(tags.empty() ? 0 : tags[i]);
    }
  }
  [[nodiscard]] std::string Take() && { return std::move(bytes_); }

 private:
  std::string bytes_;
};

}  // namespace

Result<Geometry> ParseMedit(std::string_view bytes) {
  MeditSections sections(bytes);
  MeshData mesh;
  for (std::string_view keyword = sections.Next(); !keyword.empty(); keyword = sections.Next()) {
    if (keyword == "Vertices") {
      ReadVertices(sections, mesh);
    } else if (keyword == "Edges") {
      ReadElements(sections, mesh.edges, mesh.edge_tags);
    } else if (keyword == "Triangles") {
      ReadElements(sections, mesh.triangles, mesh.triangle_tags);
    } else if (keyword == "Quadrilaterals" || keyword == "Tetrahedra" || keyword == "Prisms" ||
               keyword == "Hexahedra") {
      RefuseElements(sections, keyword);
    }
  }
  PLIANT_RETURN_IF_ERROR(sections.reader().status());
  if (mesh.points.empty()) {
    return Error{.code = ErrorCode::kEmpty, .message = "the file has no section Vertices"};
  }
  PLIANT_RETURN_IF_ERROR(CheckIndices(mesh));
  return GeometryFromMesh(std::move(mesh));
}

std::string FormatMedit(const MeshData& mesh) {
  NumberWriter out;
  out << "MeshVersionFormatted 2\n\nDimension 2\n\nVertices\n" << mesh.points.size() << '\n';
  for (const Vec2 p : mesh.points) out << p.x << ' ' << p.y << " 0\n";
  WriteElements(out, "\nEdges", mesh.edges, mesh.edge_tags);
  WriteElements(out, "\nTriangles", mesh.triangles, mesh.triangle_tags);
  out << "\nEnd\n";
  return std::move(out).text();
}

std::string FormatMeditBinary(const MeshData& mesh) {
  BinaryWriter out;
  out.Put(std::int32_t{1});
  out.Put(std::int32_t{3});
  out.Keyword(3, 4);
  out.Put(std::int32_t{2});
  out.Keyword(4, 4 + mesh.points.size() * 20);
  out.Put(static_cast<std::int32_t>(mesh.points.size()));
  for (const Vec2 p : mesh.points) {
    out.Put(p.x);
    out.Put(p.y);
    out.Put(std::int32_t{0});
  }
  out.Elements(5, mesh.edges, mesh.edge_tags);
  out.Elements(6, mesh.triangles, mesh.triangle_tags);
  out.Put(std::int32_t{54});
  out.Put(std::int64_t{0});
  return std::move(out).Take();
}

}  // namespace pliant::io
