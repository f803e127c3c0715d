#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/domain.h"
#include "core/geometry/mesh_data.h"
#include "core/mesh/mesh_diff.h"
#include "core/pliant/metric_report.h"
#include "core/pliant/options.h"
#include "core/pliant/trouble.h"

namespace pliant::client {

/// How to connect, and how long to wait for the server.
struct ConnectOptions {
  /// What the server knows us by; empty: nothing.
  std::string token = {};
  /// PEM text: who signs the server's certificate. Empty: no encryption, for one machine.
  std::string tls_roots = {};
  /// PEM texts: our own certificate and key, where the server wants them.
  std::string tls_cert = {};
  std::string tls_key = {};
  std::chrono::milliseconds connect_timeout{5'000};  ///< For the first answer of the server.
  std::chrono::milliseconds call_timeout{30'000};    ///< For short calls.
  /// For calls that carry or measure a whole mesh. Advances have no timeout of their own: see
  /// AdvanceOptions::time_max.
  std::chrono::milliseconds transfer_timeout{600'000};
  /// How long calls of a Session, and others that do no harm twice, try to take up a lost
  /// connection. 0: not at all.
  std::chrono::milliseconds reconnect_max{60'000};
  /// While a call waits and nothing comes, the server is asked so often whether it is there; one
  /// that has not answered after the timeout counts as lost. A pliantd ends connections that ask
  /// more often than every 10 s. 0: never asked, and a connection that dies silently is waited for.
  std::chrono::milliseconds keepalive_interval{20'000};
  std::chrono::milliseconds keepalive_timeout{10'000};
};

/// What the server says about itself.
struct ServerInfo {
  std::string version;
  std::vector<std::string> capabilities;       ///< Sorted as the server lists them.
  std::map<std::string, std::int64_t> limits;  ///< By the names in server/limits.h.
};

/// Where a session's mesh starts: a polygonal domain, or an existing triangulation.
using Start = std::variant<Domain, MeshData>;

/// What comes with every diff besides the mesh itself.
enum class Parts {
  kMesh,           ///< Nothing.
  kMeshAndMetric,  ///< The metric at vertices where it changed.
  kEverything,     ///< That, values of fields, and transfer rows: see Session::last_change.
};

/// When a revision of a session is on the server's disk: never, soon, or before it is acknowledged.
enum class Durability { kNone, kRelaxed, kStrict };

/// How a session is created.
struct SessionSettings {
  Options options;
  std::string session_id;                     ///< Wished id; empty: the server makes one.
  std::map<std::string, std::string> labels;  ///< Free text, at most 16 pairs.
  Parts parts = Parts::kMesh;
  /// Absent: strict where the server has a store. Anything but kNone fails with kUnimplemented
  /// where it has none.
  std::optional<Durability> durability = {};
  /// How much of earlier revisions the server keeps, in bytes: four fifths for ways back, the rest
  /// for diffs. 0 to ServerInfo::limits "history_bytes"; absent: about six times the mesh.
  std::optional<std::int64_t> history_bytes_max = {};
};

enum class SessionState { kIdle, kRunning, kAsleep };

/// A session in short.
struct SessionInfo {
  std::string session_id;
  Revision revision = Revision::kNone;
  SessionState state = SessionState::kIdle;
  MeshSummary summary;  ///< All 0 before the first commit.
  std::int64_t active_count = 0;
  std::int64_t last_update_id = 0;
  std::chrono::system_clock::time_point create_time;
  std::chrono::system_clock::time_point commit_time;
  std::map<std::string, std::string> labels;
  std::int64_t memory_bytes = 0;
  std::optional<std::int64_t> history_bytes_max = {};  ///< As SessionSettings has it.
};

/// How far one advance may go. Without limits it runs until converged.
struct AdvanceOptions {
  std::optional<std::int64_t> visits_max = {};  ///< > 0.
  /// > 0; from when the server has the advance, so also for what is staged and sent with it
  /// (AdvanceStop::kStaging). Where that is staged, a first step is made in any case.
  std::optional<std::chrono::milliseconds> time_max = {};
  std::chrono::milliseconds progress_interval{100};  ///< >= 10 ms; only with a callback.
  /// Commits an unfinished revision this often, >= 10 ms, so that replica and subscribers follow
  /// while the loop runs; less often if they do not keep up. Absent: one revision, at the end.
  std::optional<std::chrono::milliseconds> commit_interval = {};
};

/// How a running advance is doing.
struct AdvanceProgress {
  std::int64_t active_count = 0;  ///< Vertices that still wait for a visit.
  std::int64_t visits = 0;
  std::int64_t vertex_count = 0;
  std::chrono::milliseconds elapsed{0};
};

/// Why an advance ended. After all but kConverged, kVertexLimit and kVisitLimit another advance
/// goes on where it stopped.
enum class AdvanceStop {
  kConverged,    ///< No vertex is active.
  kVisitBudget,  ///< AdvanceOptions::visits_max.
  kTimeBudget,   ///< AdvanceOptions::time_max.
  kCancelled,    ///< Session::Cancel.
  kVertexLimit,  ///< Ended, but insertions were refused at Options::vertices_max.
  kVisitLimit,   ///< Variant::kPaper: Options::visits_per_vertex_max.
  /// The server shuts down, and did not come back in time; or the advance had limits.
  kServerClosing,
  /// AdvanceOptions::time_max or Session::Cancel, while updates sent with it were still being
  /// staged: nothing is committed, and staging goes on. The next advance commits them.
  kStaging,
};

/// What an advance did.
struct AdvanceReport {
  Revision base_revision = Revision::kNone;
  Revision revision = Revision::kNone;  ///< Greater, but for kStaging.
  AdvanceStop stop = AdvanceStop::kConverged;
  std::int64_t active_count = 0;
  MeshSummary summary;  ///< Of the mesh at `revision`.
  std::int64_t visits = 0;
  std::int64_t moves = 0;
  std::int64_t insertions = 0;
  std::int64_t deletions = 0;
  std::int64_t swaps = 0;
  /// Vertices that came to rest by their age alone: spots where the metric cannot be met.
  std::int64_t cooled_count = 0;
  /// Corners that Options::boundary_tolerance let go: they are vertices of a side now, or gone.
  std::int64_t softened_count = 0;
  /// Share of the motion that was done, 0 to 1; absent if nothing was to move.
  std::optional<double> motion_fraction = {};
  /// Greatest revision on the server's disk; absent if the session is kept in memory only.
  std::optional<Revision> durable_revision = {};
  /// Where the metric is not met, among what changed; empty while vertices are active.
  std::vector<Trouble> troubles = {};
  /// What limits made of the metric; `changed_count` stays on the server.
  MetricReport metric = {};
  std::chrono::microseconds compute_time{0};  ///< Of loop and commit in the core, without staging.
  std::chrono::microseconds elapsed_time{0};  ///< From receipt to answer, on the server.
};

}  // namespace pliant::client
