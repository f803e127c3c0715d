#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/mesh/mesh_diff.h"
#include "core/metric/metric_spec.h"
#include "core/motion/motion.h"
#include "core/pliant/remesher.h"
#include "server/clock.h"
#include "server/engine.h"

/// What goes into a session and what comes out of it, in core types: a session knows nothing of
/// the wire (convert.h and convert_reply.h do).
namespace pliant::server {

/// When a revision counts as safe. Numbers are part of the store's format.
enum class Durability : std::uint8_t {
  kNone = 1,     ///< Never: the session is in memory only.
  kRelaxed = 2,  ///< Soon after it is told.
  kStrict = 3,   ///< Before it is told.
};

/// A new session, its arrays checked one by one; the engine checks how they fit together.
struct SessionInput {
  std::string session_id = {};                ///< May be empty.
  std::optional<Durability> durability = {};  ///< Absent: the server's default.
  /// Undo data and diffs, in [0, kKeptBytesMax]; absent: as the mesh weighs (kept_bytes.h).
  std::optional<std::int64_t> history_bytes_max = {};
  EngineInput engine = {};
  std::map<std::string, std::string> labels = {};
};

/// What an editor or subscriber wants of the mesh; an editor never kPositions.
enum class Mirror { kFull, kNone, kPositions };

/// First command of an edit stream.
struct OpenCommand {
  Revision mirror_revision = Revision::kNone;  ///< What the client has.
  Mirror mirror = Mirror::kFull;
  bool wants_transfer = false;  ///< Transfer rows with the diffs.
};

/// Tensors at vertices of one revision.
struct VertexTensors {
  Revision revision = Revision::kNone;
  std::optional<std::vector<VertexId>> vertices = {};  ///< Absent: all live ones, ascending.
  std::vector<Metric> tensors = {};
};

/// Solution fields of one revision's elements.
struct FieldsUpdate {
  Revision revision = Revision::kNone;
  FieldUpdate update = {};
};

/// How the metric's features have moved.
struct DisplacementUpdate {
  Revision revision = Revision::kNone;  ///< Whose vertices are named.
  std::vector<VertexId> vertices = {};
  std::vector<Vec2> by = {};
};

/// What changes in the metric; what is absent stays.
struct MetricUpdate {
  std::variant<std::monostate, ExpressionMetric, SizeMetric, BackgroundMetric, IntersectedMetric,
               VertexTensors, SolutionRequest>
      source = {};
  /// Beside tensors or a solution; the time is that of the update.
  std::optional<FunctionsSpec> functions = {};
  std::optional<double> time = {};
  std::optional<double> size_min = {};
  std::optional<double> size_max = {};
  std::optional<double> anisotropy_max = {};
  std::optional<double> gradation = {};
  std::optional<double> rotation = {};
  std::optional<double> geometry = {};
  std::optional<double> gap_element_count = {};
  std::optional<std::int32_t> smoothing_count = {};
  std::optional<bool> automatic = {};
  std::optional<DisplacementUpdate> displacement = {};  ///< Comes before the source.
};

/// What moves.
struct MotionUpdate {
  std::string field = {};                 ///< Of the request: "boundary" or "nodes".
  std::optional<Revision> revision = {};  ///< Whose vertices are named; absent if none are.
  bool names_all = false;                 ///< `positions` are those of all live vertices.
  MotionRequest request = {};
};

/// Another domain.
struct DomainUpdate {
  Domain domain = {};
};

/// Options that change; what is absent stays.
struct OptionsUpdate {
  std::optional<Variant> variant = {};
  std::optional<Smoothing> smoothing = {};
  std::optional<std::uint64_t> seed = {};
  std::optional<double> step = {};
  std::optional<double> speed_threshold = {};
  std::optional<std::int32_t> age_cooling = {};
  std::optional<std::int32_t> age_max = {};
  std::optional<std::int32_t> hops_max = {};
  std::optional<double> metric_tolerance = {};
  std::optional<double> boundary_tolerance = {};
  std::optional<std::int32_t> vertices_max = {};
  std::optional<std::int32_t> visits_per_vertex_max = {};

