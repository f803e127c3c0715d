#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "client/cpp/mesh_replica.h"
#include "client/cpp/types.h"
#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/mesh/mesh_diff.h"
#include "core/metric/metric_functions.h"
#include "core/metric/metric_spec.h"
#include "core/motion/motion.h"
#include "core/pliant/frozen.h"
#include "core/pliant/quality.h"
#include "core/pliant/tensors_ahead.h"
#include "core/transfer/field_set.h"

namespace pliant::client {

/// When a client hears what the server says to an update.
enum class Answers {
  /// Every function waits for the answer to it.
  kAtOnce,
  /// Updates are only sent, so that a step costs one round trip and not one for each update. The
  /// next Advance returns the first refusal, if there was any; then it has committed nothing and
  /// the stage is empty.
  kWithAdvance,
};

/// The one editor of a session: stages updates, advances the mesh and keeps a replica of it.
///
/// Every function waits for the server's answer, unless SetAnswers lets updates go ahead. A refused
/// update leaves mesh and stream as they were, but the next Advance is refused too
/// (kUpdateRejected), which empties the stage; Discard empties it at once. So half of a step is
/// never committed.
///
/// When the connection breaks, also because the server is started anew, a call makes it again, with
/// pauses that grow and are spread at random, and repeats its command, which the server does not
/// apply twice. Where that fails for ConnectOptions::reconnect_max it ends with kUnavailable, and
/// Reopen, which tries as long, goes on from the replica's revision. What the server has lost
/// meanwhile of the stage is told by kUpdateRejected. The session lives on the server until
/// Client::DeleteSession; destroying this object only closes the stream.
///
/// *Invariants*: replica() holds the mesh of replica().revision(), bit for bit.
/// *Threads*: one at a time, but for Cancel.
class Session {
 public:
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  [[nodiscard]] const std::string& id() const;
  [[nodiscard]] const MeshReplica& replica() const;

  /// From the next update on; at first kAtOnce. With kWithAdvance, what is sent is kept until it is
  /// answered; a connection that breaks is made again as ever, and where that fails, Reopen empties
  /// the stage: the step has to be sent anew, from its first update on.
  void SetAnswers(Answers answers);

  /// Stages another metric, which replaces all of the last one. Errors: those of MakeMetricField.
  Status UpdateMetric(const MetricSpec& metric);

  /// Stages tensors at vertices of the replica's revision; the others keep theirs. An empty
  /// `vertices` means all live vertices in ascending order of slot, and ends functions beside the
  /// tensors, which else stay. Errors: kArrayLength,
  /// kIndexOutOfRange, kDuplicateId, kNotFinite, kNotPositiveDefinite (index = row),
  /// kRevisionMismatch; kOutOfRange for limits.
  /// @param limits  of these tensors and of those that vertices have, from now on; absent: as
  /// before
  Status UpdateTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                       const std::optional<MetricLimits>& limits = std::nullopt);

