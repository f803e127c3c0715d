// Goal: where a metric cannot be met the report says where, how much and why; where it can be met
// it says nothing. Method: one case for each kind, whose place and reason are known beforehand.

#include "core/pliant/trouble.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/metric/function_field.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Case;

template <class Function>
std::unique_ptr<MetricField> MakeField(Function function) {
  return std::make_unique<FunctionField<Function>>(std::move(function));
}

std::unique_ptr<Remesher> Build(Case from, const Options& options = {}) {
  auto made = Remesher::Create(from.domain, std::move(from.field), options);
  EXPECT_TRUE(made.ok()) << made.error().message;
  EXPECT_TRUE((*made)->Step({}).ok());
  EXPECT_EQ(testing::Faults((*made)->mesh()), "");
  return std::move(*made);
}

std::string Text(const Trouble& t) {
  std::ostringstream text;
  text << "kind " << static_cast<int>(t.kind) << ", " << t.vertex_count << " vertices in "
       << t.place_count << " places, box (" << t.box.low.x << ' ' << t.box.low.y << ")-("
       << t.box.high.x << ' ' << t.box.high.y << "), center " << t.center.x << ' ' << t.center.y
       << ", q " << t.q_min << ", lengths " << t.length_min << " to " << t.length_max;
  return text.str();
}

std::string Text(const std::vector<Trouble>& troubles) {
  std::string text;
  for (const Trouble& trouble : troubles) text += Text(trouble) + "\n";
  return text;
}

std::int64_t VertexCount(const std::vector<Trouble>& troubles, TroubleKind kind) {
  std::int64_t count = 0;
  for (const Trouble& trouble : troubles) count += trouble.kind == kind ? trouble.vertex_count : 0;
  return count;
}

/// Most of the vertices in trouble are in trouble of this kind.
void ExpectMostly(TroubleKind kind, const std::vector<Trouble>& troubles) {
  ASSERT_FALSE(troubles.empty());
  std::int64_t all = 0;
  for (const Trouble& trouble : troubles) {
    all += trouble.vertex_count;
    EXPECT_TRUE(trouble.q_min < kTroubleQuality || trouble.length_min < kTroubleLengthMin ||
                trouble.length_max > kTroubleLengthMax)
        << Text(trouble);
  }
  EXPECT_GE(VertexCount(troubles, kind), 0.8 * static_cast<double>(all)) << Text(troubles);
}

