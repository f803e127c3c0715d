#include "tests/bench/workload_cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "client/io/file.h"
#include "client/io/triangle.h"
#include "core/base/math.h"
#include "core/delaunay/triangulate.h"
#include "core/metric/function_field.h"
#include "core/metric/math_functions.h"
#include "core/metric/metric.h"
#include "tests/support/cases.h"

namespace pliant::bench {
namespace {

using testing::Case;
using testing::DiscState;

constexpr double kSqrt3Half = 0.8660254037844386;

// The scales of tests/support/cases.cc: nodes times these make the metric.
constexpr double kGaussianScale = 0.134436791;
constexpr double kDiagonalScale = 9.1736630e-4;
constexpr double kShockScale = 0.55669468;
constexpr double kSharpShockScale = 0.4626196;

std::string Number(double value) {
  std::array<char, 40> text;
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}

Case SupportCase(const CaseRequest& request) {
  if (request.name == "A") return testing::GaussianCase(request.node_count);
  if (request.name == "B") return testing::DiagonalCase(request.node_count);
  if (request.name == "C") return testing::ShockCase(request.node_count);
  if (request.name == "C1000") return testing::SharpShockCase(request.node_count);
  if (request.name == "E") return testing::ShockCase(request.node_count, request.front);
  return testing::DiscCase(request.node_count,
                           request.name == "F" ? DiscState::kOff : DiscState::kOn);
}

/// Letters: sizes grow from the corners of the outlines on, and are squeezed up to 8:1 along a
/// sine curve through the middle.
struct LettersMetric {
  std::vector<Vec2> corners;
  Vec2 low;
  Vec2 high;
  double scale = 1;

