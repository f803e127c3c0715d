#include "client/io/sol.h"

#include <cstddef>
#include <cstdint>
#include <utility>

#include "client/io/medit_sections.h"
#include "client/io/number_writer.h"

namespace pliant::io {
namespace {

constexpr std::int64_t kScalar = 1;
constexpr std::int64_t kTensor = 3;

void ReadSolution(MeditSections& sections, PointField& field) {
  NumberReader& reader = sections.reader();
  if (sections.dimension() == 0) {
    return reader.FailSyntax("expected Dimension before SolAtVertices");
  }
  const std::size_t count = sections.Count(1);
  const std::int64_t solution_count = reader.Integer();
  const std::int64_t type = reader.Integer();
  if (!reader.ok()) return;
  if (solution_count != 1 || (type != kScalar && type != kTensor)) {
    return reader.Fail(ErrorCode::kFileUnsupported,
                       "expected '1 1' (a size) or '1 3' (a tensor) after the count: one solution "
                       "per file, and no vectors");
  }
  // A tensor in space has xx xy yy xz yz zz: the first three are the plane's.
  const std::size_t ignored = type == kTensor && sections.dimension() == 3 ? 3 : 0;
  const std::size_t kept = type == kTensor ? 3 : 1;
  if (reader.Count(static_cast<std::int64_t>(count),
                   (kept + ignored) * sections.number_size_min()) != count) {
    return;
  }
  field.component_count = static_cast<std::int32_t>(kept);
  field.values.reserve(count * kept);
  for (std::size_t i = 0; i < count && reader.ok(); ++i) {
    for (std::size_t k = 0; k < kept; ++k) field.values.push_back(reader.Real());
    for (std::size_t k = 0; k < ignored; ++k) reader.Real();
  }
}

}  // namespace

Result<PointField> ParseSol(std::string_view bytes) {
  MeditSections sections(bytes);
  PointField field;
  for (std::string_view keyword = sections.Next(); !keyword.empty(); keyword = sections.Next()) {
    if (keyword != "SolAtVertices") continue;
    if (!field.values.empty()) sections.reader().FailSyntax("a second section SolAtVertices");
    ReadSolution(sections, field);
  }
  PLIANT_RETURN_IF_ERROR(sections.reader().status());
  if (field.values.empty()) {
    return Error{.code = ErrorCode::kEmpty, .message = "the file has no section SolAtVertices"};
  }
  return field;
}

Result<PointField> ParseMtr(std::string_view bytes) {
  NumberReader reader(bytes);
  const std::int64_t announced = reader.Integer();
  const std::int64_t component_count = reader.Integer();
  if (reader.ok() && component_count != 1 && component_count != 3) {
    reader.FailSyntax("expected 'COUNT 1' or 'COUNT 3' in the first line, found " +
                      std::to_string(component_count) + " components");
  }
  PLIANT_RETURN_IF_ERROR(reader.status());
  PointField field;
  field.component_count = static_cast<std::int32_t>(component_count);
  const auto components = static_cast<std::size_t>(component_count);
  field.values.resize(reader.Count(announced, 2 * components) * components);
  for (std::size_t i = 0; i < field.values.size() && reader.ok(); ++i) {
    field.values[i] = reader.Real();
  }
  PLIANT_RETURN_IF_ERROR(reader.status());
  return field;
}

std::string FormatSol(const PointField& field) {
  const auto components = static_cast<std::size_t>(field.component_count);
  NumberWriter out;
  out << "MeshVersionFormatted 2\n\nDimension 2\n\nSolAtVertices\n"
      << field.values.size() / components << "\n1 " << (components == 3 ? kTensor : kScalar)
      << "\n\n";
  for (std::size_t i = 0; i < field.values.size(); ++i) {
    out << field.values[i] << ((i + 1) % components == 0 ? '\n' : ' ');
  }
  out << "\nEnd\n";
  return std::move(out).text();
}

}  // namespace pliant::io
