#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "pliant/v1/array.pb.h"

/// Columns of numbers to and from `pliant.v1.Array`, for both ends of the wire. Knows the layout of
/// array.proto and nothing of meshes.
namespace pliant::wire {

static_assert(std::endian::native == std::endian::little,
              "arrays travel as little-endian bytes; a big-endian machine would have to swap them");

/// Arrays up to this size travel inside their message, larger ones ahead of it (array.proto).
inline constexpr std::size_t kInlineBytesMax = 64 * 1024;
/// Most bytes that one BlobChunk carries (array.proto).
inline constexpr std::size_t kChunkBytesMax = 512 * 1024;
/// Most complete blobs that may wait to be used (array.proto).
inline constexpr std::size_t kBlobsWaitingMax = 64;

/// Takes a chunk that has to be sent now, ahead of the message that names its blob.
using ChunkSink = std::function<void(v1::BlobChunk)>;

/// Turns columns into arrays; what does not fit inside a message goes to a sink, chunk by chunk.
///
/// One writer per stream and direction: it counts the blobs. *Threads*: one at a time.
class ColumnWriter {
 public:
  explicit ColumnWriter(ChunkSink sink) : sink_(std::move(sink)) {}

  /// Rows of kColumns numbers of type Scalar (double, std::int32_t or std::uint8_t). kColumns == 1
  /// gives shape [n], more give [n, kColumns].
  template <class Scalar, std::size_t kColumns, class Row>
  [[nodiscard]] v1::Array Write(std::span<const Row> rows) {
    CheckLayout<Scalar, kColumns, Row>();
    const std::string_view bytes(reinterpret_cast<const char*>(rows.data()), rows.size_bytes());
    return WriteBytes(bytes, {DTypeOf<Scalar>(), kColumns, rows.size()});
  }

  template <class Scalar, std::size_t kColumns, class Row>
  static constexpr void CheckLayout() {
    static_assert(std::is_trivially_copyable_v<Row>);
    static_assert(sizeof(Row) == kColumns * sizeof(Scalar), "rows must have no padding");
  }

  template <class Scalar>
  static constexpr v1::DType DTypeOf() {
    static_assert(std::same_as<Scalar, double> || std::same_as<Scalar, std::int32_t> ||
                  std::same_as<Scalar, std::uint8_t>);
    if constexpr (std::same_as<Scalar, double>) return v1::DTYPE_FLOAT64;
    return std::same_as<Scalar, std::int32_t> ? v1::DTYPE_INT32 : v1::DTYPE_UINT8;
  }

 private:
  struct Layout {
    v1::DType dtype;
    std::size_t columns;
    std::size_t rows;
  };
  v1::Array WriteBytes(std::string_view bytes, const Layout& layout);

  ChunkSink sink_;
  std::int64_t last_blob_id_ = 0;
};

/// Puts the chunks of one stream back together and reads columns out of arrays.
///
/// *Invariants*: holds at most kBlobsWaitingMax complete blobs and one incomplete one, each of at
/// most the given size. *Threads*: one at a time.
class ColumnReader {
 public:
  /// @param blob_bytes_max  a larger blob is refused, before any memory is spent on it.
  explicit ColumnReader(std::int64_t blob_bytes_max) : blob_bytes_max_(blob_bytes_max) {}

  /// Takes a chunk. Fails with kProtocolOrder (a gap, mixed blobs, sizes that do not add up, too
  /// many blobs that nobody uses) or kTooLarge; the stream is then of no use any more.
  [[nodiscard]] Status Add(const v1::BlobChunk& chunk);

  /// The rows of an array; its blob is used up. An absent array (no dtype, shape and storage) has
  /// no rows. Fails with kArrayType, kArrayLength or kProtocolOrder; `field` is for the error.
  template <class Scalar, std::size_t kColumns, class Row>
  [[nodiscard]] Result<std::vector<Row>> Read(const v1::Array& array, std::string_view field) {
    ColumnWriter::CheckLayout<Scalar, kColumns, Row>();
    const Expected expected{ColumnWriter::DTypeOf<Scalar>(), kColumns, sizeof(Scalar), field};
    PLIANT_ASSIGN_OR_RETURN(const Bytes bytes, Resolve(array, expected));
    std::vector<Row> rows(bytes.view().size() / sizeof(Row));
    if (!rows.empty()) std::memcpy(rows.data(), bytes.view().data(), bytes.view().size());
    return rows;
  }

 private:
  struct Expected {
    v1::DType dtype;
    std::size_t columns;
    std::size_t scalar_size;
    std::string_view field;
  };
  /// Bytes of the message, or of a blob that was taken out.
  struct Bytes {
    std::string_view inline_bytes;
    std::string blob;
    [[nodiscard]] std::string_view view() const { return blob.empty() ? inline_bytes : blob; }
  };
  Result<Bytes> Resolve(const v1::Array& array, const Expected& expected);

  std::int64_t blob_bytes_max_;
  std::int64_t open_id_ = 0;  ///< Of the incomplete blob; 0: none.
  std::int64_t open_total_ = 0;
  std::string open_bytes_;
  std::int64_t last_blob_id_ = 0;
  std::map<std::int64_t, std::string> complete_;
};

}  // namespace pliant::wire
