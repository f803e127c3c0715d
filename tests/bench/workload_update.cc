#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "client/io/file.h"
#include "client/io/medit.h"
#include "core/mesh/export_mesh.h"
#include "core/metric/function_field.h"
#include "core/motion/move.h"
#include "core/pliant/followed_metric.h"
#include "tests/bench/workload_step.h"

namespace pliant::bench {
namespace {

/// Case F: the disc switched on and off again, `repeat` times.
Result<nlohmann::json> RunDisc(Remesher& remesher, const Request& request) {
  CaseRequest on_request = request.instance;
  on_request.name = "F-on";
  PLIANT_ASSIGN_OR_RETURN(const BenchCase on, MakeCase(on_request));
  PLIANT_ASSIGN_OR_RETURN(const BenchCase off, MakeCase(request.instance));
  std::vector<Update> ups;
  std::vector<Update> downs;
  nlohmann::json quality_on;
  for (int run = 0; run < request.repeat; ++run) {
    PLIANT_ASSIGN_OR_RETURN(Update up,
                            RunOne(remesher, [&] { return remesher.SetField(on.field()); }));
    ups.push_back(std::move(up));
    if (run == 0) quality_on = QualityOf(remesher.mesh(), *on.field());
    PLIANT_ASSIGN_OR_RETURN(Update down,
                            RunOne(remesher, [&] { return remesher.SetField(off.field()); }));
    downs.push_back(std::move(down));
  }
  return nlohmann::json{{"on", JsonOf(ups)}, {"off", JsonOf(downs)}, {"quality_on", quality_on}};
}

/// The live vertices nearest to a point, at most `count`, ascending, and how far they reach.
struct Neighborhood {
  std::vector<VertexId> vertices;
  double radius = 0;
};
Neighborhood Nearest(const Mesh& mesh, Vec2 center, std::int64_t count) {
  const ExportedMesh all = ExportMesh(mesh);
  std::vector<std::pair<double, VertexId>> order;
  for (std::size_t i = 0; i < all.vertex_ids.size(); ++i) {
    order.emplace_back(Length(all.data.points[i] - center), all.vertex_ids[i]);
  }
  const auto last = order.begin() + std::min<std::ptrdiff_t>(count, std::ssize(order)) - 1;
  std::nth_element(order.begin(), last, order.end());
  Neighborhood result{.vertices = {}, .radius = last->first};
  for (auto it = order.begin(); it != last; ++it) result.vertices.push_back(it->second);
  std::sort(result.vertices.begin(), result.vertices.end());
  return result;
}

/// Tensors at some vertices; if all are to be sent, at the others what these have.
Result<Update> SendTensors(Remesher& remesher, const Request& request,
                           std::vector<VertexId> vertices, std::vector<Metric> tensors) {
  if (request.sends_all) {
    const Mesh& mesh = remesher.mesh();
    std::vector<Metric> by_slot(static_cast<std::size_t>(mesh.vertex_slots()));
    for (std::size_t s = 0; s < by_slot.size(); ++s) {
      by_slot[s] = mesh.metric(VertexId(static_cast<std::int32_t>(s)));
    }
    for (std::size_t i = 0; i < vertices.size(); ++i) by_slot[vertices[i].index()] = tensors[i];
    vertices = LiveVertices(mesh);
    tensors.clear();
    for (const VertexId id : vertices) tensors.push_back(by_slot[id.index()]);
  }
  return RunOne(remesher, [&] { return remesher.SetTensors(vertices, tensors); });
}

/// The tensors that all vertices have, and the wanted size beside them from now on.
Result<Update> SetBeside(Remesher& remesher, const std::string& size) {
  std::vector<Metric> tensors;
  for (const VertexId id : LiveVertices(remesher.mesh())) {
    tensors.push_back(remesher.mesh().metric(id));
  }
  const FunctionsSpec beside{.parts = {SizeMetric{size}}};
  const MetricLimits none{.gradation = {.automatic = false}};
  return RunOne(remesher, [&] { return remesher.SetTensors({}, tensors, none, beside); });
}

/// Twice the density around a point of about `changed` nodes, smooth at the rim, then as before.
Result<nlohmann::json> RunBump(Remesher& remesher, const Request& request) {
  PLIANT_ASSIGN_OR_RETURN(const BenchCase instance, MakeCase(request.instance));
  const auto field = instance.field();
  nlohmann::json beside;
  if (!request.beside.empty()) {
    PLIANT_ASSIGN_OR_RETURN(const Update set, SetBeside(remesher, request.beside));
    beside = JsonOf(std::vector{set});
  }
  const Domain& domain = instance.domain;
  // 0.6 and 0.62 of the way between opposite corners: in the dense part of case A, on no symmetry.
  const Vec2 low = domain.points[0];
  const Vec2 high = domain.points[2];
  const Vec2 center{low.x + 0.6 * (high.x - low.x), low.y + 0.62 * (high.y - low.y)};
  const auto tensors_at = [&](const Neighborhood& where, double height) {
    std::vector<Metric> tensors;
    std::int32_t hint = MetricField::kNoHint;
    for (const VertexId id : where.vertices) {
      const Vec2 p = remesher.mesh().position(id);
      const double u = std::max(0.0, 1 - Length(p - center) / where.radius);
      tensors.push_back((1 + height * u * u * (3 - 2 * u)) * field->At(p, hint));
    }
    return tensors;
  };
  std::vector<Update> ups;
  std::vector<Update> downs;
  for (int run = 0; run < request.repeat; ++run) {
    const Neighborhood where = Nearest(remesher.mesh(), center, request.changed);
    const auto finer = tensors_at(where, 1);
    PLIANT_ASSIGN_OR_RETURN(Update up, SendTensors(remesher, request, where.vertices, finer));
    ups.push_back(std::move(up));
    // The bump and as much again around it, where nodes have the metric interpolated from it.
    Neighborhood after = Nearest(remesher.mesh(), center, 4 * request.changed);
    const auto before = tensors_at(after, 0);
    PLIANT_ASSIGN_OR_RETURN(Update down, SendTensors(remesher, request, after.vertices, before));
    downs.push_back(std::move(down));
  }
  return nlohmann::json{{"on", JsonOf(ups)}, {"off", JsonOf(downs)}, {"beside", beside}};
}

/// What case F as tensors stands for: half the size inside the disc.
std::unique_ptr<MetricField> DiscOn(const Metric& base, double radius) {
  const auto metric = [base, radius](Vec2 p) {
    return Length(p - Vec2{0.5, 0.5}) < radius ? 4 * base : base;
  };
  return std::make_unique<FunctionField<decltype(metric)>>(metric);
}

/// Case F as tensors at vertices: half the size in a disc of 0.1 % of the area, `repeat` times, and
/// back at all vertices that have another tensor by then. The first of each is not counted: it
/// finds no memory warm.
Result<nlohmann::json> RunTensors(Remesher& remesher, const Request& request) {
  PLIANT_ASSIGN_OR_RETURN(const BenchCase instance, MakeCase(request.instance));
  const auto field = instance.field();
  const Mesh& mesh = remesher.mesh();
  std::int32_t hint = MetricField::kNoHint;
  const Metric base = field->At({0.5, 0.5}, hint);
  const Metric fine = 4 * base;
  const double radius = std::sqrt(0.001 / 3.14159265358979323846);
  const auto select = [&](auto wanted) {
    std::vector<VertexId> vertices;
    for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
      if (mesh.vertex(VertexId(v)).live && wanted(mesh.vertex(VertexId(v)))) {
        vertices.emplace_back(v);
      }
    }
    return vertices;
  };
  const auto is_inside = [&](const VertexRecord& v) {
    return Length(v.position - Vec2{0.5, 0.5}) < radius;
  };
  std::vector<Update> ups;
  std::vector<Update> downs;
  std::vector<double> sent;
  Untouched untouched;
  nlohmann::json quality_on;
  for (int run = 0; run <= request.repeat; ++run) {
    const auto inside = select(is_inside);
    const std::vector<Metric> finer(inside.size(), fine);
    untouched.Before(mesh, is_inside);
    PLIANT_ASSIGN_OR_RETURN(Update up,
                            RunOne(remesher, [&] { return remesher.SetTensors(inside, finer); }));
    untouched.After(up.diff, remesher.Snapshot());
    if (run == 0) quality_on = QualityOf(mesh, *DiscOn(base, radius));
    const auto other =
        select([&](const VertexRecord& v) { return RelativeChange(base, v.metric) > 1e-6; });
    const std::vector<Metric> back(other.size(), base);
    PLIANT_ASSIGN_OR_RETURN(Update down,
                            RunOne(remesher, [&] { return remesher.SetTensors(other, back); }));
    if (run == 0) continue;
    sent.push_back(static_cast<double>(inside.size()));
    ups.push_back(std::move(up));
    downs.push_back(std::move(down));
  }
  return nlohmann::json{{"on", JsonOf(ups)},
                        {"off", JsonOf(downs)},
                        {"sent_nodes", Median(sent)},
                        {"quality_on", quality_on},
                        {"untouched", untouched.Json()}};
}

/// The same metric again: once as the same formulas, once as the same tensors at every vertex.
Result<nlohmann::json> RunSame(Remesher& remesher, const Request& request) {
  const auto formulas = FormulasOf(request.instance);
  if (!formulas.has_value()) {
    return Error{.code = ErrorCode::kOutOfRange,
                 .message = "Case " + request.instance.name + " has no formulas to send twice."};
  }
  PLIANT_RETURN_IF_ERROR(remesher.SetMetric(*formulas));
  PLIANT_ASSIGN_OR_RETURN(const Progress first, remesher.Step({}));
  (void)first;
  (void)remesher.Commit();
  std::vector<Update> by_formulas;
  std::vector<Update> by_tensors;
  for (int run = 0; run < request.repeat; ++run) {
    PLIANT_ASSIGN_OR_RETURN(Update formula,
                            RunOne(remesher, [&] { return remesher.SetMetric(*formulas); }));
    by_formulas.push_back(std::move(formula));
  }
  std::vector<Metric> tensors;
  for (const VertexId id : ExportMesh(remesher.mesh()).vertex_ids) {
    tensors.push_back(remesher.mesh().metric(id));
  }
  for (int run = 0; run < request.repeat; ++run) {
    PLIANT_ASSIGN_OR_RETURN(Update tensor,
                            RunOne(remesher, [&] { return remesher.SetTensors({}, tensors); }));
    by_tensors.push_back(std::move(tensor));
  }
  for (const auto* updates : {&by_formulas, &by_tensors}) {
    for (const Update& update : *updates) {
      if (!update.diff.empty()) {
        return Error{.code = ErrorCode::kInternal,
                     .message = "The same metric again changed " +
                                std::to_string(update.diff.vertex_ids.size()) +
                                " vertices; Local promises an empty diff."};
      }
    }
  }
  return nlohmann::json{{"formulas", JsonOf(by_formulas)}, {"tensors", JsonOf(by_tensors)}};
}

/// How far a mesh's body edges lie off the body: middles of edges, in domain units.
double BoundaryError(const Mesh& mesh, const Domain& domain) {
  double worst = 0;
  for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
    const EdgeRecord& edge = mesh.edge(EdgeId(e));
    if (!edge.live || edge.tag != kBodyTag) continue;
    const Vec2 middle = 0.5 * (mesh.position(edge.vertices[0]) + mesh.position(edge.vertices[1]));
    double nearest = 1;
    for (const Segment& segment : domain.segments) {
      const Vec2 a = domain.points[static_cast<std::size_t>(segment.a)];
      const Vec2 along = domain.points[static_cast<std::size_t>(segment.b)] - a;
      const double t = std::clamp(Dot(middle - a, along) / Dot(along, along), 0.0, 1.0);
      nearest = std::min(nearest, Length(middle - (a + t * along)));
    }
    worst = std::max(worst, nearest);
  }
  return worst;
}

