#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

#include "client/cli/command.h"
#include "client/cli/error_text.h"
#include "client/cli/exit_code.h"

// pliant: the command line. Parses, runs the one command that was named, and turns its error into
// a sentence and an exit code.

namespace pliant::cli {
namespace {

constexpr const char* kFooter =
    "Exit codes: 0 success, 1 refused (bad input, a file, the server), 2 wrong usage,\n"
    "3 the server cannot be reached, 130 interrupted.\n"
    "Example:\n  pliant remesh plate.poly --size 0.05 -o plate.vtu";

ExitCode Run(int argc, char** argv) {
  CLI::App app("Adapts triangle meshes to metrics, here or on a pliantd server", "pliant");
  app.set_version_flag("--version", "pliant " PLIANT_VERSION);
  app.require_subcommand(1);
  app.footer(kFooter);
  app.get_formatter()->column_width(34);
  Command chosen;
  AddRemeshCommand(app, chosen);
  AddSessionCommand(app, chosen);
  AddJobCommand(app, chosen);
  AddPlotCommand(app, chosen);
  AddQualityCommand(app, chosen);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? ExitCode::kOk : ExitCode::kUsage;
  }
  const Status status = chosen.run();
  if (status.ok()) return ExitCode::kOk;
  std::cerr << "pliant: " << ErrorText(status.error()) << "\n";
  return ExitCodeOf(status.error());
}

}  // namespace
}  // namespace pliant::cli

int main(int argc, char** argv) {
  using pliant::cli::ExitCode;
  ExitCode code = ExitCode::kRefused;
  try {
    code = pliant::cli::Run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::cerr << "pliant: out of memory; ask for larger sizes or use --vertices-max\n";
  } catch (const std::exception& error) {
    std::cerr << "pliant: this is a bug of pliant, please report it: " << error.what() << "\n";
  }
  return static_cast<int>(code);
}
