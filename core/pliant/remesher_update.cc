// Remesher, the part that takes metrics and changes over and lets the loop follow them.

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/stoppable_executor.h"
#include "core/pliant/carry.h"
#include "core/pliant/check_options.h"
#include "core/pliant/remesher_impl.h"

namespace pliant {
namespace {

/// Bulk changes look at all nodes that woke before they change thousands of them; of more nodes
/// than these that takes longer than a cancel may wait, and the loop does the work.
constexpr std::size_t kBulkNodesMax = std::size_t{1} << 16;

/// And they look at nodes whose tensors have changed by more than this, relative: a change by less
/// makes no good edge so long or so short that it is halved, or its ends thinned out.
constexpr double kBulkChangeMin = 0.25;

/// A cancel is a reason to stop; other errors are errors.
Result<StopReason> StoppedBy(const Error& error) {
  if (error.code == ErrorCode::kCancelled) return StopReason::kCancelled;
  return error;
}

/// An update drifts if it has so many slight changes for each of these: the slopes of a change that
/// is large in its middle are left to the loop, which is at work there anyway.
constexpr std::size_t kSlightPerLarge = 4;

bool Ended(StopReason reason) {
  return reason == StopReason::kConverged || reason == StopReason::kVertexLimit;
}

}  // namespace

Status Remesher::Impl::Start(std::unique_ptr<MetricField> field, const MetricSpec* spec) {
  followed_.Follow(std::move(field), spec);
  if (options_.variant == Variant::kNested && numbering_ == Numbering::kClosesGaps &&
      options_.permissions == Permissions{}) {
    nested_.emplace(edit_, loop_, followed_.shared_field(), options_);
  } else {
    loop_.BeginUpdate(SettingsOf(options_));
    for (const VertexId vertex : LiveVertices(mesh_)) {
      edit_.SetMetric(vertex, followed_.field().At(mesh_.position(vertex), edit_.Hint(vertex)));
      loop_.Wake(vertex);
    }
  }
  return followed_.status();
}

Status Remesher::Impl::SetSpec(const MetricSpec& spec) {
  // What vertices carried along is another metric than the specification that they had it from.
  if (followed_.Follows(spec) && carriers_.empty()) return {};
  PLIANT_RETURN_IF_ERROR(FollowedMetric::Check(spec));
  PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<MetricField> field, MakeMetricField(spec, box_, stop_));
  return SetField(std::move(field), &spec);
}

Status Remesher::Impl::SetField(std::unique_ptr<MetricField> field, const MetricSpec* spec) {
  PLIANT_ASSIGN_OR_RETURN(WantedTensors raw, followed_.Evaluate(*field, stop_));
  const StopSignal* const stop = StopOfWhole();
  LeaveNestedBuild();
  carriers_.clear();  // Another field replaces what they carried.
  auto way = followed_.WayBack();
  return ApplyOrGoBack(
      followed_.SetField(std::move(field), spec, std::move(raw), way ? stop : nullptr), stop,
      std::move(way));
}

Status Remesher::Impl::SetTensors(std::span<const VertexId> given, std::span<const Metric> tensors,
                                  const WantedTerms& wanted) {
  const std::vector<VertexId> all = given.empty() ? LiveVertices(mesh_) : std::vector<VertexId>();
  const std::span<const VertexId> vertices = given.empty() ? std::span(all) : given;
  if (wanted.limits != nullptr) PLIANT_RETURN_IF_ERROR(FollowedMetric::Check(*wanted.limits));
  PLIANT_RETURN_IF_ERROR(followed_.CheckTensors(vertices, tensors, stop_));
  WantedTerms with = wanted;
  // A part of the metric leaves the rest as it is.
  if (with.functions == nullptr && !given.empty()) with.functions = functions();
  PLIANT_ASSIGN_OR_RETURN(const FollowedMetric::Terms terms, TermsOf(with));
  return FollowTensors(vertices, tensors, terms);
}

