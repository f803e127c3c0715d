#include "core/pliant/patch.h"

#include <cmath>

#include "core/base/math.h"
#include "core/base/vector_kernel.h"
#include "core/delaunay/metric_flip.h"
#include "core/geometry/predicates.h"

namespace pliant {
namespace {

/// As in SmoothingStep: beyond this distance the force is zero.
constexpr double kSquaredReach = 16;

/// Twice the cotangent of the angle at the center from which on a link edge is looked at.
///
/// An edge is swapped if the two angles opposite to it exceed 180 degrees, so that the far one must
/// be above 105 degrees for a smaller one at the center to matter. Such a triangle is watched by
/// the visits of its other corners, and by that of the far vertex itself; to load all vertices
/// behind the link at every visit cost a fifth of it and found one swap in two hundred.
constexpr double kWatchedCotangent = 2 * 0.2679491924311227;  // 75 degrees.

/// The columns of vertices from the first of a ring on; those of a ring have slots -1 and count
/// too.
struct ColumnsView {
  const double* x;
  const double* y;
  const double* m11;
  const double* m12;
  const double* m22;
};

/// A ring and the vertex in its middle: what every kernel reads.
struct RingView : ColumnsView {
  Vec2 p;
  Metric m;
};

/// Terms of SmoothingStep: what each neighbour adds to the sum.
struct StepTerms {
  double* x;
  double* y;
};

PLIANT_VECTOR_KERNEL
void RunStepKernel(const RingView& in, std::size_t count, const StepTerms& out) {
  PLIANT_INDEPENDENT
  for (std::size_t k = 0; k < count; ++k) {
    const double ex = in.p.x - in.x[k];
    const double ey = in.p.y - in.y[k];
    const double a = 0.5 * (in.m.m11 + in.m11[k]);
    const double b = 0.5 * (in.m.m12 + in.m12[k]);
    const double c = 0.5 * (in.m.m22 + in.m22[k]);
    const double squared = a * ex * ex + 2 * b * ex * ey + c * ey * ey;
    const double d4 = squared * squared;
    const double near_d4 = d4 < kSquaredReach * kSquaredReach ? d4 : 0;
    const double weight = (1 - near_d4) * ExpNegative(-near_d4) / std::sqrt(squared);
    const double factor = squared < kSquaredReach ? weight : 0;
    out.x[k] = factor * ex;
    out.y[k] = factor * ey;
  }
}

/// For each triangle of the star, with the center at p: positive if it certainly stays positive.
PLIANT_VECTOR_KERNEL
void RunMarginKernel(const ColumnsView& in, Vec2 p, std::size_t count, double* margin) {
  PLIANT_INDEPENDENT
  for (std::size_t k = 0; k < count; ++k) {
    margin[k] = internal::MarginOfOrient2d(p, {in.x[k], in.y[k]}, {(in.x + 1)[k], (in.y + 1)[k]});
  }
}

/// What RunMeasureKernel finds for each ring vertex k.
struct Measures {
  double* area;   ///< NormalizedArea of triangle k.
  double* alert;  ///< Negative where spoke k or link edge k may have to be swapped.
};

/// Areas, and the angles that decide about swaps: the two opposite each spoke, measured in the mean
/// metric of the four corners, alert if they are obtuse; and the one at the center opposite each
/// link edge, alert from kWatchedAngle on.
PLIANT_VECTOR_KERNEL
void RunMeasureKernel(const RingView& in, std::size_t count, const Measures& out) {
  constexpr double kThird = 1.0 / 3.0;
  const double* const x_before = in.x - 1;
  const double* const y_before = in.y - 1;
  const double* const x_after = in.x + 1;
  const double* const y_after = in.y + 1;
  PLIANT_INDEPENDENT
  for (std::size_t k = 0; k < count; ++k) {
    const double sum11 = in.m.m11 + in.m11[k] + (in.m11 + 1)[k];
    const double sum12 = in.m.m12 + in.m12[k] + (in.m12 + 1)[k];
    const double sum22 = in.m.m22 + in.m22[k] + (in.m22 + 1)[k];
    const double a = kThird * sum11;
    const double b = kThird * sum12;
    const double c = kThird * sum22;
    const double ux = in.x[k] - in.p.x;
    const double uy = in.y[k] - in.p.y;
    const double vx = x_after[k] - in.p.x;
    const double vy = y_after[k] - in.p.y;
    const double area = 0.5 * std::sqrt(a * c - b * b) * (ux * vy - uy * vx);
    const double at_center = ux * (a * vx + b * vy) + uy * (b * vx + c * vy);
    const double m11 = sum11 + (in.m11 - 1)[k];
    const double m12 = sum12 + (in.m12 - 1)[k];
    const double m22 = sum22 + (in.m22 - 1)[k];
    const double sx = in.p.x - x_before[k];
    const double sy = in.p.y - y_before[k];
    const double tx = in.x[k] - x_before[k];
    const double ty = in.y[k] - y_before[k];
    const double before = sx * (m11 * tx + m12 * ty) + sy * (m12 * tx + m22 * ty);
    const double wx = in.x[k] - x_after[k];
    const double wy = in.y[k] - y_after[k];
    const double after = -(vx * (m11 * wx + m12 * wy) + vy * (m12 * wx + m22 * wy));
    const double obtuse = before < after ? before : after;
    const double watched = at_center - kWatchedCotangent * area;
    out.area[k] = area;
    out.alert[k] = obtuse < watched ? obtuse : watched;
  }
}

/// The columns from the first vertex of the ring on.
template <class Columns>
ColumnsView ViewOf(const Columns& columns) {
  return {columns.x + 1, columns.y + 1, columns.m11 + 1, columns.m12 + 1, columns.m22 + 1};
}

}  // namespace

void Patch::Gather(const Mesh& mesh, const Star& star) {
  const std::span<const VertexId> ring = star.ring();
  count_ = ring.size();
  const VertexRecord& center = mesh.vertex(star.center());
  center_ = center.position;
  metric_ = center.metric;
  for (std::size_t k = 0; k < count_; ++k) ring_.Set(k + 1, mesh.vertex(ring[k]));
  ring_.Copy(0, count_);
  for (std::size_t slot = count_ + 1; slot < padded_count() + 2; ++slot) ring_.Copy(slot, 1);
  crowd_.Measure(mesh, star);
}

Vec2 Patch::Step(double alpha) const {
  double step_x[kSlots];
  double step_y[kSlots];
  RunStepKernel({ViewOf(ring_), center_, metric_}, padded_count(), {step_x, step_y});
  Vec2 sum;
  if (const std::span<const double> weights = crowd_.weights(); !weights.empty()) [[unlikely]] {
    for (std::size_t k = 0; k < count_; ++k) sum += weights[k] * Vec2{step_x[k], step_y[k]};
    return alpha * sum;
  }
  for (std::size_t k = 0; k < count_; ++k) sum += {step_x[k], step_y[k]};
  return alpha * sum;
}

bool Patch::StaysPositive(Vec2 target) const {
  double margin[kSlots];
  RunMarginKernel(ViewOf(ring_), target, padded_count(), margin);
  bool sure = true;
  for (std::size_t k = 0; k < count_; ++k) sure = sure && margin[k] > 0;
  if (sure) [[likely]] {
    return true;
  }
  for (std::size_t k = 1; k <= count_; ++k) {
    if (Orient2d(target, RingPosition(k), RingPosition(k + 1)) <= 0) return false;
  }
  return true;
}

void Patch::MoveCenter(Vec2 position, const Metric& metric) {
  center_ = position;
  metric_ = metric;
}

void Patch::Measure() {
  RunMeasureKernel({ViewOf(ring_), center_, metric_}, padded_count(), {area_, alert_});
}

bool Patch::WantsSwaps(const Mesh& mesh, const Star& star) const {
  for (std::size_t k = 0; k < count_; ++k) {
    if (alert_[k] < 0 && (SpokeWantsSwap(k + 1) || LinkWantsSwap(mesh, star, k))) return true;
  }
  return false;
}

bool Patch::SpokeWantsSwap(std::size_t slot) const {
  const Metric mean =
      0.25 * (RingMetric(slot - 1) + RingMetric(slot) + metric_ + RingMetric(slot + 1));
  return pliant::WantsSwap(center_, RingPosition(slot - 1), RingPosition(slot),
                           RingPosition(slot + 1), mean);
}

bool Patch::LinkWantsSwap(const Mesh& mesh, const Star& star, std::size_t k) const {
  const TriangleId inner = star.triangles()[k];
  const TriangleRecord& triangle = mesh.triangle(inner);
  const auto side = static_cast<std::size_t>(mesh.CornerOf(inner, star.center()));
  const TriangleId outer = triangle.neighbors[side];
  if (triangle.IsConstrained(side)) return false;
  const VertexRecord& far = mesh.vertex(
      mesh.triangle(outer).vertices[static_cast<std::size_t>(mesh.SideTowards(outer, inner))]);
  const Metric mean = 0.25 * (metric_ + RingMetric(k + 1) + RingMetric(k + 2) + far.metric);
  return pliant::WantsSwap(RingPosition(k + 2), center_, RingPosition(k + 1), far.position, mean);
}

Patch::Extents Patch::MeasureExtents() const {
  double sum = 0;
  for (std::size_t k = 0; k < count_; ++k) sum += area_[k];
  Extents extents;
  const double n = crowd_.NeighborCount(count_);
  extents.node = 2.3 / std::sqrt(n * (n - 2)) * sum;
  double before = area_[count_ - 1];
  for (std::size_t k = 0; k < count_; ++k) {
    const double extent = 0.8 * (before + area_[k]);
    before = area_[k];
    if (extent > extents.largest) {
      extents.largest = extent;
      extents.largest_spoke = k;
    }
  }
  return extents;
}

}  // namespace pliant
