#include "core/pliant/nested_build.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "core/pliant/refine.h"

namespace pliant {
namespace {

/// Coarsest level: large enough for a lattice to form, and several times the given vertices, which
/// would overload it.
constexpr double kCoarsestNodes = 500;
constexpr double kCoarsestPerGiven = 6;

/// Coarser levels ask for slightly fewer nodes than a fourth: otherwise the lattice is under
/// pressure and drifts.
constexpr double kCoarseScale = 0.97;

/// Sample points for the estimate of complexity.
constexpr double kSamples = 16384;

/// Integral of sqrt(det M), by sampling every triangle at the corners of a uniform subdivision's
/// cells. Only the number of levels depends on it.
double EstimateComplexity(const Mesh& mesh, const MetricField& field) {
  const int per_side =
      std::max(1, static_cast<int>(std::sqrt(kSamples / std::max(1, mesh.triangle_count()))));
  double complexity = 0;
  std::int32_t hint = MetricField::kNoHint;
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    const TriangleRecord& triangle = mesh.triangle(TriangleId(t));
    if (!triangle.live) continue;
    const Vec2 a = mesh.position(triangle.vertices[0]);
    const Vec2 ab = mesh.position(triangle.vertices[1]) - a;
    const Vec2 ac = mesh.position(triangle.vertices[2]) - a;
    double sum = 0;
    int count = 0;
    for (int i = 0; i < per_side; ++i) {
      for (int j = 0; i + j < per_side; ++j, ++count) {
        const double u = (i + 1.0 / 3) / per_side;
        const double v = (j + 1.0 / 3) / per_side;
        sum += std::sqrt(Determinant(field.At(a + u * ab + v * ac, hint)));
      }
    }
    complexity += 0.5 * Cross(ab, ac) * sum / count;
  }
  return complexity;
}

std::int32_t GivenVertexCount(const Mesh& mesh) {
  std::int32_t count = 0;
  for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) count += mesh.vertex(VertexId(v)).fixed;
  return count;
}

double ScaleOf(int level) { return level == 0 ? 1 : kCoarseScale / std::ldexp(1.0, 2 * level); }

}  // namespace

NestedBuild::NestedBuild(MeshEdit& edit, PliantLoop& loop, std::shared_ptr<const MetricField> field,
                         const Options& options)
    : edit_(edit),
      loop_(loop),
      field_(std::move(field)),
      options_(options),
      settings_(SettingsOf(options)) {
  const double nodes = EstimateComplexity(edit.mesh(), *field_) * 2 / std::sqrt(3.0);
  const double coarsest =
      std::max(kCoarsestNodes, kCoarsestPerGiven * GivenVertexCount(edit.mesh()));
  int levels = 0;
  for (double n = nodes; n > coarsest && levels < 30; n /= 4) ++levels;
  LoopSettings coarse = settings_;
  coarse.speed_threshold = coarse.neighbor_threshold = 0.02;
  InlineExecutor alone;  // The coarsest level is small.
  StartLevel(levels, levels == 0 ? settings_ : coarse, alone);
}

StopReason NestedBuild::Run(const Budget& budget, const Helpers& helpers) {
  if (!std::exchange(begun_, true) && BlockLoop::Suits(edit_.mesh(), options_, helpers.rule())) {
    blocks_.emplace(edit_, loop_, options_, helpers.rule());
  }
  if (!blocks_) return loop_.Run(*level_field_, budget);
  return blocks_->Run(*level_field_, budget, helpers.executor());
}

std::int64_t NestedBuild::active_count() const {
  return loop_.active_count() + (blocks_ ? blocks_->active_count() : 0);
}

void NestedBuild::NextLevel(const Helpers& helpers) {
  PLIANT_CHECK(level_ > 0);
  Executor& executor = helpers.executor();
  const double growth = ScaleOf(level_ - 1) / ScaleOf(level_);
  const std::vector<EdgeSplit> splits = PlanRefinement(edit_.mesh(), growth, executor);
  if (edit_.mesh().vertex_count() + std::ssize(splits) > options_.vertices_max) {
    Finish(helpers);  // The loop inserts one by one up to the limit and counts what it refuses.
    return;
  }
  edit_.Refine(splits,
               is_coarsest_ ? TrianglesAlongCurve(edit_.mesh()) : TrianglesBySlot(edit_.mesh()),
               executor);
  is_coarsest_ = false;
  LoopSettings fine = settings_;
  fine.age_cooling = 6;
  fine.age_max = 14;
  const bool last = level_ == 1;
  fine.speed_threshold = last ? settings_.speed_threshold : 0.02;
  fine.neighbor_threshold = last ? std::max(0.05, settings_.neighbor_threshold) : 0.02;
  StartLevel(level_ - 1, fine, executor);
}

void NestedBuild::Finish(const Helpers& helpers) {
  if (level_ > 0) StartLevel(0, settings_, helpers.executor());
}

void NestedBuild::StartLevel(int level, const LoopSettings& settings, Executor& executor) {
  if (blocks_) blocks_->Leave();
  blocks_.reset();
  begun_ = false;
  level_ = level;
  const double scale = ScaleOf(level);
  level_field_ = level == 0 ? field_ : std::make_shared<ScaledField>(field_, scale);
  loop_.BeginUpdate(settings);
  // First those of the coarser mesh, which are at rest but for the change of level, then the new
  // ones between them: one visit in fifty less than in plain order of slots.
  loop_.WakeAll(*level_field_, executor);
}

}  // namespace pliant