Status Remesher::Impl::SetLimits(const MetricLimits& limits) {
  PLIANT_RETURN_IF_ERROR(FollowedMetric::Check(limits));
  if (limits == followed_.asked_limits()) return {};
  PLIANT_ASSIGN_OR_RETURN(const FollowedMetric::Terms terms, TermsOf({&limits, functions()}));
  return FollowTensors({}, {}, terms);
}

Status Remesher::Impl::SetFunctions(const FunctionsSpec& functions, const MetricLimits& limits) {
  PLIANT_RETURN_IF_ERROR(FollowedMetric::Check(limits));
  PLIANT_ASSIGN_OR_RETURN(const FollowedMetric::Terms terms, TermsOf({&limits, &functions}));
  if (followed_.Holds(terms)) return {};
  return FollowTensors({}, {}, terms);
}

/// What is to hold for tensors at vertices, with functions that can be asked at all of them; those
/// that hold if they are the same.
Result<FollowedMetric::Terms> Remesher::Impl::TermsOf(const WantedTerms& wanted) {
  FollowedMetric::Terms terms{wanted.limits != nullptr ? *wanted.limits : followed_.asked_limits(),
                              nullptr};
  if (wanted.functions == nullptr) return terms;
  if (revision_ == Revision::kNone) {
    return Error{ErrorCode::kRevisionNotFound,
                 "there is no revision yet whose vertices could have tensors beside functions; "
                 "advance first",
                 "metric.sources"};
  }
  const SizeBounds& bounds = terms.limits.bounds;
  const auto& held = followed_.state().functions;
  // Who had no value for a step that was taken back has one again for the next.
  if (held != nullptr && held->IsMadeFrom(*wanted.functions, bounds) && held->status().ok()) {
    terms.functions = held;
    return terms;
  }
  PLIANT_ASSIGN_OR_RETURN(terms.functions,
                          MetricFunctions::Make(*wanted.functions, bounds, box_, stop_));
  PLIANT_RETURN_IF_ERROR(followed_.CheckAtVertices(*terms.functions, stop_));
  return terms;
}

/// Tensors at these vertices, and terms for those of all.
Status Remesher::Impl::FollowTensors(std::span<const VertexId> vertices,
                                     std::span<const Metric> tensors,
                                     const FollowedMetric::Terms& terms) {
  PLIANT_RETURN_IF_ERROR(LayDueLimits(stop_));
  const StopSignal* const stop = StopOfWhole();
  LeaveNestedBuild();
  const bool replaces_all = followed_.Holds(terms) && followed_.IsReplacedBy(vertices);
  if (!replaces_all) PLIANT_RETURN_IF_ERROR(LetMetricFollow());
  auto way = followed_.WayBack();
  const StopSignal* const way_stop = way ? stop : nullptr;
  Result<WantedTensors> wanted = followed_.SetTensors(vertices, tensors, terms, way_stop);
  if (wanted.ok() && wanted->vertices.empty()) return {};
  carriers_.clear();  // What they carried is replaced, or followed by now.
  return ApplyOrGoBack(std::move(wanted), stop, std::move(way));
}

/// Who may stop the rest of a metric update: nobody if that begins with what cannot be taken back.
const StopSignal* Remesher::Impl::StopOfWhole() const {
  return nested_ || !carriers_.empty() ? nullptr : stop_;
}

/// True if the session is as its last commit left it, but for values of fields.
bool Remesher::Impl::nothing_staged() const {
  return revision_ != Revision::kNone && edit_.log().empty() &&
         loop_.epoch() == committed_.loop.epoch;
}

/// Undoes an update that was stopped. @pre nothing_staged() before it
void Remesher::Impl::GoBackToCommit() {
  edit_.Rollback();
  carriers_.clear();
  rewoken_.clear();
  domain_replaced_ = false;
  followed_.Rollback(committed_.followed);
  loop_.Restore(committed_.loop);
}

