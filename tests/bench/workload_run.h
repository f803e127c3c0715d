#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/pliant/remesher.h"
#include "tests/bench/workload_cases.h"

namespace pliant::bench {

/// How tensors at vertices come with a displacement.
enum class DisplacedTensors {
  kSeen,      ///< Of the vertices where the displacement has put them: only in one process.
  kTogether,  ///< In the same update, of the places where the displacement leads.
  kApart,     ///< In a second update, after a commit.
};

/// What to run, from the command line.
struct Request {
  CaseRequest instance;
  Options options;
  MetricForm form = MetricForm::kAnalytic;
  GradationOptions limits;  ///< Not for MetricForm::kAnalytic.
  /// "", "disc", "tensors", "bump", "same", "front", "drift", "body", "nodes" or "domain".
  std::string update;
  std::int64_t changed = 1000;  ///< "bump": nodes under the bump.
  bool sends_all = false;       ///< "bump": tensors are sent for all vertices.
  std::string beside;           ///< "bump": a size in x, y that stands beside the tensors.
  std::int64_t steps = 50;      ///< "front", "drift", "body": number of steps.
  double front_step = 0.02;     ///< "front": length of a step.
  bool displaces = false;       ///< "front": the client sends the displacement of the front, too.
  DisplacedTensors displaced_tensors = DisplacedTensors::kSeen;  ///< "front" with `displaces`.
  std::int64_t swing = 0;   ///< "front": turns back after so many steps; 0: never.
  double size_step = 0.97;  ///< "drift": factor on all sizes of a step.
  bool stretches = false;   ///< "drift": the nodes move apart, the sizes stay.
  double follow = 4;        ///< "body": MotionRequest::follow_length.
  int thread_count = 1;     ///< Threads that work on the mesh.
  int repeat = 3;           ///< Runs of everything that is timed.
  std::string mesh_path;    ///< Where to write the (last) mesh; empty: nowhere.
};

/// Time that something took. On a busy machine `cpu` is the number to compare.
struct Duration {
  double wall = 0;  ///< Seconds.
  double cpu = 0;   ///< Seconds of this process.
};
[[nodiscard]] Duration TimeOf(const std::function<void()>& action);

/// The middle one; the lower of the two middle ones. @pre !values.empty()
[[nodiscard]] double Median(std::vector<double> values);
/// {"wall_s": median, "cpu_s": median, "cpu_s_all": [...]}.
[[nodiscard]] nlohmann::json JsonOf(const std::vector<Duration>& durations);

/// A mesh that has converged, and what that took: from the polygon or the background mesh to the
/// first commit, the time of Create included.
struct Built {
  std::unique_ptr<Executor> executor;  ///< Of the remesher.
  std::unique_ptr<Remesher> remesher;
  Duration duration;
  Progress progress;
};
[[nodiscard]] Result<Built> Build(const BenchCase& instance, const Request& request);
/// The metric is that of `spec`; the case's own function if there is none.
[[nodiscard]] Result<Built> BuildWith(const BenchCase& instance, const Request& request,
                                      const std::optional<MetricSpec>& spec);

/// Runs the request; the answer is the report without the machine.
[[nodiscard]] Result<nlohmann::json> RunBuild(const Request& request);
[[nodiscard]] Result<nlohmann::json> RunUpdate(const Request& request);

/// The quality of the mesh against the case's own metric, whatever form the remesher got it in.
[[nodiscard]] nlohmann::json QualityOf(const Mesh& mesh, const MetricField& field);
/// Processor, cores, compiler, flags and commit: what a number must come with.
[[nodiscard]] nlohmann::json Machine();
/// Largest resident memory of this process so far, in MiB.
[[nodiscard]] double PeakMemoryMib();
/// Resident memory of this process now, in MiB.
[[nodiscard]] double ResidentMemoryMib();

}  // namespace pliant::bench
