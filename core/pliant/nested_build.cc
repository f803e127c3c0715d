#include "core/pliant/nested_build.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include "core/base/stoppable_executor.h"
#include "core/pliant/refine.h"

namespace pliant {
namespace {

/// A mesh of no more than this many nodes is not refined from a coarser one: a lattice needs room
/// to form.
constexpr double kCoarsestNodes = 500;
/// Nor is one in which the given vertices, or all vertices on constrained edges, are more than such
/// a share of the nodes: they overload it, or leave no room for a lattice between them.
constexpr double kGivenShare = 1.0 / 6;
constexpr double kConstrainedShare = 0.6;

/// Coarser levels ask for slightly fewer nodes than a fourth: otherwise the lattice is under
/// pressure and drifts.
constexpr double kCoarseScale = 0.98;

/// A mesh without a coarser one has a random lattice, which settles slowly: it is given longer
/// steps and more visits.
constexpr double kPlainStep = 0.4;
constexpr double kPlainThreshold = 0.015;

/// From so many nodes on, new ones begin with the mean of the tensors at the ends of their edges:
/// edges are short there, and what differs is gone after a visit. On coarser levels it is not, and
/// what it disturbs costs more visits on all levels after them than the questions would.
constexpr std::int32_t kInheritedNodes = 1 << 17;
constexpr std::int32_t kInheritedNodesOfLast = 1 << 15;

/// Sample points for the estimates of complexity and of the length of the constrained edges.
constexpr double kSamples = 4096;
constexpr int kSamplesPerEdge = 64;

/// Integral of sqrt(det M), by sampling every triangle at the corners of a uniform subdivision's
/// cells. Only the number of levels depends on it.
double EstimateComplexity(const Mesh& mesh, const MetricField& field) {
  const int per_side =
      std::max(1, static_cast<int>(std::sqrt(kSamples / std::max(1, mesh.triangle_count()))));
  double complexity = 0;
  std::vector<Vec2> points;
  std::vector<std::int32_t> hints(static_cast<std::size_t>(per_side), MetricField::kNoHint);
  std::vector<Metric> metrics;
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    const TriangleRecord& triangle = mesh.triangle(TriangleId(t));
    if (!triangle.live) continue;
    const Vec2 a = mesh.position(triangle.vertices[0]);
    const Vec2 ab = mesh.position(triangle.vertices[1]) - a;
    const Vec2 ac = mesh.position(triangle.vertices[2]) - a;
    double sum = 0;
    int count = 0;
    // Row after row: each point is near that of the row before.
    for (int i = 0; i < per_side; ++i) {
      points.clear();
      for (int j = 0; i + j < per_side; ++j, ++count) {
        const double u = (i + 1.0 / 3) / per_side;
        const double v = (j + 1.0 / 3) / per_side;
        points.push_back(a + u * ab + v * ac);
      }
      metrics.resize(points.size());
      field.AtEach(points, std::span(hints).first(points.size()), metrics);
      for (const Metric& metric : metrics) sum += std::sqrt(Determinant(metric));
    }
    complexity += 0.5 * Cross(ab, ac) * sum / count;
  }
  return complexity;
}

/// What a coarser mesh cannot do without.
struct ConstraintSums {
  double given_count = 0;
  double length = 0;  ///< Of the constrained edges, in the metric.
};

ConstraintSums MeasureConstraints(const Mesh& mesh, const MetricField& field) {
  ConstraintSums constraints;
  for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
    constraints.given_count += mesh.vertex(VertexId(v)).fixed;
  }
  const int per_edge =
      std::clamp(static_cast<int>(kSamples / std::max(1, mesh.edge_count())), 1, kSamplesPerEdge);
  std::int32_t hint = MetricField::kNoHint;
  for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
    const EdgeRecord& edge = mesh.edge(EdgeId(e));
    if (!edge.live) continue;
    const Vec2 a = mesh.position(edge.vertices[0]);
    const Vec2 ab = mesh.position(edge.vertices[1]) - a;
    double sum = 0;
    for (int i = 0; i < per_edge; ++i) {
      sum += std::sqrt(SquaredLength(field.At(a + ((i + 0.5) / per_edge) * ab, hint), ab));
    }
    constraints.length += sum / per_edge;
  }
  return constraints;
}

