#pragma once

#include "core/base/result.h"

namespace pliant {

/// Causes that only jobs have: values of ErrorCode beside those that result.h lists, because the
/// core knows no jobs and its switches need not name them. Their names are ErrorCodeName's.
inline constexpr ErrorCode kJobNotFound{1001};  ///< JOB_NOT_FOUND: none of that id, or expired.
inline constexpr ErrorCode kJobExists{1002};    ///< JOB_EXISTS: the wished id is taken.
inline constexpr ErrorCode kJobNotDone{1003};   ///< JOB_NOT_DONE: it has no mesh (yet).

}  // namespace pliant