  [[nodiscard]] Options AppliedTo(Options options) const {
    options.variant = variant.value_or(options.variant);
    options.smoothing = smoothing.value_or(options.smoothing);
    options.seed = seed.value_or(options.seed);
    options.step = step.value_or(options.step);
    options.speed_threshold = speed_threshold.value_or(options.speed_threshold);
    options.age_cooling = age_cooling.value_or(options.age_cooling);
    options.age_max = age_max.value_or(options.age_max);
    options.hops_max = hops_max.value_or(options.hops_max);
    options.metric_tolerance = metric_tolerance.value_or(options.metric_tolerance);
    options.boundary_tolerance = boundary_tolerance.value_or(options.boundary_tolerance);
    options.vertices_max = vertices_max.value_or(options.vertices_max);
    options.visits_per_vertex_max = visits_per_vertex_max.value_or(options.visits_per_vertex_max);
    return options;
  }
};

/// What must be left alone; replaces what had to be before.
struct ConstraintsUpdate {
  std::optional<Revision> revision = {};  ///< Whose elements are named; absent if none are.
  Constraints constraints = {};
};

/// Forgets what is staged.
struct DiscardUpdate {};

/// Goes back to an earlier revision.
struct RollbackUpdate {
  Revision to_revision = Revision::kNone;
};

/// Applies what is staged and runs the loop, so far.
struct AdvanceSpec {
  std::int64_t visits_max = INT64_MAX;
  std::optional<std::chrono::milliseconds> time_max = {};
  std::optional<std::chrono::milliseconds> progress_interval = {};
  std::optional<std::chrono::milliseconds> commit_interval = {};
  std::optional<Clock::Time> arrival = {};  ///< At the server; absent: when its turn comes.
};

/// An update or advance that could not be converted: it comes all the same, so that its refusal
/// keeps its place in the order.
struct BadUpdate {
  Error error;
};
struct BadAdvance {
  Error error;
};

/// Which command a numbered one is. Numbers are those of EditRequest.command, and part of the
/// store's format.
enum class UpdateKind : std::uint8_t {
  kUnknown = 0,  ///< Of an answer that was stored before kinds were.
  kMetric = 4,
  kBoundary = 5,
  kNodes = 6,
  kDomain = 7,
  kFields = 8,
  kConstraints = 9,
  kOptions = 10,
  kRollback = 11,
  kDiscard = 12,
  kAdvance = 13,
};

/// What tells an update that is sent again from another one under the same number.
struct Fingerprint {
  UpdateKind kind = UpdateKind::kUnknown;
  std::uint64_t hash = 0;  ///< Of all that it says; 0: unknown.
  friend bool operator==(const Fingerprint&, const Fingerprint&) = default;
};

/// A numbered command.
struct UpdateCommand {
  std::int64_t update_id = 0;
  std::variant<BadUpdate, BadAdvance, MetricUpdate, MotionUpdate, DomainUpdate, FieldsUpdate,
               OptionsUpdate, ConstraintsUpdate, DiscardUpdate, RollbackUpdate, AdvanceSpec>
      body = {};
  /// As it came, for a session that keeps a journal: what SessionCodec reads.
  Bytes form = {};
  Fingerprint fingerprint = {};
};

/// Whether it is an update that belongs to a step, also one that could not be converted.
[[nodiscard]] inline bool IsStaging(const UpdateCommand& command) {
  return !std::holds_alternative<BadAdvance>(command.body) &&
         !std::holds_alternative<AdvanceSpec>(command.body) &&
         !std::holds_alternative<RollbackUpdate>(command.body) &&
         !std::holds_alternative<DiscardUpdate>(command.body);
}

using SessionCommand = std::variant<OpenCommand, UpdateCommand>;

/// The stream is open.
struct OpenedEvent {
  std::int64_t last_update_id = 0;
  std::int64_t active_count = 0;
  std::int32_t staged_count = 0;
};
/// An update is staged, or on its way there after its advance was answered.
struct AcceptedEvent {
  std::int32_t staged_count = 0;
};
/// An update or advance was refused.
struct RejectedEvent {
  Error error;
};
/// An advance runs.
struct ProgressEvent {
  Progress progress = {};
  std::int32_t vertex_count = 0;
  std::chrono::milliseconds elapsed{0};
};
/// A revision was committed.
struct DiffEvent {
  std::shared_ptr<const MeshDiff> diff = {};  ///< Shared with the history and other readers.
  std::int64_t applied_update_id = 0;
};
/// The whole mesh.
struct SnapshotEvent {
  std::shared_ptr<const MeshDiff> snapshot = {};
  std::int64_t applied_update_id = 0;
};
/// Why an advance ended, where it was not the engine's doing.
/// kStaging: updates before it were still being staged, so it has committed nothing. Numbers are
/// part of the store's format.
enum class AdvanceEnd { kEngine = 0, kTimeBudget = 1, kServerClosing = 2, kStaging = 3 };
/// An advance has ended.
struct AdvancedEvent {
  Revision base_revision = Revision::kNone;
  MeshSummary summary = {};
  Progress progress = {};
  std::vector<Trouble> troubles = {};  // Of a mesh that has come to rest.
  AdvanceEnd end = AdvanceEnd::kEngine;
  std::optional<double> motion_fraction = {};     ///< Absent if nothing was to move.
  std::int64_t softened_count = 0;                ///< Corners, as in SoftenReport.
  std::optional<Revision> durable_revision = {};  ///< Greatest one; absent without a journal.
  std::chrono::microseconds compute{0};
  std::chrono::microseconds elapsed{0};
};
/// The stream will end.
struct ClosingEvent {
  Error error;
};

/// The reader has everything up to the event's revision.
struct BookmarkEvent {};

/// What a session tells its editor or a subscriber.
struct SessionEvent {
  std::int64_t update_id = 0;           ///< What it answers; 0 if nothing.
  Revision revision = Revision::kNone;  ///< Of the session, when it was made.
  std::variant<OpenedEvent, AcceptedEvent, RejectedEvent, ProgressEvent, DiffEvent, SnapshotEvent,
               AdvancedEvent, ClosingEvent, BookmarkEvent>
      body = {};
};

/// Whether updates of this kind are answered so.
[[nodiscard]] inline bool CanAnswer(const SessionEvent& event, UpdateKind kind) {
  const bool commits = kind == UpdateKind::kAdvance || kind == UpdateKind::kRollback;
  if (std::holds_alternative<AcceptedEvent>(event.body)) return !commits;
  return commits || !std::holds_alternative<AdvancedEvent>(event.body);
}

/// The answer to a numbered update, and which update that was.
struct UpdateAnswer {
  SessionEvent event = {};
  Fingerprint update = {};
};

/// A session as lists show it.
struct SessionInfo {
  std::string session_id = {};
  std::map<std::string, std::string> labels = {};
  Revision revision = Revision::kNone;
  std::optional<MeshSummary> summary = {};  ///< Absent before the first commit.
  std::int64_t active_count = 0;
  std::int64_t last_update_id = 0;
  bool running = false;
  bool asleep = false;  ///< Not in memory; wakes on the next call.
  std::vector<std::int64_t> saved_revisions = {};
  std::int64_t memory_bytes = 0;                       ///< Roughly; 0 while it is built.
  std::optional<std::int64_t> history_bytes_max = {};  ///< As SessionInput has it.
  std::chrono::system_clock::time_point create_time = {};
  std::optional<std::chrono::system_clock::time_point> commit_time = {};
};

}  // namespace pliant::server
