// Goal: whatever moves, mixed with metric updates, every revision is valid, every given position
// arrives, every replica follows, and every refusal leaves no trace.
// Method: random bodies in a box, random motions (short, long, many at once, by id and by tag, some
// impossible) and random sizes, adversarial ones among them. One seed makes one session.
//
//   PLIANT_SEED=17 core_tests --gtest_filter='*RandomMotions*'   replays the session of a failure
//   PLIANT_LONG_TESTS=1                                          25 times as many

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/delaunay/import_mesh.h"
#include "core/mesh/export_mesh.h"
#include "core/mesh/validate.h"
#include "core/motion/move.h"
#include "core/motion/soften.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/misplaced.h"
#include "tests/support/seed.h"

namespace pliant {
namespace {

using testing::Faults;

constexpr std::uint64_t kMotionParts = 4;
constexpr test::Seeds kSeeds = {.count = 200, .long_count = 5000, .part_count = kMotionParts};
constexpr std::int64_t kVisitsMax = 3'000'000;
constexpr std::int32_t kFirstBody = 10;

/// A hole that is turned inside out makes no triangle negative, but some of them overlap then.
bool CoversItsDomainOnce(const Mesh& mesh) { return PlanImport(ExportMesh(mesh).data).ok(); }

class RandomSession {
 public:
  explicit RandomSession(std::uint64_t seed) : rng_(seed * 2654435761U + 7) {}

  void Run() {
    Start();
    const int updates = 2 + static_cast<int>(rng_.Below(4));
    for (int i = 0; i < updates && !::testing::Test::HasFatalFailure(); ++i) {
      SCOPED_TRACE("update " + std::to_string(i));
      if (rng_.Below(3) == 0) ChangeMetric();
      TryMotion();
      if (rng_.Below(4) == 0) ChangeMetric();
      Soften();
      Finish();
    }
  }

 private:
  /// One to four bodies, one to a quarter of the unit square: polygons, slits, thin ellipses.
  void Start() {
    Domain domain = testing::Rectangle({0, 0}, {1, 1});
    body_count_ = 1 + static_cast<std::int32_t>(rng_.Below(4));
    for (std::int32_t body = 0; body < body_count_; ++body) {
      const Vec2 center{0.25 + 0.5 * (body % 2), 0.25 + 0.5 * (body / 2)};
      centers_.push_back(center);
      AddBody(domain, body, center);
    }
    Options options;
    if (rng_.Below(2) == 0) options.boundary_tolerance = rng_.Below(2) == 0 ? 1e-3 : 0.02;
    auto made = Remesher::Create(domain, Size(), options);
    ASSERT_TRUE(made.ok()) << made.error().message;
    remesher_ = std::move(*made);
    Finish();
  }

  void AddBody(Domain& domain, std::int32_t body, Vec2 center) {
    const auto first = static_cast<std::int32_t>(domain.points.size());
    const auto corners = static_cast<std::int32_t>(2 + rng_.Below(20));
    const double a = rng_.Uniform(0.02, 0.2);
    const double b = rng_.Below(3) == 0 ? a * rng_.Uniform(0.01, 0.2) : a * rng_.Uniform(0.3, 1);
    for (std::int32_t i = 0; i < corners; ++i) {
      const double angle = 2 * std::numbers::pi * i / corners;
      domain.points.push_back(center + Vec2{a * std::cos(angle), b * std::sin(angle)});
    }
    // Two corners make a slit in the domain; some bodies are regions and no holes.
    const std::int32_t sides = corners == 2 ? 1 : corners;
    for (std::int32_t i = 0; i < sides; ++i) {
      domain.segments.push_back({first + i, first + (i + 1) % corners, kFirstBody + body});
    }
    if (corners > 2 && rng_.Below(4) != 0) domain.holes.push_back(center);
  }

  MetricSpec Size() {
    static const char* const kSizes[] = {"0.05", "0.02+0.2*abs(x-y)", "0.3", "x<0.5 ? 0.02 : 0.1",
                                         "0.01+0.3*hypot(x-0.5,y-0.5)"};
    MetricSpec spec;
    spec.source = SizeMetric{kSizes[rng_.Below(5)]};
    if (rng_.Below(4) == 0) {
      spec.source = ExpressionMetric{.m11 = "900", .m12 = "0", .m22 = "100+2000*x*x"};
    }
    if (rng_.Below(4) == 0) spec.gradation.gradation = 1.5;
    return spec;
  }

  void ChangeMetric() {
    const Status status = remesher_->SetMetric(Size());
    ASSERT_TRUE(status.ok()) << status.error().message;
    if (rng_.Below(2) == 0) Step(static_cast<std::int64_t>(1 + rng_.Below(200)));
  }

  Vec2 RandomVector(double size) { return {rng_.Uniform(-size, size), rng_.Uniform(-size, size)}; }

  PathShape RandomShape(std::int32_t body) {
    const double reach = rng_.Below(2) == 0 ? 0.03 : 0.5;
    switch (rng_.Below(4)) {
      case 0:
        return Rotation{centers_[static_cast<std::size_t>(body)] + RandomVector(0.05),
                        rng_.Uniform(-1, 1) * (rng_.Below(3) == 0 ? 7 : 0.4)};
      case 1: {
        const Vec2 c = centers_[static_cast<std::size_t>(body)];
        const double s = rng_.Uniform(0.5, 1.5);
        const double t = rng_.Uniform(-0.3, 0.3);
        return AffineMap{s, t, -t, s, {c.x - s * c.x - t * c.y, c.y + t * c.x - s * c.y}};
      }
      case 2:
        return PolynomialPath{{RandomVector(reach), RandomVector(reach)}};
      default:
        return Translation{RandomVector(reach)};
    }
  }

