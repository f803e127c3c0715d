#include "server/staged_engine.h"

#include <algorithm>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "server/revision_text.h"

namespace pliant::server {
namespace {

// The engine names what it checks by its own arguments; clients know them by their field.
Status Named(const Status& status, const std::string& field) {
  if (status.ok()) return status;
  Error error = status.error();
  if (error.field.empty()) error.field = field;
  return error;
}

// Elements of the mesh, by their slots: clients know them by these names.
bool IsElements(const std::string& field) {
  return field == "vertices" || field == "edges" || field == "triangles";
}

// The same for motions, whose fields in the core are those of MotionRequest.
Status NamedBy(const Status& status, const std::string& update) {
  if (status.ok()) return status;
  Error error = status.error();
  const std::string& field = error.field;
  if (field == "motion.vertices") {
    error.field = update + ".vertices.vertex_ids";
  } else if (field == "motion.positions") {
    error.field = update + ".vertices.positions";
  } else if (field == "motion.revision") {
    error.field = update + ".vertices.revision";
  } else if (field == "motion.tags") {
    error.field = update + ".tags";
  } else if (field == "motion.follow_length") {
    error.field = update + ".metric_follow_length";
  } else if (!IsElements(field)) {
    error.field = update;
  }
  return error;
}

/// Has an engine listen to a signal for as long as this lives, which an exception ends too. A way
/// back may put another engine in its place meanwhile.
class Listening {
 public:
  Listening(const std::unique_ptr<Engine>& engine, const StopSignal* stop) : engine_(engine) {
    engine_->ListenTo(stop);
  }
  ~Listening() {
    if (engine_ != nullptr) engine_->ListenTo(nullptr);
  }
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;

 private:
  const std::unique_ptr<Engine>& engine_;
};

// `value`, if there is one, takes the place of what stands there.
template <typename T>
void Replace(const std::optional<T>& value, T& place) {
  if (value) place = *value;
}

// What limits after an update, if these did before.
MetricLimits LimitsAfter(const MetricUpdate& update, MetricLimits limits) {
  Replace(update.size_min, limits.bounds.size_min);
  Replace(update.size_max, limits.bounds.size_max);
  Replace(update.anisotropy_max, limits.bounds.anisotropy_max);
  Replace(update.gradation, limits.gradation.gradation);
  Replace(update.rotation, limits.gradation.rotation);
  Replace(update.geometry, limits.gradation.geometry);
  Replace(update.gap_element_count, limits.gradation.gap_element_count);
  Replace(update.smoothing_count, limits.gradation.smoothing_count);
  Replace(update.automatic, limits.gradation.automatic);
  return limits;
}

Error TimeOfTensors() {
  return {ErrorCode::kProtocolOrder,
          "tensors at vertices know no time; leave it out, or send it with expressions",
          "metric.time"};
}

}  // namespace

Result<StagedEngine> StagedEngine::Create(EngineInput input, EngineFactory factory) {
  auto kept = std::make_unique<EngineInput>(std::move(input));
  PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<Engine> engine, factory(*kept));
  return StagedEngine(std::move(kept), std::move(factory), std::move(engine));
}

StagedEngine::StagedEngine(std::unique_ptr<EngineInput> input, EngineFactory factory,
                           std::unique_ptr<Engine> engine)
    : factory_(std::move(factory)),
      first_input_(std::move(input)),
      engine_(std::move(engine)),
      spec_(std::make_shared<const MetricSpec>(first_input_->metric)),
      committed_spec_(spec_) {}

StagedEngine StagedEngine::Adopt(std::unique_ptr<Engine> engine,
                                 std::shared_ptr<const MetricSpec> spec, EngineFactory factory) {
  auto input = std::make_unique<EngineInput>();
  StagedEngine staged(std::move(input), std::move(factory), std::move(engine));
  staged.first_input_ = nullptr;
  staged.spec_ = staged.committed_spec_ = std::move(spec);
  return staged;
}

Status StagedEngine::CheckCommitted() const {
  if (staged_count_ == 0 && !tainted_ && !stepped_) return {};
  return Error{ErrorCode::kProtocolOrder,
               "updates are staged, or an advance has failed: advance or discard first",
               {}};
}

std::optional<UndoStep> StagedEngine::TakeUndo() {
  std::optional<RevisionDelta> delta = engine_->TakeUndo();
  if (!delta) return std::nullopt;
  return UndoStep{*std::move(delta), previous_spec_};
}

