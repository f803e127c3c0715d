#include "core/metric/hessian.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/metric/gradation.h"

namespace pliant {
namespace {

constexpr std::size_t kUnknowns = 6;
/// Twice the unknowns: a fit through barely enough values repeats their noise.
constexpr std::size_t kPatchMin = 12;
constexpr int kRingsMax = 5;
/// A pivot below this share of its diagonal says that the patch lies on a conic.
constexpr double kPivotShare = 0x1p-30;

using Unknowns = std::array<double, kUnknowns>;

/// Vertices around one, ring by ring.
class RingPatch {
 public:
  explicit RingPatch(const VertexGraph& graph)
      : graph_(graph), seen_(graph.offsets.size() - 1, -1) {}

  void Begin(std::int32_t center) {
    center_ = center;
    vertices_.assign(1, center);
    seen_[static_cast<std::size_t>(center)] = center;
    ring_begin_ = 0;
  }
  /// Adds another ring. @return false if there is none
  bool Grow() {
    const std::size_t end = vertices_.size();
    for (std::size_t i = ring_begin_; i < end; ++i) {
      const auto v = static_cast<std::size_t>(vertices_[i]);
      for (std::int32_t k = graph_.offsets[v]; k < graph_.offsets[v + 1]; ++k) {
        const std::int32_t next = graph_.neighbors[static_cast<std::size_t>(k)];
        std::int32_t& seen = seen_[static_cast<std::size_t>(next)];
        if (seen == center_) continue;
        seen = center_;
        vertices_.push_back(next);
      }
    }
    ring_begin_ = end;
    return vertices_.size() > end;
  }

  [[nodiscard]] std::span<const std::int32_t> vertices() const { return vertices_; }

 private:
  const VertexGraph& graph_;
  std::vector<std::int32_t> seen_;  // By vertex, the last centre that met it.
  std::vector<std::int32_t> vertices_;
  std::int32_t center_ = -1;
  std::size_t ring_begin_ = 0;
};

/// Solves the normal equations by Cholesky's method; nothing if they do not determine all unknowns.
std::optional<Unknowns> SolveNormal(std::array<Unknowns, kUnknowns> a, Unknowns b) {
  for (std::size_t j = 0; j < kUnknowns; ++j) {
    const double diagonal = a[j][j];
    double pivot = diagonal;
    for (std::size_t k = 0; k < j; ++k) pivot -= a[j][k] * a[j][k];
    if (!(pivot > kPivotShare * diagonal)) return std::nullopt;
    a[j][j] = std::sqrt(pivot);
    for (std::size_t i = j + 1; i < kUnknowns; ++i) {
      for (std::size_t k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
      a[i][j] /= a[j][j];
    }
  }
  for (std::size_t i = 0; i < kUnknowns; ++i) {
    for (std::size_t k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
    b[i] /= a[i][i];
  }
  for (std::size_t i = kUnknowns; i-- > 0;) {
    for (std::size_t k = i + 1; k < kUnknowns; ++k) b[i] -= a[k][i] * b[k];
    b[i] /= a[i][i];
  }
  return b;
}

/// The Hessian of the quadratic polynomial that fits best; nothing if many do.
std::optional<Metric> Fit(std::span<const Vec2> points, std::span<const double> values,
                          std::span<const std::int32_t> patch) {
  const auto index = [&](std::size_t i) { return static_cast<std::size_t>(patch[i]); };
  const Vec2 center = points[index(0)];
  // The patch's second moments are L L'; in coordinates L^-1 (p - center) it is round.
  double xx = 0;
  double xy = 0;
  double yy = 0;
  for (std::size_t i = 1; i < patch.size(); ++i) {
    const Vec2 d = points[index(i)] - center;
    xx += d.x * d.x;
    xy += d.x * d.y;
    yy += d.y * d.y;
  }
  const double share = 1 / static_cast<double>(patch.size());
  const double l11 = std::sqrt(share * xx);
  const double l21 = share * xy / l11;
  const double rest = share * yy - l21 * l21;
  if (!(l11 > 0) || !(rest > 0)) return std::nullopt;
  const double l22 = std::sqrt(rest);

  std::array<Unknowns, kUnknowns> normal{};
  Unknowns right{};
  for (std::size_t i = 0; i < patch.size(); ++i) {
    const Vec2 d = points[index(i)] - center;
    const double x = d.x / l11;
    const double y = (d.y - l21 * x) / l22;
    const double weight = 1 / (1 + x * x + y * y);
    const Unknowns row{1, x, y, 0.5 * x * x, x * y, 0.5 * y * y};
    const double difference = values[index(i)] - values[index(0)];
    for (std::size_t j = 0; j < kUnknowns; ++j) {
      right[j] += weight * row[j] * difference;
      for (std::size_t k = 0; k <= j; ++k) normal[j][k] += weight * row[j] * row[k];
    }
  }
  const std::optional<Unknowns> fit = SolveNormal(normal, right);
  if (!fit) return std::nullopt;
  // H = L^-T K L^-1 with K from the fit; L^-1 has rows (1/l11, 0) and (c, 1/l22).
  const auto [k11, k12, k22] = std::array{(*fit)[3], (*fit)[4], (*fit)[5]};
  const double a = 1 / l11;
  const double b = 1 / l22;
  const double c = -l21 * a * b;
  return Metric{a * a * k11 + 2 * a * c * k12 + c * c * k22, a * b * k12 + b * c * k22,
                b * b * k22};
}

}  // namespace

std::vector<Metric> RecoverHessians(const MeshData& mesh, std::span<const double> values) {
  const VertexGraph graph =
      GraphOfTriangles(mesh.triangles, static_cast<std::int32_t>(mesh.points.size()));
  RingPatch patch(graph);
  std::vector<Metric> hessians(mesh.points.size(), Metric{0, 0, 0});
  for (std::size_t v = 0; v < hessians.size(); ++v) {
    patch.Begin(static_cast<std::int32_t>(v));
    std::optional<Metric> hessian;
    for (int ring = 1; ring <= kRingsMax && !hessian && patch.Grow(); ++ring) {
      if (ring < 2 || patch.vertices().size() <= kPatchMin) continue;
      hessian = Fit(mesh.points, values, patch.vertices());
    }
    // A small mesh is one patch.
    if (!hessian && patch.vertices().size() >= kUnknowns) {
      hessian = Fit(mesh.points, values, patch.vertices());
    }
    if (hessian) hessians[v] = *hessian;
  }
  return hessians;
}

Metric AbsoluteValue(const Metric& hessian) {
  // The square root of H^2, by the theorem of Cayley and Hamilton. Scaled, so that squares of
  // tiny and huge entries stay numbers.
  const double scale =
      std::fmax(std::fabs(hessian.m11), std::fmax(std::fabs(hessian.m12), std::fabs(hessian.m22)));
  if (!(scale > 0)) return {0, 0, 0};
  const Metric h = 1 / scale * hessian;
  const double determinant = std::fabs(Determinant(h));
  const Metric square{h.m11 * h.m11 + h.m12 * h.m12, h.m12 * (h.m11 + h.m22),
                      h.m12 * h.m12 + h.m22 * h.m22};
  const double trace = std::sqrt(square.m11 + square.m22 + 2 * determinant);
  return scale / trace * Metric{square.m11 + determinant, square.m12, square.m22 + determinant};
}

}  // namespace pliant
