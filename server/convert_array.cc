#include "server/convert_array.h"

namespace pliant::server {
namespace {

std::string ShapeText(const v1::Array& array) {
  std::string text = "[";
  for (const std::int64_t extent : array.shape()) {
    if (text.size() > 1) text += ",";
    text += std::to_string(extent);
  }
  return text + "]";
}

std::size_t SizeOf(v1::DType type) {
  switch (type) {
    case v1::DTYPE_UINT8:
      return 1;
    case v1::DTYPE_INT32:
    case v1::DTYPE_FLOAT32:
      return 4;
    default:
      return 8;
  }
}

}  // namespace

Status CheckArray(const v1::Array& array, v1::DType type, int columns, const std::string& field) {
  if (array.dtype() != type) {
    const std::string name = v1::DType_Name(array.dtype());
    return Error{ErrorCode::kArrayType,
                 field + " has type " + (name.empty() ? std::to_string(array.dtype()) : name) +
                     "; expected " + v1::DType_Name(type),
                 field};
  }
  if (array.storage_case() == v1::Array::kBlobId) {
    return Error{ErrorCode::kProtocolOrder,
                 field + " names blob " + std::to_string(array.blob_id()) + ", which was not sent",
                 field};
  }
  const bool right_shape =
      columns == 1 ? array.shape_size() == 1 : array.shape_size() == 2 && array.shape(1) == columns;
  const std::string wanted = columns == 1 ? "[n]" : "[n," + std::to_string(columns) + "]";
  if (!right_shape) {
    return Error{ErrorCode::kArrayLength,
                 field + " has shape " + ShapeText(array) + "; expected " + wanted, field};
  }
  const std::size_t row_bytes = static_cast<std::size_t>(columns) * SizeOf(type);
  const std::int64_t rows = array.shape(0);
  const std::size_t size = array.data().size();
  // Compared by division, because a stated count may be anything.
  if (rows < 0 || size % row_bytes != 0 || static_cast<std::uint64_t>(rows) != size / row_bytes) {
    return Error{ErrorCode::kArrayLength,
                 field + " has shape " + ShapeText(array) + " but " + std::to_string(size) +
                     " bytes; a row has " + std::to_string(row_bytes),
                 field};
  }
  return {};
}

}  // namespace pliant::server
