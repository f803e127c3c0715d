#include "core/pliant/patch.h"

#include <cmath>

#include "core/base/math.h"
#include "core/geometry/predicates.h"

// One copy of a kernel for every kind of processor, chosen when the program starts. All give the
// same bits: vector instructions round each operation like scalar ones, and the build forbids to
// contract a multiplication and an addition into one.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && \
    defined(__GNUC__) && !defined(__clang__)
#define PLIANT_VECTOR_KERNEL __attribute__((target_clones("avx2", "default")))
#else
#define PLIANT_VECTOR_KERNEL
#endif

// The columns of a kernel never overlap; the compiler cannot know.
#if defined(__clang__)
#define PLIANT_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define PLIANT_INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace pliant {
namespace {

/// As in SmoothingStep: beyond this distance the force is zero.
constexpr double kSquaredReach = 16;

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

/// For each spoke: the lesser of the inner products at the two tips opposite, in the mean metric of
/// the four corners. Negative where an angle is obtuse.
PLIANT_VECTOR_KERNEL
void RunSpokeKernel(const RingView& in, std::size_t count, double* least) {
  const double* const x_before = in.x - 1;
  const double* const y_before = in.y - 1;
  const double* const x_after = in.x + 1;
  const double* const y_after = in.y + 1;
  PLIANT_INDEPENDENT
  for (std::size_t k = 0; k < count; ++k) {
    const double m11 = in.m.m11 + in.m11[k] + (in.m11 - 1)[k] + (in.m11 + 1)[k];
    const double m12 = in.m.m12 + in.m12[k] + (in.m12 - 1)[k] + (in.m12 + 1)[k];
    const double m22 = in.m.m22 + in.m22[k] + (in.m22 - 1)[k] + (in.m22 + 1)[k];
    const double ux = in.p.x - x_before[k];
    const double uy = in.p.y - y_before[k];
    const double vx = in.x[k] - x_before[k];
    const double vy = in.y[k] - y_before[k];
    const double before = ux * (m11 * vx + m12 * vy) + uy * (m12 * vx + m22 * vy);
    const double wx = in.p.x - x_after[k];
    const double wy = in.p.y - y_after[k];
    const double zx = in.x[k] - x_after[k];
    const double zy = in.y[k] - y_after[k];
    const double after = wx * (m11 * zx + m12 * zy) + wy * (m12 * zx + m22 * zy);
    least[k] = before < after ? before : after;
  }
}

/// The same for each link edge, between the center and the vertex behind it.
PLIANT_VECTOR_KERNEL
void RunLinkKernel(const RingView& in, const ColumnsView& far, std::size_t count, double* least) {
  const double* const x_after = in.x + 1;
  const double* const y_after = in.y + 1;
  PLIANT_INDEPENDENT
  for (std::size_t k = 0; k < count; ++k) {
    const double m11 = in.m.m11 + in.m11[k] + (in.m11 + 1)[k] + far.m11[k];
    const double m12 = in.m.m12 + in.m12[k] + (in.m12 + 1)[k] + far.m12[k];
    const double m22 = in.m.m22 + in.m22[k] + (in.m22 + 1)[k] + far.m22[k];
    const double ux = in.x[k] - in.p.x;
    const double uy = in.y[k] - in.p.y;
    const double vx = x_after[k] - in.p.x;
    const double vy = y_after[k] - in.p.y;
    const double inner = ux * (m11 * vx + m12 * vy) + uy * (m12 * vx + m22 * vy);
    const double wx = in.x[k] - far.x[k];
    const double wy = in.y[k] - far.y[k];
    const double zx = x_after[k] - far.x[k];
    const double zy = y_after[k] - far.y[k];
    const double outer = wx * (m11 * zx + m12 * zy) + wy * (m12 * zx + m22 * zy);
    least[k] = inner < outer ? inner : outer;
  }
}

/// NormalizedArea of each triangle of the star.
PLIANT_VECTOR_KERNEL
void RunAreaKernel(const RingView& in, std::size_t count, double* area) {
  constexpr double kThird = 1.0 / 3.0;
  PLIANT_INDEPENDENT
  for (std::size_t k = 0; k < count; ++k) {
    const double m11 = kThird * (in.m.m11 + in.m11[k] + (in.m11 + 1)[k]);
    const double m12 = kThird * (in.m.m12 + in.m12[k] + (in.m12 + 1)[k]);
    const double m22 = kThird * (in.m.m22 + in.m22[k] + (in.m22 + 1)[k]);
    const double ux = in.x[k] - in.p.x;
    const double uy = in.y[k] - in.p.y;
    const double vx = (in.x + 1)[k] - in.p.x;
    const double vy = (in.y + 1)[k] - in.p.y;
    area[k] = 0.5 * std::sqrt(m11 * m22 - m12 * m12) * (ux * vy - uy * vx);
  }
}

/// The columns from the first vertex of the ring on.
template <class Columns>
ColumnsView ViewOf(const Columns& columns) {
  return {columns.x + 1, columns.y + 1, columns.m11 + 1, columns.m12 + 1, columns.m22 + 1};
}

}  // namespace

