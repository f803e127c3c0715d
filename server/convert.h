#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/base/result.h"
#include "pliant/v1/edit.pb.h"
#include "pliant/v1/session.pb.h"
#include "server/convert_options.h"
#include "server/session_messages.h"

/// From the wire to the core: what a client sent is checked here, once, and named in the client's
/// own words where it is wrong. Blobs have been put in place before (server/blobs.h).
///
/// Every function leaves its input as it was and has no state: any thread. Errors carry `field` as
/// a path in the .proto files, starting below the message that is converted. The other direction
/// is in convert_reply.h.
namespace pliant::server {

/// Errors: kArrayType, kArrayLength, kIndexOutOfRange, kNotFinite, kEmpty, kTooLarge, kOutOfRange,
/// kUnimplemented.
[[nodiscard]] Result<SessionInput> ConvertCreate(const v1::CreateSession& create,
                                                 const RequestLimits& limits);

/// 1 to kSessionIdLengthMax characters of [A-Za-z0-9_.-]. Error: kOutOfRange.
[[nodiscard]] Status CheckSessionId(const std::string& session_id);

/// Error: kOutOfRange with `field`.
[[nodiscard]] Result<Durability> ConvertDurability(v1::Durability durability,
                                                   const std::string& field);

/// At most kLabelsMax, keys and values not too long. Error: kTooLarge.
[[nodiscard]] Status CheckLabels(const std::map<std::string, std::string>& labels);

/// Errors: kOutOfRange, kUnimplemented.
[[nodiscard]] Result<AdvanceSpec> ConvertAdvance(const v1::Advance& advance);

/// A numbered command, also of the kinds that are not implemented. What is wrong with it becomes
/// its body.
/// @pre the command is none of open, chunk, cancel and acknowledge, which streams handle.
[[nodiscard]] UpdateCommand ConvertUpdate(const v1::EditRequest& request,
                                          const RequestLimits& limits);

/// Which optional parts a client wants.
struct WantedParts {
  bool metric = false;
  bool fields = false;
  bool transfer = false;
};

/// Errors: kOutOfRange for an unknown part, kUnimplemented.
[[nodiscard]] Result<WantedParts> ConvertParts(const google::protobuf::RepeatedField<int>& parts);

/// Errors: kOutOfRange, kUnimplemented.
[[nodiscard]] Result<OpenCommand> ConvertOpen(const v1::OpenEdit& open);

}  // namespace pliant::server
