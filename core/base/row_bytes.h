#pragma once

#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

#include "core/base/bytes.h"

namespace pliant {

/// How many numbers a row has.
template <class Number, class Row>
constexpr std::size_t RowWidth() {
  static_assert(std::is_trivially_copyable_v<Row> && std::is_arithmetic_v<Number>);
  constexpr std::size_t kRowSize = sizeof(Row);
  constexpr std::size_t kNumberSize = sizeof(Number);
  static_assert(kRowSize % kNumberSize == 0);
  return kRowSize / kNumberSize;
}

/// Rows of `Number`s without padding (points, tensors, corners) as one column of that type.
template <class Number, class Row>
void PutRows(const std::vector<Row>& rows, ByteWriter& writer) {
  std::vector<Number> numbers(rows.size() * RowWidth<Number, Row>());
  if (!rows.empty()) std::memcpy(numbers.data(), rows.data(), rows.size() * sizeof(Row));
  writer.PutColumn(numbers);
}

/// What PutRows wrote. The reader fails where a row is incomplete; then there are none.
template <class Number, class Row>
[[nodiscard]] std::vector<Row> TakeRows(ByteReader& reader) {
  constexpr std::size_t kWidth = RowWidth<Number, Row>();
  const std::vector<Number> numbers = reader.TakeColumn<Number>();
  if (numbers.size() % kWidth != 0) {
    reader.Fail();
    return {};
  }
  std::vector<Row> rows(numbers.size() / kWidth);
  if (!rows.empty()) {
    std::memcpy(static_cast<void*>(rows.data()), numbers.data(), rows.size() * sizeof(Row));
  }
  return rows;
}

}  // namespace pliant
