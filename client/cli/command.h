#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "core/base/result.h"

namespace pliant::cli {

/// What the parsed command line asks for; set by the command that was named.
struct Command {
  std::function<Status()> run;
};

/// Each adds a command to the application. Options are bound while it is parsed; `chosen.run` does
/// the work afterwards, so that a wrong option costs nothing and a failure is not a parse error.
void AddRemeshCommand(CLI::App& app, Command& chosen);
void AddSessionCommand(CLI::App& app, Command& chosen);
void AddJobCommand(CLI::App& app, Command& chosen);
void AddPlotCommand(CLI::App& app, Command& chosen);
void AddQualityCommand(CLI::App& app, Command& chosen);

}  // namespace pliant::cli
