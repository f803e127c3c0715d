// Goal: whatever updates of all kinds follow each other in one session, every mesh is valid, every
// replica has the bits of the mesh, every refusal leaves everything as it was, and every rollback,
// undo and redo leads to the bits of the revision that it names.
// Method: random sequences of metrics (formulas, tensors, background meshes, limits, adversarial
// sizes), moved boundaries and nodes, displacements with and without tensors, other domains,
// options, constraints, fields, loops that are cut short, rollbacks and undo. One seed makes one
// session.
//
//   PLIANT_SEED=17 core_tests --gtest_filter='*RandomSequences*'   replays the session of a failure
//   PLIANT_LONG_TESTS=1                                            5,000 instead of 200

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/export_mesh.h"
#include "core/mesh/validate.h"
#include "core/motion/move.h"
#include "core/motion/replace_domain.h"
#include "core/motion/soften.h"
#include "core/pliant/displace.h"
#include "core/pliant/displace_tensors.h"
#include "tests/support/cell_domain.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/misplaced.h"
#include "tests/support/seed.h"

namespace pliant {
namespace {

using testing::Faults;

constexpr std::uint64_t kParts = 4;
constexpr test::Seeds kSeeds = {.count = 200, .long_count = 5000, .part_count = kParts};
constexpr std::int64_t kVisitsMax = 3'000'000;

/// What limits did over the whole mesh.
std::array<double, 6> LimitTotalsOf(const Remesher& remesher) {
  const MetricReport& report = remesher.metric_report();
  return {static_cast<double>(report.smoothing_count),
          static_cast<double>(report.geometry_count),
          static_cast<double>(report.rotation_count),
          static_cast<double>(report.gradation_count),
          report.raw_complexity,
          report.limited_complexity};
}

/// What a refused update must leave alone.
struct Traces {
  std::vector<VertexRecord> vertices;
  std::vector<TriangleRecord> triangles;
  std::vector<EdgeRecord> edges;

  explicit Traces(const Mesh& mesh)
      : vertices(mesh.vertex_records().begin(), mesh.vertex_records().end()),
        triangles(mesh.triangle_records().begin(), mesh.triangle_records().end()),
        edges(mesh.edge_records().begin(), mesh.edge_records().end()) {}

  void ExpectOf(const Mesh& mesh) const {
    ASSERT_EQ(mesh.vertex_records().size(), vertices.size());
    ASSERT_EQ(mesh.triangle_records().size(), triangles.size());
    ASSERT_EQ(mesh.edge_records().size(), edges.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const VertexRecord& now = mesh.vertex_records()[i];
      ASSERT_EQ(now.live, vertices[i].live) << i;
      ASSERT_EQ(now.position, vertices[i].position) << i;
      ASSERT_EQ(now.metric, vertices[i].metric) << i;
      ASSERT_EQ(now.visit, vertices[i].visit) << i;
    }
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      ASSERT_EQ(mesh.triangle_records()[i].live, triangles[i].live) << i;
      ASSERT_EQ(mesh.triangle_records()[i].vertices, triangles[i].vertices) << i;
      ASSERT_EQ(mesh.triangle_records()[i].region, triangles[i].region) << i;
    }
    for (std::size_t i = 0; i < edges.size(); ++i) {
      ASSERT_EQ(mesh.edge_records()[i].vertices, edges[i].vertices) << i;
      ASSERT_EQ(mesh.edge_records()[i].tag, edges[i].tag) << i;
    }
  }
};

class RandomSession {
 public:
  explicit RandomSession(std::uint64_t seed)
      : rng_(seed * 2654435761U + 23), cells_(static_cast<std::int32_t>(2 + rng_.Below(3)), rng_) {}

  void Run() {
    auto made = Remesher::Create(cells_.domain(), RandomSpec(), {});
    ASSERT_TRUE(made.ok()) << made.error().message;
    remesher_ = std::move(*made);
    ASSERT_NO_FATAL_FAILURE(Step(kVisitsMax));
    ASSERT_NO_FATAL_FAILURE(Commit());
    const int count = 6 + static_cast<int>(rng_.Below(6));
    for (int i = 0; i < count; ++i) {
      SCOPED_TRACE("update " + std::to_string(i));
      ASSERT_NO_FATAL_FAILURE(Update());
      ASSERT_EQ(Faults(remesher_->mesh()), "") << last_;
      if (rng_.Below(3) == 0) continue;  // Several in one revision.
      if (rng_.Below(5) != 0) {
        ASSERT_NO_FATAL_FAILURE(Soften());
        ASSERT_NO_FATAL_FAILURE(Step(rng_.Below(4) == 0 ? 50 : kVisitsMax));
      }
      if (rng_.Below(5) == 0) {
        ASSERT_NO_FATAL_FAILURE(Rollback());
      } else {
        ASSERT_NO_FATAL_FAILURE(Commit());
      }
    }
  }

