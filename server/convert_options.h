#pragma once

#include <cstdint>
#include <optional>

#include "core/base/result.h"
#include "core/pliant/options.h"
#include "pliant/v1/motion.pb.h"
#include "pliant/v1/options.pb.h"
#include "server/session_messages.h"

/// Options and constraints from the wire to the core, as in convert.h. Ranges of single options,
/// ids and revisions are checked by the engine.
namespace pliant::server {

/// Bounds of the configuration that a request may not exceed.
struct RequestLimits {
  std::int32_t vertices_max = 0;
};

/// How much a session is to keep of earlier revisions. Errors: kOutOfRange.
[[nodiscard]] Result<std::optional<std::int64_t>> ConvertHistoryBytesMax(
    const v1::SessionOptions& options);

/// The options that a session begins with, but for what the server around the engine looks after.
/// Errors: kOutOfRange, kUnimplemented.
[[nodiscard]] Result<Options> ConvertOptions(const v1::SessionOptions& options,
                                             const RequestLimits& limits);

/// Options that change. Restrictions are changed by constraints alone, so that nothing is lifted by
/// being left out. Errors: kOutOfRange, kUnimplemented.
[[nodiscard]] Result<OptionsUpdate> ConvertOptionsUpdate(const v1::SessionOptions& options,
                                                         const RequestLimits& limits);

/// Errors: those of arrays, kOutOfRange, kRevisionMismatch (ids without a revision).
[[nodiscard]] Result<ConstraintsUpdate> ConvertConstraints(const v1::ConstraintUpdate& update);

}  // namespace pliant::server
