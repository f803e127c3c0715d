#pragma once

namespace pliant::cli {

/// What the program ends with; part of its interface (client/cli/README.md).
enum class ExitCode : int {
  kOk = 0,
  kRefused = 1,        ///< Bad input, a file, or the server said no.
  kUsage = 2,          ///< The command line itself is wrong.
  kUnreachable = 3,    ///< The server cannot be reached, or went away.
  kInterrupted = 130,  ///< Ctrl-C or SIGTERM, as shells expect it.
};

}  // namespace pliant::cli
