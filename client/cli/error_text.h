#pragma once

#include <string>

#include "client/cli/exit_code.h"
#include "core/base/result.h"

namespace pliant::cli {

/// The error for a person: "NOT_FINITE at domain.points[17]: point 17 has a NaN; ...".
[[nodiscard]] std::string ErrorText(const Error& error);

/// What the program ends with after this error.
[[nodiscard]] ExitCode ExitCodeOf(const Error& error);

}  // namespace pliant::cli
