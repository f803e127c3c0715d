#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "client/cli/engine.h"
#include "client/cpp/types.h"
#include "core/base/result.h"
#include "core/mesh/mesh_diff.h"
#include "core/metric/gradation.h"
#include "core/pliant/quality.h"

namespace pliant::cli {

using Json = nlohmann::ordered_json;

/// The quality block of every report.
[[nodiscard]] Json QualityJson(const Quality& quality);
/// The same for people: a few lines, each ended.
[[nodiscard]] std::string QualityText(const Quality& quality);

/// What `pliant remesh` reports besides the result itself.
struct RemeshReport {
  std::string input;
  std::string output;
  std::optional<std::string> server;  ///< Absent: local.
  double read_seconds = 0;
  double remesh_seconds = 0;
  double write_seconds = 0;
  std::int64_t peak_memory_bytes = 0;  ///< Of this process.
};
/// The report's fields are described in client/cli/README.md.
[[nodiscard]] Json RemeshJson(const RemeshReport& report, const RemeshResult& result);

/// What an advance did: the part of a report that a job has too.
[[nodiscard]] Json AdvanceJson(const client::AdvanceReport& report);

/// "2026-07-01T12:00:00Z".
[[nodiscard]] std::string UtcTime(std::chrono::system_clock::time_point time);

[[nodiscard]] Json SessionJson(const client::SessionInfo& session);

/// Why an advance ended: "converged", "visit_budget" and so on.
[[nodiscard]] std::string StopName(client::AdvanceStop stop);
/// What a person should know about an early end; empty if there is nothing to say.
[[nodiscard]] std::string StopWarning(const client::AdvanceReport& report);

/// What a trouble is called: "size_jump", "crossed", "geometry", "curvature", "vertex_limit",
/// "frozen" or "unsettled".
[[nodiscard]] std::string TroubleName(TroubleKind kind);
/// What a person should know about places where the metric is not met, a line for the whole and one
/// for each of the largest few; empty if there are none.
[[nodiscard]] std::string TroubleWarning(const client::AdvanceReport& report);

/// What a person should know about usual limits that were found to be needed, though nobody asked
/// for them; empty if that did not happen.
[[nodiscard]] std::string LimitsNote(const GradationOptions& asked,
                                     const client::AdvanceReport& report);
/// All three to standard error, a line or more each.
void PrintWarnings(const client::AdvanceReport& report, const GradationOptions& asked);

/// The most memory that this process has had, in bytes.
[[nodiscard]] std::int64_t PeakMemoryBytes();

/// Writes to standard output for "-", else replaces the file.
[[nodiscard]] Status WriteJson(const std::string& path, const Json& json);

}  // namespace pliant::cli