  Metric operator()(Vec2 p) const {
    double square = 1e300;
    for (const Vec2 corner : corners) square = std::min(square, Dot(corner - p, corner - p));
    const double size = 0.004 + 0.12 * std::sqrt(square);
    const double height = high.y - low.y;
    const double k = 2 * std::numbers::pi * 1.5 / (high.x - low.x);
    const double phase = k * (p.x - low.x);
    static const auto* sine = FindMathFunction("sin");
    static const auto* cosine = FindMathFunction("cos");
    const double curve = 0.5 * (low.y + high.y) + 0.25 * height * sine->unary(phase);
    const double slope = 0.25 * height * k * cosine->unary(phase);
    const double w = std::sqrt(1 + slope * slope);
    const double distance = std::fabs(p.y - curve) / w;
    const double aspect = 1 + 7 * Exp(-distance / (0.08 * height));
    const double across = aspect * aspect / (size * size);
    const double along = 1 / (size * size);
    const Vec2 n{-slope / w, 1 / w};
    return scale * Metric{along + (across - along) * n.x * n.x, (across - along) * n.x * n.y,
                          along + (across - along) * n.y * n.y};
  }
};

/// Integral of sqrt(det M) over a triangle, cut in four until its sides are shorter than the
/// longer wanted length at its middle.
double Complexity(const LettersMetric& metric, Vec2 a, Vec2 b, Vec2 c) {
  const Vec2 middle = (1.0 / 3.0) * (a + b + c);
  const Metric m = metric(middle);
  const double longest = std::max({Dot(b - a, b - a), Dot(c - b, c - b), Dot(a - c, a - c)});
  if (longest * EigenvaluesOf(m).low < 1) {
    return 0.5 * Cross(b - a, c - a) * std::sqrt(Determinant(m));
  }
  const Vec2 ab = 0.5 * (a + b);
  const Vec2 bc = 0.5 * (b + c);
  const Vec2 ca = 0.5 * (c + a);
  return Complexity(metric, a, ab, ca) + Complexity(metric, ab, b, bc) +
         Complexity(metric, ca, bc, c) + Complexity(metric, ab, bc, ca);
}

Result<BenchCase> MakeLetters(const CaseRequest& request) {
  PLIANT_ASSIGN_OR_RETURN(const std::string text, io::ReadFile(request.poly));
  PLIANT_ASSIGN_OR_RETURN(Domain domain, io::ParsePoly(text));
  PLIANT_ASSIGN_OR_RETURN(const DomainTriangulation mesh, TriangulateDomain(domain));
  LettersMetric metric{domain.points, domain.points[0], domain.points[0]};
  for (const Vec2 p : domain.points) {
    metric.low = {std::min(metric.low.x, p.x), std::min(metric.low.y, p.y)};
    metric.high = {std::max(metric.high.x, p.x), std::max(metric.high.y, p.y)};
  }
  double complexity = 0;
  for (const auto& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) {
      return domain.points[static_cast<std::size_t>(triangle.points[i])];
    };
    complexity += Complexity(metric, corner(0), corner(1), corner(2));
  }
  metric.scale = request.node_count * kSqrt3Half / complexity;
  return BenchCase{std::move(domain), [metric]() -> std::unique_ptr<MetricField> {
                     return std::make_unique<FunctionField<LettersMetric>>(metric);
                   }};
}

MetricSpec GaussianFormulas(double scale) {
  const std::string r2 = "(x*x+y*y)";
  const std::string f = "exp(-0.5*" + r2 + ")";
  const std::string tangential = "max(0.01," + f + ")";
  // At the origin r2 is 0 and the metric isotropic: nothing is divided by 0.
  const std::string excess =
      "(max(0.01," + f + "*abs(" + r2 + "-1))-" + tangential + ")/(" + r2 + "+1e-300)";
  const std::string s = Number(scale) + "*";
  return {.source = ExpressionMetric{.m11 = s + "(" + tangential + "+" + excess + "*x*x)",
                                     .m12 = s + excess + "*x*y",
                                     .m22 = s + "(" + tangential + "+" + excess + "*y*y)"}};
}

struct FrontShape {
  double aspect;
  double slope;
  double xc;
};

MetricSpec FrontFormulas(const FrontShape& front, double scale) {
  const std::string m2 = Number(front.slope * front.slope);
  const std::string g = "sqrt(0.25+" + m2 + "*(y-0.5)^2)";
  const std::string gp = "(" + m2 + "*(y-0.5)/" + g + ")";
  const std::string w2 = "(1+" + gp + "^2)";
  const std::string d = "abs(x-(" + Number(front.xc) + "+" + g + "-0.5))/sqrt" + w2;
  const std::string a =
      "(1+" + Number(front.aspect - 1) + "*exp(-(y-0.5)^2/" + Number(0.35 * 0.35) + "))";
  const std::string hn = "(1/" + a + "+(1-1/" + a + ")*(1-exp(-(" + d + ")/0.07)))";
  const std::string excess = "(1/" + hn + "^2-1)/" + w2;
  const std::string s = Number(scale) + "*";
  return {.source = ExpressionMetric{.m11 = s + "(1+" + excess + ")",
                                     .m12 = "-" + s + excess + "*" + gp,
                                     .m22 = s + "(1+" + excess + "*" + gp + "^2)"}};
}

/// A layer around an ellipse: the size grows with the distance from it, and is up to four times
/// smaller across than along.
struct LayerMetric {
  Vec2 radii;
  Vec2 center;
  Vec2 axis;  // Unit vector along the first radius.
  double scale = 1;

