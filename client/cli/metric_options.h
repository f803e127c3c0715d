#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "client/io/geometry.h"
#include "core/base/result.h"
#include "core/metric/metric_spec.h"

namespace pliant::cli {

/// The options that say which metric is wanted; the same in every command.
struct MetricOptions {
  std::string metric_file;      ///< --metric
  std::string background_file;  ///< --background
  std::string expression;       ///< --metric-expr
  std::string size;             ///< --size
  double time = 0;
  SizeBounds bounds;
  GradationOptions gradation;

  [[nodiscard]] bool given() const {
    return !metric_file.empty() || !expression.empty() || !size.empty();
  }
};

enum class MetricNeed { kRequired, kOptional };

void AddMetricOptions(CLI::App& command, MetricOptions& options, MetricNeed need);

/// The specification that the options describe, for this input: tensors of a file belong to the
/// points of the background mesh, or else of the input itself. Reads the files. Errors: those of
/// the files; kArrayLength if tensors and points do not match; kFileUnsupported if tensors have no
/// mesh to belong to; kExpressionSyntax for --metric-expr without three parts.
/// @pre options.given()
[[nodiscard]] Result<MetricSpec> MakeMetricSpec(const MetricOptions& options,
                                                const io::Geometry& input,
                                                const std::string& input_path);

/// The metric at every point of a mesh, for plots and files. Errors: those of MakeMetricField, and
/// kExpressionValue.
[[nodiscard]] Result<std::vector<Metric>> MetricsAtPoints(const MetricSpec& spec,
                                                          const MeshData& mesh);

}  // namespace pliant::cli
