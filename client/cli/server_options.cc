#include "client/cli/server_options.h"

#include <cstdlib>

namespace pliant::cli {
namespace {

/// PLIANT_SERVER; empty if it is not set.
std::string Environment() {
  const char* address = std::getenv("PLIANT_SERVER");
  return address == nullptr ? "" : address;
}

}  // namespace

std::optional<std::string> ServerOptions::address_if_any() const {
  if (local) return std::nullopt;
  if (!server.empty()) return server;
  if (std::string address = Environment(); !address.empty()) return address;
  return std::nullopt;
}

std::string ServerOptions::address() const {
  if (!server.empty()) return server;
  const std::string address = Environment();
  return address.empty() ? kDefaultAddress : address;
}

void AddServerOptions(CLI::App& command, ServerOptions& options, LocalWork local_work) {
  const char* fallback = local_work == LocalWork::kPossible
                             ? "PLIANT_SERVER if set, else work locally"
                             : "PLIANT_SERVER if set, else localhost:7447";
  CLI::Option* server =
      command.add_option("--server", options.server, "Address of pliantd: host:port or unix:path")
          ->type_name("ADDRESS")
          ->default_str(fallback);
  if (local_work == LocalWork::kPossible) {
    command.add_flag("--local", options.local, "Work in this process, whatever PLIANT_SERVER says")
        ->excludes(server);
  }
}

}  // namespace pliant::cli
