#include "client/cli/metric_options.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "client/io/formats.h"

namespace pliant::cli {
namespace {

std::string Trimmed(const std::string& text) {
  constexpr const char* kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

Result<ExpressionMetric> SplitExpression(const std::string& text) {
  std::vector<std::string> parts;
  std::size_t start = 0;
  for (std::size_t end = 0; end != std::string::npos; start = end + 1) {
    end = text.find(';', start);
    parts.push_back(Trimmed(text.substr(start, end - start)));
  }
  if (parts.size() != 3 || std::ranges::find(parts, "") != parts.end()) {
    return Error{.code = ErrorCode::kExpressionSyntax,
                 .message = "\"" + text +
                            "\" is not of the form \"M11; M12; M22\": three formulas "
                            "in x, y and t with a semicolon between each",
                 .field = "--metric-expr"};
  }
  return ExpressionMetric{parts[0], parts[1], parts[2]};
}

/// The mesh that the tensors of --metric belong to.
Result<MeshData> MeshOfTensors(const MetricOptions& options, const io::Geometry& input,
                               const std::string& input_path) {
  io::Geometry owner = input;
  std::string path = input_path;
  if (!options.background_file.empty()) {
    path = options.background_file;
    PLIANT_ASSIGN_OR_RETURN(owner, io::ReadGeometry(path));
  }
  if (auto* mesh = std::get_if<MeshData>(&owner)) return std::move(*mesh);
  return Error{.code = ErrorCode::kFileUnsupported,
               .message = options.metric_file + " has values at points of a mesh, but " + path +
                          " is a domain without triangles; name the mesh that the values belong "
                          "to with --background MESH",
               .field = "--metric"};
}

Result<BackgroundMetric> ReadBackground(const MetricOptions& options, const io::Geometry& input,
                                        const std::string& input_path) {
  PLIANT_ASSIGN_OR_RETURN(MeshData mesh, MeshOfTensors(options, input, input_path));
  PLIANT_ASSIGN_OR_RETURN(const io::PointField field, io::ReadField(options.metric_file));
  PLIANT_ASSIGN_OR_RETURN(std::vector<Metric> tensors, io::MetricsFromField(field));
  if (tensors.size() != mesh.points.size()) {
    const std::string& path =
        options.background_file.empty() ? input_path : options.background_file;
    return Error{.code = ErrorCode::kArrayLength,
                 .message = options.metric_file + " has " + std::to_string(tensors.size()) +
                            " values, but " + path + " has " + std::to_string(mesh.points.size()) +
                            " points",
                 .field = "--metric"};
  }
  return BackgroundMetric{std::move(mesh), std::move(tensors)};
}

}  // namespace

void AddMetricOptions(CLI::App& command, MetricOptions& options, MetricNeed need) {
  CLI::Option_group& source = *command.add_option_group(
      "Metric",
      "Which sizes are wanted: formulas in x, y and t, or values at points; of several, in every "
      "direction the finest");
  source.add_option("--size", options.size, "Wanted edge length as a formula, e.g. 0.05+0.1*x")
      ->type_name("FORMULA");
  source
      .add_option("--metric-expr", options.expression,
                  "Wanted metric as three formulas \"M11; M12; M22\" in 1/length^2")
      ->type_name("FORMULAS");
  CLI::Option* file =
      source
          .add_option("--metric", options.metric_file,
                      "Sizes or tensors at points, .sol .solb or .mtr; the points are those of the "
                      "input mesh, or of --background")
          ->type_name("FILE");
  source.require_option(need == MetricNeed::kRequired ? 1 : 0, 3);
  command.add_option("--background", options.background_file, "Mesh that --metric belongs to")
      ->type_name("MESH")
      ->needs(file);
  command.add_option("--time", options.time, "Value of t in formulas")->capture_default_str();
  command.add_option("--hmin", options.bounds.size_min, "Least wanted edge length; 0 is no limit")
      ->capture_default_str();
  command
      .add_option("--hmax", options.bounds.size_max, "Greatest wanted edge length; 0 is no limit")
      ->capture_default_str();
  command
      .add_option("--anisotropy-max", options.bounds.anisotropy_max,
                  "Greatest ratio of wanted lengths along and across; 0 is no limit")
      ->capture_default_str();
  const auto has_chosen = [&options](const std::string&) { options.gradation.automatic = false; };
  command
      .add_option("--hgrad", options.gradation.gradation,
                  "Sizes grow at most by this factor from one edge to the next; 0 is no limit. "
                  "Without --hgrad and --rotation, 1.5 and 0.7 hold where the metric cannot be met "
                  "as it is")
      ->each(has_chosen)
      ->type_name("FLOAT");
  command
      .add_option("--rotation", options.gradation.rotation,
                  "Limit on how far axes turn over one long element, 0.1 to 10, larger is looser; "
                  "0 is no limit")
      ->each(has_chosen)
      ->type_name("FLOAT");
  command
      .add_option(
          "--geometry", options.gradation.geometry,
          "Greatest size at a point of the domain by the shortest segment there, 0.1 to 10; "
          "1 suits short segments, with --hgrad; 0 is no limit")
      ->capture_default_str();
  command
      .add_option(
          "--gap-elements", options.gradation.gap_element_count,
          "How many elements fit across a gap between boundaries, 0.5 to 100, with --hgrad; "
          "0 is no limit")
      ->capture_default_str();
  command
      .add_option("--tensor-smoothing", options.gradation.smoothing_count,
                  "Averages of each tensor with those of its neighbours, 1 or 2 for noisy ones")
      ->check(CLI::Range(0, 8))
      ->capture_default_str();
}

Result<MetricSpec> MakeMetricSpec(const MetricOptions& options, const io::Geometry& input,
                                  const std::string& input_path) {
  MetricSpec spec;
  spec.time = options.time;
  spec.bounds = options.bounds;
  spec.gradation = options.gradation;
  std::vector<PlainMetric> sources;
  if (!options.size.empty()) sources.emplace_back(SizeMetric{options.size});
  if (!options.expression.empty()) {
    PLIANT_ASSIGN_OR_RETURN(sources.emplace_back(), SplitExpression(options.expression));
  }
  if (!options.metric_file.empty()) {
    PLIANT_ASSIGN_OR_RETURN(sources.emplace_back(), ReadBackground(options, input, input_path));
  }
  if (sources.size() == 1) {
    std::visit([&](auto& source) { spec.source = std::move(source); }, sources.front());
  } else {
    spec.source = IntersectedMetric{std::move(sources)};
  }
  return spec;
}

Result<std::vector<Metric>> MetricsAtPoints(const MetricSpec& spec, const MeshData& mesh) {
  PLIANT_ASSIGN_OR_RETURN(const std::unique_ptr<MetricField> field,
                          MakeMetricField(spec, BoxOf(mesh.points)));
  std::vector<Metric> metrics;
  metrics.reserve(mesh.points.size());
  std::int32_t hint = MetricField::kNoHint;
  for (const Vec2 point : mesh.points) metrics.push_back(field->At(point, hint));
  PLIANT_RETURN_IF_ERROR(field->status());
  return metrics;
}

}  // namespace pliant::cli