/// Applies what a metric update wants, or goes back to what was followed before, if there is a way.
Status Remesher::Impl::ApplyOrGoBack(Result<WantedTensors> wanted, const StopSignal* stop,
                                     std::optional<FollowedMetric::Way> way) {
  const Asks asks = nothing_staged() ? Asks::kToTheEnd : Asks::kBeforeChanges;
  Status applied =
      wanted.ok() ? Apply(*std::move(wanted), way ? stop : nullptr, asks) : Status(wanted.error());
  if (applied.ok() || !way) return applied;
  if (asks == Asks::kToTheEnd) {
    GoBackToCommit();
  } else {
    followed_.GoBack(*std::move(way));
  }
  return applied;
}

Status Remesher::Impl::Change(MeshChange& change) {
  if (change.replaces_domain() && fields_.conserves()) {
    return Error{ErrorCode::kUnimplemented,
                 "a field is conservative, and its integral means nothing on another domain: let "
                 "it be linear or bounded, or drop it, in an advance before this one",
                 "domain"};
  }
  PLIANT_RETURN_IF_ERROR(LayDueLimits(stop_));
  // What is done before a change is carried out cannot be taken back.
  const StopSignal* const stop = StopOfWhole();
  const bool may_go_back = stop != nullptr && nothing_staged();
  LeaveNestedBuild();
  change.Permit(options_.permissions);
  if (!carriers_.empty()) {
    // What vertices carried along becomes the metric only now, and that may wake nodes: not for
    // the sake of a change that will be refused.
    PLIANT_RETURN_IF_ERROR(Try(change, Fate::kUndone));
    PLIANT_RETURN_IF_ERROR(LetMetricFollow());
  }
  change.ListenTo(stop);
  Result<MeshChange::Outcome> outcome = Try(change, Fate::kKept);
  if (!outcome.ok()) return outcome.error();
  domain_replaced_ = domain_replaced_ || change.replaces_domain();
  followed_.MeshMoved();
  Status followed = FollowChange(*std::move(outcome), may_go_back ? stop : nullptr);
  if (!followed.ok()) GoBackToCommit();
  return followed;
}

/// Lets metric and loop know of a change that was carried out.
/// @param stop  null: nobody; else kCancelled if it asks to, and the caller goes back
Status Remesher::Impl::FollowChange(MeshChange::Outcome outcome, const StopSignal* stop) {
  StopPoll stopped(stop);
  for (const VertexId vertex : outcome.created) {
    if (stopped()) return Stopped();
    edit_.SetMetric(vertex, followed_.field().At(mesh_.position(vertex), edit_.Hint(vertex)));
  }
  WantedTensors wanted{std::move(outcome.moved), {}};
  PLIANT_ASSIGN_OR_RETURN(wanted.tensors, followed_.Ask(followed_.field(), wanted.vertices, stop));
  PLIANT_RETURN_IF_ERROR(Apply(std::move(wanted), stop, Asks::kToTheEnd));
  for (const VertexId vertex : outcome.disturbed) {
    if (stopped()) return Stopped();
    loop_.Wake(vertex);
  }
  for (const VertexId vertex : outcome.drifting) loop_.Drift(vertex);
  carriers_ = std::move(outcome.carriers);
  if (!carriers_.empty()) {
    using enum PliantLoop::LeftBehind;
    loop_.Follow(outcome.follows_front ? kByFront : kByBody);
  }
  return {};
}

Result<MeshChange::Outcome> Remesher::Impl::Try(MeshChange& change, Fate fate) {
  followed_.BeforeTrial();
  MeshEdit::Trial trial = edit_.BeginTrial();
  Result<MeshChange::Outcome> outcome = change.Apply(edit_);
  const Status kept = outcome.ok() ? CheckFrozenKept(mesh_, edit_.log()) : Status(outcome.error());
  if (kept.ok() && fate == Fate::kKept) {
    edit_.Keep(std::move(trial));
  } else {
    edit_.Undo(std::move(trial));
  }
  followed_.AfterTrial();
  if (!kept.ok()) return kept.error();
  return outcome;
}

