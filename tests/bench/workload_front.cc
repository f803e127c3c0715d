// Case E: a front that moves.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/mesh/export_mesh.h"
#include "core/pliant/displace.h"
#include "core/pliant/displace_tensors.h"
#include "tests/bench/workload_step.h"

namespace pliant::bench {
namespace {

/// Builds compared with: one every so many steps, each of the metric of its step.
constexpr std::int64_t kStepsPerBuild = 10;

/// Whether a client would say that a place moves with its front: as far as its metric reaches.
bool IsOfFront(Vec2 p, double front) {
  constexpr double kReach = 0.15;
  const double curve = front - 0.5 + std::sqrt(0.25 + 0.25 * (p.y - 0.5) * (p.y - 0.5));
  return std::fabs(p.x - curve) < kReach;
}

std::vector<VertexId> VerticesOfFront(const Mesh& mesh, double front) {
  std::vector<VertexId> vertices;
  for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
    if (!mesh.vertex(VertexId(v)).live) continue;
    if (IsOfFront(mesh.position(VertexId(v)), front)) vertices.emplace_back(v);
  }
  return vertices;
}

/// How far the front goes in a step: it turns back every request.swing steps.
double StepOf(const Request& request, std::int64_t step) {
  const bool back = request.swing > 0 && step / request.swing % 2 == 1;
  return back ? -request.front_step : request.front_step;
}

struct FrontStep {
  double front;  ///< Where it was.
  double by;
  const BenchCase& instance;  ///< Where it is now...
  const CaseRequest& moved;   ///< ...and what that was made from.
};

/// The front's vertices and the tensors of the places where they go, at once.
Result<Update> StepTogether(Remesher& remesher, const FrontStep& step) {
  const std::vector<VertexId> vertices = VerticesOfFront(remesher.mesh(), step.front);
  const std::vector<Vec2> by(vertices.size(), Vec2{step.by, 0});
  const std::unique_ptr<MetricField> field = step.instance.field();
  std::vector<Metric> tensors;
  std::int32_t hint = MetricField::kNoHint;
  for (const Vec2 p : ExportMesh(remesher.mesh()).data.points) {
    tensors.push_back(field->At(IsOfFront(p, step.front) ? p + Vec2{step.by, 0} : p, hint));
  }
  const MetricLimits limits = remesher.limits();
  return RunOne(remesher, [&] {
    return SetTensorsAhead(
        remesher, {.displaced = vertices, .by = by, .vertices = {}, .tensors = tensors}, {limits});
  });
}

/// Times what the remesher does; what the client does in between, computing tensors, is not timed.
Result<Update> StepOnce(Remesher& remesher, const Request& request, const FrontStep& step) {
  using enum DisplacedTensors;
  if (request.displaces && request.displaced_tensors == kTogether) {
    return StepTogether(remesher, step);
  }
  Update update;
  Status status;
  if (request.displaces) {
    const std::vector<VertexId> vertices = VerticesOfFront(remesher.mesh(), step.front);
    const std::vector<Vec2> by(vertices.size(), Vec2{step.by, 0});
    DisplaceVertices displace(vertices, by);
    update.stage = TimeOf([&] {
      status = remesher.Apply(displace);
      if (!status.ok() || request.displaced_tensors != kApart) return;
      const Result<Progress> visited = remesher.Step({.visits_max = 1});
      if (!visited.ok()) status = visited.error();
      (void)remesher.Commit();
    });
    PLIANT_RETURN_IF_ERROR(status);
  }
  std::vector<Metric> tensors;
  if (request.form == MetricForm::kTensors)
    tensors = TensorsAt(remesher.mesh(), *step.instance.field());
  std::unique_ptr<MetricField> field = step.instance.field();
  const std::optional<MetricSpec> formulas =
      request.form == MetricForm::kExpression ? FormulasOf(step.moved) : std::nullopt;
  PLIANT_ASSIGN_OR_RETURN(Update rest, RunOne(remesher, [&] {
                            if (formulas) return remesher.SetMetric(*formulas);
                            return tensors.empty() ? remesher.SetField(std::move(field))
                                                   : remesher.SetTensors({}, tensors);
                          }));
  rest.stage.wall += update.stage.wall;
  rest.stage.cpu += update.stage.cpu;
  return rest;
}

/// What the client of a mesher without sessions has: the last mesh with the new tensors on it.
MetricSpec AsSent(const Mesh& mesh, const MetricField& field) {
  BackgroundMetric background{.mesh = ExportMesh(mesh).data, .tensors = {}};
  std::int32_t hint = MetricField::kNoHint;
  for (const Vec2 p : background.mesh.points) background.tensors.push_back(field.At(p, hint));
  return {.source = std::move(background)};
}

}  // namespace

