#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "server/engine.h"
#include "server/session_messages.h"
#include "server/undo_history.h"

namespace pliant::server {

/// An engine whose updates are staged until a commit: all of them take effect, or none.
///
/// Staging applies an update to the engine at once, which checks it; what was staged is undone by
/// going back to the engine's last commit. Before the first commit there is none to go back to,
/// so the input is kept until then and the engine built anew from it.
///
/// *Invariants*: with nothing staged and no step since, the engine is at its last commit.
/// *Threads*: one caller at a time. All calls compute; none belongs on an RPC thread.
class StagedEngine {
 public:
  /// Errors: those of the engine's factory.
  static Result<StagedEngine> Create(EngineInput input, EngineFactory factory);

  /// Stages a change of the metric. Errors: those of Engine::SetMetric and SetTensors,
  /// kRevisionMismatch, kProtocolOrder for a time of tensors; then the engine is as before, but
  /// tainted().
  Status Stage(const MetricUpdate& update);

  /// Stages a motion. Errors: those of Engine::Move, `field` below "boundary" or "nodes",
  /// kRevisionMismatch; then the engine is as before, but tainted().
  Status StageMotion(const MotionUpdate& update);

  /// Stages another domain. Errors: those of Engine::ReplaceDomain; kTooLarge for more points than
  /// Options::vertices_max; then as above.
  Status Stage(const DomainUpdate& update);

  /// How far the staged motions went, the least of them; absent if there are none.
  [[nodiscard]] std::optional<double> motion_fraction() const { return motion_fraction_; }

  /// Stages fields. Errors: those of Engine::SetFields, kRevisionMismatch; then as above.
  Status Stage(const FieldsUpdate& update);

  /// Stages options. Errors: those of Engine::SetOptions; then as above.
  Status Stage(const OptionsUpdate& update);

  /// Stages constraints. Errors: those of Engine::SetConstraints, kRevisionMismatch; then as above.
  Status Stage(const ConstraintsUpdate& update);

  /// One that exists, at its last commit, following `spec`.
  static StagedEngine Adopt(std::unique_ptr<Engine> engine, std::shared_ptr<const MetricSpec> spec,
                            EngineFactory factory);

  /// What takes the engine back over its last commit; nothing if it does not know.
  std::optional<UndoStep> TakeUndo();
  /// Goes to the revision that a step leads to, under another number. The second is what leads
  /// back. Errors: kProtocolOrder if something is staged or was stepped; those of Engine::Apply.
  Result<std::pair<MeshDiff, UndoStep>> GoTo(const UndoStep& way, Revision revision);
  /// A second engine at the last commit or, with a way, where that leads.
  /// Errors: kProtocolOrder as GoTo; those of Engine::Fork.
  [[nodiscard]] Result<StagedEngine> Fork(const UndoStep* way) const;

  /// Stages whatever a command holds that can be staged; as the functions above. A discard empties
  /// the stage. Errors: theirs; kProtocolOrder for a command that is none of them.
  /// @param stop  null: nobody; else a change of the metric, a motion or another domain that it
  /// asks
  ///              to stop is refused with
  ///              kCancelled, and everything, tainted() too, is as it was.
  Status StageCommand(const UpdateCommand& command, const StopSignal* stop = nullptr);

  /// The last commit, for an EngineLoader. Errors: those of Engine::Save; kProtocolOrder as GoTo.
  [[nodiscard]] Result<Bytes> Save() const;

  /// Records that an update that belongs to this stage was refused...
  void Taint() { tainted_ = true; }
  /// ...after it had been accepted, so that whoever advances is to hear why.
  void TaintLate(std::int64_t update_id, Error error);
  /// The first such refusal since the last commit or discard, for the advance.
  [[nodiscard]] const std::optional<Error>& late_refusal() const { return late_refusal_; }
  /// True if an update was refused since the last commit or discard: a commit would be half of
  /// what the client meant.
  [[nodiscard]] bool tainted() const { return tainted_; }
  [[nodiscard]] std::int32_t staged_count() const { return staged_count_; }

  /// Undoes everything since the last commit. Errors: those of the factory, before the first.
  Status Discard();

  /// As Engine::Step.
  Result<Progress> Step(const Budget& budget) {
    stepped_ = true;
    return engine_->Step(budget);
  }

  /// As Engine's. @pre !tainted()
  MeshDiff Commit();
  MeshDiff CommitAndTransfer();

  /// What the engine follows, with what is staged and without; null where that is no
  /// specification.
  [[nodiscard]] const std::shared_ptr<const MetricSpec>& spec() const { return spec_; }
  [[nodiscard]] const std::shared_ptr<const MetricSpec>& committed_spec() const {
    return committed_spec_;
  }
  /// True if there is something that only this object's memory holds.
  [[nodiscard]] bool stepped() const { return stepped_; }
  [[nodiscard]] const Engine& engine() const { return *engine_; }
  [[nodiscard]] Revision revision() const { return engine_->revision(); }

 private:
  StagedEngine(std::unique_ptr<EngineInput> input, EngineFactory factory,
               std::unique_ptr<Engine> engine);
  [[nodiscard]] Status CheckCommitted() const;
  Status StageBody(const UpdateCommand& command);
  void EndStage();
  Status SetSpec(const MetricUpdate& update);
  Status SetSource(const MetricUpdate& update);
  /// @param moved  comes before the tensors, which are those of where it leads; null: none
  Status SetTensors(const VertexTensors& tensors, const TensorTerms& terms,
                    const DisplacementUpdate* moved);
  [[nodiscard]] double TimeNow() const;
  [[nodiscard]] Result<std::optional<FunctionsSpec>> FunctionsOf(const MetricUpdate& update) const;
  Status Move(const MotionUpdate& update);
  Status Displace(const DisplacementUpdate& displacement);
  Status SetSolution(const SolutionRequest& request, const TensorTerms& terms);
  [[nodiscard]] Status CheckRevision(Revision revision, const std::string& field) const;

  EngineFactory factory_;
  std::unique_ptr<EngineInput> first_input_;  // Until the first commit.
  std::unique_ptr<Engine> engine_;
  // What the engine follows, with what is staged and without. Shared because a background mesh is
  // large; null after tensors at vertices, when there is no specification.
  std::shared_ptr<const MetricSpec> spec_;
  std::shared_ptr<const MetricSpec> committed_spec_;
  std::shared_ptr<const MetricSpec> previous_spec_;  // Of the commit before.
  std::int32_t staged_count_ = 0;
  std::optional<double> motion_fraction_;
  bool tainted_ = false;
  std::optional<Error> late_refusal_;
  bool stepped_ = false;  // The engine has worked since its last commit.
};

}  // namespace pliant::server
