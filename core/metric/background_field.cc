#include "core/metric/background_field.h"

#include <algorithm>
#include <array>
#include <locale>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <utility>

#include "core/base/prefetch.h"
#include "core/geometry/predicates.h"
#include "core/metric/saved_field.h"

namespace pliant {
namespace {

/// Questions that are answered together.
constexpr std::size_t kLocatedAtOnce = 64;

Error RefuseTriangle(ErrorCode code, std::size_t index, const std::string& what) {
  return {.code = code,
          .message = "triangle " + std::to_string(index) + " of the background mesh " + what,
          .field = "metric.mesh.triangles",
          .index = static_cast<std::int64_t>(index)};
}

Status CheckTriangle(const MeshData& mesh, std::size_t index) {
  const auto& [a, b, c] = mesh.triangles[index];
  for (const std::int32_t corner : {a, b, c}) {
    if (corner < 0 || static_cast<std::size_t>(corner) >= mesh.points.size()) {
      return RefuseTriangle(ErrorCode::kIndexOutOfRange, index,
                            "names point " + std::to_string(corner) + "; there are " +
                                std::to_string(mesh.points.size()) + ", counted from 0");
    }
  }
  const auto point = [&](std::int32_t i) { return mesh.points[static_cast<std::size_t>(i)]; };
  const int side = Orient2d(point(a), point(b), point(c));
  if (side == 0) return RefuseTriangle(ErrorCode::kTriangleDegenerate, index, "has no area");
  if (side < 0) {
    return RefuseTriangle(ErrorCode::kTriangleOrientation, index,
                          "runs clockwise; list its corners counter-clockwise");
  }
  return {};
}

/// Names two triangles on the same side of an edge, if there are any. Three triangles at an edge
/// always have two.
Status CheckEdges(const MeshData& mesh, const StopSignal* stop) {
  struct Side {
    std::int32_t to;
    std::int32_t triangle;
    auto operator<=>(const Side&) const = default;
  };
  // In buckets by the point where a side begins; each holds a handful.
  StopPoll stopped(stop);
  std::vector<std::size_t> first(mesh.points.size() + 1, 0);
  for (const auto& corners : mesh.triangles) {
    if (stopped()) return Stopped();
    for (const std::int32_t corner : corners) ++first[static_cast<std::size_t>(corner) + 1];
  }
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<Side> sides(3 * mesh.triangles.size());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (stopped()) return Stopped();
    const auto& corners = mesh.triangles[i];
    for (std::size_t k = 0; k < 3; ++k) {
      sides[next[static_cast<std::size_t>(corners[k])]++] = {corners[(k + 1) % 3],
                                                             static_cast<std::int32_t>(i)};
    }
  }
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    if (stopped()) return Stopped();
    const std::span<Side> bucket(sides.data() + first[v], first[v + 1] - first[v]);
    std::ranges::sort(bucket);
    const auto clash = std::ranges::adjacent_find(bucket, {}, &Side::to);
    if (clash == bucket.end()) continue;
    const auto other = static_cast<std::int64_t>(std::next(clash)->triangle);
    Error error =
        RefuseTriangle(ErrorCode::kNonManifoldEdge, static_cast<std::size_t>(clash->triangle),
                       "and triangle " + std::to_string(other) +
                           " lie on the same side of the edge between points " + std::to_string(v) +
                           " and " + std::to_string(clash->to));
    error.other_index = other;
    return error;
  }
  return {};
}

Status CheckMesh(const MeshData& mesh, const StopSignal* stop) {
  StopPoll stopped(stop);
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (!IsFinite(mesh.points[i])) {
      return Error{.code = ErrorCode::kNotFinite,
                   .message = "point " + std::to_string(i) +
                              " of the background mesh has a coordinate that is NaN or infinite",
                   .field = "metric.mesh.points",
                   .index = static_cast<std::int64_t>(i)};
    }
  }
  if (mesh.triangles.empty()) {
    return Error{.code = ErrorCode::kEmpty,
                 .message = "the background mesh has no triangles; it needs at least one",
                 .field = "metric.mesh.triangles"};
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (stopped()) return Stopped();
    PLIANT_RETURN_IF_ERROR(CheckTriangle(mesh, i));
  }
  return {};
}

Error BadTensor(ErrorCode code, std::size_t index, const std::string& what) {
  return {.code = code,
          .message = "tensor " + std::to_string(index) + " " + what,
          .field = "metric.tensors",
          .index = static_cast<std::int64_t>(index)};
}