 private:
  [[nodiscard]] const Mesh& mesh() const { return remesher_->mesh(); }
  Vec2 RandomVector(double size) { return {rng_.Uniform(-size, size), rng_.Uniform(-size, size)}; }

  MetricSpec RandomSpec() {
    static const char* const kSizes[] = {"0.08",
                                         "0.03+0.2*abs(x-y)",
                                         "0.4",
                                         "x<0.5 ? 0.03 : 0.2",
                                         "0.02+0.3*hypot(x-0.5,y-0.5)",
                                         "0.05+0.04*sin(7*x+t)"};
    MetricSpec spec;
    spec.source = SizeMetric{kSizes[rng_.Below(6)]};
    if (rng_.Below(4) == 0) {
      spec.source = ExpressionMetric{.m11 = "600", .m12 = "0", .m22 = "60+1500*x*x"};
    }
    if (rng_.Below(4) == 0) spec.gradation.gradation = 1.5;
    if (rng_.Below(5) == 0) spec.gradation.geometry = 1;
    if (rng_.Below(5) == 0) spec.gradation.gap_element_count = 1;
    if (rng_.Below(5) == 0) spec.gradation.smoothing_count = 2;
    if (rng_.Below(4) == 0) spec.bounds.size_min = 0.06;
    spec.time = rng_.Uniform(0, 3);
    return spec;
  }

  void Update() {
    switch (rng_.Below(9)) {
      case 0:
        last_ = "formula";
        return Expect(remesher_->SetMetric(RandomSpec()));
      case 1:
        last_ = "background";
        return SetBackground();
      case 2:
        last_ = "tensors";
        return SetTensors();
      case 3:
        last_ = "motion";
        return Move();
      case 4:
        last_ = "displacement";
        return Displace();
      case 5:
      case 6:
        last_ = "domain";
        return Replace();
      case 7:
        last_ = "constraints and options";
        return Constrain();
      default:
        last_ = "fields";
        return SetFields();
    }
  }

  static void Expect(const Status& status) { ASSERT_TRUE(status.ok()) << status.error().message; }

  Metric RandomTensor() {
    const double long_size = 1 / rng_.Uniform(0.06, 0.4);
    const double short_size = long_size * (rng_.Below(4) == 0 ? rng_.Uniform(1, 8) : 1);
    const double c = rng_.Uniform(-1, 1);
    const double s = std::sqrt(1 - c * c);
    return MetricFromAxes({1 / long_size, 1 / short_size, {c, s}});
  }

  void SetBackground() {
    const ExportedMesh exported = ExportMesh(mesh());
    BackgroundMetric background{exported.data, {}};
    for (std::size_t i = 0; i < exported.data.points.size(); ++i) {
      const double h = 0.05 + 0.1 * std::fabs(exported.data.points[i].x - 0.3);
      background.tensors.push_back(Metric{1 / (h * h), 0, 1 / (h * h)});
    }
    MetricSpec spec;
    spec.source = std::move(background);
    Expect(remesher_->SetMetric(spec));
  }

  /// At all vertices, at a few, or at half of them without any sense.
  void SetTensors() {
    const std::uint64_t kind = rng_.Below(3);
    std::vector<VertexId> vertices;
    std::vector<Metric> tensors;
    const double h = rng_.Uniform(0.05, 0.2);
    for (const VertexId id : testing::LiveVertices(mesh())) {
      if (kind == 1 && rng_.Below(20) != 0) continue;
      if (kind == 2 && rng_.Below(2) != 0) continue;
      vertices.push_back(id);
      tensors.push_back(kind == 2 ? RandomTensor() : Metric{1 / (h * h), 0, 1 / (h * h)});
    }
    if (vertices.empty()) return;
    if (remesher_->revision() == Revision::kNone || rng_.Below(3) != 0) {
      return Expect(remesher_->SetTensors(vertices, tensors));
    }
    const FunctionsSpec functions{.parts = {SizeMetric{"0.05 + 0.3*abs(x - y)"}},
                                  .time = rng_.Unit()};
    Expect(remesher_->SetTensors(vertices, tensors, remesher_->limits(), functions));
  }

