#include "core/metric/grid_metric.h"

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

namespace pliant {
namespace {

constexpr std::size_t kNodesMax = std::size_t{1} << 30;

Error Refusal(ErrorCode code, const std::string& name, const std::string& what) {
  const std::string field = "metric.grid." + name;
  return {.code = code, .message = field + " " + what, .field = field};
}

Status CheckAxis(double origin, double step, const std::string& axis) {
  if (!std::isfinite(origin)) {
    return Refusal(ErrorCode::kNotFinite, "origin_" + axis, "is NaN or infinite");
  }
  if (!std::isfinite(step)) {
    return Refusal(ErrorCode::kNotFinite, "step_" + axis, "is NaN or infinite");
  }
  if (!(step > 0)) {
    return Refusal(ErrorCode::kOutOfRange, "step_" + axis,
                   "is " + std::to_string(step) + "; it must be positive");
  }
  return {};
}

/// A grid whose far end is so far from its step that nodes fall together makes no triangles.
Status CheckEnd(double origin, double step, std::size_t count, const std::string& axis) {
  const double last = origin + step * static_cast<double>(count - 1);
  const double before = origin + step * static_cast<double>(count - 2);
  if (std::isfinite(last) && before < last && origin < origin + step) return {};
  return Refusal(ErrorCode::kOutOfRange, "step_" + axis,
                 "is too large or too small for the origin: nodes would be infinite or coincide");
}

Status CheckGrid(const GridMetric& grid) {
  PLIANT_RETURN_IF_ERROR(CheckAxis(grid.origin.x, grid.step.x, "x"));
  PLIANT_RETURN_IF_ERROR(CheckAxis(grid.origin.y, grid.step.y, "y"));
  if (grid.column_count < 2) {
    return Refusal(ErrorCode::kOutOfRange, "column_count",
                   "is " + std::to_string(grid.column_count) + "; a row has 2 nodes or more");
  }
  const std::size_t count = grid.tensors.size();
  if (count > kNodesMax) {
    return Refusal(
        ErrorCode::kTooLarge, "tensors",
        "has " + std::to_string(count) + " rows; allowed are " + std::to_string(kNodesMax));
  }
  if (count % grid.column_count != 0 || count / grid.column_count < 2) {
    return Refusal(ErrorCode::kArrayLength, "tensors",
                   "has " + std::to_string(count) + " rows; expected a multiple of column_count, " +
                       std::to_string(grid.column_count) + ", at least twice that");
  }
  PLIANT_RETURN_IF_ERROR(CheckEnd(grid.origin.x, grid.step.x, grid.column_count, "x"));
  return CheckEnd(grid.origin.y, grid.step.y, count / grid.column_count, "y");
}

}  // namespace

Result<BackgroundMetric> ToBackground(GridMetric grid) {
  PLIANT_RETURN_IF_ERROR(CheckGrid(grid));
  const std::size_t columns = grid.column_count;
  const std::size_t rows = grid.tensors.size() / columns;
  BackgroundMetric background;
  background.mesh.points.reserve(grid.tensors.size());
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      background.mesh.points.push_back({grid.origin.x + grid.step.x * static_cast<double>(column),
                                        grid.origin.y + grid.step.y * static_cast<double>(row)});
    }
  }
  background.mesh.triangles.reserve(2 * (rows - 1) * (columns - 1));
  for (std::size_t row = 0; row + 1 < rows; ++row) {
    for (std::size_t column = 0; column + 1 < columns; ++column) {
      const auto a = static_cast<std::int32_t>(row * columns + column);
      const auto above = a + static_cast<std::int32_t>(columns);
      background.mesh.triangles.push_back({a, a + 1, above + 1});
      background.mesh.triangles.push_back({a, above + 1, above});
    }
  }
  background.tensors = std::move(grid.tensors);
  return background;
}

}  // namespace pliant
