#include "server/engine.h"

#include <utility>

#include "core/mesh/export_mesh.h"
#include "core/mesh/validate.h"
#include "core/metric/expression_field.h"
#include "core/motion/move.h"
#include "core/motion/replace_domain.h"
#include "core/motion/soften.h"
#include "core/pliant/displace.h"
#include "core/pliant/displace_tensors.h"
#include "core/pliant/followed_metric.h"

namespace pliant::server {
namespace {

/// Interleaved columns as fields of their own. A last row that is not complete shows as fields of
/// different lengths.
std::vector<std::vector<double>> ColumnsOf(std::span<const double> values,
                                           std::size_t column_count) {
  std::vector<std::vector<double>> columns(column_count);
  for (std::size_t i = 0; i < values.size(); ++i) columns[i % column_count].push_back(values[i]);
  return columns;
}

class RemesherMeasurement final : public Measurement {
 public:
  RemesherMeasurement(const Remesher& remesher, MetricBasis basis, ThreadPool* threads)
      : raw_(basis == MetricBasis::kRaw ? remesher.raw_field() : nullptr),
        field_(raw_ != nullptr ? *raw_ : remesher.field()),
        measurement_(remesher.mesh(), field_),
        helpers_(MayShare(field_) ? threads : nullptr) {}

  bool Continue() override { return measurement_.Continue(helpers_.executor()); }
  Quality Take() override { return measurement_.Take(); }

 private:
  /// Formulas are what takes long, and they can be asked by several threads. Tensors at vertices
  /// cannot: looking them up moves what the mesh was at the last commit along (FrozenMesh).
  [[nodiscard]] static bool MayShare(const MetricField& field) {
    return dynamic_cast<const ExpressionField*>(&field) != nullptr;
  }

  const std::shared_ptr<const MetricField> raw_;
  const MetricField& field_;
  QualityMeasurement measurement_;
  Helpers helpers_;
};

/// Has a session listen to a signal for as long as this lives, which an exception ends too.
class ListeningTo {
 public:
  ListeningTo(Remesher& remesher, const StopSignal* stop) : remesher_(remesher) {
    remesher_.ListenTo(stop);
  }
  ~ListeningTo() { remesher_.ListenTo(nullptr); }
  ListeningTo(const ListeningTo&) = delete;
  ListeningTo& operator=(const ListeningTo&) = delete;

 private:
  Remesher& remesher_;
};

class RemesherEngine final : public Engine {
 public:
  RemesherEngine(std::unique_ptr<Remesher> remesher, ThreadPool* threads)
      : remesher_(std::move(remesher)), threads_(threads) {
    remesher_->UseHelpers(Helpers(threads_));
  }

