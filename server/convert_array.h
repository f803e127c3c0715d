#pragma once

#include <array>
#include <bit>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/geometry/vec2.h"
#include "core/metric/metric.h"
#include "pliant/v1/array.pb.h"

/// Arrays of the wire as vectors of core types and back: one copy of the bytes.
namespace pliant::server {

static_assert(std::endian::native == std::endian::little, "arrays on the wire are little-endian");

/// Type and count of numbers that make up one row of T.
template <class T>
struct RowLayout;
template <>
struct RowLayout<std::int32_t> {
  static constexpr v1::DType kType = v1::DTYPE_INT32;
  static constexpr int kColumns = 1;
};
template <class Tag>
struct RowLayout<Id<Tag>> : RowLayout<std::int32_t> {};
template <class T, std::size_t kCount>
struct RowLayout<std::array<T, kCount>> {
  static constexpr v1::DType kType = RowLayout<T>::kType;
  static constexpr int kColumns = kCount;
};
template <>
struct RowLayout<Vec2> {
  static constexpr v1::DType kType = v1::DTYPE_FLOAT64;
  static constexpr int kColumns = 2;
};
template <>
struct RowLayout<Metric> {
  static constexpr v1::DType kType = v1::DTYPE_FLOAT64;
  static constexpr int kColumns = 3;
};

/// Checks type, shape and count of bytes. Errors: kArrayType, kArrayLength, kProtocolOrder (a blob
/// that was not put in place), each with `field`.
[[nodiscard]] Status CheckArray(const v1::Array& array, v1::DType type, int columns,
                                const std::string& field);

/// The rows of an array; an absent (default) array has none.
template <class T>
[[nodiscard]] Result<std::vector<T>> ReadRows(const v1::Array& array, const std::string& field) {
  using Layout = RowLayout<T>;
  static_assert(sizeof(T) == static_cast<std::size_t>(Layout::kColumns) *
                                 (Layout::kType == v1::DTYPE_INT32 ? 4 : 8));
  if (array.shape().empty() && array.storage_case() == v1::Array::STORAGE_NOT_SET &&
      array.dtype() == v1::DTYPE_UNSPECIFIED) {
    return std::vector<T>();
  }
  PLIANT_RETURN_IF_ERROR(CheckArray(array, Layout::kType, Layout::kColumns, field));
  std::vector<T> rows(array.data().size() / sizeof(T));
  if (!rows.empty()) std::memcpy(rows.data(), array.data().data(), array.data().size());
  return rows;
}

/// Writes rows as an array of the wire.
template <class T>
void WriteRows(std::span<const T> rows, v1::Array& array) {
  using Layout = RowLayout<T>;
  array.set_dtype(Layout::kType);
  array.add_shape(static_cast<std::int64_t>(rows.size()));
  if (Layout::kColumns > 1) array.add_shape(Layout::kColumns);
  array.set_data(rows.data(), rows.size_bytes());
}

}  // namespace pliant::server
