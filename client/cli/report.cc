#include "client/cli/report.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <iostream>

#include "client/cli/progress_bar.h"
#include "client/io/file.h"

namespace pliant::cli {
namespace {

Json LengthsJson(const LengthStatistics& lengths) {
  return {{"mean", lengths.mean},
          {"min", lengths.min},
          {"max", lengths.max},
          {"share_sqrt2", lengths.share_sqrt2},
          {"share_125", lengths.share_125}};
}

template <std::size_t kBins>
Json HistogramJson(const Histogram<kBins>& histogram) {
  return {{"low", 0.0}, {"high", histogram.upper}, {"counts", histogram.counts}};
}

template <class... Values>
std::string Format(const char* format, Values... values) {
  std::array<char, 256> buffer;
  std::snprintf(buffer.data(), buffer.size(), format, values...);
  return buffer.data();
}

std::string Hex(std::uint64_t value) {
  return Format("%016llx", static_cast<unsigned long long>(value));
}

std::string StateName(client::SessionState state) {
  switch (state) {
    case client::SessionState::kIdle:
      return "idle";
    case client::SessionState::kRunning:
      return "running";
    case client::SessionState::kAsleep:
      return "asleep";
  }
  return "idle";
}

Json LimitsJson(const MetricReport& limits) {
  if (!limits.limits_anything()) return nullptr;
  return {
      {"smoothing_count", limits.smoothing_count},    {"geometry_count", limits.geometry_count},
      {"rotation_count", limits.rotation_count},      {"gradation_count", limits.gradation_count},
      {"size_ratio_max", limits.size_ratio_max},      {"complexity_before", limits.raw_complexity},
      {"complexity_after", limits.limited_complexity}};
}

Json TroublesJson(const std::vector<Trouble>& troubles) {
  Json json = Json::array();
  for (const Trouble& t : troubles) {
    json.push_back({{"kind", TroubleName(t.kind)},
                    {"vertex_count", t.vertex_count},
                    {"place_count", t.place_count},
                    {"center", {t.center.x, t.center.y}},
                    {"box", {t.box.low.x, t.box.low.y, t.box.high.x, t.box.high.y}},
                    {"q_min", t.q_min},
                    {"length_min", t.length_min},
                    {"length_max", t.length_max}});
  }
  return json;
}

}  // namespace

Json QualityJson(const Quality& quality) {
  return {{"vertex_count", quality.vertex_count},
          {"triangle_count", quality.triangle_count},
          {"edge_count", quality.edge_count},
          {"q_mean", quality.q_mean},
          {"q_min", quality.q_min},
          {"q_percentile_1", quality.q_percentile_1},
          {"complexity", quality.complexity},
          {"integrated", LengthsJson(quality.integrated)},
          {"averaged", LengthsJson(quality.averaged)},
          {"angles_deg", HistogramJson(quality.angles)},
          {"lengths", HistogramJson(quality.lengths)}};
}

std::string QualityText(const Quality& quality) {
  const auto lengths = [](const char* name, const LengthStatistics& l) {
    return Format(
        "%-22s %.3f mean, %.3f to %.3f; %.1f %% in [1/sqrt 2, sqrt 2], "
        "%.1f %% in [0.8, 1.25]\n",
        name, l.mean, l.min, l.max, 100 * l.share_sqrt2, 100 * l.share_125);
  };
  std::string text = "vertices               " + Grouped(quality.vertex_count) +
                     "\ntriangles              " + Grouped(quality.triangle_count) +
                     "\nedges                  " + Grouped(quality.edge_count) + "\n";
  text += Format("triangle quality       %.4f mean, %.4f at 1 %%, %.4f least\n", quality.q_mean,
                 quality.q_percentile_1, quality.q_min);
  text += lengths("lengths, integrated", quality.integrated);
  text += lengths("lengths, averaged", quality.averaged);
  text += Format("complexity             %.6g\n", quality.complexity);
  return text;
}

std::string UtcTime(std::chrono::system_clock::time_point time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 32> buffer;
  std::strftime(buffer.data(), buffer.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return buffer.data();
}

Json AdvanceJson(const client::AdvanceReport& advance) {
  return {{"vertex_count", advance.summary.vertex_count},
          {"triangle_count", advance.summary.triangle_count},
          {"constrained_edge_count", advance.summary.edge_count},
          {"state_hash", Hex(advance.summary.state_hash)},
          {"stop", StopName(advance.stop)},
          {"active_count", advance.active_count},
          {"loop",
           {{"visits", advance.visits},
            {"moves", advance.moves},
            {"insertions", advance.insertions},
            {"deletions", advance.deletions},
            {"swaps", advance.swaps},
            {"cooled_count", advance.cooled_count}}},
          {"limits", LimitsJson(advance.metric)},
          {"troubles", TroublesJson(advance.troubles)}};
}

Json RemeshJson(const RemeshReport& report, const RemeshResult& result) {
  Json json = {{"pliant_version", PLIANT_VERSION},
               {"mode", report.server ? "server" : "local"},
               {"input", report.input},
               {"output", report.output}};
  const Json advance = AdvanceJson(result.report);
  for (const auto& [key, value] : advance.items()) {
    if (key == "loop") {  // In the order of README.md.
      json["seconds"] = {{"read", report.read_seconds},
                         {"remesh", report.remesh_seconds},
                         {"write", report.write_seconds}};
      json["peak_memory_bytes"] = report.peak_memory_bytes;
    }
    json[key] = value;
  }
  json["quality"] = QualityJson(result.quality);
  if (report.server) json["server"] = *report.server;
  return json;
}

Json SessionJson(const client::SessionInfo& session) {
  Json json = {{"session_id", session.session_id},
               {"revision", static_cast<std::int64_t>(session.revision)},
               {"state", StateName(session.state)},
               {"vertex_count", session.summary.vertex_count},
               {"triangle_count", session.summary.triangle_count},
               {"constrained_edge_count", session.summary.edge_count},
               {"state_hash", Hex(session.summary.state_hash)},
               {"active_count", session.active_count},
               {"create_time", UtcTime(session.create_time)},
               {"commit_time", UtcTime(session.commit_time)},
               {"labels", session.labels},
               {"memory_bytes", session.memory_bytes}};
  if (session.history_bytes_max) json["history_bytes_max"] = *session.history_bytes_max;
  return json;
}

std::string StopName(client::AdvanceStop stop) {
  switch (stop) {
    case client::AdvanceStop::kConverged:
      return "converged";
    case client::AdvanceStop::kVisitBudget:
      return "visit_budget";
    case client::AdvanceStop::kTimeBudget:
      return "time_budget";
    case client::AdvanceStop::kCancelled:
      return "cancelled";
    case client::AdvanceStop::kVertexLimit:
      return "vertex_limit";
    case client::AdvanceStop::kVisitLimit:
      return "visit_limit";
    case client::AdvanceStop::kServerClosing:
      return "server_closing";
    case client::AdvanceStop::kStaging:
      return "staging";
  }
  return "converged";
}

std::string TroubleName(TroubleKind kind) {
  switch (kind) {
    case TroubleKind::kGeometry:
      return "geometry";
    case TroubleKind::kVertexLimit:
      return "vertex_limit";
    case TroubleKind::kCrossed:
      return "crossed";
    case TroubleKind::kCurvature:
      return "curvature";
    case TroubleKind::kSizeJump:
      return "size_jump";
    case TroubleKind::kFrozen:
      return "frozen";
    case TroubleKind::kUnsettled:
      break;
  }
  return "unsettled";
}

namespace {

/// What may help against troubles, a line each.
std::string Advice(const client::AdvanceReport& report) {
  const auto any = [&](auto is_such) {
    return std::ranges::any_of(report.troubles, is_such, &Trouble::kind);
  };
  std::string text;
  if (!report.metric.limits && any(LimitsHelp)) {
    text += Format("\n  --hgrad %g --rotation %g make a metric that jumps or turns one to follow",
                   GradationOptions::kUsualGradation, GradationOptions::kUsualRotation);
  }
  if (any([](TroubleKind kind) { return kind == TroubleKind::kGeometry; })) {
    text += "\n  --geometry 1 with --hgrad makes edges as short as the segments of the domain";
  }
  return text;
}

}  // namespace

std::string TroubleWarning(const client::AdvanceReport& report) {
  if (report.troubles.empty()) return {};
  constexpr std::size_t kShownMax = 5;
  std::int64_t vertex_count = 0;
  std::int64_t place_count = 0;
  for (const Trouble& trouble : report.troubles) {
    vertex_count += trouble.vertex_count;
    place_count += trouble.place_count;
  }
  std::string text = "the metric is not met at " + Grouped(place_count) + " places, " +
                     Grouped(vertex_count) + " vertices";
  for (std::size_t i = 0; i < std::min(kShownMax, report.troubles.size()); ++i) {
    const Trouble& t = report.troubles[i];
    text += Format("\n  %-12s %s vertices near (%.6g, %.6g), lengths %.3g to %.3g, quality %.3g",
                   TroubleName(t.kind).c_str(), Grouped(t.vertex_count).c_str(), t.center.x,
                   t.center.y, t.length_min, t.length_max, t.q_min);
  }
  if (report.troubles.size() > kShownMax) text += "\n  and more; --json has them";
  return text + Advice(report);
}

std::string LimitsNote(const GradationOptions& asked, const client::AdvanceReport& report) {
  if (!asked.awaits_need() || !report.metric.limits) return {};
  return Format(
      "no mesh follows this metric as it is, so --hgrad %g and --rotation %g limit it, which "
      "asks for %.3g times as many vertices; --hgrad 0 leaves it as it is",
      GradationOptions::kUsualGradation, GradationOptions::kUsualRotation,
      report.metric.limited_complexity / report.metric.raw_complexity);
}

std::string StopWarning(const client::AdvanceReport& report) {
  const std::string active = Grouped(report.active_count) + " vertices are still active";
  switch (report.stop) {
    case client::AdvanceStop::kConverged:
      return {};
    case client::AdvanceStop::kVisitBudget:
      return "stopped by --visits-max; " + active;
    case client::AdvanceStop::kTimeBudget:
      return "stopped by --seconds-max; " + active;
    case client::AdvanceStop::kCancelled:
      return "stopped early; " + active;
    case client::AdvanceStop::kVertexLimit:
      return "the mesh is coarser than wanted: --vertices-max was reached";
    case client::AdvanceStop::kVisitLimit:
      return "the loop did not come to rest and was ended; " + active +
             "; --variant nested and cooled always come to rest";
    case client::AdvanceStop::kServerClosing:
      return "stopped because the server shuts down; " + active;
    case client::AdvanceStop::kStaging:
      return "stopped before all updates were staged; nothing was committed";
  }
  return {};
}

void PrintWarnings(const client::AdvanceReport& report, const GradationOptions& asked) {
  for (const std::string& warning : {StopWarning(report), TroubleWarning(report)}) {
    if (!warning.empty()) std::cerr << "pliant: warning: " << warning << "\n";
  }
  const std::string note = LimitsNote(asked, report);
  if (!note.empty()) std::cerr << "pliant: note: " << note << "\n";
}

std::int64_t PeakMemoryBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

Status WriteJson(const std::string& path, const Json& json) {
  const std::string text = json.dump(2) + "\n";
  if (path != "-") return io::WriteFileAtomically(path, text);
  std::cout << text << std::flush;
  return {};
}

}  // namespace pliant::cli
