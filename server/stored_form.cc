#include "server/stored_form.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>

namespace pliant::server {
namespace {

constexpr char kName[] = "stored message";
constexpr RequestLimits kNoLimits{.vertices_max = INT32_MAX};

template <class Message>
Bytes Serialized(const Message& message) {
  Bytes bytes(message.ByteSizeLong());
  message.SerializeWithCachedSizesToArray(reinterpret_cast<std::uint8_t*>(bytes.data()));
  return bytes;
}

template <class Message>
bool Parse(std::span<const std::byte> bytes, Message& message) {
  return message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
}

/// Hashes what is written to it, block by block.
class HashingStream final : public google::protobuf::io::ZeroCopyOutputStream {
 public:
  explicit HashingStream(std::size_t size)
      : block_size_(std::clamp<std::size_t>(size, 1, kBlockBytesMax)),
        block_(std::make_unique_for_overwrite<std::byte[]>(block_size_)) {}

  bool Next(void** data, int* size) override {
    if (used_ == block_size_) Fold();
    *data = block_.get() + used_;
    *size = static_cast<int>(block_size_ - used_);
    used_ = block_size_;
    return true;
  }
  void BackUp(int count) override { used_ -= static_cast<std::size_t>(count); }
  [[nodiscard]] std::int64_t ByteCount() const override {
    return folded_ + static_cast<std::int64_t>(used_);
  }

  [[nodiscard]] std::uint64_t Finish() {
    Fold();
    return hash_;
  }

 private:
  /// Part of the store's format.
  static constexpr std::size_t kBlockBytesMax = 65'536;

  void Fold() {
    ByteWriter both;
    both.Put(hash_);
    both.Put(Checksum({block_.get(), used_}));
    hash_ = Checksum(std::move(both).Take());
    folded_ += static_cast<std::int64_t>(used_);
    used_ = 0;
  }

  const std::size_t block_size_;
  const std::unique_ptr<std::byte[]> block_;
  std::size_t used_ = 0;
  std::int64_t folded_ = 0;
  std::uint64_t hash_ = 0;
};

static_assert(v1::EditRequest::kMetric == static_cast<int>(UpdateKind::kMetric));
static_assert(v1::EditRequest::kBoundary == static_cast<int>(UpdateKind::kBoundary));
static_assert(v1::EditRequest::kNodes == static_cast<int>(UpdateKind::kNodes));
static_assert(v1::EditRequest::kDomain == static_cast<int>(UpdateKind::kDomain));
static_assert(v1::EditRequest::kFields == static_cast<int>(UpdateKind::kFields));
static_assert(v1::EditRequest::kConstraints == static_cast<int>(UpdateKind::kConstraints));
static_assert(v1::EditRequest::kOptions == static_cast<int>(UpdateKind::kOptions));
static_assert(v1::EditRequest::kRollback == static_cast<int>(UpdateKind::kRollback));
static_assert(v1::EditRequest::kDiscard == static_cast<int>(UpdateKind::kDiscard));
static_assert(v1::EditRequest::kAdvance == static_cast<int>(UpdateKind::kAdvance));

}  // namespace

UpdateKind KindOf(const v1::EditRequest& request) {
  return static_cast<UpdateKind>(request.command_case());
}

Fingerprint FingerprintOf(const v1::EditRequest& request) {
  HashingStream stream(request.ByteSizeLong());
  {
    google::protobuf::io::CodedOutputStream coded(&stream);
    coded.SetSerializationDeterministic(true);
    request.SerializeWithCachedSizes(&coded);
  }
  // 0 stands for an unknown one.
  return {.kind = KindOf(request), .hash = std::max<std::uint64_t>(stream.Finish(), 1)};
}

Bytes FormOf(const v1::CreateSession& create) { return Serialized(create); }

Bytes FormOf(const v1::EditRequest& request) { return Serialized(request); }

Result<SessionInput> WireCodec::ReadInput(std::span<const std::byte> bytes) const {
  v1::CreateSession create;
  if (!Parse(bytes, create)) return CorruptData(kName, "is no CreateSession");
  return ConvertCreate(create, kNoLimits);
}

UpdateCommand WireCodec::ReadUpdate(std::span<const std::byte> bytes) const {
  v1::EditRequest request;
  if (!Parse(bytes, request)) return {.body = BadUpdate{CorruptData(kName, "is no EditRequest")}};
  return ConvertUpdate(request, kNoLimits);
}

}  // namespace pliant::server