  void Move() {
    MotionRequest request;
    const double reach = rng_.Below(2) == 0 ? 0.02 : 0.4;
    if (rng_.Below(2) == 0) {
      std::vector<std::int32_t> tags;
      for (const auto& [tag, length] : testing::TagLengths(mesh())) {
        if (rng_.Below(3) == 0) tags.push_back(tag);
      }
      if (!tags.empty()) request.tags.push_back({tags, Translation{RandomVector(reach)}});
    }
    const bool named = request.tags.empty();
    for (const VertexId id : testing::LiveVertices(mesh())) {
      if (!named || rng_.Below(6) != 0) continue;
      request.vertices.push_back(id);
      request.positions.push_back(mesh().position(id) + RandomVector(0.02));
    }
    if (rng_.Below(3) == 0) request.follow_length = rng_.Uniform(0, 5);
    if (rng_.Below(3) == 0) request.on_impossible = ImpossibleMotion::kStop;
    const Traces before(mesh());
    const auto report = MoveVertices(*remesher_, request);
    if (report.ok()) return;
    const ErrorCode code = report.error().code;
    ASSERT_TRUE(code == ErrorCode::kCrossingSegments || code == ErrorCode::kFrozen ||
                testing::IsMisplaced(mesh(), request, report.error()))
        << report.error().message;
    before.ExpectOf(mesh());
  }

  void Displace() {
    std::vector<VertexId> vertices;
    const double left = rng_.Uniform(0, 0.8);
    for (const VertexId id : testing::LiveVertices(mesh())) {
      const double x = mesh().position(id).x;
      if (x > left && x < left + 0.2) vertices.push_back(id);
    }
    const std::vector<Vec2> by(vertices.size(), RandomVector(rng_.Below(2) == 0 ? 0.02 : 0.2));
    const Traces before(mesh());
    const Status status =
        rng_.Below(2) == 0 ? DisplaceAlone(vertices, by) : DisplaceWithTensors(vertices, by);
    if (status.ok()) return;
    ASSERT_EQ(status.error().code, ErrorCode::kFrozen) << status.error().message;
    before.ExpectOf(mesh());
  }

  Status DisplaceAlone(std::span<const VertexId> vertices, std::span<const Vec2> by) {
    DisplaceVertices displacement(vertices, by);
    return remesher_->Apply(displacement);
  }

  /// Tensors of where the displacement leads: of all vertices, or of half of them.
  Status DisplaceWithTensors(std::span<const VertexId> vertices, std::span<const Vec2> by) {
    const bool is_of_all = rng_.Below(2) == 0;
    std::vector<VertexId> senders;
    std::vector<Metric> tensors;
    const double h = rng_.Uniform(0.05, 0.2);
    for (const VertexId id : testing::LiveVertices(mesh())) {
      if (!is_of_all && rng_.Below(2) != 0) continue;
      if (!is_of_all) senders.push_back(id);
      tensors.push_back(Metric::Isotropic(h + 0.1 * mesh().position(id).x));
    }
    if (tensors.empty()) return DisplaceAlone(vertices, by);
    const TensorsAhead request{
        .displaced = vertices, .by = by, .vertices = senders, .tensors = tensors};
    const MetricLimits limits = remesher_->limits();
    if (remesher_->revision() == Revision::kNone || rng_.Below(3) != 0) {
      return SetTensorsAhead(*remesher_, request, {limits});
    }
    const FunctionsSpec functions{.parts = {SizeMetric{"0.05 + 0.3*abs(x - y)"}},
                                  .time = rng_.Unit()};
    return SetTensorsAhead(*remesher_, request, {limits, &functions});
  }

  void Replace() {
    cells_.Change(rng_);
    const Traces before(mesh());
    const auto report = ReplaceDomain(*remesher_, cells_.domain());
    if (report.ok()) {
      ASSERT_NEAR(Area(mesh()), cells_.area(), 1e-9);
      const auto regions = testing::RegionAreas(mesh());
      ASSERT_EQ(regions.size(), cells_.region_areas().size());
      for (const auto& [tag, area] : cells_.region_areas()) {
        ASSERT_NEAR(regions.at(tag), area, 1e-9);
      }
      return;
    }
    const ErrorCode code = report.error().code;
    ASSERT_TRUE((code == ErrorCode::kFrozen && freezes_) ||
                (code == ErrorCode::kUnimplemented && conserves_))
        << report.error().message;
    before.ExpectOf(mesh());
  }

  void Constrain() {
    if (rng_.Below(2) == 0) {
      Options options = remesher_->options();
      options.metric_tolerance = rng_.Uniform(0.01, 0.2);
      options.hops_max = static_cast<std::int32_t>(1 + rng_.Below(20));
      options.boundary_tolerance = rng_.Below(2) == 0 ? 0 : rng_.Uniform(0, 0.05);
      return Expect(remesher_->SetOptions(options));
    }
    Constraints constraints;
    freezes_ = rng_.Below(2) == 0;
    if (freezes_) {
      const auto regions = testing::RegionAreas(mesh());
      if (rng_.Below(3) == 0) constraints.regions.push_back(regions.begin()->first);
      for (const VertexId id : testing::LiveVertices(mesh())) {
        if (rng_.Below(10) == 0) constraints.vertices.push_back(id);
      }
    }
    constraints.permissions.swap = rng_.Below(6) != 0;
    constraints.permissions.insert = rng_.Below(6) != 0;
    Expect(remesher_->SetConstraints(constraints));
  }

