#include "server/stored_form.h"

#include <cstdint>
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

}  // namespace

Bytes FormOf(const v1::CreateSession& create) { return Serialized(create); }

Bytes FormOf(const v1::EditRequest& request) { return Serialized(request); }

Result<EngineInput> WireCodec::ReadInput(std::span<const std::byte> bytes) const {
  v1::CreateSession create;
  if (!Parse(bytes, create)) return CorruptData(kName, "is no CreateSession");
  PLIANT_ASSIGN_OR_RETURN(SessionInput input, ConvertCreate(create, kNoLimits));
  return std::move(input.engine);
}

UpdateCommand WireCodec::ReadUpdate(std::span<const std::byte> bytes) const {
  v1::EditRequest request;
  if (!Parse(bytes, request)) return {.body = BadUpdate{CorruptData(kName, "is no EditRequest")}};
  return ConvertUpdate(request, kNoLimits);
}

}  // namespace pliant::server