Result<LargeVector<LogMetric>> TakeLogs(const BackgroundMetric& metric, const SizeBounds& bounds,
                                        const StopSignal* stop) {
  if (metric.tensors.size() != metric.mesh.points.size()) {
    return Error{.code = ErrorCode::kArrayLength,
                 .message = "the background mesh has " + std::to_string(metric.mesh.points.size()) +
                            " points but " + std::to_string(metric.tensors.size()) +
                            " tensors; expected one for each point",
                 .field = "metric.tensors"};
  }
  LargeVector<LogMetric> logs;
  logs.reserve(metric.tensors.size());
  StopPoll stopped(stop);
  for (std::size_t i = 0; i < metric.tensors.size(); ++i) {
    if (stopped()) return Stopped();
    const Metric& tensor = metric.tensors[i];
    if (!IsFinite(tensor)) {
      return BadTensor(ErrorCode::kNotFinite, i, "has an entry that is NaN or infinite");
    }
    const std::optional<Metric> admitted = AdmitTensor(tensor, bounds);
    if (!admitted) {
      const Eigenvalues eigenvalues = EigenvaluesOf(tensor);
      std::ostringstream out;
      out.imbue(std::locale::classic());
      out << "with eigenvalues " << eigenvalues.low << " and " << eigenvalues.high
          << " is not a metric; expected both positive (size_max replaces eigenvalues of 0)";
      return BadTensor(ErrorCode::kNotPositiveDefinite, i, out.str());
    }
    logs.push_back(Log(*admitted));
  }
  return logs;
}

}  // namespace

Result<std::unique_ptr<BackgroundField>> BackgroundField::Make(const BackgroundMetric& metric,
                                                               const SizeBounds& bounds,
                                                               const StopSignal* stop) {
  PLIANT_RETURN_IF_ERROR(CheckMesh(metric.mesh, stop));
  const MeshData& mesh = metric.mesh;
  const Neighborhood neighbors =
      FindNeighbors(mesh.triangles, static_cast<std::int32_t>(mesh.points.size()), stop);
  if (neighbors.overlaps) PLIANT_RETURN_IF_ERROR(CheckEdges(mesh, stop));
  PLIANT_ASSIGN_OR_RETURN(LargeVector<LogMetric> logs, TakeLogs(metric, bounds, stop));
  if (stop != nullptr && stop->asked()) return Stopped();
  TriangleLocator locator(mesh.points, mesh.triangles, neighbors.across);
  return std::unique_ptr<BackgroundField>(new BackgroundField(std::move(locator), std::move(logs)));
}

std::unique_ptr<BackgroundField> BackgroundField::OfValid(LinkedTriangles mesh,
                                                          std::span<const Metric> tensors,
                                                          const StopSignal* stop) {
  LargeVector<LogMetric> logs(tensors.size());
  for (std::size_t begin = 0; begin < tensors.size(); begin += StopPoll::kPeriod) {
    if (stop != nullptr && stop->asked()) return nullptr;
    const std::size_t count = std::min<std::size_t>(StopPoll::kPeriod, tensors.size() - begin);
    LogEach(tensors.subspan(begin, count), std::span(logs).subspan(begin, count));
  }
  return std::unique_ptr<BackgroundField>(
      new BackgroundField(TriangleLocator(std::move(mesh)), std::move(logs)));
}

std::unique_ptr<BackgroundField> BackgroundField::Restore(
    const std::vector<Vec2>& points, const std::vector<std::array<std::int32_t, 3>>& triangles,
    std::span<const LogMetric> logs) {
  if (triangles.empty() || logs.size() != points.size()) return nullptr;
  for (const auto& corners : triangles) {
    for (const std::int32_t corner : corners) {
      if (corner < 0 || static_cast<std::size_t>(corner) >= points.size()) return nullptr;
    }
  }
  if (!std::ranges::all_of(points, [](Vec2 p) { return IsFinite(p); })) return nullptr;
  TriangleLocator locator(points, triangles);
  return std::unique_ptr<BackgroundField>(
      new BackgroundField(std::move(locator), {logs.begin(), logs.end()}));
}

Status BackgroundField::Save(ByteWriter& writer) const {
  PutFieldKind(SavedFieldKind::kBackground, writer);
  std::vector<double> values;
  values.reserve(3 * logs_.size());
  for (const Vec2 p : locator_.points()) values.insert(values.end(), {p.x, p.y});
  writer.PutColumn(values);
  std::vector<std::int32_t> corners;
  corners.reserve(3 * static_cast<std::size_t>(locator_.triangle_count()));
  for (std::int32_t t = 0; t < locator_.triangle_count(); ++t) {
    corners.insert(corners.end(), locator_.corners(t).begin(), locator_.corners(t).end());
  }
  writer.PutColumn(corners);
  values.clear();
  for (const LogMetric& log : logs_) values.insert(values.end(), {log.l11, log.l12, log.l22});
  writer.PutColumn(values);
  return {};
}

std::size_t BackgroundField::bytes() const {
  // Triangles, their neighbours and the boxes of the tree; points, their triangle and logarithms.
  return 100 * static_cast<std::size_t>(locator_.triangle_count()) + 44 * logs_.size();
}

