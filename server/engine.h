#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/geometry/mesh_data.h"
#include "core/mesh/mesh_diff.h"
#include "core/metric/metric_spec.h"
#include "core/motion/motion.h"
#include "core/pliant/options.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"

namespace pliant::server {

/// Everything that an engine starts from.
struct EngineInput {
  std::variant<Domain, MeshData> start;
  MetricSpec metric;
  Options options;
};

/// What a session asks of its mesh: pliant::Remesher, seen through an interface so that tests can
/// make a session's engine fail. Functions mean what they mean in core/pliant/remesher.h.
///
/// *Threads*: one caller at a time.
class Engine {
 public:
  virtual ~Engine() = default;
  virtual Status SetMetric(const MetricSpec& metric) = 0;
  virtual Status SetTensors(std::span<const VertexId> vertices,
                            std::span<const Metric> tensors) = 0;
  /// As pliant::MoveVertices.
  virtual Result<MotionReport> Move(const MotionRequest& request) = 0;
  /// Live vertices now, ascending.
  [[nodiscard]] virtual std::vector<VertexId> Vertices() const = 0;
  virtual Result<Progress> Step(const Budget& budget) = 0;
  [[nodiscard]] virtual std::vector<Trouble> FindTroubles() const = 0;
  virtual MeshDiff Commit() = 0;
  virtual void Rollback() = 0;
  /// A commit now would spoil the first mesh, which is still being built from coarse to fine.
  [[nodiscard]] virtual bool building() const { return false; }
  /// The whole mesh of the last commit as a diff from nothing, whatever has changed since.
  [[nodiscard]] virtual MeshDiff Snapshot() const = 0;
  [[nodiscard]] virtual Quality MeasureQuality() const = 0;
  /// What is wrong with the mesh, a sentence each: asked after a bug, before going on.
  [[nodiscard]] virtual std::vector<std::string> Validate() const = 0;
  [[nodiscard]] virtual Revision revision() const = 0;
  /// Live vertices now, committed or not.
  [[nodiscard]] virtual std::int32_t vertex_count() const = 0;
};

/// Makes engines. Errors: those of Remesher::Create.
using EngineFactory = std::function<Result<std::unique_ptr<Engine>>(const EngineInput&)>;

/// The factory of the real thing.
[[nodiscard]] EngineFactory RemesherFactory();

}  // namespace pliant::server
