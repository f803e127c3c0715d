#pragma once

#include <string>

#include "client/plot/drawing.h"
#include "core/base/result.h"

namespace pliant::plot {

/// Writes the drawing as .svg or .png (192 dots per inch), as the extension says, in one step.
/// Fails with kFileUnsupported for other extensions, kFileUnwritable, or what FormatPng says.
[[nodiscard]] Status WriteDrawing(const std::string& path, const Drawing& drawing);

}  // namespace pliant::plot
