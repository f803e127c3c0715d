#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

namespace pliant::cli {

/// Where pliantd listens if nobody says otherwise.
inline constexpr const char* kDefaultAddress = "localhost:7447";

/// Which pliantd to talk to, if any.
struct ServerOptions {
  std::string server;  ///< --server
  bool local = false;  ///< --local

  /// The server's address for work that can be done here as well: --server, else PLIANT_SERVER,
  /// else none; none with --local.
  [[nodiscard]] std::optional<std::string> address_if_any() const;
  /// The server's address for work that needs one: --server, else PLIANT_SERVER, else the default.
  [[nodiscard]] std::string address() const;
};

enum class LocalWork { kPossible, kImpossible };

void AddServerOptions(CLI::App& command, ServerOptions& options, LocalWork local_work);

}  // namespace pliant::cli