  Status SetMetric(const MetricSpec& metric) override {
    has_updates_ = true;
    return remesher_->SetMetric(metric);
  }
  Status SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                    const TensorTerms& terms) override {
    has_updates_ = true;
    if (!terms.functions) return remesher_->SetTensors(vertices, tensors, terms.limits);
    return remesher_->SetTensors(vertices, tensors, terms.limits, *terms.functions);
  }
  Status SetLimits(const MetricLimits& limits) override {
    has_updates_ = true;
    return remesher_->SetLimits(limits);
  }
  Status SetFunctions(const FunctionsSpec& functions, const MetricLimits& limits) override {
    has_updates_ = true;
    return remesher_->SetFunctions(functions, limits);
  }
  MetricLimits limits() const override { return remesher_->limits(); }
  const FunctionsSpec* functions() const override { return remesher_->functions(); }
  void ListenTo(const StopSignal* stop) override { remesher_->ListenTo(stop); }
  Result<MotionReport> Move(const MotionRequest& request) override {
    has_updates_ = true;
    return MoveVertices(*remesher_, request);
  }
  Status ReplaceDomain(const Domain& domain) override {
    has_new_domain_ = true;
    const Result<DomainReport> report = pliant::ReplaceDomain(*remesher_, domain);
    return report.ok() ? Status() : Status(report.error());
  }
  Status Displace(std::span<const VertexId> vertices, std::span<const Vec2> by) override {
    has_updates_ = true;
    DisplaceVertices displacement(vertices, by);
    return remesher_->Apply(displacement);
  }
  Status SetTensorsAhead(const TensorsAhead& request, const TensorTerms& terms) override {
    has_updates_ = true;
    return pliant::SetTensorsAhead(*remesher_, request,
                                   {terms.limits, terms.functions ? &*terms.functions : nullptr});
  }
  std::vector<VertexId> Vertices() const override { return LiveVertices(remesher_->mesh()); }
  TroubleSearch WhereTroublesMayBe() const override { return remesher_->WhereTroublesMayBe(); }
  std::vector<Trouble> FindTroubles(const TroubleSearch& search) const override {
    return remesher_->FindTroubles(search);
  }
  Status SetSolution(const SolutionRequest& request, const TensorTerms& terms) override {
    has_updates_ = true;
    const ExportedMesh mesh = ExportMesh(remesher_->mesh());
    std::vector<double> stored;
    std::size_t column_count = request.column_count;
    if (!request.values) {
      const Field* field = remesher_->fields().Find(request.name);
      if (field == nullptr || field->location != FieldLocation::kVertex) {
        return Error{ErrorCode::kOutOfRange,
                     "there is no field '" + request.name +
                         "' at the vertices of this revision; fields that are staged count from "
                         "the next advance on",
                     "metric.solution.field"};
      }
      column_count = field->column_count;
      for (const VertexId id : mesh.vertex_ids) {
        const auto row = field->row(id.index());
        stored.insert(stored.end(), row.begin(), row.end());
      }
    }
    SolutionTarget target = request.target;
    target.bounds = terms.limits.bounds;
    PLIANT_ASSIGN_OR_RETURN(
        const std::vector<Metric> tensors,
        MetricOfSolution(
            mesh.data, ColumnsOf(request.values ? *request.values : stored, column_count), target));
    Status set = SetTensors({}, tensors, terms);
    if (set.ok() || set.error().field.rfind("metric.tensors", 0) != 0) return set;
    // The client has sent values, not tensors.
    Error error = set.error();
    error.message = "row " + std::to_string(error.index) +
                    " of the solution asks for a metric that no mesh can follow (" + error.message +
                    "); are its values finite, and of a size that their second "
                    "derivatives leave finite? Scale them";
    error.field = "metric.solution.field";
    return error;
  }
  Status SetFields(const FieldUpdate& update) override { return remesher_->SetFields(update); }
  Status SetConstraints(const Constraints& constraints) override {
    return remesher_->SetConstraints(constraints);
  }
  Status SetOptions(const Options& options) override { return remesher_->SetOptions(options); }
  Options options() const override { return remesher_->options(); }
  Result<Progress> Step(const Budget& budget) override {
    // The client looks for the points of a domain that it has sent where it has sent them.
    const bool keeps_points = std::exchange(has_new_domain_, false);
    if (std::exchange(has_updates_, false) && !keeps_points) {
      const ListeningTo listening(*remesher_, budget.stop);
      const Result<SoftenReport> softened = SoftenBoundary(*remesher_);
      if (!softened.ok()) return softened.error();
      softened_count_ += softened->softened_count;
    }
    return remesher_->Step(budget);
  }
  std::int64_t softened_count() const override { return softened_count_; }
  MeshDiff Commit() override {
    softened_count_ = 0;
    MeshDiff diff = remesher_->Commit();
    diff.transfer.reset();  // Where fields were carried they were made, but nobody asked.
    return diff;
  }
  MeshDiff CommitAndTransfer() override {
    softened_count_ = 0;
    return remesher_->CommitAndTransfer();
  }
  void Rollback() override {
    has_updates_ = has_new_domain_ = false;
    softened_count_ = 0;
    remesher_->Rollback();
  }
  MeshDiff Snapshot() const override {
    MeshDiff snapshot = remesher_->Snapshot();
    snapshot.fields.changed = remesher_->fields().At(snapshot.vertex_ids, snapshot.triangle_ids);
    return snapshot;
  }
  std::unique_ptr<Measurement> Measure(MetricBasis basis) const override {
    return std::make_unique<RemesherMeasurement>(*remesher_, basis, threads_);
  }
  std::vector<std::string> Validate() const override { return pliant::Validate(remesher_->mesh()); }
  std::optional<RevisionDelta> TakeUndo() override { return remesher_->TakeUndo(); }
  RevisionDelta InverseOf(const RevisionDelta& delta) const override {
    return remesher_->InverseOf(delta);
  }
  Result<MeshDiff> Apply(const RevisionDelta& delta, Revision revision) override {
    return remesher_->Apply(delta, revision);
  }
  Result<std::unique_ptr<Engine>> Fork() const override {
    PLIANT_ASSIGN_OR_RETURN(const Bytes bytes, remesher_->Save());
    PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<Remesher> copy, Remesher::Load(bytes));
    return std::unique_ptr<Engine>(std::make_unique<RemesherEngine>(std::move(copy), threads_));
  }
  Result<Bytes> Save() const override { return remesher_->Save(); }
  Result<RevisionDelta> ReadDelta(std::span<const std::byte> bytes) const override {
    return remesher_->ReadDelta(bytes);
  }
  bool building() const override { return remesher_->building(); }
  int step_threads() const override {
    const bool in_blocks = building() && vertex_count() >= BlockRule{}.nodes_min;
    return threads_ != nullptr && in_blocks ? threads_->thread_count() : 1;
  }
  Revision revision() const override { return remesher_->revision(); }
  std::int32_t vertex_count() const override { return remesher_->mesh().vertex_count(); }

