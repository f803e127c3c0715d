#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/geometry/domain.h"
#include "core/geometry/mesh_data.h"
#include "core/mesh/mesh_diff.h"
#include "core/metric/metric_functions.h"
#include "core/metric/metric_spec.h"
#include "core/metric/solution_metric.h"
#include "core/motion/motion.h"
#include "core/pliant/options.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "core/pliant/revision_delta.h"
#include "core/pliant/tensors_ahead.h"
#include "core/threads/thread_pool.h"

namespace pliant::server {

/// Everything that an engine starts from.
struct EngineInput {
  std::variant<Domain, MeshData> start;
  MetricSpec metric;
  Options options;
};

/// A metric that a nodal field asks for.
struct SolutionRequest {
  std::string name = {};  ///< Of a field of the session, if there are no values.
  /// At the live vertices in ascending order, row after row: each column is a field of its own.
  std::optional<std::vector<double>> values = {};
  std::size_t column_count = 1;
  SolutionTarget target = {};
};

/// What holds for tensors at vertices.
struct TensorTerms {
  MetricLimits limits = {};
  /// Beside them from now on; absent: none, or, for tensors at some vertices, those that hold.
  std::optional<FunctionsSpec> functions = {};
};

/// Which metric a mesh is measured with: the one it follows, or the one that was sent.
enum class MetricBasis { kLimited, kRaw };

/// A measurement of an engine's mesh, in parts of a few milliseconds: see
/// pliant::QualityMeasurement.
class Measurement {
 public:
  virtual ~Measurement() = default;
  /// Measures the next part; false if there is none any more.
  virtual bool Continue() = 0;
  /// What was measured. Once. @pre Continue has returned false
  [[nodiscard]] virtual Quality Take() = 0;
};

/// What a session asks of its mesh: pliant::Remesher, seen through an interface so that tests can
/// make a session's engine fail. Functions mean what they mean in core/pliant/remesher.h.
///
/// *Threads*: one caller at a time.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual Status SetMetric(const MetricSpec& metric) = 0;
  /// Tensors on these terms; limits() and functions() are those that hold. No vertices: all of
  /// them.
  virtual Status SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                            const TensorTerms& terms) = 0;
  virtual Status SetLimits(const MetricLimits& limits) = 0;
  /// Functions beside the tensors that vertices have. An engine that knows none says so.
  virtual Status SetFunctions(const FunctionsSpec& functions, const MetricLimits& limits);
  [[nodiscard]] virtual MetricLimits limits() const = 0;
  [[nodiscard]] virtual const FunctionsSpec* functions() const { return nullptr; }
  /// Who may end SetMetric, SetTensors and SetSolution before they take anything over; they then
  /// return kCancelled. Not owned; null: nobody. An engine that cannot be ended does nothing.
  virtual void ListenTo(const StopSignal* stop) { (void)stop; }
  /// As pliant::MoveVertices.
  virtual Result<MotionReport> Move(const MotionRequest& request) = 0;
  /// As pliant::ReplaceDomain. An engine that cannot says so.
  virtual Status ReplaceDomain(const Domain& domain);
  /// Lets vertices go along with the metric's features, and their tensors with them: see
  /// pliant::DisplaceVertices. An engine that cannot says so.
  virtual Status Displace(std::span<const VertexId> vertices, std::span<const Vec2> by);
  /// As pliant::SetTensorsAhead, on these terms. An engine that cannot says so.
  virtual Status SetTensorsAhead(const TensorsAhead& request, const TensorTerms& terms);
  /// Live vertices now, ascending.
  [[nodiscard]] virtual std::vector<VertexId> Vertices() const = 0;
  /// What to look at, before a commit, and the look, right after it.
  [[nodiscard]] virtual TroubleSearch WhereTroublesMayBe() const = 0;
  [[nodiscard]] virtual std::vector<Trouble> FindTroubles(const TroubleSearch& search) const = 0;
  /// Tensors at all vertices, from a solution, on these terms. Errors: those of MetricOfSolution
  /// and SetTensors; kOutOfRange if there is no nodal field of that name.
  virtual Status SetSolution(const SolutionRequest& request, const TensorTerms& terms) = 0;
  virtual Status SetFields(const FieldUpdate& update) = 0;
  /// An engine that knows neither says so.
  virtual Status SetConstraints(const Constraints& constraints);
  virtual Status SetOptions(const Options& options);
  [[nodiscard]] virtual Options options() const { return {}; }
  virtual Result<Progress> Step(const Budget& budget) = 0;
  /// As SoftenReport::softened_count, in the steps since the last commit.
  [[nodiscard]] virtual std::int64_t softened_count() const { return 0; }
  /// Without transfer rows, whose price is a third of a small commit.
  virtual MeshDiff Commit() = 0;
  /// With them; an engine that has none commits all the same.
  virtual MeshDiff CommitAndTransfer() { return Commit(); }
  virtual void Rollback() = 0;
  /// The ways back and forth between revisions; an engine that has none says so.
  virtual std::optional<RevisionDelta> TakeUndo() { return std::nullopt; }
  [[nodiscard]] virtual RevisionDelta InverseOf(const RevisionDelta& delta) const { return delta; }
  virtual Result<MeshDiff> Apply(const RevisionDelta& delta, Revision revision);
  /// A second engine at the last commit. @pre nothing changed since
  [[nodiscard]] virtual Result<std::unique_ptr<Engine>> Fork() const;
  /// The last commit as bytes, for an EngineLoader. @pre nothing changed since
  [[nodiscard]] virtual Result<Bytes> Save() const;
  /// Reads what WriteDelta wrote of a delta that leads from the last commit.
  [[nodiscard]] virtual Result<RevisionDelta> ReadDelta(std::span<const std::byte> bytes) const;
  /// A commit now would spoil the first mesh, which is still being built from coarse to fine.
  [[nodiscard]] virtual bool building() const { return false; }
  /// The whole mesh of the last commit as a diff from nothing, whatever has changed since.
  [[nodiscard]] virtual MeshDiff Snapshot() const = 0;
  /// Begins to measure the mesh as it is. Until that is over, or given up, the engine must not
  /// change.
  [[nodiscard]] virtual std::unique_ptr<Measurement> Measure(MetricBasis basis) const = 0;
  /// What is wrong with the mesh, a sentence each: asked after a bug, before going on.
  [[nodiscard]] virtual std::vector<std::string> Validate() const = 0;
  [[nodiscard]] virtual Revision revision() const = 0;
  /// Threads that work on a step as the mesh is now: longer steps keep them busy.
  [[nodiscard]] virtual int step_threads() const { return 1; }
  /// Live vertices now, committed or not.
  [[nodiscard]] virtual std::int32_t vertex_count() const = 0;
};

/// The whole measurement in one go.
[[nodiscard]] Quality MeasureQuality(const Engine& engine, MetricBasis basis);

/// Makes engines. Errors: those of Remesher::Create.
using EngineFactory = std::function<Result<std::unique_ptr<Engine>>(const EngineInput&)>;

/// Makes engines of what Engine::Save gave. Errors: those of Remesher::Load.
using EngineLoader = std::function<Result<std::unique_ptr<Engine>>(std::span<const std::byte>)>;

/// The factory and the loader of the real thing.
/// @param threads  help with large meshes, all engines in turn; not owned, null: none. No bit of a
/// mesh depends on them.
[[nodiscard]] EngineFactory RemesherFactory(ThreadPool* threads = nullptr);
[[nodiscard]] EngineLoader RemesherLoader(ThreadPool* threads = nullptr);

}  // namespace pliant::server
