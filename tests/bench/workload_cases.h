#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/metric/metric_field.h"
#include "core/metric/metric_spec.h"

namespace pliant::bench {

/// How the remesher learns the metric.
enum class MetricForm {
  kAnalytic,    ///< A C++ function.
  kExpression,  ///< Formulas, as a client sends them.
  kBackground,  ///< Tensors at the vertices of a mesh that is already adapted to the metric.
};

/// Which case, and how large.
struct CaseRequest {
  std::string name = "A";
  double node_count = 10'000;  ///< Wanted; an ideal unit mesh has about as many.
  std::string poly;            ///< Case D: a Triangle .poly with the outlines.
  double front = 0.5;          ///< Case E: where the front stands.
};

/// A domain and its metric. The field can be had any number of times.
struct BenchCase {
  Domain domain;
  std::function<std::unique_ptr<MetricField>()> field;
};

/// The case that `request` names: A (Gaussian), B (diagonal), C (front, 100:1), C1000 (1000:1),
/// D (letters), E (front at `front`), F (disc off) or F-on. Fails with kOutOfRange for another
/// name, and as the reader of .poly does.
[[nodiscard]] Result<BenchCase> MakeCase(const CaseRequest& request);

/// The same metric as formulas; nothing for cases that have none (D, F-on).
[[nodiscard]] std::optional<MetricSpec> FormulasOf(const CaseRequest& request);

}  // namespace pliant::bench
