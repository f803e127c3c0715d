#pragma once

#include <functional>
#include <string>

#include "client/cpp/client.h"
#include "client/cpp/mesh_replica.h"
#include "client/cpp/types.h"
#include "core/base/result.h"
#include "core/metric/metric_spec.h"
#include "core/pliant/options.h"
#include "core/pliant/quality.h"

namespace pliant::cli {

/// One mesh to be made.
struct RemeshJob {
  client::Start start;
  MetricSpec metric;
  Options options;
  client::AdvanceOptions advance;
  /// Threads for a large mesh in this process; 0: one for each core. No bit depends on it.
  int thread_count = 0;
};

/// The mesh, its metric at the vertices, and how it went.
struct RemeshResult {
  client::CompactMesh mesh;
  client::AdvanceReport report;
  Quality quality;
};

enum class Proceed { kGoOn, kCancel };
/// Called a few times a second; kCancel ends the work with kCancelled.
using OnProgress = std::function<Proceed(const client::AdvanceProgress&)>;

/// Runs the core in this process.
[[nodiscard]] Result<RemeshResult> RemeshLocally(const RemeshJob& job,
                                                 const OnProgress& on_progress);

/// Runs the same on a server, in a session that is deleted afterwards. The mesh has the same bits
/// unless a time limit ends the loop.
[[nodiscard]] Result<RemeshResult> RemeshOnServer(const std::string& address, const RemeshJob& job,
                                                  const OnProgress& on_progress);

/// Advances a session, cancels it if on_progress says so, and then fails with kCancelled.
[[nodiscard]] Result<client::AdvanceReport> AdvanceWithProgress(
    client::Session& session, const client::AdvanceOptions& options, const OnProgress& on_progress);

}  // namespace pliant::cli
