#include <CLI/CLI.hpp>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "client/io/formats.h"
#include "client/plot/chart.h"
#include "client/plot/mesh_plot.h"
#include "client/plot/write_drawing.h"

// pliant_sheet: pictures of several things at once, described by a JSON file. What `pliant plot`,
// which draws one mesh, does not do.
//
//   {"panels": [{"mesh": "a.mesh", "title": "initial"}, ...], "columns": 3, "size": 300}
//   {"chart": {"title": ..., "x_label": ..., "y_label": ...,
//              "series": [{"name": ..., "points": [[x, y], ...]}, ...]}}

namespace pliant {
namespace {

using Json = nlohmann::json;

Result<plot::Drawing> DrawPanel(const Json& panel, double size) {
  const std::string path = panel.at("mesh");
  PLIANT_ASSIGN_OR_RETURN(const io::Geometry geometry, io::ReadGeometry(path));
  const auto* mesh = std::get_if<MeshData>(&geometry);
  if (mesh == nullptr) {
    return Error{.code = ErrorCode::kFileUnsupported,
                 .message = path + " has no triangles",
                 .field = "panels"};
  }
  plot::PlotOptions options{.width = size, .height = size};
  options.title = panel.value("title", "");
  options.caption = plot::MeshCaption(*mesh, plot::TriangleQualities(*mesh, {}));
  return plot::PlotMesh(*mesh, options);
}

Result<plot::Drawing> DrawPanels(const Json& sheet) {
  const double size = sheet.value("size", 300.0);
  const auto columns = sheet.value<std::size_t>("columns", 3);
  std::vector<plot::Drawing> rows;
  std::vector<plot::Drawing> row;
  const Json& panels = sheet.at("panels");
  for (std::size_t i = 0; i < panels.size(); ++i) {
    PLIANT_ASSIGN_OR_RETURN(plot::Drawing panel, DrawPanel(panels[i], size));
    row.push_back(std::move(panel));
    if (row.size() == columns || i + 1 == panels.size()) {
      rows.push_back(plot::Beside(std::exchange(row, {})));
    }
  }
  return plot::Below(std::move(rows));
}

plot::Drawing DrawChart(const Json& description) {
  plot::ScalingChart chart;
  chart.title = description.value("title", "");
  chart.x_label = description.value("x_label", "");
  chart.y_label = description.value("y_label", "");
  for (const Json& line : description.at("series")) {
    plot::Series series{.name = line.value("name", "")};
    for (const Json& point : line.at("points")) series.points.push_back({point[0], point[1]});
    chart.series.push_back(std::move(series));
  }
  return plot::PlotScaling(chart, {.width = 640, .height = 480});
}

struct SheetOptions {
  std::string sheet;
  std::vector<std::string> outputs;
  double dpi = 192;
};

Status Draw(const SheetOptions& options) {
  std::ifstream file(options.sheet);
  const Json sheet = Json::parse(file);
  plot::Drawing drawing;
  if (sheet.contains("chart")) {
    drawing = DrawChart(sheet["chart"]);
  } else {
    PLIANT_ASSIGN_OR_RETURN(drawing, DrawPanels(sheet));
  }
  for (const std::string& output : options.outputs) {
    PLIANT_RETURN_IF_ERROR(plot::WriteDrawing(output, drawing, options.dpi));
  }
  return {};
}

}  // namespace
}  // namespace pliant

int main(int argc, char** argv) {
  CLI::App app("Draws several meshes, or a chart of running times, on one sheet");
  pliant::SheetOptions options;
  app.add_option("sheet", options.sheet, "What to draw: .json")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("-o,--output", options.outputs, "Pictures: .svg or .png")->required();
  app.add_option("--dpi", options.dpi, "Pixels per inch of a .png")
      ->check(CLI::Range(10.0, 2000.0));
  CLI11_PARSE(app, argc, argv);
  try {
    const pliant::Status status = pliant::Draw(options);
    if (status.ok()) return EXIT_SUCCESS;
    std::cerr << "pliant_sheet: " << status.error().message << "\n";
  } catch (const nlohmann::json::exception& error) {
    std::cerr << "pliant_sheet: " << options.sheet << ": " << error.what() << "\n";
  }
  return EXIT_FAILURE;
}
