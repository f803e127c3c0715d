#pragma once

#include <cstdint>
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
  kTensors,     ///< A function at first, then tensors at the vertices of the session's own mesh.
};

/// Which case, and how large.
struct CaseRequest {
  std::string name = "A";
  double node_count = 10'000;  ///< Wanted; an ideal unit mesh has about as many.
  std::string poly;            ///< Case D: a Triangle .poly with the outlines.
  double front = 0.5;          ///< Case E: where the front stands.
  double shift = 0;            ///< Case G: how far right of (0.4, 0.5) the body stands.
  double turn_degrees = 0;     ///< Case G: by how much it is turned, counter-clockwise.
};

/// A domain and its metric. The field can be had any number of times.
struct BenchCase {
  Domain domain;
  std::function<std::unique_ptr<MetricField>()> field;
};

/// Tag of the edges of case G's body.
inline constexpr std::int32_t kBodyTag = 5;

/// The case that `request` names: A (Gaussian), B (diagonal), C (front, 100:1), C1000 (1000:1),
/// D (letters), E (front at `front`), F (disc off), F-on, G-hole or G-flap (a body in a boundary
/// layer, its edges tagged kBodyTag). Fails with kOutOfRange for another
/// name, and as the reader of .poly does.
[[nodiscard]] Result<BenchCase> MakeCase(const CaseRequest& request);

/// The same metric as formulas; nothing for cases that have none (D, F-on).
[[nodiscard]] std::optional<MetricSpec> FormulasOf(const CaseRequest& request);

}  // namespace pliant::bench
