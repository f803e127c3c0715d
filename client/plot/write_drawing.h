#pragma once

#include <string>

#include "client/plot/drawing.h"
#include "core/base/result.h"

namespace pliant::plot {

/// Writes the drawing as .svg or .png, as the extension says, in one step. A .png has
/// `dots_per_inch`; a unit of the drawing is 1/96 inch.
/// Fails with kFileUnsupported for other extensions, kFileUnwritable, or what FormatPng says.
[[nodiscard]] Status WriteDrawing(const std::string& path, const Drawing& drawing,
                                  double dots_per_inch = 192);

}  // namespace pliant::plot