Status Remesher::Impl::SetConstraints(const Constraints& constraints) {
  PLIANT_ASSIGN_OR_RETURN(FrozenElements wanted, WhatFreezes(mesh_, constraints));
  if (revision_ == Revision::kNone && !wanted.empty()) {
    return Error{ErrorCode::kRevisionNotFound,
                 "there is no revision yet whose elements could be frozen; advance first",
                 "constraints"};
  }
  LeaveNestedBuild();
  PLIANT_RETURN_IF_ERROR(LetMetricFollow());
  if (!frozen_) frozen_ = FrozenOf(mesh_);
  const std::vector<VertexId> freed = ChangeFrozen(edit_, *frozen_, wanted);
  frozen_ = std::move(wanted);
  Options options = options_;
  options.permissions = constraints.permissions;
  UseOptions(options);
  for (const VertexId vertex : freed) loop_.Wake(vertex);
  return {};
}

Status Remesher::Impl::SetOptions(const Options& options) {
  PLIANT_RETURN_IF_ERROR(CheckOptions(options));
  if (options.variant != options_.variant || options.seed != options_.seed) {
    return Error{ErrorCode::kProtocolOrder,
                 "the variant and the seed are chosen when a session is created; leave them out",
                 options.seed != options_.seed ? "options.seed" : "options.variant"};
  }
  LeaveNestedBuild();
  PLIANT_RETURN_IF_ERROR(LetMetricFollow());
  UseOptions(options);
  return {};
}

/// Begins an update by these options, with every node awake if they allow what was refused before.
void Remesher::Impl::UseOptions(const Options& options) {
  const Permissions& was = options_.permissions;
  const Permissions& may = options.permissions;
  const bool allows_more = (may.insert && !was.insert) || (may.swap && !was.swap) ||
                           (may.move && !was.move) || (may.surface && !was.surface) ||
                           (mesh_.vertex_count() >= options_.vertices_max &&
                            options.vertices_max > options_.vertices_max);
  options_ = options;
  loop_.SetOptions(options_);
  followed_.SetTolerance(options_.metric_tolerance);
  loop_.BeginUpdate(SettingsOf(options_));
  if (!allows_more) return;
  for (const VertexId vertex : LiveVertices(mesh_)) loop_.Wake(vertex);
}

/// The limits are laid on the mesh as it is when an update begins, which may be too coarse to
/// know the metric; they are laid again on the mesh that comes out.
Result<Progress> Remesher::Impl::Step(Budget budget) {
  PLIANT_RETURN_IF_ERROR(LetMetricFollow());
  Progress progress;
  PLIANT_ASSIGN_OR_RETURN(progress.stop_reason, RunToRest(budget));
  was_stopped_ = progress.stop_reason == StopReason::kCancelled;
  progress.active_count = nested_ ? nested_->active_count() : loop_.active_count();
  if (was_stopped_) {
    // What the loop leaves bad may not have been looked for yet: the update is not at rest.
    progress.active_count = std::max<std::int64_t>(1, progress.active_count);
  }
  progress.counts = loop_.counts();
  progress.metric = followed_.limits().report();
  // The first commit closes gaps in the numbering.
  if (revision_ == Revision::kNone) progress.metric.worst = VertexId();
  return progress;
}

