#include "tests/support/cases.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/math.h"
#include "core/metric/function_field.h"

namespace pliant::testing {
namespace {

template <class Function>
std::unique_ptr<MetricField> MakeField(Function function) {
  return std::make_unique<FunctionField<Function>>(std::move(function));
}

/// Size hn along the unit normal n, ht across it.
Metric AcrossNormal(Vec2 n, double hn, double ht) {
  const double p = 1 / (hn * hn);
  const double q = 1 / (ht * ht);
  return {p * n.x * n.x + q * n.y * n.y, (p - q) * n.x * n.y, p * n.y * n.y + q * n.x * n.x};
}

struct Shock {
  double aspect;
  double slope;
  double xc;
  double scale;

  Metric operator()(Vec2 p) const {
    const double t = p.y - 0.5;
    const double g = std::sqrt(0.25 + slope * slope * t * t);
    const double gp = slope * slope * t / g;
    const double w = std::sqrt(1 + gp * gp);
    const double d = std::fabs(p.x - (xc + g - 0.5)) / w;
    const double a = 1 + (aspect - 1) * Exp(-t * t / (0.35 * 0.35));
    const double hn = 1 / a + (1 - 1 / a) * (1 - Exp(-d / 0.07));
    return scale * AcrossNormal({1 / w, -gp / w}, hn, 1);
  }
};

constexpr double kSqrt3Half = 0.8660254037844386;

}  // namespace

Domain Rectangle(Vec2 low, Vec2 high) {
  Domain domain;
  domain.points = {low, {high.x, low.y}, high, {low.x, high.y}};
  domain.segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}};
  return domain;
}

Case GaussianCase(double node_count) {
  const double scale = 0.134436791 * node_count;
  return {Rectangle({-3, -3}, {3, 3}), MakeField([scale](Vec2 p) {
            const double r2 = Dot(p, p);
            const double f = Exp(-r2 / 2);
            const double radial = std::max(0.01, f * std::fabs(r2 - 1));
            const double tangential = std::max(0.01, f);
            const double r = std::sqrt(r2);
            const Vec2 n = r > 1e-12 ? (1 / r) * p : Vec2{1, 0};
            return scale * Metric{radial * n.x * n.x + tangential * n.y * n.y,
                                  (radial - tangential) * n.x * n.y,
                                  radial * n.y * n.y + tangential * n.x * n.x};
          })};
}

Case DiagonalCase(double node_count) {
  const double scale = 9.1736630e-4 * node_count;
  return {Rectangle({0, 0}, {1, 1}), MakeField([scale](Vec2 p) {
            return scale * Metric::Isotropic(0.01 + 0.25 * std::fabs(p.x - p.y) / std::sqrt(2.0));
          })};
}

Case ShockCase(double node_count, double xc) {
  return {Rectangle({0, 0}, {1, 1}), MakeField(Shock{100, 0.5, xc, 0.55669468 * node_count})};
}

Case SharpShockCase(double node_count) {
  return {Rectangle({0, 0}, {1, 1}), MakeField(Shock{1000, 0.15, 0.5, 0.4626196 * node_count})};
}

Case DiscCase(double node_count, DiscState state) {
  const double radius = std::sqrt(0.001 / 3.14159265358979323846);
  const double scale = node_count * kSqrt3Half;
  const double depth = state == DiscState::kOn ? 0.5 : 0;
  return {Rectangle({0, 0}, {1, 1}), MakeField([=](Vec2 p) {
            const double d = Length(p - Vec2{0.5, 0.5}) / radius;
            const double u = std::clamp(1 - d, 0.0, 1.0);
            return scale * Metric::Isotropic(1 - depth * u * u * (3 - 2 * u));
          })};
}

Case JumpCase() {
  return {Rectangle({0, 0}, {1, 1}),
          MakeField([](Vec2 p) { return Metric::Isotropic(p.x < 0.83 ? 0.1 : 0.005); })};
}

Case CheckerboardCase() {
  return {Rectangle({0, 0}, {1, 1}), MakeField([](Vec2 p) {
            const bool odd = (static_cast<int>(4 * p.x) + static_cast<int>(4 * p.y)) % 2 != 0;
            const double fine = 1 / (0.0025 * 0.0025);
            const double coarse = 1 / (0.05 * 0.05);
            return odd ? Metric{fine, 0, coarse} : Metric{coarse, 0, fine};
          })};
}

Case ConstantCase(double node_count) {
  const double scale = node_count * kSqrt3Half;
  return {Rectangle({0, 0}, {1, 1}), MakeField([scale](Vec2) {
            return scale *
                   AcrossNormal({0.5, 0.8660254037844386}, 1 / std::sqrt(20.0), std::sqrt(20.0));
          })};
}

}  // namespace pliant::testing
