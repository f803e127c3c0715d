#include "client/io/medit_sections.h"

#include <string>

namespace pliant::io {
namespace {

bool IsLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

constexpr std::int64_t kDimension = 3;
constexpr std::int64_t kEnd = 54;

std::string_view KeywordName(std::int64_t number) {
  switch (number) {
    case 4:
      return "Vertices";
    case 5:
      return "Edges";
    case 6:
      return "Triangles";
    case 7:
      return "Quadrilaterals";
    case 8:
      return "Tetrahedra";
    case 9:
      return "Prisms";
    case 10:
      return "Hexahedra";
    case 62:
      return "SolAtVertices";
    default:
      return "?";
  }
}

}  // namespace

MeditSections::MeditSections(std::string_view bytes) : reader_(bytes) {
  using std::string_view_literals::operator""sv;
  const std::string_view head = bytes.substr(0, 4);
  if (head == "\1\0\0\0"sv || head == "\0\0\0\1"sv) {
    binary_ = true;
    reader_.set_encoding(head[0] == '\1' ? NumberReader::Encoding::kBinary
                                         : NumberReader::Encoding::kBinarySwapped);
    ReadBinaryHeader();
    return;
  }
  if (reader_.Word() != "MeshVersionFormatted") {
    reader_.Seek(0);
    reader_.FailSyntax("expected 'MeshVersionFormatted'; this is no Medit file");
  }
}

void MeditSections::ReadBinaryHeader() {
  reader_.Skip(4);
  const std::int64_t version = reader_.Short();
  if (!reader_.ok()) return;
  if (version < 1 || version > 4) {
    reader_.Fail(ErrorCode::kFileUnsupported, "Medit version " + std::to_string(version) +
                                                  " is unknown; versions 1 to 4 are read");
    return;
  }
  reader_.set_real_size(version == 1 ? 4 : 8);
  wide_positions_ = version >= 3;
  wide_integers_ = version >= 4;
  next_position_ = reader_.position();
}

std::string_view MeditSections::Next() {
  for (;;) {
    const std::string_view keyword = binary_ ? NextBinary() : NextText();
    if (keyword != "Dimension") return reader_.ok() ? keyword : std::string_view();
    ReadDimension();
  }
}

std::string_view MeditSections::NextText() {
  for (;;) {
    const std::string_view word = reader_.Word();
    if (word.empty() || word == "End") return {};
    if (word.front() == '"') {
      // A title such as "Created by X": its words are no keywords.
      if (word.size() == 1 || word.back() != '"') reader_.SkipPast("\"");
    } else if (IsLetter(word.front())) {
      return word;
    }
  }
}

std::string_view MeditSections::NextBinary() {
  if (!reader_.ok() || next_position_ == 0) return {};
  reader_.Seek(next_position_);
  if (reader_.ok() && reader_.remaining() == 0) return {};
  const std::int64_t number = reader_.Short();
  const std::int64_t next = wide_positions_ ? reader_.Long() : reader_.Short();
  if (!reader_.ok() || number == kEnd) return {};
  // Positions must grow, or a hostile file would make this loop for ever; 0 marks the last section.
  if (next != 0 && next <= static_cast<std::int64_t>(next_position_)) {
    reader_.FailSyntax("the section points back to byte " + std::to_string(next));
    return {};
  }
  next_position_ = static_cast<std::size_t>(next);
  reader_.set_integer_size(wide_integers_ ? 8 : 4);
  return number == kDimension ? "Dimension" : KeywordName(number);
}

void MeditSections::ReadDimension() {
  dimension_ = reader_.Short();
  if (reader_.ok() && dimension_ != 2 && dimension_ != 3) {
    reader_.FailSyntax("expected Dimension 2 or 3, found " + std::to_string(dimension_));
  }
}

std::size_t MeditSections::Count(std::size_t numbers_per_element) {
  return reader_.Count(reader_.Integer(), numbers_per_element * number_size_min());
}

}  // namespace pliant::io