Result<std::pair<MeshDiff, UndoStep>> StagedEngine::GoTo(const UndoStep& way, Revision revision) {
  PLIANT_RETURN_IF_ERROR(CheckCommitted());
  UndoStep back{engine_->InverseOf(way.delta), committed_spec_};
  back.delta.base = revision;
  PLIANT_ASSIGN_OR_RETURN(MeshDiff diff, engine_->Apply(way.delta, revision));
  spec_ = committed_spec_ = way.spec;
  return std::pair(std::move(diff), std::move(back));
}

Result<StagedEngine> StagedEngine::Fork(const UndoStep* way) const {
  PLIANT_RETURN_IF_ERROR(CheckCommitted());
  PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<Engine> copy, engine_->Fork());
  if (way != nullptr) {
    const Result<MeshDiff> diff = copy->Apply(way->delta, way->delta.revision);
    if (!diff.ok()) return diff.error();
  }
  return Adopt(std::move(copy), way != nullptr ? way->spec : committed_spec_, factory_);
}

Result<Bytes> StagedEngine::Save() const {
  PLIANT_RETURN_IF_ERROR(CheckCommitted());
  return engine_->Save();
}

Status StagedEngine::StageCommand(const UpdateCommand& command, const StopSignal* stop) {
  const Listening listening(engine_, stop);
  return StageBody(command);
}

Status StagedEngine::StageBody(const UpdateCommand& command) {
  return std::visit(
      [this](const auto& body) -> Status {
        using Body = std::decay_t<decltype(body)>;
        if constexpr (std::is_same_v<Body, DiscardUpdate>) {
          return Discard();
        } else if constexpr (std::is_same_v<Body, MotionUpdate>) {
          return StageMotion(body);
        } else if constexpr (requires { Stage(body); }) {
          return Stage(body);
        } else {
          return Error{ErrorCode::kProtocolOrder, "this is no update that can be staged", {}};
        }
      },
      command.body);
}

Status StagedEngine::Stage(const MetricUpdate& update) {
  Status status;
  if (update.displacement) {
    engine_->ListenTo(nullptr);  // What is displaced stays so.
    // Tensors say where vertices go, so that the engine takes both at once.
    const bool is_together = std::holds_alternative<VertexTensors>(update.source);
    if (!is_together) status = Displace(*update.displacement);
  }
  if (!status.ok()) {
    tainted_ = true;
    return Named(status, "metric.displacement");
  }
  status = SetSource(update);
  if (!status.ok()) {
    if (status.error().code != ErrorCode::kCancelled) tainted_ = true;
    return Named(
        status, std::holds_alternative<VertexTensors>(update.source) ? "metric.tensors" : "metric");
  }
  ++staged_count_;
  return {};
}

/// What is wanted from now on, by whatever the update says of it.
Status StagedEngine::SetSource(const MetricUpdate& update) {
  const MetricLimits before = engine_->limits();
  const MetricLimits limits = LimitsAfter(update, before);
  const bool keeps_source = std::holds_alternative<std::monostate>(update.source);
  if (update.displacement && keeps_source && !update.time && limits == before) {
    spec_ = nullptr;  // The metric goes along, and is no longer what the specification says.
    return {};
  }
  const VertexTensors* const tensors = std::get_if<VertexTensors>(&update.source);
  const SolutionRequest* const solution = std::get_if<SolutionRequest>(&update.source);
  const bool keeps_tensors = keeps_source && spec_ == nullptr;
  if (tensors == nullptr && solution == nullptr && !keeps_tensors) return SetSpec(update);
  PLIANT_ASSIGN_OR_RETURN(const std::optional<FunctionsSpec> functions, FunctionsOf(update));
  if (tensors != nullptr) {
    const auto& moved = update.displacement;
    return SetTensors(*tensors, {limits, functions}, moved ? &*moved : nullptr);
  }
  if (solution != nullptr) return SetSolution(*solution, {limits, functions});
  return functions ? engine_->SetFunctions(*functions, limits) : engine_->SetLimits(limits);
}

/// What an update of values at vertices wants beside them, if it says so: functions, or only
/// another time for those that stay.
Result<std::optional<FunctionsSpec>> StagedEngine::FunctionsOf(const MetricUpdate& update) const {
  std::optional<FunctionsSpec> functions = update.functions;
  const FunctionsSpec* const held = engine_->functions();
  if (functions) {
    functions->time = TimeNow();
  } else if (update.time) {
    const VertexTensors* const tensors = std::get_if<VertexTensors>(&update.source);
    const bool keeps_them = std::holds_alternative<std::monostate>(update.source) ||
                            (tensors != nullptr && tensors->vertices);
    if (held == nullptr || !keeps_them) return TimeOfTensors();
    functions = *held;
  }
  if (functions) Replace(update.time, functions->time);
  return functions;
}