void Patch::Gather(const Mesh& mesh, const Star& star) {
  count_ = star.ring().size();
  const VertexRecord& center = mesh.vertex(star.center());
  center_ = center.position;
  metric_ = center.metric;
  for (std::size_t k = 0; k < count_; ++k) ring_.Set(k + 1, mesh.vertex(star.ring()[k]));
  ring_.Set(0, mesh.vertex(star.ring().back()));
  for (std::size_t slot = count_ + 1; slot < padded_count() + 2; ++slot) {
    ring_.Set(slot, mesh.vertex(star.ring().front()));
  }
}

Vec2 Patch::Step(double alpha) const {
  double step_x[kSlots];
  double step_y[kSlots];
  RunStepKernel({ViewOf(ring_), center_, metric_}, padded_count(), {step_x, step_y});
  Vec2 sum;
  for (std::size_t k = 0; k < count_; ++k) sum += {step_x[k], step_y[k]};
  return alpha * sum;
}

bool Patch::StaysPositive(Vec2 target) const {
  for (std::size_t k = 1; k <= count_; ++k) {
    if (Orient2d(target, {ring_.x[k], ring_.y[k]}, {ring_.x[k + 1], ring_.y[k + 1]}) <= 0) {
      return false;
    }
  }
  return true;
}

void Patch::MoveCenter(Vec2 position, const Metric& metric) {
  center_ = position;
  metric_ = metric;
}

bool Patch::MaySwap(const Mesh& mesh, const Star& star) {
  double least[kSlots];
  const RingView ring{ViewOf(ring_), center_, metric_};
  RunSpokeKernel(ring, padded_count(), least);
  for (std::size_t k = 0; k < count_; ++k) {
    if (least[k] < 0) return true;
  }
  for (std::size_t k = 0; k < count_; ++k) {
    const TriangleId inner = star.triangles()[k];
    const TriangleRecord& triangle = mesh.triangle(inner);
    const auto side = static_cast<std::size_t>(mesh.CornerOf(inner, star.center()));
    const TriangleId outer = triangle.neighbors[side];
    // Behind a constrained edge nothing is swapped: the center again stands for "acute".
    VertexId far = star.center();
    if (outer.valid() && ((triangle.constrained >> side) & 1) == 0) {
      far = mesh.triangle(outer).vertices[static_cast<std::size_t>(mesh.SideTowards(outer, inner))];
    }
    far_.Set(k + 1, mesh.vertex(far));
  }
  for (std::size_t k = count_; k < padded_count(); ++k) far_.Set(k + 1, mesh.vertex(star.center()));
  RunLinkKernel(ring, ViewOf(far_), padded_count(), least);
  for (std::size_t k = 0; k < count_; ++k) {
    if (least[k] < 0) return true;
  }
  return false;
}

Patch::Extents Patch::MeasureExtents() const {
  double area[kSlots];
  RunAreaKernel({ViewOf(ring_), center_, metric_}, padded_count(), area);
  double sum = 0;
  for (std::size_t k = 0; k < count_; ++k) sum += area[k];
  Extents extents;
  const auto n = static_cast<double>(count_);
  extents.node = 2.3 / std::sqrt(n * (n - 2)) * sum;
  double before = area[count_ - 1];
  for (std::size_t k = 0; k < count_; ++k) {
    const double extent = 0.8 * (before + area[k]);
    before = area[k];
    if (extent > extents.largest) {
      extents.largest = extent;
      extents.largest_spoke = k;
    }
  }
  return extents;
}

}  // namespace pliant
