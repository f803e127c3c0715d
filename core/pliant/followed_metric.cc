#include "core/pliant/followed_metric.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "core/mesh/linked_triangles.h"
#include "core/pliant/ask.h"
#include "core/pliant/nodal_field.h"

namespace pliant {
namespace {

/// From one vertex in so many on, tensors are followed as a copy of the whole mesh, which answers
/// faster than a mesh that is changing.
constexpr std::ptrdiff_t kCopyShare = 8;

/// Of tensors of which fewer than one in so many are others than those followed, only these are
/// followed: a copy of the whole mesh would take longer than all else.
constexpr std::ptrdiff_t kFewShare = 32;

/// From one vertex in so many on, limiting everything anew is cheaper than following the changes;
/// the result is the same.
constexpr std::size_t kReloadShare = 6;

}  // namespace

std::vector<VertexId> LiveVertices(const Mesh& mesh) {
  std::vector<VertexId> vertices;
  vertices.reserve(static_cast<std::size_t>(mesh.vertex_count()));
  for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
    if (mesh.vertex(VertexId(v)).live) vertices.emplace_back(v);
  }
  return vertices;
}

std::optional<FollowedMetric::Way> FollowedMetric::WayBack() const {
  const bool lays = state_.keeps_raw() && !state_.limits_due;
  if (!limits_.as_committed() || limits_.on() != lays) return std::nullopt;
  return Way{state_, field_, base_};
}

void FollowedMetric::GoBack(Way way) {
  if (!limits_.as_committed()) limits_.Rollback();
  state_ = std::move(way.state);
  field_ = std::move(way.field);
  base_ = std::move(way.base);
}

Result<WantedTensors> FollowedMetric::Evaluate(const MetricField& field, const StopSignal* stop) {
  WantedTensors wanted{LiveVertices(mesh_), {}};
  PLIANT_ASSIGN_OR_RETURN(wanted.tensors, Ask(field, wanted.vertices, stop));
  PLIANT_RETURN_IF_ERROR(field.status());
  return wanted;
}

Result<std::vector<Metric>> FollowedMetric::Ask(const MetricField& field,
                                                std::span<const VertexId> vertices,
                                                const StopSignal* stop) {
  std::vector<Metric> tensors(vertices.size());
  for (std::size_t begin = 0; begin < vertices.size(); begin += StopPoll::kPeriod) {
    if (stop != nullptr && stop->asked()) return Stopped();
    const std::size_t count = std::min<std::size_t>(StopPoll::kPeriod, vertices.size() - begin);
    AskAt(edit_, field, vertices.subspan(begin, count), std::span(tensors).subspan(begin, count));
  }
  return tensors;
}

void FollowedMetric::Take(std::shared_ptr<MetricField> field, const MetricSpec* spec) {
  TakeLimits(spec == nullptr ? MetricLimits{.gradation = {.automatic = false}}
                             : MetricLimits{spec->bounds, spec->gradation});
  state_.source = std::move(field);
  state_.functions = nullptr;
  state_.spec.reset();
  if (spec != nullptr && IsFormula(*spec)) state_.spec = *spec;
  field_ = state_.source;
}

void FollowedMetric::TakeLimits(const MetricLimits& limits) {
  state_.bounds = limits.bounds;
  // What was needed once holds on: limits that come and go with every metric help nobody.
  state_.usual_hold = state_.usual_hold && limits.gradation.awaits_need();
  state_.limits_due = false;
  state_.limits = state_.usual_hold ? limits.gradation.WithUsual() : limits.gradation;
}

MetricLimits FollowedMetric::asked_limits() const {
  MetricLimits asked{state_.bounds, state_.limits};
  if (state_.usual_hold) asked.gradation.gradation = asked.gradation.rotation = 0;
  return asked;
}

void FollowedMetric::Follow(std::shared_ptr<MetricField> field, const MetricSpec* spec) {
  Take(std::move(field), spec);
  limits_.TurnOff();
  state_.limit_rounds_left = state_.limits.any() ? kLimitRounds : 0;
}