/// Case G: the body moves, by 0.1 to the right and back, or by 10 degrees, and its layer with it.
Result<nlohmann::json> RunBody(Remesher& remesher, const Request& request) {
  std::vector<Update> updates;
  CaseRequest moving = request.instance;
  nlohmann::json quality;
  double q_min = 1;
  double q_mean = 0;
  double share = 0;
  double longest = 0;
  double off = 0;
  Untouched untouched;
  double removed = 0;
  double sub_steps = 0;
  for (std::int64_t step = 0; step < request.steps; ++step) {
    MotionRequest motion;
    motion.follow_length = request.follow;
    if (request.instance.name == "G-flap") {
      moving.turn_degrees += 10;
      motion.tags = {{{kBodyTag}, Rotation{{0.4, 0.5}, 10 * 3.14159265358979323846 / 180}}};
    } else {
      const double by = step % 6 < 3 ? 0.1 : -0.1;
      moving.shift += by;
      motion.tags = {{{kBodyTag}, Translation{{by, 0}}}};
    }
    PLIANT_ASSIGN_OR_RETURN(const BenchCase instance, MakeCase(moving));
    untouched.Before(remesher.mesh(), [](const VertexRecord&) { return true; });
    PLIANT_ASSIGN_OR_RETURN(Update update, RunOne(remesher, [&]() -> Status {
                              PLIANT_ASSIGN_OR_RETURN(const MotionReport report,
                                                      MoveVertices(remesher, motion));
                              removed += static_cast<double>(report.removed_count);
                              sub_steps += static_cast<double>(report.sub_step_count);
                              return remesher.SetField(instance.field());
                            }));
    untouched.After(update.diff, remesher.Snapshot());
    updates.push_back(std::move(update));
    quality = QualityOf(remesher.mesh(), *instance.field());
    q_min = std::min(q_min, quality["q_min"].get<double>());
    q_mean += quality["q_mean"].get<double>();
    share += quality["integrated_125"].get<double>();
    longest = std::max(longest, quality["integrated"]["max"].get<double>());
    off = std::max(off, BoundaryError(remesher.mesh(), instance.domain));
  }
  const auto steps = static_cast<double>(request.steps);
  return nlohmann::json{{"steps", JsonOf(updates)},
                        {"q_mean_of_steps", q_mean / steps},
                        {"q_min_of_steps", q_min},
                        {"integrated_125_of_steps", share / steps},
                        {"longest_of_steps", longest},
                        {"untouched", untouched.Json()},
                        {"boundary_error", off},
                        {"removed_per_step", removed / steps},
                        {"sub_steps_per_step", sub_steps / steps},
                        {"quality_last", quality}};
}

}  // namespace

