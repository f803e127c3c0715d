#include "tests/support/session_script.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/rng.h"
#include "core/mesh/export_mesh.h"
#include "core/motion/motion.h"
#include "core/motion/move.h"
#include "core/pliant/displace_tensors.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant::testing {
namespace {

void Expect(const Status& status) {
  PLIANT_CHECK(status.ok(), "error", status.ok() ? "" : status.error().message);
}

MetricSpec RandomSpec(const Mesh& mesh, Rng& rng) {
  MetricSpec spec;
  const std::string a = std::to_string(rng.Uniform(0.08, 0.2));
  switch (rng.Below(4)) {
    case 0:
      spec.source = SizeMetric{a + " + 0.1*abs(x - 0.3)"};
      break;
    case 1:
      spec.source = SizeMetric{a + " + 0.05*t*y"};
      spec.time = rng.Unit();
      break;
    case 2:
      spec.source = ExpressionMetric{"60 + 100*x", "20*sin(3*y)", "1/(" + a + ")^2"};
      break;
    default: {
      BackgroundMetric background{ExportMesh(mesh).data, {}};
      for (const Vec2 p : background.mesh.points) {
        background.tensors.push_back(Metric::Isotropic(rng.Uniform(0.1, 0.13) + 0.05 * p.x));
      }
      spec.source = std::move(background);
    }
  }
  if (rng.Below(3) == 0) spec.gradation.gradation = 1.4;
  if (rng.Below(4) == 0) spec.gradation.rotation = 0.7;
  if (rng.Below(4) == 0) spec.gradation.geometry = 0.1;
  if (rng.Below(4) == 0) spec.bounds = {.size_min = 0.09, .size_max = 0.25};
  return spec;
}

/// Tensors near those that the vertices have.
std::vector<Metric> RandomTensors(const Mesh& mesh, const std::vector<VertexId>& vertices,
                                  Rng& rng) {
  std::vector<Metric> tensors;
  const double factor = rng.Uniform(0.6, 1.6);
  for (const VertexId vertex : vertices) tensors.push_back(factor * mesh.metric(vertex));
  return tensors;
}

/// One or two, before and after the tensors.
FunctionsSpec RandomFunctions(Rng& rng) {
  FunctionsSpec functions;
  functions.parts.emplace_back(
      SizeMetric{std::to_string(rng.Uniform(0.08, 0.15)) + " + 0.2*abs(x - 0.7 + 0.2*t)"});
  if (rng.Below(2) == 0) functions.parts.emplace_back(ExpressionMetric{"40 + 30*y", "5", "30"});
  functions.before_count = rng.Below(functions.parts.size() + 1);
  functions.time = rng.Unit();
  return functions;
}

/// All off, or some.
MetricLimits RandomLimits(Rng& rng) {
  MetricLimits limits;
  if (rng.Below(2) == 0) limits.gradation.gradation = rng.Uniform(1.2, 2);
  if (rng.Below(3) == 0) limits.gradation.rotation = 0.7;
  if (rng.Below(3) == 0) limits.gradation.smoothing_count = 1;
  if (rng.Below(3) == 0) limits.bounds.size_min = rng.Uniform(0.02, 0.05);
  return limits;
}

/// Of the last commit, whose elements fields are for.
struct ElementCounts {
  std::int32_t vertices;
  std::int32_t triangles;
};

/// Sets, changes or drops one of three fields.
FieldUpdate RandomFields(const ElementCounts& counts, Rng& rng) {
  constexpr std::array kNames{"a", "b", "c"};
  const std::string name = kNames[rng.Below(3)];
  FieldUpdate update;
  if (rng.Below(4) == 0) {
    update.dropped_names = {name};
    return update;
  }
  const bool on_cells = name == "b";
  const auto count = static_cast<std::size_t>(on_cells ? counts.triangles : counts.vertices);
  FieldValues values{.name = name,
                     .location = on_cells ? FieldLocation::kTriangle : FieldLocation::kVertex,
                     .column_count = name == "c" ? 2U : 1U};
  for (std::size_t i = 0; i < count * values.column_count; ++i) {
    values.values.push_back(rng.Uniform(-1, 1));
  }
  update.values.push_back(std::move(values));
  constexpr std::array kKinds{TransferKind::kLinear, TransferKind::kBounded,
                              TransferKind::kConservative};
  update.transfer = kKinds[rng.Below(3)];
  return update;
}

/// Moves a node of the boundary or of the interior a little; a node of the boundary that leaves its
/// line cuts the segment. What is refused changes nothing, which is fine here.
void MoveRandomly(Remesher& session, Rng& rng) {
  const Mesh& mesh = session.mesh();
  std::vector<VertexId> candidates;
  const bool boundary = rng.Below(2) == 0;
  for (const VertexId vertex : testing::LiveVertices(mesh)) {
    const VertexRecord& record = mesh.vertex(vertex);
    if (!record.fixed && record.edge.valid() == boundary) candidates.push_back(vertex);
  }
  if (candidates.empty()) return;
  const VertexId vertex = candidates[rng.Below(candidates.size())];
  const Vec2 by{rng.Uniform(-0.03, 0.03), rng.Uniform(-0.03, 0.03)};
  const MotionRequest request{
      .vertices = {vertex}, .positions = {mesh.position(vertex) + by}, .tags = {}};
  (void)MoveVertices(session, request);
}

/// Displaces a strip, with tensors of where it goes for all vertices or for the strip.
void DisplaceRandomly(Remesher& session, Rng& rng) {
  const Mesh& mesh = session.mesh();
  const std::vector<VertexId> all = testing::LiveVertices(mesh);
  const double middle = rng.Unit();
  std::vector<VertexId> strip;
  for (const VertexId vertex : all) {
    if (std::fabs(mesh.position(vertex).x - middle) < 0.2) strip.push_back(vertex);
  }
  const std::vector<Vec2> by(strip.size(), {rng.Uniform(-0.2, 0.2), rng.Uniform(-0.02, 0.02)});
  const bool is_of_all = rng.Below(2) == 0 || strip.empty();
  const std::vector<Metric> tensors = RandomTensors(mesh, is_of_all ? all : strip, rng);
  const TensorsAhead request{.displaced = strip,
                             .by = by,
                             .vertices = is_of_all ? std::span<const VertexId>() : strip,
                             .tensors = tensors};
  const MetricLimits limits = session.limits();
  Expect(SetTensorsAhead(session, request, {limits}));
}

}  // namespace

