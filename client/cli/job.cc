#include <chrono>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/interrupt.h"
#include "client/cli/job_report.h"
#include "client/cli/mesh_output.h"
#include "client/cli/progress_bar.h"
#include "client/cli/report.h"
#include "client/cli/server_command.h"

// pliant job: what remesh --detach has started, one command for each thing that can be done with
// it.

namespace pliant::cli {
namespace {

using client::Client;

struct JobOptions : ServerCommandOptions {
  double seconds_max = 0;
};
using SharedJobOptions = std::shared_ptr<JobOptions>;

void Print(const client::JobInfo& job) { std::cout << JobText(job); }

Status Show(const client::JobInfo& job, const JobOptions& options) {
  if (!options.json.empty()) return WriteJson(options.json, JobJson(job));
  Print(job);
  return {};
}

Status List(const JobOptions& options, Client& server) {
  PLIANT_ASSIGN_OR_RETURN(const std::vector<client::JobInfo> jobs, server.ListJobs());
  return ShowAll(jobs, options.json, JobJson, Print);
}

Status ShowOne(const JobOptions& options, Client& server) {
  PLIANT_ASSIGN_OR_RETURN(const client::JobInfo job, server.GetJob(options.id));
  return Show(job, options);
}

// Ctrl-C ends the waiting; the job goes on.
Status Wait(const JobOptions& options, Client& server) {
  client::JobWait wait;
  if (options.seconds_max > 0) {
    wait.time_max =
        std::chrono::milliseconds(static_cast<std::int64_t>(options.seconds_max * 1000));
  }
  const InterruptGuard guard;
  const Result<client::JobInfo> job = [&] {
    ProgressBar bar(std::cerr, ProgressBar::OfStandardError());
    wait.on_look = [&](const client::JobInfo& info) {
      if (info.progress) bar.Show(*info.progress);
      return !guard.interrupted();
    };
    return server.WaitForJob(options.id, wait);
  }();
  if (!job.ok()) return job.error();
  PLIANT_RETURN_IF_ERROR(Show(*job, options));
  return JobStatus(*job);
}

Status Cancel(const JobOptions& options, Client& server) {
  for (const std::string& id : options.ids) {
    const Result<client::JobInfo> job = server.CancelJob(id);
    if (!job.ok()) return job.error();
    Print(*job);
  }
  return {};
}

Status Fetch(const JobOptions& options, Client& server) {
  PLIANT_RETURN_IF_ERROR(CheckMeshOutput(options.output));
  PLIANT_ASSIGN_OR_RETURN(const client::MeshReplica replica,
                          server.FetchResult(options.id, client::Parts::kMeshAndMetric));
  return WriteCompactMesh(options.output, replica.Compact());
}

void AddJobId(CLI::App& command, const SharedJobOptions& options) {
  command.add_option("id", options->id, "Which job")->required()->type_name("ID");
}

}  // namespace

void AddJobCommand(CLI::App& app, Command& chosen) {
  CLI::App& group = *app.add_subcommand("job", "Jobs on a server, made by remesh --detach");
  group.require_subcommand(1);
  group.footer("Example:\n  pliant job wait $(pliant remesh plate.poly --size 0.05 --detach)");
  const auto options = std::make_shared<JobOptions>();

  CLI::App& list = *group.add_subcommand("list", "List all jobs, newest first");
  AddJson(list, *options);
  list.footer("Example:\n  pliant job list --json");
  FinishServerCommand(list, options, List, chosen);

  CLI::App& show = *group.add_subcommand("show", "Describe a job");
  AddJobId(show, options);
  AddJson(show, *options);
  show.footer("Example:\n  pliant job show plate");
  FinishServerCommand(show, options, ShowOne, chosen);

  CLI::App& wait = *group.add_subcommand("wait", "Wait until a job has ended; 0 if it is done");
  AddJobId(wait, options);
  wait.add_option("--seconds-max", options->seconds_max, "Wait no longer than this; 0: for ever")
      ->check(CLI::Range(0.0, 1e8))
      ->capture_default_str();
  AddJson(wait, *options);
  wait.footer("Example:\n  pliant job wait plate && pliant job fetch plate -o plate.vtu");
  FinishServerCommand(wait, options, Wait, chosen);

  CLI::App& cancel = *group.add_subcommand("cancel", "Stop jobs; those that have ended stay");
  cancel.add_option("ids", options->ids, "Which jobs")->required()->type_name("ID");
  cancel.footer("Example:\n  pliant job cancel plate");
  FinishServerCommand(cancel, options, Cancel, chosen);

  CLI::App& fetch = *group.add_subcommand("fetch", "Download the mesh of a job that is done");
  AddJobId(fetch, options);
  fetch.add_option("-o,--output", options->output, "Mesh: .mesh, .meshb, .msh, .vtu or .node/.ele")
      ->required()
      ->type_name("FILE");
  fetch.footer("Example:\n  pliant job fetch plate -o plate.vtu");
  FinishServerCommand(fetch, options, Fetch, chosen);
}

}  // namespace pliant::cli