Result<WantedTensors> FollowedMetric::SetField(std::shared_ptr<MetricField> field,
                                               const MetricSpec* spec, WantedTensors raw,
                                               const StopSignal* stop) {
  const bool keeps_raw = limits_.on() && limits_.functions() == nullptr;
  const GradationOptions old_limits = state_.limits;
  Take(std::move(field), spec);
  state_.limit_rounds_left = state_.limits.any() ? kLimitRounds : 0;
  if (!state_.limits.any()) {
    limits_.TurnOff();
    return raw;
  }
  if (!committed()) return Limit();
  --state_.limit_rounds_left;
  std::vector<std::size_t> others;
  StopPoll stopped(stop);
  if (keeps_raw && old_limits == state_.limits) {
    PLIANT_RETURN_IF_ERROR(limits_.Follow(*base_, *state_.source, stop));
    for (std::size_t i = 0; i < raw.vertices.size(); ++i) {
      if (stopped()) return Stopped();
      if (limits_.Raw(raw.vertices[i]) != raw.tensors[i]) others.push_back(i);
    }
    if (kReloadShare * others.size() <= raw.vertices.size()) {
      for (const std::size_t i : others) limits_.SetRaw(raw.vertices[i], raw.tensors[i]);
      return LayLimits(stop);
    }
  }
  PLIANT_RETURN_IF_ERROR(limits_.Load(state_.limits, raw.vertices, raw.tensors, stop));
  return LayLimits(stop);
}

Result<WantedTensors> FollowedMetric::SetTensors(std::span<const VertexId> vertices,
                                                 std::span<const Metric> tensors,
                                                 const StopSignal* stop) {
  const bool has_raw = limits_.on() && committed();
  StopPoll stopped(stop);
  if (has_raw) PLIANT_RETURN_IF_ERROR(limits_.Follow(*base_, *RawOfVertices(), stop));
  std::vector<Metric> bounded;
  bounded.reserve(tensors.size());
  WantedTensors others;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (stopped()) return Stopped();
    const Metric& old = has_raw ? limits_.Raw(vertices[i]) : mesh_.metric(vertices[i]);
    bounded.push_back(Bound(tensors[i], state_.bounds));
    if (!Differs(old, bounded.back())) continue;
    others.vertices.push_back(vertices[i]);
    others.tensors.push_back(bounded.back());
  }
  if (has_raw) {
    return others.vertices.empty() ? LayLimits(stop) : LimitTensors(vertices, bounded, stop);
  }
  if (others.vertices.empty() && !state_.limits.any()) return WantedTensors{};
  WantedTensors given{{vertices.begin(), vertices.end()}, std::move(bounded)};
  // Where little has changed, those within the tolerance stay, as they do in the mesh.
  if (committed() && kFewShare * std::ssize(others.vertices) <= std::ssize(given.vertices)) {
    given = std::move(others);
  }
  PLIANT_ASSIGN_OR_RETURN(WantedTensors wanted, FollowTensors(std::move(given), stop));
  if (!state_.limits.any()) return wanted;
  state_.limit_rounds_left = kLimitRounds;
  return Limit();
}

/// Vertices want other tensors. Those within the tolerance stay, so that many small changes add up
/// and are seen at last. @pre the limits know the mesh as it is
Result<WantedTensors> FollowedMetric::LimitTensors(std::span<const VertexId> vertices,
                                                   const std::vector<Metric>& tensors,
                                                   const StopSignal* stop) {
  StopPoll stopped(stop);
  WantedTensors others;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (stopped()) return Stopped();
    if (!Differs(limits_.Raw(vertices[i]), tensors[i])) continue;
    others.vertices.push_back(vertices[i]);
    others.tensors.push_back(tensors[i]);
  }
  PLIANT_RETURN_IF_ERROR(limits_.SetRawOf(others, stop));
  state_.source = nullptr;
  state_.spec.reset();
  state_.limit_rounds_left = state_.limits.any() ? kLimitRounds - 1 : 0;
  return LayLimits(stop);
}

/// Tensors at some vertices, and at the others what they have.
Result<WantedTensors> FollowedMetric::FollowTensors(WantedTensors wanted, const StopSignal* stop) {
  if (committed()) {
    if (stop != nullptr && stop->asked()) return Stopped();
    std::unique_ptr<BackgroundField> copy;
    if (WantsCopy(wanted)) {
      copy = CopyWith(wanted, stop);
      if (copy == nullptr) return Stopped();
    }
    state_.spec.reset();
    state_.source = nullptr;
    base_ = std::make_shared<FrozenMesh>(edit_);
    if (copy != nullptr) {
      recalled_ = std::make_shared<RecalledField>(std::move(copy), base_);
      field_ = recalled_;
    } else {
      PLIANT_RETURN_IF_ERROR(FollowMesh(wanted, stop));
    }
    return wanted;
  }
  state_.spec.reset();
  // Before the first commit nothing is logged: a copy, as a background mesh.
  WantedTensors sent = Evaluate(*state_.source).value();
  const auto row = [&](VertexId vertex) {
    return std::ranges::lower_bound(sent.vertices, vertex) - sent.vertices.begin();
  };
  for (std::size_t i = 0; i < wanted.vertices.size(); ++i) {
    sent.tensors[static_cast<std::size_t>(row(wanted.vertices[i]))] = wanted.tensors[i];
  }
  state_.source = CopyOf(sent.tensors, nullptr);
  field_ = state_.source;
  return wanted;
}

