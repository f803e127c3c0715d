#include <iostream>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "client/cli/engine.h"
#include "client/cli/interrupt.h"
#include "client/cli/loop_options.h"
#include "client/cli/mesh_output.h"
#include "client/cli/metric_options.h"
#include "client/cli/progress_bar.h"
#include "client/cli/report.h"
#include "client/cli/server_command.h"
#include "client/io/file.h"
#include "client/io/formats.h"

// pliant session: sessions on a server, one command for each thing that can be done with them.

namespace pliant::cli {
namespace {

using client::Client;

struct SessionOptions : ServerCommandOptions {
  std::string input;
  MetricOptions metric;
  LoopOptions loop;
};
using SharedSessionOptions = std::shared_ptr<SessionOptions>;

void Print(const client::SessionInfo& session) {
  const Json json = SessionJson(session);
  std::cout << session.session_id << "  revision " << json["revision"] << "  "
            << json["state"].get<std::string>() << "  " << Grouped(session.summary.vertex_count)
            << " vertices  " << Grouped(session.summary.triangle_count) << " triangles  created "
            << json["create_time"].get<std::string>() << "\n";
}

Status Create(const SessionOptions& options, Client& server) {
  PLIANT_ASSIGN_OR_RETURN(io::Geometry input, io::ReadGeometry(options.input));
  PLIANT_ASSIGN_OR_RETURN(const MetricSpec metric,
                          MakeMetricSpec(options.metric, input, options.input));
  client::Start start;
  std::visit([&](auto& geometry) { start = std::move(geometry); }, input);
  client::SessionSettings settings;
  settings.options = options.loop.options;
  settings.session_id = options.id;
  settings.labels["client"] = "pliant session create";
  PLIANT_ASSIGN_OR_RETURN(const std::unique_ptr<client::Session> session,
                          server.CreateSession(start, metric, settings));
  const InterruptGuard guard;
  Result<client::AdvanceReport> report = [&] {
    ProgressBar bar(std::cerr, ProgressBar::OfStandardError());
    return AdvanceWithProgress(*session, options.loop.advance(),
                               [&](const client::AdvanceProgress& progress) {
                                 bar.Show(progress);
                                 return guard.interrupted() ? Proceed::kCancel : Proceed::kGoOn;
                               });
  }();
  if (!report.ok()) {
    // A session without its first mesh is of no use to whoever asked for one.
    static_cast<void>(server.DeleteSession(session->id()));
    return report.error();
  }
  PrintWarnings(*report, metric.gradation);
  PLIANT_ASSIGN_OR_RETURN(const client::SessionInfo info, server.GetSession(session->id()));
  if (!options.json.empty()) return WriteJson(options.json, SessionJson(info));
  std::cout << session->id() << "\n";
  return {};
}

Status List(const SessionOptions& options, Client& server) {
  PLIANT_ASSIGN_OR_RETURN(const std::vector<client::SessionInfo> sessions, server.ListSessions());
  return ShowAll(sessions, options.json, SessionJson, Print);
}

Status Show(const SessionOptions& options, Client& server) {
  PLIANT_ASSIGN_OR_RETURN(const client::SessionInfo session, server.GetSession(options.id));
  if (!options.json.empty()) return WriteJson(options.json, SessionJson(session));
  Print(session);
  return {};
}

Status Get(const SessionOptions& options, Client& server) {
  PLIANT_RETURN_IF_ERROR(CheckMeshOutput(options.output));
  PLIANT_ASSIGN_OR_RETURN(const client::MeshReplica replica,
                          server.GetMesh(options.id, client::Parts::kMeshAndMetric));
  return WriteCompactMesh(options.output, replica.Compact());
}

Status ShowQuality(const SessionOptions& options, Client& server) {
  PLIANT_ASSIGN_OR_RETURN(const Quality quality, server.GetQuality(options.id));
  if (!options.json.empty()) return WriteJson(options.json, QualityJson(quality));
  std::cout << QualityText(quality);
  return {};
}

Status Export(const SessionOptions& options, Client& server) {
  PLIANT_ASSIGN_OR_RETURN(const Bytes file, server.ExportSession(options.id));
  return io::WriteFileAtomically(
      options.output, std::string_view(reinterpret_cast<const char*>(file.data()), file.size()));
}

Status Import(const SessionOptions& options, Client& server) {
  PLIANT_ASSIGN_OR_RETURN(const std::string file, io::ReadFile(options.input));
  Result<client::SessionInfo> session =
      server.ImportSession(std::as_bytes(std::span(file)), options.id);
  if (!session.ok()) {
    Error error = session.error();
    // What the server calls "file" has a name here.
    if (error.field == "file") error.field = options.input;
    return error;
  }
  if (!options.json.empty()) return WriteJson(options.json, SessionJson(*session));
  std::cout << session->session_id << "\n";
  return {};
}

Status Delete(const SessionOptions& options, Client& server) {
  for (const std::string& id : options.ids) {
    PLIANT_RETURN_IF_ERROR([&]() -> Status {
      const Result<Revision> revision = server.DeleteSession(id);
      return revision.ok() ? Status() : Status(revision.error());
    }());
  }
  return {};
}

CLI::App& Add(CLI::App& group, const std::string& name, const std::string& what) {
  return *group.add_subcommand(name, what);
}

void AddSessionId(CLI::App& command, const SharedSessionOptions& options) {
  command.add_option("id", options->id, "Which session")->required()->type_name("ID");
}

}  // namespace

void AddSessionCommand(CLI::App& app, Command& chosen) {
  CLI::App& group = *app.add_subcommand("session", "Sessions on a server");
  group.require_subcommand(1);
  group.footer("Example:\n  pliant session list");
  const auto options = std::make_shared<SessionOptions>();

  CLI::App& create = Add(group, "create", "Create a session with its first mesh; prints its id");
  create.add_option("input", options->input, "Domain or mesh, as for remesh")
      ->required()
      ->type_name("INPUT");
  create.add_option("--id", options->id, "Wished id; the server makes one if absent")
      ->type_name("ID");
  AddJson(create, *options);
  AddMetricOptions(create, options->metric, MetricNeed::kRequired);
  AddLoopOptions(create, options->loop);
  create.footer("Example:\n  pliant session create plate.poly --size 0.05 --id plate");
  FinishServerCommand(create, options, Create, chosen);

  CLI::App& list = Add(group, "list", "List all sessions, oldest first");
  AddJson(list, *options);
  list.footer("Example:\n  pliant session list --json");
  FinishServerCommand(list, options, List, chosen);

  CLI::App& show = Add(group, "show", "Describe a session");
  AddSessionId(show, options);
  AddJson(show, *options);
  show.footer("Example:\n  pliant session show plate");
  FinishServerCommand(show, options, Show, chosen);

  CLI::App& get = Add(group, "get", "Download a session's mesh");
  AddSessionId(get, options);
  get.add_option("-o,--output", options->output, "Mesh: .mesh, .meshb, .msh, .vtu or .node/.ele")
      ->required()
      ->type_name("FILE");
  get.footer("Example:\n  pliant session get plate -o plate.vtu");
  FinishServerCommand(get, options, Get, chosen);

  CLI::App& quality = Add(group, "quality", "Measure how well a session's mesh meets its metric");
  AddSessionId(quality, options);
  AddJson(quality, *options);
  quality.footer("Example:\n  pliant session quality plate");
  FinishServerCommand(quality, options, ShowQuality, chosen);

  CLI::App& to_file = Add(group, "export", "Write a session with all that it knows into a file");
  AddSessionId(to_file, options);
  to_file.add_option("-o,--output", options->output, "The file, for pliant session import")
      ->required()
      ->type_name("FILE");
  to_file.footer("Example:\n  pliant session export plate -o plate.pliant");
  FinishServerCommand(to_file, options, Export, chosen);

  CLI::App& from_file = Add(group, "import", "Create a session from such a file; prints its id");
  from_file.add_option("input", options->input, "What pliant session export wrote")
      ->required()
      ->type_name("FILE");
  from_file.add_option("--id", options->id, "Wished id; the server makes one if absent")
      ->type_name("ID");
  AddJson(from_file, *options);
  from_file.footer("Example:\n  pliant session import plate.pliant --id plate");
  FinishServerCommand(from_file, options, Import, chosen);

  CLI::App& remove = Add(group, "delete", "End sessions and free what they hold");
  remove.add_option("ids", options->ids, "Which sessions")->required()->type_name("ID");
  remove.footer("Example:\n  pliant session delete plate");
  FinishServerCommand(remove, options, Delete, chosen);
}

}  // namespace pliant::cli