Result<nlohmann::json> RunFront(Remesher& remesher, const Request& request) {
  std::vector<Update> updates;
  std::vector<Duration> builds;
  std::vector<Duration> builds_as_sent;
  CaseRequest moving = request.instance;
  nlohmann::json quality;
  Untouched untouched;
  Untouched by_vertex;
  double q_min = 1;
  double q_mean = 0;
  double share = 0;
  double longest = 0;
  double over_ideal = 0;
  for (std::int64_t step = 0; step < request.steps; ++step) {
    PLIANT_ASSIGN_OR_RETURN(const BenchCase last, MakeCase(moving));
    const std::shared_ptr<MetricField> before = last.field();
    const double by = StepOf(request, step);
    moving.front += by;
    PLIANT_ASSIGN_OR_RETURN(const BenchCase instance, MakeCase(moving));
    const std::shared_ptr<MetricField> field = instance.field();
    std::int32_t hint = MetricField::kNoHint;
    const double tolerance = request.options.metric_tolerance;
    untouched.Before(remesher.mesh(), [&](const VertexRecord& vertex) {
      const Vec2 p = vertex.position;
      return RelativeChange(before->At(p, hint), field->At(p, hint)) > tolerance;
    });
    // A vertex holds its tensor while changes are below the tolerance: many of them add up.
    by_vertex.Before(remesher.mesh(), [&](const VertexRecord& vertex) {
      const Vec2 p = vertex.position;
      return RelativeChange(vertex.metric, field->At(p, hint)) > tolerance ||
             (request.displaces && IsOfFront(p, moving.front - by));
    });
    const bool compares = step % kStepsPerBuild == 0;
    std::optional<MetricSpec> sent;
    if (compares && request.form == MetricForm::kTensors) sent = AsSent(remesher.mesh(), *field);
    PLIANT_ASSIGN_OR_RETURN(Update update,
                            StepOnce(remesher, request, {moving.front - by, by, instance, moving}));
    untouched.After(update.diff, remesher.Snapshot());
    by_vertex.After(update.diff, remesher.Snapshot());
    updates.push_back(std::move(update));
    quality = QualityOf(remesher.mesh(), *field);
    q_min = std::min(q_min, quality["q_min"].get<double>());
    q_mean += quality["q_mean"].get<double>();
    share += quality["integrated_125"].get<double>();
    longest = std::max(longest, quality["integrated"]["max"].get<double>());
    over_ideal +=
        remesher.mesh().vertex_count() / (1.1547005383792515 * quality["complexity"].get<double>());
    if (compares) {
      PLIANT_ASSIGN_OR_RETURN(const Built built, Build(instance, request));
      builds.push_back(built.duration);
    }
    if (sent) {
      PLIANT_ASSIGN_OR_RETURN(const Built built, BuildWith(instance, request, sent));
      builds_as_sent.push_back(built.duration);
    }
  }
  const auto steps = static_cast<double>(request.steps);
  nlohmann::json report{{"steps", JsonOf(updates)},
                        {"builds", JsonOf(builds)},
                        {"untouched", untouched.Json()},
                        {"untouched_unasked", by_vertex.Json()["untouched_outside_zone"]},
                        {"q_mean_of_steps", q_mean / steps},
                        {"q_min_of_steps", q_min},
                        {"integrated_125_of_steps", share / steps},
                        {"longest_of_steps", longest},
                        {"nodes_over_ideal", over_ideal / steps},
                        {"quality_last", quality}};
  if (!builds_as_sent.empty()) report["builds_as_sent"] = JsonOf(builds_as_sent);
  return report;
}

}  // namespace pliant::bench
