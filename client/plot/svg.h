#pragma once

#include <string>

#include "client/plot/drawing.h"

namespace pliant::plot {

/// The drawing as an SVG 1.1 document. Coordinates to 1/1000 of a unit; each Segments is one path
/// element, so that large meshes stay small and quick.
[[nodiscard]] std::string FormatSvg(const Drawing& drawing);

}  // namespace pliant::plot
