#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/command.h"
#include "client/cli/report.h"
#include "client/cli/server_options.h"
#include "client/cpp/client.h"

/// What the commands below `pliant session` and `pliant job` have in common: each does one thing
/// with things that have ids on a server.
namespace pliant::cli {

/// The options that they share; a group of commands derives its own from it.
struct ServerCommandOptions {
  ServerOptions server;
  std::string id;
  std::vector<std::string> ids;
  std::string output;
  std::string json;
};

inline void AddJson(CLI::App& command, ServerCommandOptions& options) {
  command.add_option("--json", options.json, "As JSON; without FILE to standard output")
      ->type_name("[FILE]")
      ->expected(0, 1);
}

/// The last step for each command: where the server is, and what to do with it.
template <class Options>
void FinishServerCommand(CLI::App& command, const std::shared_ptr<Options>& options,
                         Status (*work)(const Options&, client::Client&), Command& chosen) {
  AddServerOptions(command, options->server, LocalWork::kImpossible);
  const CLI::Option* json = command.get_option_no_throw("--json");
  command.callback([options, json, work, &chosen] {
    if (json != nullptr && json->count() > 0 && options->json.empty()) options->json = "-";
    chosen.run = [options, work]() -> Status {
      PLIANT_ASSIGN_OR_RETURN(client::Client server,
                              client::Client::Connect(options->server.address()));
      return work(*options, server);
    };
  });
}

/// Shows a list as one array of JSON if `--json` asks for it, else item by item.
template <class Item>
Status ShowAll(const std::vector<Item>& items, const std::string& json,
               Json (*to_json)(const Item&), void (*print)(const Item&)) {
  if (json.empty()) {
    for (const Item& item : items) print(item);
    return {};
  }
  Json array = Json::array();
  for (const Item& item : items) array.push_back(to_json(item));
  return WriteJson(json, array);
}

}  // namespace pliant::cli
