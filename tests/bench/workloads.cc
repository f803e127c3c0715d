// Times whole builds and updates on the cases of the peer benchmark, in this process, and reports
// as JSON: tests/bench/README.md.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>

#include "tests/bench/workload_run.h"

namespace {

using pliant::Variant;
using pliant::bench::DisplacedTensors;
using pliant::bench::MetricForm;
using pliant::bench::Request;

const std::map<std::string, Variant> kVariants = {
    {"nested", Variant::kNested}, {"cooled", Variant::kCooled}, {"paper", Variant::kPaper}};
const std::map<std::string, MetricForm> kForms = {{"analytic", MetricForm::kAnalytic},
                                                  {"expression", MetricForm::kExpression},
                                                  {"background", MetricForm::kBackground},
                                                  {"tensors", MetricForm::kTensors}};

const std::map<std::string, DisplacedTensors> kDisplacedTensors = {
    {"seen", DisplacedTensors::kSeen},
    {"together", DisplacedTensors::kTogether},
    {"apart", DisplacedTensors::kApart}};

int Run(const Request& request, nlohmann::json report, const std::string& path) {
  auto result = request.update.empty() ? RunBuild(request) : RunUpdate(request);
  if (!result.ok()) {
    std::cerr << result.error().message << '\n';
    return 1;
  }
  report["result"] = *result;
  report["machine"] = pliant::bench::Machine();
  if (path.empty()) {
    std::cout << report.dump(2) << '\n';
    return 0;
  }
  std::ofstream file(path);
  file << report.dump(2) << '\n';
  return file.good() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Request request;
  std::string variant = "nested";
  std::string metric = "analytic";
  std::string displaced_tensors = "seen";
  std::string json_path;
  CLI::App app("Times builds and updates of meshes; the report is JSON.");
  app.add_option("--case", request.instance.name, "A, B, C, C1000, D, E or F")->required();
  app.add_option("--nodes", request.instance.node_count, "wanted nodes")
      ->check(CLI::PositiveNumber);
  app.add_option("--poly", request.instance.poly, "case D: outlines as a Triangle .poly");
  app.add_option("--front", request.instance.front, "case E: where the front starts");
  app.add_option("--variant", variant)->check(CLI::IsMember(kVariants));
  app.add_option("--metric", metric)->check(CLI::IsMember(kForms));
  app.add_option("--hgrad", request.limits.gradation, "limit of the metric; 0: none");
  app.add_option("--rotation", request.limits.rotation, "limit of the metric; 0: none");
  app.add_option("--geometry", request.limits.geometry, "limit of the metric; 0: none");
  app.add_option(
      "--update", request.update,
      "disc, tensors, bump, same, front, drift, body, nodes or domain; default: build only");
  app.add_flag("--send-all", request.sends_all, "bump: tensors are sent for all vertices");
  app.add_option("--beside", request.beside, "bump: a size in x, y that stands beside the tensors")
      ->excludes("--send-all");
  app.add_option("--changed", request.changed, "bump: nodes under it")
      ->check(CLI::Range(2, 1 << 30));
  app.add_option("--follow", request.follow, "body: nodes within so many lengths go with it");
  app.add_option("--steps", request.steps, "front, drift, body: number of steps")
      ->check(CLI::PositiveNumber);
  app.add_option("--front-step", request.front_step, "front: length of a step");
  app.add_option("--size-step", request.size_step, "drift: factor on all sizes of a step")
      ->check(CLI::Range(0.5, 2.0));
  app.add_flag("--stretch", request.stretches,
               "drift: the nodes move apart instead, by the inverse of the factor");
  app.add_flag("--displace", request.displaces, "front: its displacement is sent, too");
  app.add_option("--displaced-tensors", displaced_tensors,
                 "front: tensors after the displacement as it came out (seen), of the places where "
                 "it leads (together), or in a second update (apart)")
      ->check(CLI::IsMember(kDisplacedTensors));
  app.add_option("--swing", request.swing, "front: turns back after so many steps; 0: never");
  app.add_option("--threads", request.thread_count, "threads that work on the mesh")
      ->check(CLI::Range(1, 1024));
  app.add_option("--repeat", request.repeat)->check(CLI::PositiveNumber);
  app.add_option("--mesh", request.mesh_path, "write the mesh here (Medit)");
  app.add_option("--json", json_path, "write the report here; default: standard output");
  CLI11_PARSE(app, argc, argv);
  request.options.variant = kVariants.at(variant);
  request.form = kForms.at(metric);
  request.displaced_tensors = kDisplacedTensors.at(displaced_tensors);
  return Run(request,
             {{"case", request.instance.name},
              {"nodes_wanted", request.instance.node_count},
              {"variant", variant},
              {"metric", metric},
              {"update", request.update},
              {"threads", request.thread_count},
              {"repeat", request.repeat}},
             json_path);
}