Result<StopReason> Remesher::Impl::RunToRest(Budget budget) {
  const Status laid = LayDueLimits(budget.stop);
  if (!laid.ok()) return StoppedBy(laid.error());
  for (;;) {
    ChangeInBulk();
    const std::int64_t visits_before = loop_.counts().visits;
    const StopReason reason =
        nested_ ? nested_->Run(budget, helpers_) : loop_.Run(followed_.field(), budget);
    PLIANT_RETURN_IF_ERROR(followed_.status());
    budget.visits_max -= loop_.counts().visits - visits_before;
    if (!Ended(reason)) return reason;
    if (nested_ && nested_->levels_left() > 0) {
      if (nested_->NextLevel(helpers_, budget.stop)) continue;
      return StopReason::kCancelled;
    }
    nested_.reset();
    const Status limited = LimitAgain(budget.stop);
    if (!limited.ok()) return StoppedBy(limited.error());
    if (loop_.active_count() > 0) continue;
    StoppableExecutor executor(helpers_.executor(), budget.stop);
    if (!loop_.Mend(executor)) {
      if (!NeedsLimits() || reason != StopReason::kConverged) return reason;
      followed_.HoldUsualLimits();
      continue;
    }
    if (executor.stopped()) return StopReason::kCancelled;
  }
}

/// Not before a step: until then a request may name vertices of the last revision, and all of them.
void Remesher::Impl::ChangeInBulk() {
  std::vector<VertexId> nodes = std::exchange(rewoken_, {});
  if (revision_ == Revision::kNone || nodes.empty() || nodes.size() > kBulkNodesMax) return;
  loop_.ThinOut(nodes);
  loop_.HalveLongEdges(followed_.field(), std::move(nodes));
}

TroubleContext Remesher::Impl::ContextOfTroubles() const {
  const LoopCounts& counts = loop_.counts();
  return {.insertions_refused = counts.refused_at_limit > 0 || counts.refused_by_allowance > 0,
          .permissions = options_.permissions};
}

TroubleSearch Remesher::Impl::WhereTroublesMayBe() const {
  return {.everywhere = revision_ == Revision::kNone,
          .changed = edit_.log().vertices.ids(),
          .context = ContextOfTroubles()};
}

std::vector<Trouble> Remesher::Impl::FindTroubles(const TroubleSearch& search) const {
  const std::vector<TriangleId> triangles =
      search.everywhere ? LiveTrianglesOf(mesh_) : TrianglesAt(mesh_, search.changed);
  return pliant::FindTroubles(mesh_, triangles, search.context);
}

/// The levels of the first build follow the metric that it began with, in the mesh's records too.
void Remesher::Impl::LeaveNestedBuild() {
  if (nested_) nested_->Finish(helpers_);
  nested_.reset();
}

/// The metric takes over what vertices carried along with them. Put off until someone needs it:
/// a metric that is sent together with a motion makes it superfluous.
Status Remesher::Impl::LetMetricFollow() {
  if (carriers_.empty()) return {};
  const std::vector<VertexId> carriers = std::exchange(carriers_, {});
  std::vector<Metric> tensors;
  tensors.reserve(carriers.size());
  for (const VertexId vertex : carriers) tensors.push_back(mesh_.metric(vertex));
  PLIANT_ASSIGN_OR_RETURN(WantedTensors wanted, followed_.Carry(carriers, tensors));
  if (wanted.vertices.empty()) return {};
  return Apply(std::move(wanted), nullptr);
}

/// The loop has come to rest. Limits the metric on the mesh that it made, as often as that wakes
/// nodes and rounds are left. Nodes that the metric of before kept busy until they were old get
/// their visits back: it is another metric now.
/// @param stop  null: nobody; else kCancelled if it asks to, and limits are due
Status Remesher::Impl::LimitAgain(const StopSignal* stop) {
  if (!followed_.limits_again()) return {};
  const bool may_put_off = followed_.may_put_limits_off();
  Result<WantedTensors> wanted = followed_.Limit(may_put_off ? stop : nullptr);
  if (!wanted.ok()) {
    if (wanted.error().code == ErrorCode::kCancelled) followed_.PutLimitsOff();
    return wanted.error();
  }
  PLIANT_RETURN_IF_ERROR(Apply(*std::move(wanted), nullptr));
  if (loop_.active_count() == 0) followed_.EndRounds();
  return {};
}

