#pragma once

#include <string>
#include <string_view>

#include "client/io/geometry.h"
#include "core/base/result.h"

namespace pliant::io {

/// Reads a Medit solution, text (.sol) or binary (.solb): one scalar (1 component) or symmetric
/// tensor (3 components m11, m12, m22) per vertex. Of a tensor in dimension 3 the x-y part is kept.
/// Fails as ParseMedit does; kFileUnsupported for vectors and for several solutions in one file.
[[nodiscard]] Result<PointField> ParseSol(std::string_view bytes);

/// Reads the metric file of BAMG (.mtr): "count 1" and sizes, or "count 3" and m11, m12, m22.
[[nodiscard]] Result<PointField> ParseMtr(std::string_view bytes);

/// The field as a Medit solution in dimension 2, text.
[[nodiscard]] std::string FormatSol(const PointField& field);

}  // namespace pliant::io
