#include "server/engine.h"

#include <utility>

#include "core/mesh/validate.h"
#include "core/motion/move.h"
#include "core/pliant/followed_metric.h"

namespace pliant::server {
namespace {

class RemesherEngine final : public Engine {
 public:
  explicit RemesherEngine(std::unique_ptr<Remesher> remesher) : remesher_(std::move(remesher)) {}

  Status SetMetric(const MetricSpec& metric) override { return remesher_->SetMetric(metric); }
  Status SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors) override {
    return remesher_->SetTensors(vertices, tensors);
  }
  Result<MotionReport> Move(const MotionRequest& request) override {
    return MoveVertices(*remesher_, request);
  }
  std::vector<VertexId> Vertices() const override { return LiveVertices(remesher_->mesh()); }
  Result<Progress> Step(const Budget& budget) override { return remesher_->Step(budget); }
  std::vector<Trouble> FindTroubles() const override { return remesher_->FindTroubles(); }
  MeshDiff Commit() override { return remesher_->Commit(); }
  void Rollback() override { remesher_->Rollback(); }
  MeshDiff Snapshot() const override { return remesher_->Snapshot(); }
  Quality MeasureQuality() const override {
    return pliant::MeasureQuality(remesher_->mesh(), remesher_->field());
  }
  std::vector<std::string> Validate() const override { return pliant::Validate(remesher_->mesh()); }
  bool building() const override { return remesher_->building(); }
  Revision revision() const override { return remesher_->revision(); }
  std::int32_t vertex_count() const override { return remesher_->mesh().vertex_count(); }

 private:
  std::unique_ptr<Remesher> remesher_;
};

}  // namespace

EngineFactory RemesherFactory() {
  return [](const EngineInput& input) -> Result<std::unique_ptr<Engine>> {
    PLIANT_ASSIGN_OR_RETURN(
        std::unique_ptr<Remesher> remesher,
        std::visit(
            [&](const auto& start) { return Remesher::Create(start, input.metric, input.options); },
            input.start));
    return std::unique_ptr<Engine>(std::make_unique<RemesherEngine>(std::move(remesher)));
  };
}

}  // namespace pliant::server
