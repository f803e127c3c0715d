#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/clock.h"
#include "server/engine.h"
#include "server/session.h"

/// Stand-ins for what a session uses, so that its tests decide about time, work and failures.
namespace pliant::server {

/// A clock that moves only when told.
class ManualClock final : public Clock {
 public:
  [[nodiscard]] Time Now() const override { return Time(Duration(ticks_.load())); }
  [[nodiscard]] WallTime WallNow() const override {
    return WallTime(std::chrono::hours(1)) + Duration(ticks_.load());
  }
  void Advance(Duration duration) { ticks_ += duration.count(); }

 private:
  std::atomic<Duration::rep> ticks_ = 0;
};

/// What a FakeEngine does next; shared with the test.
struct FakeEngineScript {
  std::int64_t visits_needed = 10;     ///< Until an advance converges.
  std::int64_t visits_per_update = 5;  ///< That a staged update adds.
  ManualClock* clock = nullptr;        ///< If set, a visit takes a microsecond of it.
  std::optional<Error> create_error = {};
  std::optional<Error> step_error = {};
  std::optional<Error> update_error = {};
  std::function<void()> during_update = {};  ///< Called while an update is staged.
  /// Called while a step runs, before it looks whether it should stop.
  std::function<void()> during_step = {};
  std::function<void()> during_troubles = {};  ///< Called when troubles are looked for.
  double motion_fraction = 1;                  ///< What a motion reaches.
  std::int64_t softened_count = 0;             ///< Of every revision.
  int measurement_part_count = 1;
  std::function<void()> during_measurement = {};  ///< Called in each part of a measurement.
  bool throw_in_step = false;
  bool throw_in_commit = false;
  bool invalid_after_rollback = false;
  int created_count = 0;
  int rollback_count = 0;
  int transfer_count = 0;  ///< Commits with transfer rows.
  std::vector<std::string> calls = {};
};

/// Counts three vertices, in as many parts as the script says.
class FakeMeasurement final : public Measurement {
 public:
  explicit FakeMeasurement(std::shared_ptr<FakeEngineScript> script) : script_(std::move(script)) {}

  bool Continue() override {
    if (script_->during_measurement) script_->during_measurement();
    return ++part_count_ < script_->measurement_part_count;
  }
  Quality Take() override {
    Quality quality;
    quality.vertex_count = 3;
    return quality;
  }

 private:
  std::shared_ptr<FakeEngineScript> script_;
  int part_count_ = 0;
};

/// An engine without a mesh: three vertices, of which vertex 0 moves at each commit that had work.
class FakeEngine final : public Engine {
 public:
  explicit FakeEngine(std::shared_ptr<FakeEngineScript> script)
      : script_(std::move(script)), work_(script_->visits_needed), committed_work_(work_) {}