/// True if so many tensors are better followed as a copy.
bool FollowedMetric::WantsCopy(const WantedTensors& others) const {
  return kCopyShare * std::ssize(others.vertices) > mesh_.vertex_count();
}

/// From now on the field is that of the mesh's tensors as they are, and of others at some vertices.
Status FollowedMetric::FollowMesh(const WantedTensors& others, const StopSignal* stop) {
  if (WantsCopy(others)) {
    field_ = CopyWith(others, stop);
    if (field_ == nullptr) return Stopped();
    return {};
  }
  for (std::size_t i = 0; i < others.vertices.size(); ++i) {
    base_->SetMetric(others.vertices[i], others.tensors[i]);
  }
  field_ = std::make_shared<NodalField>(base_);
  return {};
}

/// The tensors of all vertices as a background mesh; null if it was stopped. @par Cost O(mesh)
std::unique_ptr<BackgroundField> FollowedMetric::CopyWith(const WantedTensors& others,
                                                          const StopSignal* stop) const {
  // Mostly they are all vertices, as in LiveVertices.
  if (std::ssize(others.vertices) == mesh_.vertex_count() &&
      std::ranges::is_sorted(others.vertices)) {
    return CopyOf(others.tensors, stop);
  }
  std::vector<std::size_t> row_of(static_cast<std::size_t>(mesh_.vertex_slots()));
  std::vector<Metric> tensors;
  tensors.reserve(static_cast<std::size_t>(mesh_.vertex_count()));
  StopPoll stopped(stop);
  for (std::int32_t v = 0; v < mesh_.vertex_slots(); ++v) {
    if (stopped()) return nullptr;
    const VertexRecord& record = mesh_.vertex(VertexId(v));
    if (!record.live) continue;
    row_of[static_cast<std::size_t>(v)] = tensors.size();
    tensors.push_back(record.metric);
  }
  for (std::size_t i = 0; i < others.vertices.size(); ++i) {
    if (stopped()) return nullptr;
    tensors[row_of[others.vertices[i].index()]] = others.tensors[i];
  }
  return CopyOf(tensors, stop);
}

/// The mesh as a background mesh with these tensors. The mesh is valid, and so are they. Hints
/// become those of the copy, which numbers triangles in order of slot: the first question of every
/// vertex would else walk there from anywhere. Null if it was stopped.
std::unique_ptr<BackgroundField> FollowedMetric::CopyOf(std::span<const Metric> tensors,
                                                        const StopSignal* stop) const {
  MeshTriangles triangles = LinkTriangles(mesh_, stop);
  if (stop != nullptr && stop->asked()) return nullptr;
  std::unique_ptr<BackgroundField> copy =
      BackgroundField::OfValid(std::move(triangles.linked), tensors, stop);
  if (copy == nullptr) return nullptr;
  StopPoll stopped(stop);
  for (std::int32_t v = 0; v < mesh_.vertex_slots(); ++v) {
    if (stopped()) return nullptr;
    const VertexRecord& record = mesh_.vertex(VertexId(v));
    if (record.live) edit_.Hint(VertexId(v)) = triangles.rank_of[record.triangle.index()];
  }
  return copy;
}

Result<WantedTensors> FollowedMetric::Limit(const StopSignal* stop) {
  --state_.limit_rounds_left;
  const bool follows = limits_.on() && limits_.options() == state_.limits;
  if (!follows || !committed()) return LimitAnew(stop);
  PLIANT_RETURN_IF_ERROR(limits_.Follow(*base_, *RawOfVertices(), stop));
  PLIANT_RETURN_IF_ERROR(status());
  return LayLimits(stop);
}

void FollowedMetric::PutLimitsOff() {
  PLIANT_CHECK(may_put_limits_off());
  limits_.TurnOff();
  state_.limits_due = true;
}

Result<WantedTensors> FollowedMetric::LayDueLimits(const StopSignal* stop) {
  PLIANT_CHECK(limits_due());
  state_.limits_due = false;
  Result<WantedTensors> wanted = LimitAnew(stop);
  if (!wanted.ok()) PutLimitsOff();
  return wanted;
}