  /// Names and values are those of the last commit, so that there is one first; a field that was
  /// dropped since could not be dropped again.
  void SetFields() {
    ASSERT_NO_FATAL_FAILURE(Commit());
    if (rng_.Below(4) == 0) {
      for (const Field& field : remesher_->fields().fields()) {
        Expect(remesher_->SetFields({.dropped_names = {field.name}}));
      }
      return;
    }
    FieldUpdate update;
    FieldValues values{.name = rng_.Below(2) == 0 ? "u" : "v", .values = {}};
    for (const VertexId id : testing::LiveVertices(mesh())) {
      values.values.push_back(mesh().position(id).x);
    }
    update.values.push_back(std::move(values));
    update.transfer = rng_.Below(4) == 0   ? TransferKind::kConservative
                      : rng_.Below(2) == 0 ? TransferKind::kBounded
                                           : TransferKind::kLinear;
    conserves_ = conserves_ || update.transfer == TransferKind::kConservative;
    Expect(remesher_->SetFields(update));
  }

  void Soften() {
    const auto report = SoftenBoundary(*remesher_);
    ASSERT_TRUE(report.ok()) << last_ << ": " << report.error().message;
    ASSERT_EQ(Faults(mesh()), "") << last_;
  }

  void Step(std::int64_t visits) {
    const auto progress = remesher_->Step({.visits_max = visits});
    ASSERT_TRUE(progress.ok()) << last_ << ": " << progress.error().message;
    ASSERT_EQ(Faults(mesh()), "") << last_;
  }

  void Commit() {
    const bool tries_undo = committed_ != nullptr && rng_.Below(3) == 0;
    ASSERT_EQ(replica_.Apply(remesher_->CommitAndTransfer()), "") << last_;
    ASSERT_EQ(replica_.DifferenceTo(mesh()), "") << last_;
    const auto bytes = remesher_->Save();
    ASSERT_TRUE(bytes.ok()) << bytes.error().message;
    if (tries_undo) {
      const auto undo = remesher_->TakeUndo();
      ASSERT_TRUE(undo.has_value());
      const RevisionDelta redo = remesher_->InverseOf(*undo);
      const auto undone = remesher_->Apply(*undo, undo->revision);
      ASSERT_TRUE(undone.ok()) << undone.error().message;
      ASSERT_EQ(testing::DifferenceOf(mesh(), committed_->mesh()), "") << "undo of " << last_;
      const auto redone = remesher_->Apply(redo, redo.revision);
      ASSERT_TRUE(redone.ok()) << redone.error().message;
      ASSERT_TRUE(*remesher_->Save() == *bytes) << "redo of " << last_;
    }
    auto loaded = Remesher::Load(*bytes);
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    committed_ = std::move(*loaded);
    // Limits that followed the mesh are those of a mesh that was loaded, which are laid anew.
    ASSERT_EQ(LimitTotalsOf(*remesher_), LimitTotalsOf(*committed_)) << last_;
    ASSERT_EQ(testing::DifferenceOf(mesh(), committed_->mesh()), "") << last_;
  }

  void Rollback() {
    remesher_->Rollback();
    ASSERT_EQ(Faults(mesh()), "") << last_;
    ASSERT_EQ(replica_.DifferenceTo(mesh()), "") << last_;
    ASSERT_EQ(testing::DifferenceOf(mesh(), committed_->mesh()), "") << last_;
    ASSERT_TRUE(*remesher_->Save() == *committed_->Save()) << last_;
    freezes_ = true;  // What the last revision froze holds again; it may be nothing.
    conserves_ = true;
  }

  Rng rng_;
  testing::CellDomain cells_;
  std::unique_ptr<Remesher> remesher_;
  std::unique_ptr<Remesher> committed_;  // As it was saved at the last commit.
  testing::Replica replica_;
  std::string last_;        // Kind of the last update.
  bool freezes_ = false;    // Something may be frozen.
  bool conserves_ = false;  // A field may be conservative.
};

class RandomSequences : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(RandomSequences, KeepEveryPromise) {
  for (const std::uint64_t seed : kSeeds.OfPart(GetParam())) {
    SCOPED_TRACE(test::Replay(seed, "core_tests", "*RandomSequences*/0"));
    RandomSession(seed).Run();
    if (HasFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(Part, RandomSequences, ::testing::Range<std::uint64_t>(0, kParts));

}  // namespace
}  // namespace pliant
