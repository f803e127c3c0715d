#include <array>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <string>
#include <utility>

#include "client/cli/command.h"
#include "client/cli/detach.h"
#include "client/cli/engine.h"
#include "client/cli/interrupt.h"
#include "client/cli/loop_options.h"
#include "client/cli/mesh_output.h"
#include "client/cli/metric_options.h"
#include "client/cli/progress_bar.h"
#include "client/cli/report.h"
#include "client/cli/server_options.h"
#include "client/io/formats.h"

// pliant remesh: one mesh, from file to file, here or on a server.

namespace pliant::cli {
namespace {

struct RemeshOptions {
  std::string input;
  std::string output;
  std::string output_metric;
  std::string json;
  MetricOptions metric;
  LoopOptions loop;
  int thread_count = 0;
  ServerOptions server;
  bool detach = false;
  DetachOptions detached;
};

/// Seconds since it was made, or last asked.
class Stopwatch {
 public:
  double Lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - start_).count();
    start_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

Result<RemeshJob> ReadJob(const RemeshOptions& options) {
  PLIANT_ASSIGN_OR_RETURN(io::Geometry input, io::ReadGeometry(options.input));
  RemeshJob job;
  PLIANT_ASSIGN_OR_RETURN(job.metric, MakeMetricSpec(options.metric, input, options.input));
  std::visit([&](auto& start) { job.start = std::move(start); }, input);
  job.options = options.loop.options;
  job.advance = options.loop.advance();
  job.thread_count = options.thread_count;
  return job;
}

Result<RemeshResult> Compute(const RemeshJob& job, const std::optional<std::string>& server) {
  const InterruptGuard guard;
  ProgressBar bar(std::cerr, ProgressBar::OfStandardError());
  const OnProgress on_progress = [&](const client::AdvanceProgress& progress) {
    bar.Show(progress);
    return guard.interrupted() ? Proceed::kCancel : Proceed::kGoOn;
  };
  return server ? RemeshOnServer(*server, job, on_progress) : RemeshLocally(job, on_progress);
}

void PrintSummary(const RemeshReport& report, const RemeshResult& result) {
  std::array<char, 96> rest;
  std::snprintf(rest.data(), rest.size(), "mean quality %.3f, least %.3f, %.3f s",
                result.quality.q_mean, result.quality.q_min, report.remesh_seconds);
  std::cout << report.output << ": " << Grouped(result.report.summary.vertex_count) << " vertices, "
            << Grouped(result.report.summary.triangle_count) << " triangles, " << rest.data()
            << "\n";
}

Status Run(const RemeshOptions& options) {
  PLIANT_RETURN_IF_ERROR(CheckMeshOutput(options.output));
  RemeshReport report{
      .input = options.input, .output = options.output, .server = options.server.address_if_any()};
  Stopwatch watch;
  PLIANT_ASSIGN_OR_RETURN(const RemeshJob job, ReadJob(options));
  report.read_seconds = watch.Lap();
  PLIANT_ASSIGN_OR_RETURN(const RemeshResult result, Compute(job, report.server));
  report.remesh_seconds = watch.Lap();
  PLIANT_RETURN_IF_ERROR(WriteCompactMesh(options.output, result.mesh));
  if (!options.output_metric.empty()) {
    PLIANT_RETURN_IF_ERROR(
        io::WriteField(options.output_metric, io::FieldFromMetrics(result.mesh.metrics)));
  }
  report.write_seconds = watch.Lap();
  report.peak_memory_bytes = PeakMemoryBytes();
  PrintWarnings(result.report, job.metric.gradation);
  if (!options.json.empty()) {
    PLIANT_RETURN_IF_ERROR(WriteJson(options.json, RemeshJson(report, result)));
  }
  if (options.json != "-") PrintSummary(report, result);
  return {};
}

Status Detach(const RemeshOptions& options) {
  PLIANT_ASSIGN_OR_RETURN(RemeshJob job, ReadJob(options));
  return SubmitDetached(options.server.address(), job, options.detached);
}

// What is written here has no place where nobody waits, and the other way round.
void CheckTarget(const RemeshOptions& options) {
  if (!options.detach && options.output.empty()) throw CLI::RequiredError("--output or --detach");
  const bool writes =
      !options.output.empty() || !options.output_metric.empty() || !options.json.empty();
  if (options.detach && (writes || options.server.local)) {
    throw CLI::ExcludesError("--detach", "--output, --output-metric, --json and --local");
  }
}

}  // namespace

void AddRemeshCommand(CLI::App& app, Command& chosen) {
  const auto options = std::make_shared<RemeshOptions>();
  CLI::App& command =
      *app.add_subcommand("remesh", "Make a mesh of a domain, or adapt a mesh, to a metric");
  command
      .add_option("input", options->input,
                  "Domain or mesh: .poly, .node/.ele, .mesh, .meshb or .msh")
      ->required()
      ->type_name("INPUT");
  command
      .add_option("-o,--output", options->output,
                  "Mesh: .mesh, .meshb, .msh, .vtu or .node/.ele; required unless --detach")
      ->type_name("FILE");
  command.add_option("--output-metric", options->output_metric, "Its metric at the vertices: .sol")
      ->type_name("FILE");
  command.add_option("--json", options->json, "Report as JSON; without FILE to standard output")
      ->type_name("[FILE]")
      ->expected(0, 1);
  AddMetricOptions(command, options->metric, MetricNeed::kRequired);
  AddLoopOptions(command, options->loop);
  AddServerOptions(command, options->server, LocalWork::kPossible);
  command.add_flag("--detach", options->detach,
                   "Hand it to a server as a job, print the job's id and wait for nothing");
  AddDetachOptions(command, options->detached);
  command
      .add_option(
          "--threads", options->thread_count,
          "Threads that work on a large mesh here (a server has --mesh-threads); 0: one for "
          "each core. The mesh does not depend on it")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command.footer(
      "Example:\n  pliant remesh plate.poly --size \"0.02+0.1*hypot(x,y)\" -o plate.vtu");
  CLI::Option* json = command.get_option("--json");
  command.callback([options, json, &chosen] {
    if (json->count() > 0 && options->json.empty()) options->json = "-";
    CheckTarget(*options);
    chosen.run = [options] { return options->detach ? Detach(*options) : Run(*options); };
  });
}

}  // namespace pliant::cli
