#include "proto/columns.h"

#include <algorithm>

namespace pliant::wire {
namespace {

Error Make(ErrorCode code, std::string message, std::string_view field = {}) {
  return {.code = code, .message = std::move(message), .field = std::string(field)};
}

std::string Text(std::int64_t value) { return std::to_string(value); }

/// Memory is only spent as bytes arrive: the announced size is a promise of the other side.
constexpr std::int64_t kReserveBytesMax = 16 * 1024 * 1024;

}  // namespace

v1::Array ColumnWriter::WriteBytes(std::string_view bytes, const Layout& layout) {
  v1::Array array;
  array.set_dtype(layout.dtype);
  array.add_shape(static_cast<std::int64_t>(layout.rows));
  if (layout.columns > 1) array.add_shape(static_cast<std::int64_t>(layout.columns));
  if (bytes.size() <= kInlineBytesMax) {
    array.set_data(bytes.data(), bytes.size());
    return array;
  }
  array.set_blob_id(++last_blob_id_);
  for (std::size_t offset = 0; offset < bytes.size(); offset += kChunkBytesMax) {
    const std::string_view piece = bytes.substr(offset, kChunkBytesMax);
    v1::BlobChunk chunk;
    chunk.set_blob_id(last_blob_id_);
    chunk.set_total_bytes(static_cast<std::int64_t>(bytes.size()));
    chunk.set_offset_bytes(static_cast<std::int64_t>(offset));
    chunk.set_data(piece.data(), piece.size());
    sink_(std::move(chunk));
  }
  return array;
}

Status ColumnReader::Add(const v1::BlobChunk& chunk) {
  const auto size = static_cast<std::int64_t>(chunk.data().size());
  if (size < 1 || size > static_cast<std::int64_t>(kChunkBytesMax)) {
    return Make(ErrorCode::kTooLarge,
                "a chunk carries " + Text(size) + " bytes; 1 to 524288 are allowed", "chunk.data");
  }
  if (open_id_ == 0) {
    if (chunk.blob_id() <= last_blob_id_) {
      return Make(ErrorCode::kProtocolOrder,
                  "blob " + Text(chunk.blob_id()) + " comes after blob " + Text(last_blob_id_) +
                      "; number blobs from 1, upwards",
                  "chunk.blob_id");
    }
    if (chunk.total_bytes() < 1 || chunk.total_bytes() > blob_bytes_max_) {
      return Make(ErrorCode::kTooLarge,
                  "a blob of " + Text(chunk.total_bytes()) + " bytes; at most " +
                      Text(blob_bytes_max_) + " are allowed",
                  "chunk.total_bytes");
    }
    if (complete_.size() >= kBlobsWaitingMax) {
      return Make(ErrorCode::kProtocolOrder,
                  "64 blobs wait already; send the message that uses them first", "chunk.blob_id");
    }
    open_id_ = last_blob_id_ = chunk.blob_id();
    open_total_ = chunk.total_bytes();
    open_bytes_.reserve(static_cast<std::size_t>(std::min(open_total_, kReserveBytesMax)));
  }
  const auto received = static_cast<std::int64_t>(open_bytes_.size());
  if (chunk.blob_id() != open_id_ || chunk.total_bytes() != open_total_ ||
      chunk.offset_bytes() != received || size > open_total_ - received) {
    return Make(ErrorCode::kProtocolOrder,
                "chunk of blob " + Text(chunk.blob_id()) + " at byte " +
                    Text(chunk.offset_bytes()) + " of " + Text(chunk.total_bytes()) +
                    "; expected blob " + Text(open_id_) + " to go on at byte " + Text(received) +
                    " of " + Text(open_total_),
                "chunk.offset_bytes");
  }
  open_bytes_ += chunk.data();
  if (received + size == open_total_) {
    complete_.emplace(open_id_, std::move(open_bytes_));
    open_bytes_ = {};
    open_id_ = 0;
  }
  return {};
}

Result<ColumnReader::Bytes> ColumnReader::Resolve(const v1::Array& array,
                                                  const Expected& expected) {
  Bytes bytes;
  if (array.storage_case() == v1::Array::kBlobId) {
    auto node = complete_.extract(array.blob_id());
    if (node.empty()) {
      return Make(ErrorCode::kProtocolOrder,
                  "blob " + Text(array.blob_id()) +
                      " has not been sent completely ahead of this message, or was used before",
                  expected.field);
    }
    bytes.blob = std::move(node.mapped());
  } else {
    bytes.inline_bytes = array.data();
    if (array.dtype() == v1::DTYPE_UNSPECIFIED && array.shape().empty() &&
        bytes.inline_bytes.empty()) {
      return bytes;
    }
  }
  if (array.dtype() != expected.dtype) {
    const char* wanted = expected.dtype == v1::DTYPE_FLOAT64 ? "float64" : "int32";
    return Make(
        ErrorCode::kArrayType,
        std::string("expected an array of ") + wanted + ", found " + v1::DType_Name(array.dtype()),
        expected.field);
  }
  const auto columns = static_cast<std::int64_t>(expected.columns);
  const bool shape_fits = array.shape_size() == (columns > 1 ? 2 : 1) && array.shape(0) >= 0 &&
                          (columns == 1 || array.shape(1) == columns);
  if (!shape_fits) {
    const std::string wanted = columns > 1 ? "[n," + Text(columns) + "]" : "[n]";
    return Make(ErrorCode::kArrayLength, "expected an array of shape " + wanted, expected.field);
  }
  const std::size_t row_size = expected.columns * expected.scalar_size;
  const std::size_t rows = bytes.view().size() / row_size;
  if (rows * row_size != bytes.view().size() || array.shape(0) != static_cast<std::int64_t>(rows)) {
    return Make(ErrorCode::kArrayLength,
                "the shape says " + Text(array.shape(0)) + " rows of " +
                    Text(static_cast<std::int64_t>(row_size)) + " bytes, but there are " +
                    Text(static_cast<std::int64_t>(bytes.view().size())) + " bytes",
                expected.field);
  }
  return bytes;
}

}  // namespace pliant::wire