/// The value of t in expressions, as long as no update gives another one.
double StagedEngine::TimeNow() const {
  if (spec_ != nullptr) return spec_->time;
  return engine_->functions() != nullptr ? engine_->functions()->time : 0;
}

/// Carried out at once, so that what is sent with it is laid on the mesh as it is then.
Status StagedEngine::Displace(const DisplacementUpdate& displacement) {
  PLIANT_RETURN_IF_ERROR(CheckRevision(displacement.revision, "metric.displacement.revision"));
  if (displacement.vertices.empty()) return {};
  PLIANT_RETURN_IF_ERROR(engine_->Displace(displacement.vertices, displacement.by));
  stepped_ = true;
  return {};
}

Status StagedEngine::Stage(const DomainUpdate& update) {
  const std::size_t count = update.domain.points.size();
  const std::int32_t vertices_max = engine_->options().vertices_max;
  Status status;
  if (count > static_cast<std::size_t>(vertices_max)) {
    status = Error{
        ErrorCode::kTooLarge,
        std::to_string(count) + " points; options.vertices_max is " + std::to_string(vertices_max),
        "domain.points"};
  } else {
    status = engine_->ReplaceDomain(update.domain);
  }
  if (!status.ok()) {
    if (status.error().code != ErrorCode::kCancelled) tainted_ = true;
    return Named(status, "domain");
  }
  ++staged_count_;
  return {};
}

Status StagedEngine::Stage(const OptionsUpdate& update) {
  const Status status = engine_->SetOptions(update.AppliedTo(engine_->options()));
  if (!status.ok()) {
    tainted_ = true;
    return Named(status, "options");
  }
  ++staged_count_;
  return {};
}

Status StagedEngine::Stage(const ConstraintsUpdate& update) {
  Status status;
  if (update.revision) status = CheckRevision(*update.revision, "constraints.revision");
  if (status.ok()) status = engine_->SetConstraints(update.constraints);
  if (!status.ok()) {
    tainted_ = true;
    return Named(status, "constraints");
  }
  ++staged_count_;
  return {};
}

Status StagedEngine::StageMotion(const MotionUpdate& update) {
  const Status status = Move(update);
  if (!status.ok()) {
    if (status.error().code != ErrorCode::kCancelled) tainted_ = true;
    return NamedBy(status, update.field);
  }
  ++staged_count_;
  return {};
}

Status StagedEngine::Stage(const FieldsUpdate& update) {
  Status status = CheckRevision(update.revision, "fields.revision");
  if (status.ok()) status = engine_->SetFields(update.update);
  if (!status.ok()) {
    tainted_ = true;
    return Named(status, "fields");
  }
  ++staged_count_;
  return {};
}

Status StagedEngine::Move(const MotionUpdate& update) {
  if (update.revision && *update.revision != revision()) {
    return Error{ErrorCode::kRevisionMismatch,
                 "positions are for revision " + RevisionText(*update.revision) +
                     "; the session is at " + RevisionText(revision()),
                 "motion.revision"};
  }
  MotionRequest request = update.request;
  if (update.names_all) request.vertices = engine_->Vertices();
  PLIANT_ASSIGN_OR_RETURN(const MotionReport report, engine_->Move(request));
  motion_fraction_ = std::min(report.fraction, motion_fraction_.value_or(1));
  // What follows the boundary is no longer what the specification says.
  if (request.follow_length > 0) spec_ = nullptr;
  return {};
}

Status StagedEngine::CheckRevision(Revision wanted, const std::string& field) const {
  const auto current = static_cast<std::int64_t>(revision());
  if (revision() == Revision::kNone) {
    return Error{ErrorCode::kRevisionMismatch,
                 "the session has no revision yet, so it has no elements to send values for: "
                 "advance first",
                 field};
  }
  if (wanted != revision()) {
    return Error{ErrorCode::kRevisionMismatch,
                 "values are for revision " + RevisionText(wanted) + "; the session is at " +
                     std::to_string(current),
                 field};
  }
  return {};
}

/// The limits that hold are laid on the result, with which it still has the wanted complexity.
Status StagedEngine::SetSolution(const SolutionRequest& request, const TensorTerms& terms) {
  if (revision() == Revision::kNone) {
    return Error{ErrorCode::kRevisionMismatch,
                 "the session has no revision yet, so it has no vertices where a solution could "
                 "be known: advance first",
                 "metric.solution"};
  }
  PLIANT_RETURN_IF_ERROR(engine_->SetSolution(request, terms));
  spec_ = nullptr;
  return {};
}