 private:
  std::unique_ptr<Remesher> remesher_;
  ThreadPool* const threads_;
  bool has_updates_ = false;     // Of metric or geometry, since the last step.
  bool has_new_domain_ = false;  // Likewise.
  std::int64_t softened_count_ = 0;
};

}  // namespace

Quality MeasureQuality(const Engine& engine, MetricBasis basis) {
  const std::unique_ptr<Measurement> measurement = engine.Measure(basis);
  while (measurement->Continue()) {
  }
  return measurement->Take();
}

Status Engine::ReplaceDomain(const Domain&) {
  return Error{ErrorCode::kUnimplemented, "this engine keeps its domain", {}};
}

Status Engine::SetFunctions(const FunctionsSpec&, const MetricLimits&) {
  return Error{ErrorCode::kUnimplemented, "this engine has no functions beside tensors", {}};
}

Status Engine::Displace(std::span<const VertexId>, std::span<const Vec2>) {
  return Error{ErrorCode::kUnimplemented, "this engine displaces nothing", {}};
}

Status Engine::SetTensorsAhead(const TensorsAhead&, const TensorTerms&) {
  return Error{ErrorCode::kUnimplemented, "this engine displaces nothing", {}};
}

Status Engine::SetConstraints(const Constraints&) {
  return Error{ErrorCode::kUnimplemented, "this engine freezes nothing", {}};
}

Status Engine::SetOptions(const Options&) {
  return Error{ErrorCode::kUnimplemented, "this engine has no options", {}};
}

Result<MeshDiff> Engine::Apply(const RevisionDelta&, Revision) {
  return Error{ErrorCode::kUnimplemented, "this engine keeps no revisions", {}};
}

Result<std::unique_ptr<Engine>> Engine::Fork() const {
  return Error{ErrorCode::kUnimplemented, "this engine cannot be copied", {}};
}

Result<Bytes> Engine::Save() const {
  return Error{ErrorCode::kUnimplemented, "this engine cannot be saved", {}};
}

Result<RevisionDelta> Engine::ReadDelta(std::span<const std::byte>) const {
  return Error{ErrorCode::kUnimplemented, "this engine keeps no revisions", {}};
}

EngineLoader RemesherLoader(ThreadPool* threads) {
  return [threads](std::span<const std::byte> bytes) -> Result<std::unique_ptr<Engine>> {
    PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<Remesher> remesher, Remesher::Load(bytes));
    return std::unique_ptr<Engine>(std::make_unique<RemesherEngine>(std::move(remesher), threads));
  };
}

EngineFactory RemesherFactory(ThreadPool* threads) {
  return [threads](const EngineInput& input) -> Result<std::unique_ptr<Engine>> {
    PLIANT_ASSIGN_OR_RETURN(
        std::unique_ptr<Remesher> remesher,
        std::visit(
            [&](const auto& start) { return Remesher::Create(start, input.metric, input.options); },
            input.start));
    return std::unique_ptr<Engine>(std::make_unique<RemesherEngine>(std::move(remesher), threads));
  };
}

}  // namespace pliant::server
