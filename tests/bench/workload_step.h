#pragma once

#include <functional>
#include <vector>

#include "core/mesh/mesh_diff.h"
#include "tests/bench/workload_run.h"

namespace pliant::bench {

/// One update: staging, loop and commit, timed apart, and what it changed.
struct Update {
  Duration stage;
  Duration loop;
  Duration commit;
  Progress progress;
  MeshDiff diff;

  [[nodiscard]] Duration total() const {
    return {stage.wall + loop.wall + commit.wall, stage.cpu + loop.cpu + commit.cpu};
  }
};

[[nodiscard]] Result<Update> RunOne(Remesher& remesher, const std::function<Status()>& stage);
[[nodiscard]] nlohmann::json JsonOf(const std::vector<Update>& updates);

/// Tensors of a field at all live vertices, in order of slot.
[[nodiscard]] std::vector<Metric> TensorsAt(const Mesh& mesh, const MetricField& field);

/// How much of a mesh an update leaves as it was, counted over the steps of a run.
class Untouched {
 public:
  /// Before an update: @param inside  whether it is about a vertex
  void Before(const Mesh& mesh, const std::function<bool(const VertexRecord&)>& inside);
  /// After it: `snapshot` is the whole mesh.
  void After(const MeshDiff& diff, const MeshDiff& snapshot);

  /// Means over the steps: shares of all vertices and of those outside the zone that kept their
  /// bits; bytes of the diff, as arrays of the protocol, over those of the whole mesh.
  [[nodiscard]] nlohmann::json Json() const;

 private:
  std::vector<bool> live_;     // By slot.
  std::vector<bool> outside_;  // Of live vertices.
  double live_count_ = 0;
  double outside_count_ = 0;
  double kept_ = 0;  // Sums of shares.
  double kept_outside_ = 0;
  double bytes_ = 0;
  double steps_ = 0;
};

/// Case E; sizes that change slowly.
[[nodiscard]] Result<nlohmann::json> RunDrift(Remesher& remesher, const Request& request);
[[nodiscard]] Result<nlohmann::json> RunFront(Remesher& remesher, const Request& request);

/// All nodes are moved.
[[nodiscard]] Result<nlohmann::json> RunNodes(Remesher& remesher, const Request& request);

/// The domain is replaced.
[[nodiscard]] Result<nlohmann::json> RunDomain(Remesher& remesher, const Request& request);

}  // namespace pliant::bench
