#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/command.h"
#include "client/cli/metric_options.h"
#include "client/io/formats.h"
#include "client/plot/chart.h"
#include "client/plot/mesh_plot.h"
#include "client/plot/write_drawing.h"
#include "core/pliant/quality.h"

// pliant plot: what the figures of the paper show.

namespace pliant::cli {
namespace {

struct PlotCommandOptions {
  std::string input;
  std::string output;
  std::string title;
  MetricOptions metric;
  std::vector<double> window;  ///< x_min y_min x_max y_max, or nothing.
  double size = 720;
  double dpi = 192;
  bool ellipses = false;
  bool histograms = false;
  bool quality_colors = false;
  bool stretch = false;
};

Result<std::optional<BoundingBox>> WindowOf(const PlotCommandOptions& options) {
  if (options.window.empty()) return std::optional<BoundingBox>();
  const BoundingBox box{{options.window[0], options.window[1]},
                        {options.window[2], options.window[3]}};
  if (box.low.x < box.high.x && box.low.y < box.high.y) return std::optional(box);
  return Error{.code = ErrorCode::kOutOfRange,
               .message =
                   "the window is empty: give XMIN YMIN XMAX YMAX with XMIN < XMAX and "
                   "YMIN < YMAX",
               .field = "--window"};
}

/// The panels with histograms of normalized angles and lengths.
Result<plot::Drawing> HistogramPanels(const MetricSpec& spec, const MeshData& mesh) {
  PLIANT_ASSIGN_OR_RETURN(const std::unique_ptr<MetricField> field,
                          MakeMetricField(spec, BoxOf(mesh.points)));
  const Quality quality = MeasureQuality(mesh, *field);
  PLIANT_RETURN_IF_ERROR(field->status());
  return plot::PlotQuality({.angle_counts = quality.angles.counts,
                            .length_counts = quality.lengths.counts,
                            .length_max = quality.lengths.upper});
}

Status Run(const PlotCommandOptions& options) {
  PLIANT_ASSIGN_OR_RETURN(const io::Geometry input, io::ReadGeometry(options.input));
  const auto* mesh = std::get_if<MeshData>(&input);
  if (mesh == nullptr || mesh->points.empty()) {
    return Error{.code = ErrorCode::kFileUnsupported,
                 .message = options.input + " has no triangles; make a mesh of it with remesh",
                 .field = "input"};
  }
  plot::PlotOptions plot_options{.width = options.size, .height = options.size};
  PLIANT_ASSIGN_OR_RETURN(plot_options.window, WindowOf(options));
  plot_options.title = options.title;
  if (options.stretch) plot_options.fit = plot::WindowFit::kStretch;

  MetricSpec spec;
  if (options.metric.given()) {
    PLIANT_ASSIGN_OR_RETURN(spec, MakeMetricSpec(options.metric, input, options.input));
    PLIANT_ASSIGN_OR_RETURN(plot_options.metrics, MetricsAtPoints(spec, *mesh));
  }
  if (options.ellipses) plot_options.ellipses = plot::Ellipses::kShow;
  std::vector<double> qualities = plot::TriangleQualities(*mesh, plot_options.metrics);
  plot_options.caption = plot::MeshCaption(*mesh, qualities);
  if (options.quality_colors) {
    plot_options.fill = plot::Fill::kValues;
    plot_options.triangle_values = std::move(qualities);
  }
  plot::Drawing drawing = plot::PlotMesh(*mesh, plot_options);
  if (options.histograms) {
    PLIANT_ASSIGN_OR_RETURN(plot::Drawing panels, HistogramPanels(spec, *mesh));
    std::vector<plot::Drawing> column;
    column.push_back(std::move(drawing));
    column.push_back(std::move(panels));
    drawing = plot::Below(std::move(column));
  }
  return plot::WriteDrawing(options.output, drawing, options.dpi);
}

/// Ellipses and histograms show a metric, so there must be one.
void CheckMetricGiven(const PlotCommandOptions& options) {
  if ((options.ellipses || options.histograms) && !options.metric.given()) {
    throw CLI::RequiredError(
        "--ellipses and --histograms show a metric: --metric, --metric-expr "
        "or --size");
  }
}

}  // namespace

void AddPlotCommand(CLI::App& app, Command& chosen) {
  const auto options = std::make_shared<PlotCommandOptions>();
  CLI::App& command = *app.add_subcommand("plot", "Draw a mesh, its metric and its quality");
  command.add_option("input", options->input, "Mesh: .node/.ele, .mesh, .meshb or .msh")
      ->required()
      ->type_name("MESH");
  command.add_option("-o,--output", options->output, "Picture: .svg or .png")
      ->required()
      ->type_name("FILE");
  command.add_flag("--ellipses", options->ellipses, "The metric's ellipse around each vertex");
  command.add_flag("--histograms", options->histograms, "Normalized angles and edge lengths below");
  command.add_flag("--quality", options->quality_colors, "Colour triangles by their quality");
  command.add_option("--window", options->window, "Only this part: XMIN YMIN XMAX YMAX")
      ->expected(4)
      ->delimiter(',')
      ->type_name("NUMBERS");
  command.add_flag("--stretch", options->stretch, "Fill the picture, with a scale per direction");
  command.add_option("--title", options->title, "Above the picture")->type_name("TEXT");
  command.add_option("--dpi", options->dpi, "Pixels per inch of a .png")
      ->check(CLI::Range(10.0, 2000.0))
      ->capture_default_str();
  command.add_option("--picture-size", options->size, "Width and height, in 1/96 inch")
      ->check(CLI::Range(16.0, 16000.0))
      ->capture_default_str();
  AddMetricOptions(command, options->metric, MetricNeed::kOptional);
  command.footer("Example:\n  pliant plot wing.mesh --metric wing.sol --histograms -o wing.svg");
  command.callback([options, &chosen] {
    CheckMetricGiven(*options);
    chosen.run = [options] { return Run(*options); };
  });
}

}  // namespace pliant::cli