TEST(FindTroubles, SaysNothingOfMetricsThatCanBeMet) {
  EXPECT_EQ(Text(Build(testing::GaussianCase(10'000))->FindTroubles()), "");
  EXPECT_EQ(Text(Build(testing::DiagonalCase(925))->FindTroubles()), "");
  EXPECT_EQ(Text(Build(testing::DiagonalCase(20'000))->FindTroubles()), "");
  EXPECT_EQ(Text(Build(testing::DiscCase(5'000, testing::DiscState::kOn))->FindTroubles()), "");
}

TEST(FindTroubles, FindsTheJumpOfTheSize) {
  const auto troubles = Build(testing::JumpCase())->FindTroubles();
  ExpectMostly(TroubleKind::kSizeJump, troubles);
  for (const Trouble& trouble : troubles) {
    EXPECT_GT(trouble.box.high.x, 0.7) << Text(trouble);
    EXPECT_LT(trouble.box.low.x, 0.87) << Text(trouble);
  }
}

TEST(FindTroubles, FindsCrossedDirections) {
  const auto troubles = Build(testing::CheckerboardCase())->FindTroubles();
  ExpectMostly(TroubleKind::kCrossed, troubles);
}

TEST(FindTroubles, FindsAHoleThatIsSmallerThanTheWantedSize) {
  Case holed{testing::Rectangle({0, 0}, {1, 1}), nullptr};
  constexpr Vec2 kCenter{0.3, 0.6};
  for (int k = 0; k < 4; ++k) {
    const Vec2 corner{k == 0 || k == 3 ? -1e-3 : 1e-3, k < 2 ? -1e-3 : 1e-3};
    holed.domain.points.push_back(kCenter + corner);
    holed.domain.segments.push_back({4 + k, 4 + (k + 1) % 4, 5});
  }
  holed.domain.holes = {kCenter};
  holed.field = MakeField([](Vec2) { return Metric::Isotropic(0.05); });
  const auto troubles = Build(std::move(holed))->FindTroubles();
  ASSERT_EQ(troubles.size(), 1U) << Text(troubles);
  EXPECT_EQ(troubles[0].kind, TroubleKind::kGeometry);
  EXPECT_LT(Length(troubles[0].center - kCenter), 0.05) << Text(troubles);
  EXPECT_NEAR(troubles[0].length_min, 2e-3 / 0.05, 1e-9);
  EXPECT_LT(troubles[0].box.high.x - troubles[0].box.low.x, 0.3) << Text(troubles);
}

TEST(FindTroubles, FindsAChannelThatIsNarrowerThanTheWantedSize) {
  Case channel{testing::Rectangle({0, 0}, {10, 0.02}),
               MakeField([](Vec2) { return Metric::Isotropic(0.2); })};
  const auto troubles = Build(std::move(channel))->FindTroubles();
  ASSERT_EQ(troubles.size(), 1U) << Text(troubles);
  EXPECT_EQ(troubles[0].kind, TroubleKind::kGeometry) << Text(troubles);
  EXPECT_LT(troubles[0].length_min, 0.12);
}

// A ring of radius 0.3 that asks for 1:800 along it: an edge of the wanted length strays from the
// ring by several times its thickness.
TEST(FindTroubles, FindsAFrontThatIsTooCurved) {
  Case ring{testing::Rectangle({0, 0}, {1, 1}), MakeField([](Vec2 p) {
              const Vec2 e = p - Vec2{0.5, 0.5};
              const double r = std::max(Length(e), 1e-9);
              const Vec2 n = (1 / r) * e;
              const double thin = std::min(3e-4 + 2.0 * std::fabs(r - 0.3), 0.18);
              const double a = 1 / (thin * thin);
              const double b = 1 / (0.18 * 0.18);
              return Metric{a * n.x * n.x + b * n.y * n.y, (a - b) * n.x * n.y,
                            a * n.y * n.y + b * n.x * n.x};
            })};
  const auto troubles = Build(std::move(ring))->FindTroubles();
  ExpectMostly(TroubleKind::kCurvature, troubles);
  for (const Trouble& trouble : troubles) {
    if (trouble.kind != TroubleKind::kCurvature) continue;
    EXPECT_NEAR(Length(trouble.center - Vec2{0.5, 0.5}), 0.3, 0.1) << Text(trouble);
  }
}

TEST(FindTroubles, FindsRefusedInsertions) {
  Options options;
  options.vertices_max = 500;
  const auto troubles = Build(testing::DiagonalCase(20'000), options)->FindTroubles();
  ExpectMostly(TroubleKind::kVertexLimit, troubles);
}

// The metric of one corner cannot be met after an update; nothing else changed, and nothing else is
// looked at.
TEST(FindTroubles, LooksOnlyAtWhatChangedSinceTheLastCommit) {
  const auto remesher = Build(testing::JumpCase());
  EXPECT_FALSE(remesher->FindTroubles().empty());
  (void)remesher->Commit();
  EXPECT_EQ(Text(remesher->FindTroubles()), "");
  ASSERT_TRUE(remesher
                  ->SetField(MakeField([](Vec2 p) {
                    const bool corner = p.x < 0.15 && p.y < 0.15;
                    return Metric::Isotropic(corner ? 0.004 : p.x < 0.83 ? 0.1 : 0.005);
                  }))
                  .ok());
  ASSERT_TRUE(remesher->Step({}).ok());
  const auto troubles = remesher->FindTroubles();
  ExpectMostly(TroubleKind::kSizeJump, troubles);
  for (const Trouble& trouble : troubles) {
    EXPECT_LT(trouble.box.high.x, 0.6) << Text(trouble);
  }
}

// Goal: where to look is taken down before a commit, and looked at right after it: of the first
// mesh, which closes gaps in its numbers, and of an update, with vertices that are gone.
TEST(FindTroubles, SaysTheSameRightAfterTheCommit) {
  const auto remesher = Build(testing::JumpCase());
  for (const double finer : {1.0, 0.8, 1.25}) {
    SCOPED_TRACE(::testing::Message() << finer);
    if (finer != 1) {
      std::vector<VertexId> vertices;
      std::vector<Metric> tensors;
      for (std::int32_t v = 0; v < remesher->mesh().vertex_slots(); v += 2) {
        if (!remesher->mesh().IsLive(VertexId(v))) continue;
        vertices.emplace_back(v);
        tensors.push_back((1 / (finer * finer)) * remesher->mesh().metric(VertexId(v)));
      }
      ASSERT_TRUE(remesher->SetTensors(vertices, tensors).ok());
      ASSERT_TRUE(remesher->Step({}).ok());
    }
    const std::string before = Text(remesher->FindTroubles());
    const TroubleSearch search = remesher->WhereTroublesMayBe();
    (void)remesher->Commit();
    EXPECT_EQ(Text(remesher->FindTroubles(search)), before);
    EXPECT_FALSE(before.empty());
  }
}

// Goal: the triangles at some vertices, ascending and each once, whether they lie close together by
// slot or far apart. Oracle: every triangle is asked whether one of its corners is named.
TEST(TrianglesAt, AreThoseWithACornerThatIsNamed) {
  const auto remesher = Build(testing::DiagonalCase(5'000));
  (void)remesher->Commit();
  const Mesh& mesh = remesher->mesh();
  struct Changes {
    std::int32_t stride;
    std::int32_t count_max;
  };
  for (const auto& [stride, count_max] :
       {Changes{1, 12}, Changes{7, 12}, Changes{400, 12}, Changes{2, 5'000}, Changes{1, 100'000}}) {
    SCOPED_TRACE(::testing::Message() << stride << " " << count_max);
    std::vector<VertexId> named;
    std::vector<bool> changed(static_cast<std::size_t>(mesh.vertex_slots()));
    for (std::int32_t v = 3, n = 0; v < mesh.vertex_slots() && n < count_max; v += stride, ++n) {
      named.emplace_back(v);
      changed[static_cast<std::size_t>(v)] = true;
    }
    std::vector<TriangleId> expected;
    for (const TriangleId id : LiveTrianglesOf(mesh)) {
      const auto& corners = mesh.triangle(id).vertices;
      const bool touched = std::any_of(corners.begin(), corners.end(),
                                       [&](VertexId v) { return changed[v.index()]; });
      if (touched) expected.push_back(id);
    }
    EXPECT_EQ(TrianglesAt(mesh, named), expected);
  }
  EXPECT_TRUE(TrianglesAt(mesh, {}).empty());
}

TEST(FindTroubles, IsBoundedAndCountsEverything) {
  // Slits far from each other, each smaller than the wanted size.
  Case slits{testing::Rectangle({0, 0}, {8, 8}),
             MakeField([](Vec2) { return Metric::Isotropic(0.1); })};
  for (int i = 0; i < 64; ++i) {
    const Vec2 p{0.5 + i % 8, 0.5 + static_cast<double>(i / 8)};
    slits.domain.points.push_back(p);
    slits.domain.points.push_back(p + Vec2{1e-3, 0});
    slits.domain.segments.push_back({4 + 2 * i, 5 + 2 * i, 7});
  }
  const auto troubles = Build(std::move(slits))->FindTroubles();
  EXPECT_LE(troubles.size(), kTroublesMax);
  std::int64_t places = 0;
  for (const Trouble& trouble : troubles) {
    EXPECT_EQ(trouble.kind, TroubleKind::kGeometry) << Text(trouble);
    places += trouble.place_count;
  }
  EXPECT_EQ(places, 64);
}

}  // namespace
}  // namespace pliant