Status StagedEngine::SetTensors(const VertexTensors& tensors, const TensorTerms& terms,
                                const DisplacementUpdate* moved) {
  const auto current = static_cast<std::int64_t>(revision());
  if (revision() == Revision::kNone) {
    return Error{ErrorCode::kRevisionMismatch,
                 "the session has no revision yet, so it has no vertices to send tensors for: "
                 "advance first",
                 "metric.revision"};
  }
  if (tensors.revision != revision()) {
    return Error{ErrorCode::kRevisionMismatch,
                 "tensors are for revision " + RevisionText(tensors.revision) +
                     "; the session is at " + std::to_string(current),
                 "metric.revision"};
  }
  const std::vector<VertexId> all;
  const std::vector<VertexId>& vertices = tensors.vertices ? *tensors.vertices : all;
  // For the engine no vertices means all of them; from a client an empty list is an empty list.
  const bool is_of_none = tensors.vertices && vertices.empty();
  if (moved != nullptr) {
    PLIANT_RETURN_IF_ERROR(CheckRevision(moved->revision, "metric.displacement.revision"));
    if (moved->vertices.empty()) {
      moved = nullptr;
    } else if (is_of_none) {
      PLIANT_RETURN_IF_ERROR(Displace(*moved));
    }
  }
  if (is_of_none) {
    if (terms.functions) {
      PLIANT_RETURN_IF_ERROR(engine_->SetFunctions(*terms.functions, terms.limits));
    } else {
      if (terms.limits == engine_->limits() && moved == nullptr) return {};
      PLIANT_RETURN_IF_ERROR(engine_->SetLimits(terms.limits));
    }
  } else if (moved != nullptr) {
    stepped_ = true;  // Also where the tensors are refused, when vertices may have moved.
    PLIANT_RETURN_IF_ERROR(
        engine_->SetTensorsAhead({moved->vertices, moved->by, vertices, tensors.tensors}, terms));
  } else {
    PLIANT_RETURN_IF_ERROR(engine_->SetTensors(vertices, tensors.tensors, terms));
  }
  spec_ = nullptr;
  return {};
}

Status StagedEngine::SetSpec(const MetricUpdate& update) {
  MetricSpec spec;
  if (spec_ != nullptr) spec = *spec_;
  spec.time = TimeNow();
  std::visit(
      [&](const auto& source) {
        using Source = std::decay_t<decltype(source)>;
        if constexpr (std::is_constructible_v<decltype(spec.source), const Source&>) {
          spec.source = source;
        }
      },
      update.source);
  Replace(update.time, spec.time);
  const MetricLimits limits = LimitsAfter(update, engine_->limits());
  spec.bounds = limits.bounds;
  spec.gradation = limits.gradation;
  PLIANT_RETURN_IF_ERROR(engine_->SetMetric(spec));
  spec_ = std::make_shared<const MetricSpec>(std::move(spec));
  return {};
}

void StagedEngine::TaintLate(std::int64_t update_id, Error error) {
  tainted_ = true;
  if (late_refusal_) return;
  error.message = "update " + std::to_string(update_id) +
                  " was accepted before it was checked, and is refused: " + error.message +
                  "; nothing was committed and the stage is empty now: send the step again";
  late_refusal_ = std::move(error);
}

Status StagedEngine::Discard() {
  if (staged_count_ > 0 || stepped_) {
    if (first_input_ != nullptr) {
      PLIANT_ASSIGN_OR_RETURN(engine_, factory_(*first_input_));
    } else {
      engine_->Rollback();
    }
  }
  spec_ = committed_spec_;
  staged_count_ = 0;
  motion_fraction_.reset();
  tainted_ = false;
  late_refusal_.reset();
  stepped_ = false;
  return {};
}

MeshDiff StagedEngine::Commit() {
  PLIANT_CHECK(!tainted_);
  MeshDiff diff = engine_->Commit();
  EndStage();
  return diff;
}

MeshDiff StagedEngine::CommitAndTransfer() {
  PLIANT_CHECK(!tainted_);
  MeshDiff diff = engine_->CommitAndTransfer();
  EndStage();
  return diff;
}

// All that was staged is committed.
void StagedEngine::EndStage() {
  first_input_ = nullptr;
  previous_spec_ = std::exchange(committed_spec_, spec_);
  staged_count_ = 0;
  motion_fraction_.reset();
  stepped_ = false;
}

}  // namespace pliant::server