void BackgroundField::PrefetchBehindHint(std::int32_t hint) const {
  if (!locator_.IsTriangle(hint)) return;
  for (const std::int32_t corner : locator_.corners(hint)) {
    PrefetchToRead(&locator_.points()[static_cast<std::size_t>(corner)]);
    PrefetchToRead(&logs_[static_cast<std::size_t>(corner)]);
  }
}

Metric BackgroundField::At(Vec2 p, std::int32_t& hint) const {
  const Location location = locator_.Locate(p, hint);
  hint = location.triangle;
  return Exp(LogIn(location));
}

void BackgroundField::AtEach(std::span<const Vec2> points, std::span<std::int32_t> hints,
                             std::span<Metric> metrics) const {
  // Who has no hint begins where another one ended: such walks follow each other.
  if (!std::ranges::all_of(hints, [&](std::int32_t hint) { return locator_.IsTriangle(hint); })) {
    MetricField::AtEach(points, hints, metrics);
    return;
  }
  std::array<Location, kLocatedAtOnce> found;
  std::array<LogMetric, kLocatedAtOnce> logs;
  for (std::size_t begin = 0; begin < points.size(); begin += kLocatedAtOnce) {
    const auto located = std::span(found).first(std::min(kLocatedAtOnce, points.size() - begin));
    for (std::size_t i = 0; i < located.size(); ++i) located[i].triangle = hints[begin + i];
    locator_.LocateEach(points.subspan(begin, located.size()), located);
    for (const Location& location : located) PrefetchLogs(location);
    for (std::size_t i = 0; i < located.size(); ++i) {
      hints[begin + i] = located[i].triangle;
      logs[i] = LogIn(located[i]);
    }
    ExpEach(std::span(logs).first(located.size()), metrics.subspan(begin, located.size()));
  }
}

/// Has the memory fetch what LogIn reads.
void BackgroundField::PrefetchLogs(const Location& location) const {
  for (const std::int32_t corner : locator_.corners(location.triangle)) {
    PrefetchToRead(&logs_[static_cast<std::size_t>(corner)]);
  }
}

LogMetric BackgroundField::LogIn(const Location& location) const {
  const auto& corners = locator_.corners(location.triangle);
  LogMetric mean = location.weights[0] * logs_[static_cast<std::size_t>(corners[0])];
  for (std::size_t k = 1; k < 3; ++k) {
    mean = mean + location.weights[k] * logs_[static_cast<std::size_t>(corners[k])];
  }
  return mean;
}

std::optional<Metric> BackgroundField::Probe(Vec2 p, std::int32_t& hint) const {
  if (!Meet(locator_.box(), {p, p})) return std::nullopt;
  return At(p, hint);
}

/// @param to_answers  makes answers of logarithms, of up to kLocatedAtOnce at once
template <class Answer, class ToAnswers>
void BackgroundField::AnswerEach(std::span<QuestionFor<Answer>> questions,
                                 ToAnswers to_answers) const {
  std::array<Vec2, kLocatedAtOnce> places;
  std::array<Location, kLocatedAtOnce> found;
  std::array<QuestionFor<Answer>*, kLocatedAtOnce> asked;
  std::array<LogMetric, kLocatedAtOnce> logs;
  while (!questions.empty()) {
    const std::size_t taken = std::min(kLocatedAtOnce, questions.size());
    std::size_t count = 0;
    for (QuestionFor<Answer>& one : questions.first(taken)) {
      one.answer.reset();
      if (!Meet(locator_.box(), {one.place, one.place})) continue;
      places[count] = one.place;
      found[count].triangle = one.hint;
      asked[count++] = &one;
    }
    locator_.LocateEach(std::span(places).first(count), std::span(found).first(count));
    for (const Location& location : std::span(found).first(count)) PrefetchLogs(location);
    for (std::size_t k = 0; k < count; ++k) logs[k] = LogIn(found[k]);
    const std::span<const Answer> answers = to_answers(std::span(logs).first(count));
    for (std::size_t k = 0; k < count; ++k) {
      asked[k]->hint = found[k].triangle;
      asked[k]->answer = answers[k];
    }
    questions = questions.subspan(taken);
  }
}

void BackgroundField::ProbeEach(std::span<Question> questions) const {
  std::array<Metric, kLocatedAtOnce> metrics;
  AnswerEach(questions, [&](std::span<const LogMetric> logs) {
    ExpEach(logs, std::span(metrics).first(logs.size()));
    return std::span<const Metric>(metrics).first(logs.size());
  });
}

void BackgroundField::ProbeLogEach(std::span<LogQuestion> questions) const {
  AnswerEach(questions, [](std::span<const LogMetric> logs) { return logs; });
}

}  // namespace pliant
