#pragma once

#include "core/base/bytes.h"
#include "pliant/v1/edit.pb.h"
#include "pliant/v1/session.pb.h"
#include "server/convert.h"
#include "server/saved_state.h"
#include "server/session_messages.h"

namespace pliant::server {

/// What a client sent, its arrays in place, as the store keeps it: the message itself.
[[nodiscard]] Bytes FormOf(const v1::CreateSession& create);
[[nodiscard]] Bytes FormOf(const v1::EditRequest& request);

/// Which update it is: the same for one that is sent again, its arrays in place both times, however
/// they came. @par Cost a pass over the bytes, without a copy of them
[[nodiscard]] Fingerprint FingerprintOf(const v1::EditRequest& request);
/// The kind alone, of one whose arrays are not in place.
[[nodiscard]] UpdateKind KindOf(const v1::EditRequest& request);

/// Reads them again, by the conversions of convert.h.
class WireCodec final : public SessionCodec {
 public:
  /// What was allowed when it came is allowed again, whatever the configuration says now.
  [[nodiscard]] Result<SessionInput> ReadInput(std::span<const std::byte> bytes) const override;
  [[nodiscard]] UpdateCommand ReadUpdate(std::span<const std::byte> bytes) const override;
};

}  // namespace pliant::server