  MotionRequest RandomRequest() {
    MotionRequest request;
    if (rng_.Below(3) != 0) {
      for (std::int32_t body = 0; body < body_count_; ++body) {
        if (body > 0 && rng_.Below(2) == 0) continue;
        request.tags.push_back({{kFirstBody + body}, RandomShape(body)});
      }
    }
    const std::uint64_t kind = request.tags.empty() ? 1 + rng_.Below(2) : rng_.Below(4);
    const Mesh& mesh = remesher_->mesh();
    const double noise = rng_.Below(2) == 0 ? 1e-3 : 0.02;
    for (std::int32_t i = 0; i < mesh.vertex_slots() && (kind == 1 || kind == 2); ++i) {
      const VertexId vertex(i);
      if (!mesh.vertex(vertex).live) continue;
      // All nodes of a boundary, or some of all nodes.
      const bool chosen = kind == 1 ? mesh.vertex(vertex).edge.valid() : rng_.Below(5) == 0;
      if (!chosen) continue;
      request.vertices.push_back(vertex);
      request.positions.push_back(mesh.position(vertex) + RandomVector(noise));
    }
    if (rng_.Below(3) == 0) request.follow_length = rng_.Uniform(0, 5);
    if (rng_.Below(3) == 0) request.on_impossible = ImpossibleMotion::kStop;
    return request;
  }

  void TryMotion() {
    const MotionRequest request = RandomRequest();
    const std::vector<VertexRecord> before = Records();
    const double area = Area(remesher_->mesh());
    const auto report =
        MoveVertices(*remesher_, request, [](const Mesh& mesh) { ASSERT_EQ(Faults(mesh), ""); });
    ASSERT_EQ(Faults(remesher_->mesh()), "");
    ASSERT_TRUE(CoversItsDomainOnce(remesher_->mesh()));
    if (!report.ok()) {
      ASSERT_TRUE(report.error().code == ErrorCode::kCrossingSegments ||
                  testing::IsMisplaced(remesher_->mesh(), request, report.error()))
          << report.error().message;
      ASSERT_EQ(request.on_impossible, ImpossibleMotion::kRefuse);
      ASSERT_EQ(Area(remesher_->mesh()), area);
      const std::vector<VertexRecord> after = Records();
      ASSERT_EQ(before.size(), after.size());
      for (std::size_t i = 0; i < before.size(); ++i) {
        ASSERT_EQ(before[i].live, after[i].live);
        ASSERT_EQ(before[i].position, after[i].position);
        ASSERT_EQ(before[i].visit, after[i].visit);
      }
      return;
    }
    if (report->fraction < 1) {
      ASSERT_EQ(request.on_impossible, ImpossibleMotion::kStop);
      return;
    }
    for (std::size_t i = 0; i < request.vertices.size(); ++i) {
      ASSERT_TRUE(remesher_->mesh().IsLive(request.vertices[i]));
      ASSERT_EQ(remesher_->mesh().position(request.vertices[i]), request.positions[i]);
    }
  }

  [[nodiscard]] std::vector<VertexRecord> Records() const {
    std::vector<VertexRecord> records;
    for (std::int32_t i = 0; i < remesher_->mesh().vertex_slots(); ++i) {
      records.push_back(remesher_->mesh().vertex(VertexId(i)));
    }
    return records;
  }

  void Step(std::int64_t visits) {
    const auto progress = remesher_->Step({.visits_max = visits});
    ASSERT_TRUE(progress.ok());
    ASSERT_EQ(Faults(remesher_->mesh()), "");
  }

  /// No point of a boundary moves farther than the tolerance, so that the area of the domain can
  /// not change by more than a strip of that width.
  void Soften() {
    const double area = Area(remesher_->mesh());
    double length = 0;
    for (const auto& [tag, of_tag] : testing::TagLengths(remesher_->mesh())) length += of_tag;
    const auto report = SoftenBoundary(*remesher_);
    ASSERT_TRUE(report.ok()) << report.error().message;
    ASSERT_EQ(Faults(remesher_->mesh()), "");
    const double tolerance = remesher_->options().boundary_tolerance;
    ASSERT_LE(std::fabs(Area(remesher_->mesh()) - area), tolerance * length + 1e-12);
  }

  /// Runs the loop to its end, then commits or rolls back.
  void Finish() {
    const auto progress = remesher_->Step({.visits_max = kVisitsMax});
    ASSERT_TRUE(progress.ok()) << progress.error().message;
    ASSERT_EQ(progress->stop_reason, StopReason::kConverged);
    ASSERT_EQ(Faults(remesher_->mesh()), "");
    if (remesher_->revision() != Revision::kNone && rng_.Below(5) == 0) {
      remesher_->Rollback();
      ASSERT_EQ(Faults(remesher_->mesh()), "");
      ASSERT_EQ(replica_.DifferenceTo(remesher_->mesh()), "");
      return;
    }
    ASSERT_EQ(replica_.Apply(remesher_->Commit()), "");
    ASSERT_EQ(replica_.DifferenceTo(remesher_->mesh()), "");
  }

  Rng rng_;
  std::int32_t body_count_ = 0;
  std::vector<Vec2> centers_;
  std::unique_ptr<Remesher> remesher_;
  testing::Replica replica_;
};

class RandomMotions : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(RandomMotions, KeepEveryPromise) {
  for (const std::uint64_t seed : kSeeds.OfPart(GetParam())) {
    SCOPED_TRACE(test::Replay(seed, "core_tests", "*RandomMotions*/0"));
    RandomSession(seed).Run();
    if (HasFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(Part, RandomMotions, ::testing::Range<std::uint64_t>(0, kMotionParts));

}  // namespace
}  // namespace pliant