void FollowedMetric::HoldUsualLimits() {
  PLIANT_CHECK(awaits_need());
  state_.limits = state_.limits.WithUsual();
  state_.usual_hold = true;
  state_.limit_rounds_left = kLimitRounds;
}

/// Lays limits on the whole mesh.
Result<WantedTensors> FollowedMetric::LimitAnew(const StopSignal* stop) {
  PLIANT_RETURN_IF_ERROR(LoadLimits(stop));
  return LayLimits(stop);
}

Status FollowedMetric::LoadLimits(const StopSignal* stop) {
  PLIANT_ASSIGN_OR_RETURN(const WantedTensors raw, Evaluate(*RawOfVertices(), stop));
  const MeshLimits::Rules rules{state_.limits, state_.functions};
  return limits_.Load(rules, raw.vertices, raw.tensors, stop);
}

/// Lays the limits that the limiter has been told of.
Result<WantedTensors> FollowedMetric::LayLimits(const StopSignal* stop) {
  PLIANT_ASSIGN_OR_RETURN(WantedTensors wanted, limits_.Update(stop));
  if (committed()) base_ = std::make_shared<FrozenMesh>(edit_);
  if (as_sent()) {
    field_ = state_.source;
  } else if (as_met()) {
    field_ = MetField();
  } else if (committed()) {
    PLIANT_RETURN_IF_ERROR(FollowMesh(wanted, stop));
  } else {
    field_ = CopyWith(wanted, nullptr);
  }
  return wanted;
}

Result<WantedTensors> FollowedMetric::Settle() {
  if (!state_.keeps_raw() || state_.limits_due) return WantedTensors{};
  if (committed()) {
    PLIANT_RETURN_IF_ERROR(limits_.Follow(*base_, *RawOfVertices()));
    PLIANT_RETURN_IF_ERROR(status());
  } else {
    PLIANT_RETURN_IF_ERROR(LoadLimits(nullptr));
  }
  return limits_.Update();
}

RawTensors FollowedMetric::AfterCommit() {
  RawTensors undo = limits_.Commit();
  FollowCommitted();
  return undo;
}

/// The mesh of the commit becomes what the metric lives on.
void FollowedMetric::FollowCommitted() {
  base_ = std::make_shared<FrozenMesh>(edit_);
  if (as_sent()) {
    field_ = state_.source;
  } else if (as_met()) {
    field_ = MetField();
  } else {
    field_ = std::make_shared<NodalField>(base_);
  }
}

void FollowedMetric::BeforeTrial() {
  if (base_ != nullptr) base_->CatchUp();
}

void FollowedMetric::AfterTrial() {
  if (base_ != nullptr) base_->LogWasEmptied();
}

void FollowedMetric::MeshMoved() {
  if (limits_.on() && state_.limits.any()) state_.limit_rounds_left = kLimitRounds - 1;
}

void FollowedMetric::Rollback(const State& committed) {
  state_ = committed;
  limits_.Rollback();
  FollowCommitted();
}

RawTensors FollowedMetric::GoTo(const State& state, const RawTensors& raw,
                                std::span<const VertexId> touched) {
  const bool follows = limits_.on() && state.limits == state_.limits &&
                       MetricFunctions::AreSame(state.functions.get(), limits_.functions()) &&
                       !raw.all;
  state_ = state;
  if (!state_.keeps_raw() || state_.limits_due) {
    limits_.TurnOff();
  } else {
    if (follows) {
      limits_.ShareFunctions(state_.functions);
      limits_.Apply(raw, touched);
    } else {
      const MeshLimits::Rules rules{state_.limits, state_.functions};
      PLIANT_CHECK(limits_.Load(rules, raw.vertices, raw.tensors, nullptr).ok());
    }
    PLIANT_CHECK(limits_.Update().ok());
  }
  return AfterCommit();
}

/// Functions and raw tensors. @pre there are functions, and limits were laid on `base_`
std::shared_ptr<MetricField> FollowedMetric::MetField() const {
  return state_.functions->Over(limits_.RawField(base_));
}

std::shared_ptr<const MetricField> FollowedMetric::RawField() const {
  return state_.functions != nullptr ? MetField() : RawOfVertices();
}

/// The same without functions.
std::shared_ptr<const MetricField> FollowedMetric::RawOfVertices() const {
  if (state_.source != nullptr) return state_.source;
  if (!limits_.on()) return field_;
  return limits_.RawField(base_);
}

}  // namespace pliant