  /// The same, intersected with functions of place from now on: see VertexMetric of the protocol.
  /// Errors: also those of MakeMetricField for each function.
  Status UpdateTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                       const FunctionsSpec& functions,
                       const std::optional<MetricLimits>& limits = std::nullopt);
  /// The same with a displacement, as in Displace: row i is the tensor at the place of vertex i in
  /// the replica plus its displacement. Errors: also those of Displace.
  /// @param functions  as above; null: as without
  Status UpdateTensors(const TensorsAhead& ahead, const FunctionsSpec* functions = nullptr,
                       const std::optional<MetricLimits>& limits = std::nullopt);
  /// Stages other functions, or another time of theirs, for the tensors that vertices have.
  Status UpdateFunctions(const FunctionsSpec& functions,
                         const std::optional<MetricLimits>& limits = std::nullopt);

  /// Stages other limits of the same metric, whatever it comes from. What bounds have cut off
  /// tensors at vertices is lost. Errors: kOutOfRange.
  Status UpdateLimits(const MetricLimits& limits);

  /// Stages where the metric's features have moved: vertices of the replica's revision go along,
  /// and so does their metric, unless UpdateMetric follows; for tensors, UpdateTensors takes both.
  /// A help and no order; see MetricDisplacement of the protocol. Errors: kArrayLength,
  /// kIndexOutOfRange, kDuplicateId, kNotFinite (index = row), kRevisionMismatch.
  Status Displace(std::span<const VertexId> vertices, std::span<const Vec2> by);

  /// Stages another domain; whatever both have in common keeps its ids. Errors: those of
  /// ReplaceDomain.
  Status ReplaceDomain(const Domain& domain);

  /// Stages a motion of boundaries; vertices are those of the replica's revision. Errors: those of
  /// MoveVertices, kFrozen.
  Status MoveBoundary(const MotionRequest& motion);
  /// Stages new positions of any vertices; an empty `vertices` means all live ones. Errors: as
  /// MoveBoundary.
  Status MoveNodes(std::span<const VertexId> vertices, std::span<const Vec2> positions,
                   ImpossibleMotion on_impossible = ImpossibleMotion::kRefuse);

  /// Stages values of fields that live on the server, at elements of the replica's revision, or
  /// drops fields. Errors: those of FieldSet::Stage.
  Status SetFields(const FieldUpdate& fields);

  /// Stages what must be left alone from now on, in place of what had to be before; {} lifts all.
  /// Errors: kIndexOutOfRange, kDuplicateId.
  Status Freeze(const Constraints& constraints);

  /// Stages other options. The seed, the variant and the permissions of `options` count for
  /// nothing: the first two stay, the last are Freeze's. Errors: kOutOfRange.
  Status SetOptions(const Options& options);

  /// Empties the stage.
  Status Discard();

  /// Commits what is staged and runs the loop; the replica follows. Always commits one revision,
  /// also after a budget or a cancel; more of them with AdvanceOptions::commit_interval. One
  /// without a limit that a server has ended which shuts down goes on when there is a server again,
  /// within ConnectOptions::reconnect_max; the report is that of all its parts.
  ///
  /// @param on_progress  called on this thread every AdvanceOptions::progress_interval. Empty: no
  ///                     progress is asked for.
  /// @param on_change    called on this thread with every diff, or snapshot, that has come, the
  ///                     last included; the replica has followed it.
  /// Both may look at the session and Cancel; what changes it is refused there: kProtocolOrder.
  /// Neither may throw.
  /// Errors: kUpdateRejected, kExpressionValue, kReplicaMismatch (Resync is the way out), and
  /// those of the connection.
  Result<AdvanceReport> Advance(const AdvanceOptions& options = {},
                                const std::function<void(const AdvanceProgress&)>& on_progress = {},
                                const std::function<void(const MeshDiff&)>& on_change = {});

  /// Ends a running Advance early; its valid mesh is committed, unless its updates are still being
  /// staged (AdvanceStop::kStaging), and Advance returns. While that
  /// waits for a lost server it ends with kUnavailable. From any thread; without a running advance
  /// nothing happens.
  void Cancel();

  /// Opens the stream again, at the replica's revision: after a lost connection. Answers that were
  /// on their way are lost, so updates that had no answer must be made again. Fails with
  /// kSessionBusy if another editor has the session; with kUpdateRejected if it is open again but
  /// not what was staged: then the stage is empty.
  Status Reopen();

  /// Throws the replica away and gets a snapshot.
  Status Resync();

  /// Goes back to an earlier revision, bit for bit; the replica follows. Nothing may be staged.
  /// Errors: kRevisionNotFound, whose message names the oldest that is kept; kProtocolOrder.
  Result<AdvanceReport> Rollback(Revision to_revision);
  /// Keeps a revision, kNone: the current one, until Release. Errors: kRevisionNotFound,
  /// kResourceExhausted.
  Result<Revision> SaveRevision(Revision revision = Revision::kNone);
  /// Errors: kRevisionNotFound.
  Status Release(std::span<const Revision> revisions);
  /// A second session from a kept revision, kNone: the current one; its id, for
  /// Client::OpenSession. Errors: kRevisionNotFound, kSessionExists, kResourceExhausted.
  Result<std::string> Fork(Revision revision = Revision::kNone, const std::string& wished_id = {});

  /// The diff, or snapshot, by which replica() came to its revision, with what Parts asks for.
  [[nodiscard]] const MeshDiff& last_change() const;

  /// The mesh as the server has it now; independent of replica(), which should be the same.
  Result<MeshReplica> GetMesh();
  /// Measures the mesh against the metric that it follows, on the server.
  Result<Quality> GetQuality();

  /// For Client and for the simulation; see session_impl.h.
  class Impl;
  explicit Session(std::unique_ptr<Impl> impl);

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace pliant::client
