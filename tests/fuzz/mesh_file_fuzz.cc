// Goal: no file crashes a reader or makes it ask for memory out of proportion.
// Method: libFuzzer with address and undefined-behaviour checks; the first byte picks the reader.
// Run: build-fuzz/tests/fuzz/mesh_file_fuzz -max_total_time=60

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "client/io/gmsh.h"
#include "client/io/gmsh_writer.h"
#include "client/io/medit.h"
#include "client/io/sol.h"
#include "client/io/triangle.h"
#include "core/base/check.h"

namespace pliant::io {
namespace {

/// What was read can be written, and reads back as the same.
void CheckRoundTrip(const Geometry& geometry) {
  const MeshData* mesh = std::get_if<MeshData>(&geometry);
  if (mesh == nullptr) return;
  const auto medit = ParseMedit(FormatMedit(*mesh));
  PLIANT_CHECK(medit.ok() && std::get<MeshData>(*medit).triangles == mesh->triangles);
  PLIANT_CHECK(ParseMedit(FormatMeditBinary(*mesh)).ok());
  PLIANT_CHECK(ParseGmsh(FormatGmsh22(*mesh, {})).ok());
  PLIANT_CHECK(ParseGmsh(FormatGmsh41(*mesh, {})).ok());
}

void ReadAny(std::uint8_t reader, std::string_view bytes) {
  switch (reader % 6) {
    case 0: {
      const auto result = ParseMedit(bytes);
      if (result.ok()) CheckRoundTrip(*result);
      return;
    }
    case 1: {
      const auto result = ParseGmsh(bytes);
      if (result.ok()) CheckRoundTrip(result->geometry);
      return;
    }
    case 2:
      static_cast<void>(ParsePoly(bytes));
      return;
    case 3: {
      // The three files of a mesh, between bytes 1.
      const std::size_t first = std::min(bytes.find('\1'), bytes.size());
      const std::size_t second = std::min(bytes.find('\1', first + 1), bytes.size());
      const auto result =
          ParseTriangleMesh({.node = std::string(bytes.substr(0, first)),
                             .ele = std::string(bytes.substr(first, second - first)),
                             .edge = std::string(bytes.substr(second))});
      if (result.ok()) CheckRoundTrip(GeometryFromMesh(*result));
      return;
    }
    case 4:
      static_cast<void>(ParseSol(bytes));
      return;
    default:
      static_cast<void>(ParseMtr(bytes));
  }
}

}  // namespace
}  // namespace pliant::io

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  pliant::io::ReadAny(data[0], {reinterpret_cast<const char*>(data) + 1, size - 1});
  return 0;
}
