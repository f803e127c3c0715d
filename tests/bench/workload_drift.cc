// A size that changes a little with every update, everywhere.
#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "core/motion/move.h"
#include "core/pliant/followed_metric.h"
#include "tests/bench/workload_step.h"
#include "tests/support/ideal_count.h"

namespace pliant::bench {
namespace {

/// What the steps have left.
struct Left {
  double over_ideal = 0;
  nlohmann::json quality;
};

Left LeftIn(const Remesher& remesher, const MetricField& field) {
  Left left;
  left.quality = QualityOf(remesher.mesh(), field);
  left.over_ideal =
      remesher.mesh().vertex_count() /
      testing::IdealVertexCount(remesher.mesh(), field, left.quality["complexity"].get<double>());
  return left;
}

/// All nodes away from the origin by a factor, as a Lagrangian solver sends them. Those that the
/// loop has put inside segments go along with the ends of these.
Status Stretch(Remesher& remesher, double factor) {
  const Mesh& mesh = remesher.mesh();
  MotionRequest motion;
  for (const VertexId vertex : LiveVertices(mesh)) {
    const VertexRecord& record = mesh.vertex(vertex);
    if (record.edge.valid() && !record.fixed) continue;
    motion.vertices.push_back(vertex);
    motion.positions.push_back(factor * record.position);
  }
  PLIANT_ASSIGN_OR_RETURN(const MotionReport report, MoveVertices(remesher, motion));
  (void)report;
  return {};
}

Status Send(Remesher& remesher, const Request& request, const CaseRequest& scaled,
            const BenchCase& instance, const std::vector<Metric>& tensors) {
  if (!tensors.empty()) return remesher.SetTensors({}, tensors);
  if (request.form == MetricForm::kExpression) {
    if (const auto formulas = FormulasOf(scaled)) return remesher.SetMetric(*formulas);
  }
  return remesher.SetField(instance.field());
}

}  // namespace

Result<nlohmann::json> RunDrift(Remesher& remesher, const Request& request) {
  std::vector<Update> updates;
  CaseRequest scaled = request.instance;
  PLIANT_ASSIGN_OR_RETURN(const BenchCase first, MakeCase(scaled));
  double over_least = 2;
  double over_most = 0;
  double share_least = 1;
  double q_mean_least = 1;
  double q_min_least = 1;
  nlohmann::json ratios = nlohmann::json::array();
  Untouched untouched;
  Left left = LeftIn(remesher, *first.field());
  const double before = left.over_ideal;
  for (std::int64_t step = 0; step < request.steps; ++step) {
    // The cases scale their metric by the nodes that are wanted.
    if (!request.stretches) scaled.node_count /= request.size_step * request.size_step;
    PLIANT_ASSIGN_OR_RETURN(const BenchCase instance, MakeCase(scaled));
    const std::shared_ptr<MetricField> field = instance.field();
    std::vector<Metric> tensors;
    if (request.form == MetricForm::kTensors) tensors = TensorsAt(remesher.mesh(), *field);
    untouched.Before(remesher.mesh(), [](const VertexRecord&) { return true; });
    PLIANT_ASSIGN_OR_RETURN(Update update, RunOne(remesher, [&] {
                              return request.stretches
                                         ? Stretch(remesher, 1 / request.size_step)
                                         : Send(remesher, request, scaled, instance, tensors);
                            }));
    untouched.After(update.diff, remesher.Snapshot());
    updates.push_back(std::move(update));
    left = LeftIn(remesher, *field);
    ratios.push_back(left.over_ideal);
    over_least = std::min(over_least, left.over_ideal);
    over_most = std::max(over_most, left.over_ideal);
    share_least = std::min(share_least, left.quality["integrated_125"].get<double>());
    q_mean_least = std::min(q_mean_least, left.quality["q_mean"].get<double>());
    q_min_least = std::min(q_min_least, left.quality["q_min"].get<double>());
  }
  return nlohmann::json{{"steps", JsonOf(updates)},
                        {"nodes_over_ideal_before", before},
                        {"nodes_over_ideal_least", over_least},
                        {"nodes_over_ideal_most", over_most},
                        {"nodes_over_ideal_last", left.over_ideal},
                        {"nodes_over_ideal_of_steps", ratios},
                        {"integrated_125_least", share_least},
                        {"q_mean_least", q_mean_least},
                        {"q_min_least", q_min_least},
                        {"untouched", untouched.Json()},
                        {"quality_last", left.quality}};
}

}  // namespace pliant::bench
