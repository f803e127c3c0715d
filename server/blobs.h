#pragma once

#include <google/protobuf/message.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "pliant/v1/array.pb.h"

namespace pliant::server {

/// Puts the blobs of one stream and direction together from their chunks.
///
/// *Invariants*: at most kBlobsPendingMax complete blobs and kUploadBytesMax bytes wait.
/// *Threads*: one at a time.
class BlobAssembler {
 public:
  /// Takes the next chunk. Errors: kProtocolOrder, kTooLarge; the stream should end then.
  Status Add(v1::BlobChunk chunk);

  /// Moves the bytes of the blobs that the arrays of `message`, at any depth, name into these
  /// arrays. Errors: kProtocolOrder with the array's path in `field`.
  Status Resolve(google::protobuf::Message& message);

  /// Bytes that wait.
  [[nodiscard]] std::size_t pending_bytes() const { return pending_bytes_; }

 private:
  Status ResolveArray(v1::Array& array, const std::string& path);
  Status ResolveWithin(google::protobuf::Message& message, const std::string& path);

  std::map<std::int64_t, std::string> complete_;
  std::int64_t last_id_ = 0;
  std::string open_;            // The blob that is being received...
  std::size_t open_total_ = 0;  // ...and its size; 0 if none is.
  std::size_t pending_bytes_ = 0;
};

/// Moves the arrays of `message` that are larger than kInlineBytesMax into chunks, to be sent
/// before it; numbers them from `last_blob_id` + 1 on and advances that.
[[nodiscard]] std::vector<v1::BlobChunk> TakeLargeArrays(google::protobuf::Message& message,
                                                         std::int64_t& last_blob_id);

}  // namespace pliant::server