  Metric operator()(Vec2 p) const {
    const Vec2 arm = p - center;
    const double u = Dot(arm, axis);
    const double v = Cross(axis, arm);
    const double level = Length({u / radii.x, v / radii.y});
    const Vec2 slope{u / (radii.x * radii.x), v / (radii.y * radii.y)};
    const double steepness = std::max(1e-12, Length(slope));
    const double distance = std::max(0.0, level * (level - 1) / steepness);
    const double along = 0.02 + 0.15 * distance;
    const double across = along / (1 + 3 * Exp(-distance / 0.05));
    const Vec2 normal = steepness < 1e-9 ? Vec2{1, 0} : (1 / steepness) * slope;
    const Vec2 n{normal.x * axis.x - normal.y * axis.y, normal.x * axis.y + normal.y * axis.x};
    const double low = 1 / (along * along);
    const double excess = 1 / (across * across) - low;
    return scale * Metric{low + excess * n.x * n.x, excess * n.x * n.y, low + excess * n.y * n.y};
  }
};

BenchCase MakeBody(const CaseRequest& request) {
  // One over the integral of sqrt(det M) at scale 1, times sqrt(3) / 2, where the body starts.
  constexpr double kHoleScale = 1.57111598e-3;
  constexpr double kFlapScale = 1.01226050e-3;
  constexpr int kPointCount = 256;
  const bool hole = request.name == "G-hole";
  static const auto* sine = FindMathFunction("sin");
  static const auto* cosine = FindMathFunction("cos");
  const double turn = request.turn_degrees * std::numbers::pi / 180;
  LayerMetric metric{hole ? Vec2{0.1, 0.1} : Vec2{0.25, 0.05},
                     {0.4 + request.shift, 0.5},
                     {cosine->unary(turn), sine->unary(turn)},
                     (hole ? kHoleScale : kFlapScale) * request.node_count};
  Domain domain = testing::Rectangle({0, 0}, {1, 1});
  const auto first = static_cast<std::int32_t>(domain.points.size());
  for (std::int32_t i = 0; i < kPointCount; ++i) {
    const double t = 2 * std::numbers::pi * i / kPointCount;
    const Vec2 p{metric.radii.x * cosine->unary(t), metric.radii.y * sine->unary(t)};
    domain.points.push_back(metric.center + p.x * metric.axis +
                            p.y * Vec2{-metric.axis.y, metric.axis.x});
    domain.segments.push_back({first + i, first + (i + 1) % kPointCount, kBodyTag});
  }
  domain.holes.push_back(metric.center);
  return {std::move(domain), [metric]() -> std::unique_ptr<MetricField> {
            return std::make_unique<FunctionField<LayerMetric>>(metric);
          }};
}

}  // namespace

Result<BenchCase> MakeCase(const CaseRequest& request) {
  if (request.name == "D") return MakeLetters(request);
  if (request.name == "G-hole" || request.name == "G-flap") return MakeBody(request);
  constexpr std::array kNames = {"A", "B", "C", "C1000", "E", "F", "F-on"};
  if (std::find(kNames.begin(), kNames.end(), request.name) == kNames.end()) {
    return Error{.code = ErrorCode::kOutOfRange,
                 .message = "There is no case '" + request.name +
                            "'; there are A, B, C, C1000, D, E, F, F-on, G-hole and G-flap.",
                 .field = "case"};
  }
  return BenchCase{SupportCase(request).domain,
                   [request] { return std::move(SupportCase(request).field); }};
}

std::optional<MetricSpec> FormulasOf(const CaseRequest& request) {
  const double n = request.node_count;
  if (request.name == "A") return GaussianFormulas(kGaussianScale * n);
  if (request.name == "B") {
    const std::string size =
        "(0.01+0.25*abs(x-y)/sqrt(2))/" + Number(std::sqrt(kDiagonalScale * n));
    return MetricSpec{.source = SizeMetric{size}};
  }
  if (request.name == "C") return FrontFormulas({100, 0.5, 0.5}, kShockScale * n);
  if (request.name == "C1000") return FrontFormulas({1000, 0.15, 0.5}, kSharpShockScale * n);
  if (request.name == "E") return FrontFormulas({100, 0.5, request.front}, kShockScale * n);
  if (request.name == "F") {
    return MetricSpec{.source = SizeMetric{Number(1 / std::sqrt(n * kSqrt3Half))}};
  }
  return std::nullopt;
}

}  // namespace pliant::bench
