#pragma once

#include <string>

#include "client/plot/drawing.h"
#include "core/base/result.h"

namespace pliant::plot {

/// The drawing as a PNG file with `scale` pixels per unit (2: 192 dots per inch).
///
/// Lines of a Segments whose ends fall on the same quarter pixels are drawn once, so that a mesh
/// far finer than the picture costs no more than one as fine. Fails with kOutOfRange for a size
/// without pixels or beyond 32,767 of them in a direction, kResourceExhausted without memory.
[[nodiscard]] Result<std::string> FormatPng(const Drawing& drawing, double scale = 2);

}  // namespace pliant::plot