  Status SetMetric(const MetricSpec& metric) override {
    script_->calls.push_back("metric t=" + std::to_string(static_cast<int>(metric.time)));
    limits_ = {metric.bounds, metric.gradation};
    functions_.reset();
    return Update();
  }
  Status SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                    const TensorTerms& terms) override {
    limits_ = terms.limits;
    if (terms.functions || vertices.empty()) functions_ = terms.functions;
    script_->calls.push_back("tensors " + std::to_string(vertices.size()) + "/" +
                             std::to_string(tensors.size()) + Beside());
    return Update();
  }
  Status SetFunctions(const FunctionsSpec& functions, const MetricLimits& limits) override {
    limits_ = limits;
    functions_ = functions;
    script_->calls.push_back("functions" + Beside());
    return Update();
  }
  const FunctionsSpec* functions() const override { return functions_ ? &*functions_ : nullptr; }
  Status SetLimits(const MetricLimits& limits) override {
    script_->calls.push_back("limits");
    limits_ = limits;
    return Update();
  }
  MetricLimits limits() const override { return limits_; }
  void ListenTo(const StopSignal* stop) override { stop_ = stop; }
  Result<MotionReport> Move(const MotionRequest& request) override {
    script_->calls.push_back("move " + std::to_string(request.vertices.size()) + "/" +
                             std::to_string(request.tags.size()));
    PLIANT_RETURN_IF_ERROR(Update());
    MotionReport report;
    report.fraction = script_->motion_fraction;
    return report;
  }
  Status ReplaceDomain(const Domain& domain) override {
    script_->calls.push_back("domain " + std::to_string(domain.points.size()));
    return Update();
  }
  Status Displace(std::span<const VertexId> vertices, std::span<const Vec2>) override {
    script_->calls.push_back("displace " + std::to_string(vertices.size()));
    return Update();
  }
  Status SetTensorsAhead(const TensorsAhead& request, const TensorTerms& terms) override {
    PLIANT_RETURN_IF_ERROR(Displace(request.displaced, request.by));
    return SetTensors(request.vertices, request.tensors, terms);
  }
  std::vector<VertexId> Vertices() const override {
    return {VertexId(0), VertexId(2), VertexId(3)};
  }
  Status SetSolution(const SolutionRequest& request, const TensorTerms& terms) override {
    limits_ = terms.limits;
    functions_ = terms.functions;
    script_->calls.push_back("solution " + request.name + Beside());
    return Update();
  }
  Status SetFields(const FieldUpdate& update) override {
    script_->calls.push_back("fields " + std::to_string(update.values.size()));
    return Update();
  }
  Status SetConstraints(const Constraints& constraints) override {
    script_->calls.push_back("constraints " + std::to_string(constraints.vertices.size()));
    return Update();
  }
  Status SetOptions(const Options& options) override {
    script_->calls.push_back("options " + std::to_string(options.hops_max));
    return Update();
  }
  Result<Progress> Step(const Budget& budget) override {
    PLIANT_CHECK(!script_->throw_in_step, "test", "step");
    if (script_->step_error) return *script_->step_error;
    Progress progress;
    progress.counts.visits = visits_;
    progress.active_count = work_;
    if (script_->during_step) script_->during_step();
    if (budget.stop != nullptr && budget.stop->asked()) {
      progress.stop_reason = StopReason::kCancelled;
      return progress;
    }
    const std::int64_t now = std::min(budget.visits_max, work_);
    work_ -= now;
    visits_ += now;
    if (script_->clock != nullptr) script_->clock->Advance(std::chrono::microseconds(now));
    progress.counts.visits = visits_;
    progress.active_count = work_;
    progress.stop_reason = work_ == 0 ? StopReason::kConverged : StopReason::kVisitBudget;
    return progress;
  }
  std::int64_t softened_count() const override { return script_->softened_count; }
  TroubleSearch WhereTroublesMayBe() const override {
    return {.changed = std::vector<VertexId>(static_cast<std::size_t>(visits_)), .context = {}};
  }
  std::vector<Trouble> FindTroubles(const TroubleSearch& search) const override {
    if (script_->during_troubles) script_->during_troubles();
    return {{.kind = TroubleKind::kSizeJump, .vertex_count = std::ssize(search.changed)}};
  }
  MeshDiff Commit() override {
    PLIANT_CHECK(!script_->throw_in_commit, "test", "commit");
    MeshDiff diff;
    diff.base_revision = revision_;
    revision_ = Revision(static_cast<std::int64_t>(revision_) + 1);
    diff.revision = revision_;
    if (visits_ > 0) {
      diff.vertex_ids = {VertexId(0)};
      diff.vertex_positions = {{static_cast<double>(diff.revision), 0}};
    }
    diff.summary.vertex_count = 3;
    diff.summary.state_hash = static_cast<std::uint64_t>(diff.revision);
    visits_ = 0;
    committed_work_ = work_;
    committed_limits_ = limits_;
    committed_functions_ = functions_;
    return diff;
  }
  MeshDiff CommitAndTransfer() override {
    ++script_->transfer_count;
    return Commit();
  }
  void Rollback() override {
    ++script_->rollback_count;
    visits_ = 0;
    work_ = committed_work_;
    limits_ = committed_limits_;
    functions_ = committed_functions_;
  }
  MeshDiff Snapshot() const override {
    MeshDiff diff;
    diff.revision = revision_;
    diff.vertex_ids = {VertexId(0), VertexId(2)};
    diff.vertex_positions = {{static_cast<double>(revision_), 0}, {1, 1}};
    diff.summary.vertex_count = 2;
    return diff;
  }
  std::unique_ptr<Measurement> Measure(MetricBasis) const override {
    return std::make_unique<FakeMeasurement>(script_);
  }
  std::vector<std::string> Validate() const override {
    if (script_->invalid_after_rollback) return {"triangle 7 is inverted"};
    return {};
  }
  Revision revision() const override { return revision_; }
  std::int32_t vertex_count() const override { return 3; }