std::unique_ptr<Remesher> SessionScript::Start() const {
  Options options;
  constexpr std::array kVariants{Variant::kNested, Variant::kCooled, Variant::kPaper};
  options.variant = kVariants[seed_ % 3];
  options.seed = seed_;
  options.visits_per_vertex_max = 40;
  MetricSpec spec;
  spec.source = SizeMetric{"0.12 + 0.02*x"};
  if (seed_ % 2 == 0) spec.gradation.gradation = 1.5;
  const Domain domain = Rectangle({0, 0}, {1, 1});
  Result<std::unique_ptr<Remesher>> made =
      seed_ % 5 == 4
          ? Remesher::Create(GridData(4, 4), {.source = SizeMetric{"0.5 + 0.1*x"}}, options)
          : Remesher::Create(domain, spec, options);
  PLIANT_CHECK(made.ok(), "error", made.error().message);
  return *std::move(made);
}

MeshDiff SessionScript::Run(Remesher& session, int n) const {
  Rng rng(seed_ * 1000 + static_cast<std::uint64_t>(n));
  const Mesh& mesh = session.mesh();
  const ElementCounts committed{mesh.vertex_count(), mesh.triangle_count()};
  const std::uint64_t kind = n == 1 ? 3 : rng.Below(8);
  if (kind == 0) {
    Expect(session.SetMetric(RandomSpec(mesh, rng)));
  } else if (kind == 1) {
    const std::vector<VertexId> all = testing::LiveVertices(mesh);
    const std::vector<VertexId> few(
        all.begin(), all.begin() + static_cast<std::ptrdiff_t>(
                                       std::min<std::size_t>(3, 1 + rng.Below(all.size() - 1))));
    const std::vector<Metric> tensors = RandomTensors(mesh, few, rng);
    if (rng.Below(3) == 0) {
      Expect(session.SetTensors(few, tensors, RandomLimits(rng)));
    } else {
      Expect(session.SetTensors(few, tensors));
    }
  } else if (kind == 2) {
    const std::vector<VertexId> all = testing::LiveVertices(mesh);
    Expect(session.SetTensors({}, RandomTensors(mesh, all, rng)));
  } else if (kind == 4) {
    Expect(session.SetLimits(RandomLimits(rng)));
  } else if (kind == 5) {
    DisplaceRandomly(session, rng);
  } else if (kind == 6) {
    const std::vector<VertexId> all = testing::LiveVertices(mesh);
    Expect(session.SetTensors({}, RandomTensors(mesh, all, rng), session.limits(),
                              RandomFunctions(rng)));
  } else if (kind == 7) {
    FunctionsSpec functions = RandomFunctions(rng);
    if (session.functions() != nullptr && rng.Below(2) == 0) {
      functions = *session.functions();
      functions.time = rng.Unit();
    }
    Expect(session.SetFunctions(functions, session.limits()));
  }
  if (n > 1 && rng.Below(3) == 0) MoveRandomly(session, rng);
  if (n > 1 && rng.Below(3) == 0) {
    const FieldUpdate update = RandomFields(committed, rng);
    // A field that is not there cannot be dropped.
    const bool drops = !update.dropped_names.empty();
    if (!drops || session.fields().Find(update.dropped_names[0]) != nullptr) {
      Expect(session.SetFields(update));
    }
  }
  const bool cut_short = rng.Below(3) == 0;
  const std::int64_t visits =
      cut_short ? static_cast<std::int64_t>(1 + rng.Below(150)) : std::int64_t{4000};
  const auto progress = session.Step({.visits_max = visits});
  PLIANT_CHECK(progress.ok(), "error", progress.error().message);
  return session.Commit();
}

}  // namespace pliant::testing