/// How often the wanted size can be doubled from a mesh of `node_count` nodes.
int CountLevels(double node_count, const ConstraintSums& constraints) {
  int levels = 0;
  for (double nodes = node_count / 4; nodes * 4 > kCoarsestNodes && levels < 30; nodes /= 4) {
    const double constrained = constraints.length / std::ldexp(1.0, levels + 1);
    if (constraints.given_count > kGivenShare * nodes ||
        constraints.given_count + constrained > kConstrainedShare * nodes) {
      break;
    }
    ++levels;
  }
  return levels;
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
  const int levels = CountLevels(nodes, MeasureConstraints(edit.mesh(), *field_));
  LoopSettings first = settings_;
  if (levels > 0) {
    first.speed_threshold = first.neighbor_threshold = 0.02;
  } else {
    if (options.step == 0) first.alpha = kPlainStep;
    if (options.speed_threshold == 0) {
      first.speed_threshold = first.neighbor_threshold = kPlainThreshold;
    }
  }
  InlineExecutor alone;  // The coarsest level is small.
  StartLevel(levels, first);
  (void)Wake(alone);
}

StopReason NestedBuild::Run(const Budget& budget, const Helpers& helpers) {
  StoppableExecutor executor(helpers.executor(), budget.stop);
  if (!Wake(executor)) return StopReason::kCancelled;
  if (!std::exchange(begun_, true) && BlockLoop::Suits(edit_.mesh(), options_, helpers.rule())) {
    blocks_.emplace(edit_, loop_, options_, helpers.rule());
  }
  if (!blocks_) return loop_.Run(*level_field_, budget);
  return blocks_->Run(*level_field_, budget, helpers.executor());
}

std::int64_t NestedBuild::active_count() const {
  const std::int64_t count = loop_.active_count() + (blocks_ ? blocks_->active_count() : 0);
  return waking_ || (count == 0 && level_ > 0) ? edit_.mesh().vertex_count() : count;
}

bool NestedBuild::NextLevel(const Helpers& helpers, const StopSignal* stop) {
  PLIANT_CHECK(level_ > 0);
  StoppableExecutor executor(helpers.executor(), stop);
  const double growth = ScaleOf(level_ - 1) / ScaleOf(level_);
  const std::vector<EdgeSplit> splits = PlanRefinement(edit_.mesh(), growth, executor);
  if (executor.stopped()) return false;
  if (edit_.mesh().vertex_count() + std::ssize(splits) > options_.vertices_max) {
    Finish(helpers);  // The loop inserts one by one up to the limit and counts what it refuses.
    return true;
  }
  if (!edit_.Refine(
          splits, is_coarsest_ ? TrianglesAlongCurve(edit_.mesh()) : TrianglesBySlot(edit_.mesh()),
          executor)) {
    return false;
  }
  is_coarsest_ = false;
  LoopSettings fine = settings_;
  fine.age_cooling = 6;
  fine.age_max = 14;
  const bool last = level_ == 1;
  fine.speed_threshold = last ? settings_.speed_threshold : 0.02;
  fine.neighbor_threshold = last ? std::max(0.05, settings_.neighbor_threshold) : 0.02;
  StartLevel(level_ - 1, fine);
  if (edit_.mesh().vertex_count() >= (last ? kInheritedNodesOfLast : kInheritedNodes)) {
    refined_by_ = growth;
  }
  return true;
}

void NestedBuild::Finish(const Helpers& helpers) {
  // Nodes that were woken and are in no queue would be lost to the next level.
  (void)Wake(helpers.executor());
  if (blocks_) blocks_->Leave();
  if (level_ == 0) {
    loop_.AskForUnvisited(*field_);
    return;
  }
  StartLevel(0, settings_);
  (void)Wake(helpers.executor());
}

void NestedBuild::StartLevel(int level, const LoopSettings& settings) {
  if (blocks_) blocks_->Leave();
  blocks_.reset();
  begun_ = false;
  refined_by_ = 0;
  level_ = level;
  const double scale = ScaleOf(level);
  level_field_ = level == 0 ? field_ : std::make_shared<ScaledField>(field_, scale);
  loop_.BeginUpdate(settings);
  waking_ = true;
}

/// First those of the coarser mesh, which are at rest but for the change of level, then the new
/// ones between them: one visit in fifty less than in plain order of slots.
/// @return false if the executor was stopped
bool NestedBuild::Wake(Executor& executor) {
  if (!waking_) return true;
  waking_ = refined_by_ > 0 ? !loop_.WakeRefined(refined_by_, executor)
                            : !loop_.WakeAll(*level_field_, executor);
  return !waking_;
}

}  // namespace pliant