Result<nlohmann::json> RunUpdate(const Request& request) {
  PLIANT_ASSIGN_OR_RETURN(const BenchCase instance, MakeCase(request.instance));
  PLIANT_ASSIGN_OR_RETURN(const Built built, Build(instance, request));
  nlohmann::json report{{"nodes", built.remesher->mesh().vertex_count()},
                        {"build", bench::JsonOf(std::vector{built.duration})}};
  Result<nlohmann::json> result =
      Error{.code = ErrorCode::kOutOfRange,
            .message = "There is no update '" + request.update +
                       "'; there are disc, tensors, bump, same, front, drift, body, nodes, domain.",
            .field = "update"};
  if (request.update == "disc") result = RunDisc(*built.remesher, request);
  if (request.update == "tensors") result = RunTensors(*built.remesher, request);
  if (request.update == "bump") result = RunBump(*built.remesher, request);
  if (request.update == "same") result = RunSame(*built.remesher, request);
  if (request.update == "front") result = RunFront(*built.remesher, request);
  if (request.update == "drift") result = RunDrift(*built.remesher, request);
  if (request.update == "body") result = RunBody(*built.remesher, request);
  if (request.update == "nodes") result = RunNodes(*built.remesher, request);
  if (request.update == "domain") result = RunDomain(*built.remesher, request);
  PLIANT_RETURN_IF_ERROR(result);
  report[request.update] = *result;
  report["nodes_after"] = built.remesher->mesh().vertex_count();
  report["peak_rss_mib"] = PeakMemoryMib();
  if (!request.mesh_path.empty()) {
    PLIANT_RETURN_IF_ERROR(io::WriteFileAtomically(
        request.mesh_path, io::FormatMedit(ExportMesh(built.remesher->mesh()).data)));
  }
  return report;
}

}  // namespace pliant::bench