/// Lays the limits that a commit put off. @param stop  null: nobody; else kCancelled if it asks to,
/// and nothing has happened
Status Remesher::Impl::LayDueLimits(const StopSignal* stop) {
  if (!followed_.limits_due()) return {};
  PLIANT_ASSIGN_OR_RETURN(WantedTensors wanted, followed_.LayDueLimits(stop));
  PLIANT_RETURN_IF_ERROR(Apply(std::move(wanted), nullptr, Asks::kBeforeChanges, Carries::kNobody));
  if (loop_.active_count() == 0) followed_.EndRounds();
  return {};
}

/// True if the update has come to rest with a metric that it cannot meet, where the usual limits
/// help. Mending tells cheaply that nothing is wrong, as nearly always.
bool Remesher::Impl::NeedsLimits() {
  const std::vector<VertexId> poor = loop_.TakePoor();
  if (poor.empty() || !followed_.awaits_need()) return false;
  return std::ranges::any_of(FindTroubles({.changed = poor, .context = ContextOfTroubles()}),
                             [](const Trouble& trouble) { return LimitsHelp(trouble.kind); });
}

/// Takes over tensors that differ by more than the tolerance, and wakes their nodes. Smaller
/// changes leave the old tensor in place, so that many of them add up and are seen at last.
/// @param stop  null: nobody; else kCancelled if it asks to
Status Remesher::Impl::Apply(WantedTensors wanted, const StopSignal* stop, Asks asks,
                             Carries carries) {
  std::vector<VertexId> disturbed;
  std::int64_t carried_count = 0;
  // Only a mesh at rest, at the beginning of an update: later there is nothing left to carry.
  if (carries == Carries::kFronts && edit_.committed() != Revision::kNone && edit_.log().empty() &&
      options_.variant != Variant::kPaper && options_.permissions == Permissions{}) {
    auto carried = CarryAlong(edit_, followed_.field(), std::move(wanted),
                              {.tolerance = options_.metric_tolerance,
                               .stop = stop,
                               .recalled = followed_.recalled_field()});
    if (!carried) return Stopped();
    wanted = std::move(carried->wanted);
    disturbed = std::move(carried->disturbed);
    carried_count = carried->carried_count;
  }
  StopPoll stopped(carried_count == 0 || asks == Asks::kToTheEnd ? stop : nullptr);
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < wanted.vertices.size(); ++i) {
    if (stopped()) return Stopped();
    if (followed_.Differs(mesh_.metric(wanted.vertices[i]), wanted.tensors[i])) others.push_back(i);
  }
  loop_.BeginUpdate(SettingsOf(options_));
  if (carried_count > 0) {
    followed_.MeshMoved();
    loop_.Follow(PliantLoop::LeftBehind::kByFront);
  }
  std::vector<VertexId> slight;
  std::size_t large_count = 0;
  for (const std::size_t i : others) {
    if (asks == Asks::kToTheEnd && stopped()) return Stopped();
    const double change = RelativeChange(mesh_.metric(wanted.vertices[i]), wanted.tensors[i]);
    edit_.SetMetric(wanted.vertices[i], wanted.tensors[i]);
    loop_.Wake(wanted.vertices[i]);
    if (change > kBulkChangeMin) {
      rewoken_.push_back(wanted.vertices[i]);
      ++large_count;
    } else {
      slight.push_back(wanted.vertices[i]);
    }
  }
  if (loop_.counts().visits == 0 && kSlightPerLarge * large_count <= slight.size()) {
    for (const VertexId vertex : slight) loop_.Drift(vertex);
  }
  for (const VertexId vertex : disturbed) loop_.Wake(vertex);
  return {};
}

}  // namespace pliant
