#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/plot/drawing.h"
#include "core/geometry/bounding_box.h"
#include "core/geometry/mesh_data.h"
#include "core/metric/metric.h"

namespace pliant::plot {

enum class WindowFit {
  kEqual,    ///< The same scale in both directions.
  kStretch,  ///< The window fills the panel, with a scale of its own in each direction (figure 14).
};
enum class Fill {
  kRegions,  ///< Pale colours by region tag if there is more than one region, else white.
  kNone,
  kValues,  ///< Colours by PlotOptions::triangle_values, with a scale beside the mesh.
};
enum class Ellipses { kHide, kShow };

struct PlotOptions {
  /// Size of the panel in units of 1/96 inch; with kEqual, the mesh is as large as fits in it.
  double width = 720;
  double height = 720;
  std::optional<BoundingBox> window = {};  ///< What is shown, with axes; the whole mesh if absent.
  WindowFit fit = WindowFit::kEqual;
  Fill fill = Fill::kRegions;
  /// One value from 0 (bad) to 1 (good) per triangle, such as TriangleQualities; for kValues.
  std::vector<double> triangle_values = {};
  std::string values_label = "quality";
  /// kShow draws the ellipse d(p_i, y) = 1/2 around each vertex (figure 10b): with the metric right
  /// and the mesh perfect, those of neighbours touch.
  Ellipses ellipses = Ellipses::kHide;
  std::vector<Metric> metrics = {};  ///< One per point; for the ellipses.
  std::string title = {};            ///< Above the mesh.
  std::string caption = {};          ///< Below it, such as MeshCaption.
};

/// Draws a mesh: thin lines for its edges, bold ones for its boundary and its constrained edges,
/// these coloured by tag if there is more than one. Arrays in the options whose length does not fit
/// the mesh are not drawn. @par Cost O(n log n); about a second for 1M triangles.
[[nodiscard]] Drawing PlotMesh(const MeshData& mesh, const PlotOptions& options = {});

/// Q = 4 sqrt(3) A / sum l^2 of each triangle, 1 if equilateral: area and edge lengths in the mean
/// metric of the corners; without metrics, in the plane. Inverted triangles have 0.
[[nodiscard]] std::vector<double> TriangleQualities(const MeshData& mesh,
                                                    std::span<const Metric> metrics);

/// "925 nodes, 1,743 triangles, mean quality 0.96"; without qualities, the counts only.
[[nodiscard]] std::string MeshCaption(const MeshData& mesh, std::span<const double> qualities);

}  // namespace pliant::plot
