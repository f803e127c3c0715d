#include <iostream>
#include <memory>
#include <string>

#include "client/cli/command.h"
#include "client/cli/metric_options.h"
#include "client/cli/report.h"
#include "client/io/formats.h"

// pliant quality: how well a mesh in a file meets a metric.

namespace pliant::cli {
namespace {

struct QualityOptions {
  std::string input;
  std::string json;
  MetricOptions metric;
};

Status Run(const QualityOptions& options) {
  PLIANT_ASSIGN_OR_RETURN(const io::Geometry input, io::ReadGeometry(options.input));
  const auto* mesh = std::get_if<MeshData>(&input);
  if (mesh == nullptr) {
    return Error{.code = ErrorCode::kFileUnsupported,
                 .message = options.input + " has no triangles; make a mesh of it with remesh",
                 .field = "input"};
  }
  PLIANT_ASSIGN_OR_RETURN(const MetricSpec spec,
                          MakeMetricSpec(options.metric, input, options.input));
  PLIANT_ASSIGN_OR_RETURN(const std::unique_ptr<MetricField> field,
                          MakeMetricField(spec, BoxOf(mesh->points)));
  const Quality quality = MeasureQuality(*mesh, *field);
  PLIANT_RETURN_IF_ERROR(field->status());
  if (!options.json.empty()) return WriteJson(options.json, QualityJson(quality));
  std::cout << QualityText(quality);
  return {};
}

}  // namespace

void AddQualityCommand(CLI::App& app, Command& chosen) {
  const auto options = std::make_shared<QualityOptions>();
  CLI::App& command = *app.add_subcommand("quality", "Measure how well a mesh meets a metric");
  command.add_option("input", options->input, "Mesh: .node/.ele, .mesh, .meshb or .msh")
      ->required()
      ->type_name("MESH");
  CLI::Option* json =
      command.add_option("--json", options->json, "As JSON; without FILE to standard output")
          ->type_name("[FILE]")
          ->expected(0, 1);
  AddMetricOptions(command, options->metric, MetricNeed::kRequired);
  command.footer("Example:\n  pliant quality wing.mesh --metric wing.sol");
  command.callback([options, json, &chosen] {
    if (json->count() > 0 && options->json.empty()) options->json = "-";
    chosen.run = [options] { return Run(*options); };
  });
}

}  // namespace pliant::cli
