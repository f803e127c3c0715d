#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "client/io/file.h"
#include "client/io/medit.h"
#include "core/mesh/export_mesh.h"
#include "core/threads/thread_pool.h"
#include "tests/bench/schedule_executor.h"
#include "tests/bench/workload_run.h"

namespace pliant::bench {
namespace {

/// The tensors of the case at the vertices of a mesh that was adapted to them: what a solver has.
Result<MetricSpec> BackgroundOf(const BenchCase& instance, const Request& request) {
  Request analytic = request;
  analytic.form = MetricForm::kAnalytic;
  PLIANT_ASSIGN_OR_RETURN(const Built built, Build(instance, analytic));
  BackgroundMetric background{.mesh = ExportMesh(built.remesher->mesh()).data, .tensors = {}};
  const auto field = instance.field();
  std::int32_t hint = MetricField::kNoHint;
  for (const Vec2 p : background.mesh.points) background.tensors.push_back(field->At(p, hint));
  return MetricSpec{.source = std::move(background)};
}

Result<std::optional<MetricSpec>> SpecWithoutLimits(const BenchCase& instance,
                                                    const Request& request) {
  switch (request.form) {
    case MetricForm::kAnalytic:
    case MetricForm::kTensors:
      return std::optional<MetricSpec>();
    case MetricForm::kExpression:
      if (auto formulas = FormulasOf(request.instance); formulas.has_value()) return formulas;
      return Error{.code = ErrorCode::kOutOfRange,
                   .message = "Case " + request.instance.name +
                              " has no formulas; take --metric analytic or background.",
                   .field = "metric"};
    case MetricForm::kBackground: {
      PLIANT_ASSIGN_OR_RETURN(MetricSpec spec, BackgroundOf(instance, request));
      return std::optional<MetricSpec>(std::move(spec));
    }
  }
  PLIANT_CHECK(false, "metric form");
}

/// The specification that stands for the case's field; nothing for a C++ function.
Result<std::optional<MetricSpec>> SpecOf(const BenchCase& instance, const Request& request) {
  PLIANT_ASSIGN_OR_RETURN(std::optional<MetricSpec> spec, SpecWithoutLimits(instance, request));
  if (spec) {
    spec->gradation = request.limits;
  } else if (request.limits.any()) {
    return Error{.code = ErrorCode::kOutOfRange,
                 .message = "A C++ function has no limits; take --metric expression or background.",
                 .field = "metric"};
  }
  return spec;
}

/// CPU seconds of the last run if several threads had shared the work, by their number; empty if
/// they did.
nlohmann::json ScheduleOf(const Built& built) {
  nlohmann::json result;
  const auto* schedule = dynamic_cast<const ScheduleExecutor*>(built.executor.get());
  if (schedule == nullptr) return result;
  result["1"] = built.duration.cpu;
  for (const auto& [thread_count, saved] : schedule->saved_s()) {
    result[std::to_string(thread_count)] = built.duration.cpu - saved;
  }
  return result;
}

nlohmann::json CountsOf(const Progress& progress, std::int32_t vertex_count) {
  const LoopCounts& counts = progress.counts;
  return {{"visits", counts.visits},
          {"visits_per_node", static_cast<double>(counts.visits) / vertex_count},
          {"insertions", counts.insertions},
          {"deletions", counts.deletions},
          {"swaps", counts.swaps},
          {"cooled", counts.cooled},
          {"converged", progress.stop_reason == StopReason::kConverged}};
}

}  // namespace

Result<Built> BuildWith(const BenchCase& instance, const Request& request,
                        const std::optional<MetricSpec>& spec) {
  Built built;
  std::optional<Error> error;
  auto field = instance.field();
  if (request.thread_count > 1) {
    built.executor = std::make_unique<ThreadPool>(request.thread_count);
  } else {
    built.executor = std::make_unique<ScheduleExecutor>();
  }
  built.duration = TimeOf([&] {
    auto created = spec.has_value()
                       ? Remesher::Create(instance.domain, *spec, request.options)
                       : Remesher::Create(instance.domain, std::move(field), request.options);
    if (!created.ok()) {
      error = created.error();
      return;
    }
    built.remesher = std::move(created).value();
    built.remesher->UseHelpers(Helpers(built.executor.get()));
    const auto progress = built.remesher->Step({});
    if (!progress.ok()) {
      error = progress.error();
      return;
    }
    built.progress = *progress;
    (void)built.remesher->Commit();
  });
  if (error.has_value()) return *error;
  return built;
}

Result<Built> Build(const BenchCase& instance, const Request& request) {
  PLIANT_ASSIGN_OR_RETURN(const auto spec, SpecOf(instance, request));
  return BuildWith(instance, request, spec);
}

Result<nlohmann::json> RunBuild(const Request& request) {
  PLIANT_ASSIGN_OR_RETURN(const BenchCase instance, MakeCase(request.instance));
  PLIANT_ASSIGN_OR_RETURN(const auto spec, SpecOf(instance, request));
  std::vector<Duration> durations;
  Built built;
  for (int run = 0; run < request.repeat; ++run) {
    built = {};  // Before the next one starts, so that memory holds one mesh only.
    PLIANT_ASSIGN_OR_RETURN(built, BuildWith(instance, request, spec));
    durations.push_back(built.duration);
  }
  const double memory = PeakMemoryMib();
  const nlohmann::json schedule = ScheduleOf(built);
  const Mesh& mesh = built.remesher->mesh();
  nlohmann::json report = CountsOf(built.progress, mesh.vertex_count());
  report["nodes"] = mesh.vertex_count();
  report["time"] = JsonOf(durations);
  report["nodes_per_cpu_s"] = mesh.vertex_count() / report["time"]["cpu_s"].get<double>();
  const MetricReport& limits = built.remesher->metric_report();
  if (limits.limits) {
    report["limits"] = {{"geometry_count", limits.geometry_count},
                        {"rotation_count", limits.rotation_count},
                        {"gradation_count", limits.gradation_count},
                        {"size_ratio_max", limits.size_ratio_max},
                        {"raw_complexity", limits.raw_complexity},
                        {"limited_complexity", limits.limited_complexity}};
  }
  if (!schedule.empty()) report["cpu_s_on_threads"] = schedule;
  report["peak_rss_mib"] = memory;
  report["quality"] = QualityOf(mesh, *instance.field());
  if (!request.mesh_path.empty()) {
    PLIANT_RETURN_IF_ERROR(
        io::WriteFileAtomically(request.mesh_path, io::FormatMedit(ExportMesh(mesh).data)));
  }
  return report;
}

}  // namespace pliant::bench
