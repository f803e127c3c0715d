#pragma once

#include <memory>

#include "core/geometry/domain.h"
#include "core/metric/metric_field.h"

namespace pliant::testing {

/// A domain and an analytic metric that asks for about `node_count` nodes: the cases of the peer
/// benchmark, with the same formulas and scales.
struct Case {
  Domain domain;
  std::unique_ptr<MetricField> field;
};

/// Axis-parallel rectangle, segments tagged 1 (bottom), 2 (right), 3 (top), 4 (left).
[[nodiscard]] Domain Rectangle(Vec2 low, Vec2 high);

/// A: absolute Hessian of exp(-r^2/2) on [-3, 3]^2, eigenvalues at least 0.01.
[[nodiscard]] Case GaussianCase(double node_count);
/// B: isotropic on the unit square, small along the diagonal.
[[nodiscard]] Case DiagonalCase(double node_count);
/// C: hyperbolic front, aspect ratio 100:1 in the middle; `xc` is where it stands, 0.5 at first.
[[nodiscard]] Case ShockCase(double node_count, double xc = 0.5);
/// C at 1000:1, with a straighter front.
[[nodiscard]] Case SharpShockCase(double node_count);
/// F: constant size on the unit square; with `on`, half of it in a disc of 0.1 % of the area.
enum class DiscState { kOff, kOn };
[[nodiscard]] Case DiscCase(double node_count, DiscState state);
/// Jump of the size from 0.1 to 0.005 in a half plane: no mesh can meet it.
[[nodiscard]] Case JumpCase();
/// Crossed tensors of aspect ratio 20 on a 4 x 4 board: no mesh can meet it.
[[nodiscard]] Case CheckerboardCase();
/// A constant metric of aspect ratio 20, turned by 30 degrees.
[[nodiscard]] Case ConstantCase(double node_count);

}  // namespace pliant::testing