 private:
  /// What stands beside tensors, for the calls.
  [[nodiscard]] std::string Beside() const {
    if (!functions_) return {};
    return " beside " + std::to_string(functions_->parts.size()) + " from " +
           std::to_string(functions_->before_count) +
           " t=" + std::to_string(static_cast<int>(functions_->time));
  }
  Status Update() {
    if (script_->update_error) return *script_->update_error;
    if (script_->during_update) script_->during_update();
    if (stop_ != nullptr && stop_->asked()) return Stopped();
    work_ += script_->visits_per_update;
    return {};
  }

  std::shared_ptr<FakeEngineScript> script_;
  const StopSignal* stop_ = nullptr;
  std::int64_t work_ = 0;
  std::int64_t committed_work_ = 0;
  MetricLimits limits_;
  MetricLimits committed_limits_;
  std::optional<FunctionsSpec> functions_;
  std::optional<FunctionsSpec> committed_functions_;
  std::int64_t visits_ = 0;
  Revision revision_ = Revision::kNone;
};

inline EngineFactory FakeFactory(std::shared_ptr<FakeEngineScript> script) {
  return [script](const EngineInput&) -> Result<std::unique_ptr<Engine>> {
    ++script->created_count;
    if (script->create_error) return *script->create_error;
    return std::unique_ptr<Engine>(std::make_unique<FakeEngine>(script));
  };
}

/// An editor that a test feeds and reads.
class FakeEditor final : public Editor {
 public:
  std::optional<SessionCommand> NextCommand() override {
    if (commands.empty() || !has_room) return std::nullopt;
    SessionCommand command = std::move(commands.front());
    commands.pop_front();
    return command;
  }
  void LookAhead(const std::function<bool(const SessionCommand&)>& look) const override {
    if (!has_room) return;
    for (const SessionCommand& command : commands) {
      if (!look(command)) return;
    }
  }
  void CommandDone() override { ++done_count; }
  [[nodiscard]] bool HasRoom() const override { return has_room; }
  void Send(SessionEvent event) override {
    if (before_send) before_send();
    events.push_back(std::move(event));
  }
  void Close(const Error& error) override { closed = error; }

  /// The events' kinds and ids in order, e.g. "opened", "rejected 3", "diff 4".
  [[nodiscard]] std::vector<std::string> Log() const {
    static const char* const kNames[] = {"opened",   "accepted", "rejected", "progress", "diff",
                                         "snapshot", "advanced", "closing",  "bookmark"};
    std::vector<std::string> log;
    for (const SessionEvent& event : events) {
      log.emplace_back(kNames[event.body.index()]);
      if (event.update_id != 0) log.back().append(" ").append(std::to_string(event.update_id));
    }
    return log;
  }

  std::deque<SessionCommand> commands;
  std::vector<SessionEvent> events;
  std::function<void()> before_send = {};
  std::optional<Error> closed;
  bool has_room = true;
  int done_count = 0;
};

/// A subscriber that a test holds up and reads.
class FakeSubscriber final : public Subscriber {
 public:
  [[nodiscard]] bool ready() const override { return is_ready; }
  [[nodiscard]] bool wants_transfer() const override { return wants_rows; }
  [[nodiscard]] bool wants_mesh() const override { return !is_listener; }
  [[nodiscard]] bool Follows(const MeshDiff&) override { return takes_diffs; }
  void Send(SessionEvent event) override {
    const auto number = [](Revision revision) {
      return std::to_string(static_cast<std::int64_t>(revision));
    };
    if (const auto* diff = std::get_if<DiffEvent>(&event.body)) {
      log.push_back("diff " + number(diff->diff->base_revision) + "-" +
                    number(diff->diff->revision));
    } else if (const auto* snapshot = std::get_if<SnapshotEvent>(&event.body)) {
      log.push_back("snapshot " + number(snapshot->snapshot->revision));
    } else {
      log.push_back("bookmark " + number(event.revision));
    }
  }
  void Close(const Error& error) override { closed = error; }

  std::vector<std::string> log;
  std::optional<Error> closed;
  bool is_ready = true;
  bool wants_rows = false;
  bool is_listener = false;
  bool takes_diffs = true;
};

}  // namespace pliant::server
