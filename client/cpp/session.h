#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>

#include "client/cpp/mesh_replica.h"
#include "client/cpp/types.h"
#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/metric/metric_spec.h"
#include "core/pliant/quality.h"

namespace pliant::client {

/// The one editor of a session: stages updates, advances the mesh and keeps a replica of it.
///
/// Every function waits for the server's answer. A refused update leaves mesh and stream as they
/// were, but the next Advance is refused too (kUpdateRejected), which empties the stage; Discard
/// empties it at once. So half of a step is never committed.
///
/// When the connection breaks, functions fail with kUnavailable; Reopen goes on from the replica's
/// revision. The session lives on the server until Client::DeleteSession; destroying this object
/// only closes the stream.
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

  /// Stages another metric, which replaces all of the last one. Errors: those of MakeMetricField.
  Status UpdateMetric(const MetricSpec& metric);

  /// Stages tensors at vertices of the replica's revision; the others keep theirs. An empty
  /// `vertices` means all live vertices in ascending order of slot. Errors: kArrayLength,
  /// kIndexOutOfRange, kDuplicateId, kNotFinite, kNotPositiveDefinite (index = row),
  /// kRevisionMismatch.
  Status UpdateTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors);

  /// Empties the stage.
  Status Discard();

  /// Commits what is staged and runs the loop; the replica follows. Always commits one revision,
  /// also after a budget or a cancel.
  ///
  /// @param on_progress  called on this thread every AdvanceOptions::progress_interval; may call
  ///                     Cancel. Empty: no progress is asked for.
  /// Errors: kUpdateRejected, kExpressionValue, kReplicaMismatch (Resync is the way out), and
  /// those of the connection.
  Result<AdvanceReport> Advance(
      const AdvanceOptions& options = {},
      const std::function<void(const AdvanceProgress&)>& on_progress = {});

  /// Ends a running Advance early; its valid mesh is committed and Advance returns. From any
  /// thread; without a running advance nothing happens.
  void Cancel();

  /// Opens the stream again, at the replica's revision: after a lost connection. Answers that were
  /// on their way are lost, so updates that had no answer must be made again. Fails with
  /// kSessionBusy if another editor has the session.
  Status Reopen();

  /// Throws the replica away and gets a snapshot.
  Status Resync();

  /// The mesh as the server has it now; independent of replica(), which should be the same.
  Result<MeshReplica> GetMesh();
  /// Measures the mesh against the metric that it follows, on the server.
  Result<Quality> GetQuality();

 private:
  friend class Client;
  class Impl;
  explicit Session(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace pliant::client
