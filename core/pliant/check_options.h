#pragma once

#include "core/base/result.h"
#include "core/pliant/options.h"

namespace pliant {

/// kOutOfRange for the first option outside the range that options.h states; `field` names it, e.g.
/// "options.age_max".
[[nodiscard]] Status CheckOptions(const Options& options);

}  // namespace pliant
