#include "server/blobs.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "server/limits.h"

namespace pliant::server {
namespace {

Error OrderError(std::string message, std::string field) {
  return {ErrorCode::kProtocolOrder, std::move(message), std::move(field)};
}

// Calls `visit` with every submessage that is set, directly below `message`, and its field's name.
void ForEachSubmessage(
    google::protobuf::Message& message,
    const std::function<void(google::protobuf::Message&, const std::string&)>& visit) {
  const google::protobuf::Reflection* reflection = message.GetReflection();
  std::vector<const google::protobuf::FieldDescriptor*> fields;
  reflection->ListFields(message, &fields);
  for (const google::protobuf::FieldDescriptor* field : fields) {
    if (field->cpp_type() != google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (field->is_map()) continue;  // No map of this protocol holds arrays.
    if (!field->is_repeated()) {
      visit(*reflection->MutableMessage(&message, field), field->name());
      continue;
    }
    const int count = reflection->FieldSize(message, field);
    for (int i = 0; i < count; ++i) {
      visit(*reflection->MutableRepeatedMessage(&message, field, i),
            field->name() + "[" + std::to_string(i) + "]");
    }
  }
}

void ForEachArray(google::protobuf::Message& message,
                  const std::function<void(v1::Array&)>& visit) {
  if (message.GetDescriptor() == v1::Array::descriptor()) {
    visit(static_cast<v1::Array&>(message));
    return;
  }
  ForEachSubmessage(message, [&](google::protobuf::Message& child, const std::string&) {
    ForEachArray(child, visit);
  });
}

}  // namespace

Status BlobAssembler::Add(v1::BlobChunk chunk) {
  if (chunk.data().empty() || chunk.data().size() > kChunkBytesMax) {
    return Error{ErrorCode::kTooLarge,
                 "a chunk carries 1 to " + std::to_string(kChunkBytesMax) + " bytes, this one " +
                     std::to_string(chunk.data().size()),
                 "chunk.data"};
  }
  if (open_total_ == 0) {
    if (chunk.blob_id() <= last_id_) {
      return OrderError("blob " + std::to_string(chunk.blob_id()) + " does not come after blob " +
                            std::to_string(last_id_),
                        "chunk.blob_id");
    }
    if (chunk.total_bytes() <= 0 ||
        static_cast<std::uint64_t>(chunk.total_bytes()) > kUploadBytesMax - pending_bytes_) {
      return Error{ErrorCode::kTooLarge,
                   "a blob of " + std::to_string(chunk.total_bytes()) + " bytes beside " +
                       std::to_string(pending_bytes_) + " that wait; allowed are 1 to " +
                       std::to_string(kUploadBytesMax) + " in all",
                   "chunk.total_bytes"};
    }
    if (complete_.size() >= kBlobsPendingMax) {
      return Error{ErrorCode::kTooLarge,
                   std::to_string(kBlobsPendingMax) +
                       " blobs wait already for a message that "
                       "names them",
                   "chunk.blob_id"};
    }
    last_id_ = chunk.blob_id();
    open_total_ = static_cast<std::size_t>(chunk.total_bytes());
    // Memory is taken as bytes arrive, not as they are announced.
    open_.clear();
  }
  if (chunk.blob_id() != last_id_ || chunk.offset_bytes() != static_cast<int64_t>(open_.size()) ||
      static_cast<std::size_t>(chunk.total_bytes()) != open_total_ ||
      chunk.data().size() > open_total_ - open_.size()) {
    return OrderError("expected blob " + std::to_string(last_id_) + " to go on at byte " +
                          std::to_string(open_.size()) + " of " + std::to_string(open_total_) +
                          ", got blob " + std::to_string(chunk.blob_id()) + " at byte " +
                          std::to_string(chunk.offset_bytes()) + " of " +
                          std::to_string(chunk.total_bytes()),
                      "chunk.offset_bytes");
  }
  pending_bytes_ += chunk.data().size();
  if (open_.empty()) {
    open_ = std::move(*chunk.mutable_data());
  } else {
    open_ += chunk.data();
  }
  if (open_.size() == open_total_) {
    complete_.emplace(last_id_, std::move(open_));
    open_.clear();
    open_total_ = 0;
  }
  return {};
}

Status BlobAssembler::Resolve(google::protobuf::Message& message) {
  return ResolveWithin(message, "");
}

Status BlobAssembler::ResolveWithin(google::protobuf::Message& message, const std::string& path) {
  if (message.GetDescriptor() == v1::Array::descriptor()) {
    return ResolveArray(static_cast<v1::Array&>(message), path);
  }
  Status status;
  ForEachSubmessage(message, [&](google::protobuf::Message& child, const std::string& name) {
    if (status.ok()) status = ResolveWithin(child, path.empty() ? name : path + "." + name);
  });
  return status;
}

Status BlobAssembler::ResolveArray(v1::Array& array, const std::string& path) {
  if (array.storage_case() != v1::Array::kBlobId) return {};
  const auto blob = complete_.find(array.blob_id());
  if (blob == complete_.end()) {
    return OrderError(
        "blob " + std::to_string(array.blob_id()) +
            " was not sent in full before the message that names it, or is used twice",
        path);
  }
  pending_bytes_ -= blob->second.size();
  array.set_data(std::move(blob->second));
  complete_.erase(blob);
  return {};
}

std::vector<v1::BlobChunk> TakeLargeArrays(google::protobuf::Message& message,
                                           std::int64_t& last_blob_id) {
  std::vector<v1::BlobChunk> chunks;
  ForEachArray(message, [&](v1::Array& array) {
    if (array.data().size() <= kInlineBytesMax) return;
    const std::string bytes = std::move(*array.mutable_data());
    array.set_blob_id(++last_blob_id);
    for (std::size_t offset = 0; offset < bytes.size(); offset += kChunkBytesMax) {
      v1::BlobChunk& chunk = chunks.emplace_back();
      chunk.set_blob_id(last_blob_id);
      chunk.set_total_bytes(static_cast<std::int64_t>(bytes.size()));
      chunk.set_offset_bytes(static_cast<std::int64_t>(offset));
      chunk.set_data(bytes.substr(offset, kChunkBytesMax));
    }
  });
  return chunks;
}

}  // namespace pliant::server
