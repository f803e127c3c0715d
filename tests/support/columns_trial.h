#pragma once

#include <array>
#include <string>
#include <string_view>

#include "core/base/ids.h"
#include "core/geometry/vec2.h"
#include "core/metric/metric.h"
#include "proto/columns.h"
#include "tests/support/pieces.h"

namespace pliant::test {

/// Reads an array as one kind of column; what is wrong with how that went, or nothing.
template <class Scalar, std::size_t kColumns, class Row>
std::string TryColumn(wire::ColumnReader& reader, const v1::Array& array) {
  const auto rows = reader.Read<Scalar, kColumns, Row>(array, "field");
  if (!rows.ok()) {
    return rows.error().message.empty() || rows.error().field != "field" ? "a refusal says nothing"
                                                                         : "";
  }
  const std::int64_t stated = array.shape_size() > 0 ? array.shape(0) : 0;
  return static_cast<std::int64_t>(rows->size()) == stated ? "" : "rows that nobody stated";
}

/// Pieces are chunks (choice % 6 == 0) or arrays, read as one kind of column or another. What is
/// wrong with how they are read, or nothing.
inline std::string TryColumns(std::string_view bytes) {
  wire::ColumnReader reader(/*blob_bytes_max=*/1 << 20);
  for (const Piece& piece : Cut(bytes)) {
    std::string wrong;
    v1::BlobChunk chunk;
    v1::Array array;
    if (piece.choice % 6 == 0) {
      if (!chunk.ParseFromString(piece.bytes)) continue;
      const Status status = reader.Add(chunk);
      if (!status.ok() && status.error().message.empty()) wrong = "a refusal says nothing";
      // A stream ends at the first chunk that is refused; the reader must stand it all the same.
    } else if (array.ParseFromString(piece.bytes)) {
      switch (piece.choice % 6) {
        case 1:
          wrong = TryColumn<std::int32_t, 1, VertexId>(reader, array);
          break;
        case 2:
          wrong = TryColumn<double, 2, Vec2>(reader, array);
          break;
        case 3:
          wrong = TryColumn<std::int32_t, 3, std::array<VertexId, 3>>(reader, array);
          break;
        case 4:
          wrong = TryColumn<double, 3, Metric>(reader, array);
          break;
        default:
          wrong = TryColumn<double, 1, double>(reader, array);
      }
    }
    if (!wrong.empty()) return wrong;
  }
  return "";
}

}  // namespace pliant::test
