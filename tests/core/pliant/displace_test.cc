#include "core/pliant/displace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/mesh/export_mesh.h"
#include "core/mesh/validate.h"
#include "core/pliant/frozen.h"
#include "core/pliant/remesher.h"
#include "core/pliant/slide.h"
#include "tests/support/cases.h"
#include "tests/support/loop_mesh.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Faults;

VertexId NodeAt(int x, int y) { return VertexId(13 * y + x); }

/// A block of 4 x 4 vertices in a grid of 12 x 12 cells, to be moved.
std::vector<Displacement> Block(const Mesh& mesh, Vec2 by) {
  std::vector<Displacement> list;
  for (int y = 4; y < 8; ++y) {
    for (int x = 4; x < 8; ++x) list.push_back({NodeAt(x, y), mesh.position(NodeAt(x, y)) + by});
  }
  return list;
}

// Goal: the block arrives, what stood there is gone, and the grid is a mesh again.
TEST(Displace, RunsOverWhatStandsInTheWay) {
  auto grid = testing::ImportedMesh(testing::GridData(12, 12));
  const std::vector<Displacement> block = Block(grid->mesh, {2.5, 0.5});
  const std::optional<Displaced> displaced = Displace(grid->edit, block);
  ASSERT_TRUE(displaced.has_value());
  EXPECT_EQ(Faults(grid->mesh), "");
  EXPECT_NEAR(Area(grid->mesh), 144, 1e-9);
  EXPECT_GT(displaced->removed_count, 5);
  EXPECT_LT(displaced->removed_count, 30);
  for (const Displacement& one : block) {
    if (!grid->mesh.IsLive(one.vertex)) continue;
    EXPECT_EQ(grid->mesh.position(one.vertex), one.to);
  }
  EXPECT_TRUE(grid->mesh.IsLive(NodeAt(5, 5)));
  EXPECT_TRUE(
      std::binary_search(displaced->disturbed.begin(), displaced->disturbed.end(), NodeAt(3, 5)));
  EXPECT_FALSE(
      std::binary_search(displaced->disturbed.begin(), displaced->disturbed.end(), NodeAt(0, 0)));
}

// Goal: whoever is sent out of the domain goes; the walls stay.
TEST(Displace, LosesWhoWouldLeaveTheDomain) {
  auto grid = testing::ImportedMesh(testing::GridData(12, 12));
  const std::optional<Displaced> displaced = Displace(grid->edit, Block(grid->mesh, {5.25, 0.125}));
  ASSERT_TRUE(displaced.has_value());
  EXPECT_EQ(Faults(grid->mesh), "");
  EXPECT_NEAR(Area(grid->mesh), 144, 1e-9);
  EXPECT_FALSE(grid->mesh.IsLive(NodeAt(7, 5)));
}

// Goal: whoever's triangles keep their shape when others go a little way is not disturbed; where
// they lose it, he is. Method: a lattice, of which a block of 1/4 moves by a twentieth and by half
// of an edge; its rim has some 60 triangles that not all corners have moved with.
TEST(Displace, DisturbsOnlyWhereTrianglesLoseTheirShape) {
  testing::Case uniform = testing::DiscCase(1'000, testing::DiscState::kOff);
  const auto session = *Remesher::Create(uniform.domain, std::move(uniform.field), {});
  ASSERT_TRUE(session->Step({}).ok());
  (void)session->Commit();
  const double edge = 1 / std::sqrt(session->mesh().metric(VertexId(0)).m11);
  std::size_t disturbed[2] = {};
  for (const bool is_far : {false, true}) {
    auto copy = testing::ImportedMesh(ExportMesh(session->mesh()).data);
    std::vector<Displacement> block;
    for (const VertexId vertex : testing::LiveVertices(copy->mesh)) {
      copy->edit.SetMetric(vertex, session->mesh().metric(VertexId(0)));
      const Vec2 p = copy->mesh.position(vertex);
      if (std::abs(p.x - 0.5) > 0.25 || std::abs(p.y - 0.5) > 0.25) continue;
      block.push_back({vertex, p + Vec2{(is_far ? 0.5 : 0.05) * edge, 0}});
    }
    const std::optional<Displaced> displaced = Displace(copy->edit, block);
    ASSERT_TRUE(displaced.has_value());
    EXPECT_EQ(Faults(copy->mesh), "");
    disturbed[is_far ? 1 : 0] = displaced->disturbed.size();
  }
  EXPECT_LT(3 * disturbed[0], disturbed[1]);
  EXPECT_GT(disturbed[1], 60U);
}

// Goal: what is frozen stays, also where others are sent over it.
TEST(Displace, LeavesFrozenElementsAlone) {
  auto grid = testing::ImportedMesh(testing::GridData(12, 12));
  const Constraints constraints{.vertices = {NodeAt(9, 5), NodeAt(9, 6)}};
  const Result<FrozenElements> frozen = WhatFreezes(grid->mesh, constraints);
  ASSERT_TRUE(frozen.ok());
  (void)ChangeFrozen(grid->edit, {}, *frozen);
  EXPECT_FALSE(IsDisplaceable(grid->mesh, NodeAt(9, 5)));
  (void)Displace(grid->edit, Block(grid->mesh, {2.5, 0.5}));
  EXPECT_EQ(Faults(grid->mesh), "");
  for (const VertexId vertex : constraints.vertices) {
    ASSERT_TRUE(grid->mesh.IsLive(vertex));
    EXPECT_EQ(grid->mesh.position(vertex), (Vec2{9.0, vertex == NodeAt(9, 5) ? 5.0 : 6.0}));
  }
}

// Goal: random displacements leave a valid mesh, and one that is untouched where they are refused.
TEST(Displace, KeepsTheMeshValidWhateverIsAsked) {
  const std::uint64_t seed = 11;
  Rng rng(seed);
  int refused = 0;
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(trial);
    auto grid = testing::ImportedMesh(testing::GridData(12, 12));
    const auto same = testing::ImportedMesh(testing::GridData(12, 12));
    std::vector<Displacement> list;
    for (std::int32_t v = 0; v < grid->mesh.vertex_slots(); ++v) {
      const VertexId vertex(v);
      if (!IsDisplaceable(grid->mesh, vertex) || rng.Below(3) == 0) continue;
      const double reach = trial % 2 == 0 ? 0.6 : 3;
      list.push_back({vertex, grid->mesh.position(vertex) +
                                  Vec2{rng.Uniform(-reach, reach), rng.Uniform(-reach, reach)}});
    }
    if (!Displace(grid->edit, list)) {
      ++refused;
      EXPECT_EQ(testing::DifferenceOf(grid->mesh, same->mesh), "");
    }
    ASSERT_EQ(Faults(grid->mesh), "") << "seed " << seed;
    ASSERT_NEAR(Area(grid->mesh), 144, 1e-9);
  }
  EXPECT_LT(refused, 200);
}

/// Displacements of one length of everyone in the left two thirds of the unit square who can
/// follow.
std::vector<Displacement> LeftPart(const Mesh& mesh, Vec2 by) {
  std::vector<Displacement> list;
  for (const VertexId vertex : testing::LiveVertices(mesh)) {
    if (mesh.position(vertex).x > 0.66) continue;
    if (const auto place = PlaceAfter(mesh, vertex, by)) list.push_back({vertex, *place});
  }
  return list;
}

// Goal: the walls go along: whoever slides arrives on his wall, who stood there is gone, and the
// mesh is one again. Method: parts of a square with walls of 16 edges, moved to and fro at random.
TEST(Displace, LetsWallsSlideAlong) {
  const std::uint64_t seed = 5;
  Rng rng(seed);
  std::int64_t slid_count = 0;
  std::int64_t fewer = 0;
  for (int trial = 0; trial < 40; ++trial) {
    SCOPED_TRACE(trial);
    auto square = testing::LoopMesh(testing::DiscCase(300, testing::DiscState::kOff));
    const Mesh& mesh = square->mesh;
    const Vec2 by{rng.Uniform(-0.2, 0.2), 0.01 * rng.Uniform(-1, 1)};
    const std::vector<Displacement> list = LeftPart(mesh, by);
    const std::int32_t edges_before = mesh.edge_count();
    const bool moved = Displace(square->edit, list).has_value();
    ASSERT_EQ(Faults(mesh), "") << "seed " << seed;
    ASSERT_NEAR(Area(mesh), 1, 1e-12);
    if (!moved) continue;
    fewer += edges_before - mesh.edge_count();
    for (const Displacement& one : list) {
      if (!mesh.IsLive(one.vertex) || !mesh.vertex(one.vertex).edge.valid()) continue;
      if (!(std::fabs(by.x) > 0.02) || one.to.x == 0 || one.to.x == 1) continue;
      EXPECT_NEAR(mesh.position(one.vertex).x, one.to.x, 1e-12);
      EXPECT_EQ(mesh.position(one.vertex).y, one.to.y);
      ++slid_count;
    }
  }
  EXPECT_GT(slid_count, 200);
  EXPECT_GT(fewer, 20);
}

// Goal: where the way is blocked, the walls are as they were, too. Method: frozen triangles stand
// where the moved part would come to lie.
TEST(Displace, PutsWallsBackIfTheWayIsBlocked) {
  auto square = testing::LoopMesh(testing::DiscCase(300, testing::DiscState::kOff));
  auto same = testing::LoopMesh(testing::DiscCase(300, testing::DiscState::kOff));
  for (testing::EditedMesh* one : {square.get(), same.get()}) {
    for (std::int32_t t = 0; t < one->mesh.triangle_slots(); ++t) {
      const TriangleId id(t);
      if (!one->mesh.triangle(id).live) continue;
      const bool is_ahead = std::ranges::any_of(one->mesh.triangle(id).vertices, [&](VertexId v) {
        return std::fabs(one->mesh.position(v).x - 0.78) < 0.03;
      });
      if (is_ahead) one->edit.SetHold(id, MeshEdit::Hold::kFrozen);
    }
  }
  const std::vector<Displacement> list = LeftPart(square->mesh, {0.2, 0});
  EXPECT_GT(std::ranges::count_if(
                list, [&](const Displacement& d) { return IsSlidable(square->mesh, d.vertex); }),
            10);
  EXPECT_FALSE(Displace(square->edit, list).has_value());
  EXPECT_EQ(testing::DifferenceOf(square->mesh, same->mesh), "");
}

// Goal: a session that keeps its surface keeps it here, too.
TEST(DisplaceVertices, LeavesWallsThatMustStay) {
  for (const bool surface : {true, false}) {
    auto square = testing::LoopMesh(testing::DiscCase(300, testing::DiscState::kOff));
    const std::vector<VertexId> vertices = testing::LiveVertices(square->mesh);
    const std::vector<Vec2> by(vertices.size(), Vec2{0.02, 0});
    std::vector<Vec2> before;
    for (const VertexId vertex : vertices) before.push_back(square->mesh.position(vertex));
    DisplaceVertices displace(vertices, by);
    displace.Permit({.surface = surface});
    ASSERT_TRUE(displace.Apply(square->edit).ok());
    EXPECT_GT(displace.displaced_count(), 100);
    int slid = 0;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (!square->mesh.IsLive(vertices[i])) continue;
      const bool is_inside = before[i].y > 0 && before[i].y < 1;
      if (!is_inside && square->mesh.position(vertices[i]) != before[i]) ++slid;
    }
    EXPECT_GE(slid, surface ? 10 : 0);
    EXPECT_LE(slid, surface ? 100 : 0);
  }
}

TEST(DisplaceVertices, RefusesWhatItCannotRead) {
  auto grid = testing::ImportedMesh(testing::GridData(4, 4));
  const auto error = [&](std::vector<VertexId> vertices, std::vector<Vec2> by) {
    const auto outcome = DisplaceVertices(vertices, by).Apply(grid->edit);
    EXPECT_FALSE(outcome.ok());
    EXPECT_EQ(outcome.error().field, "metric.displacements");
    return std::pair(outcome.error().code, outcome.error().index);
  };
  const Vec2 nan{std::numeric_limits<double>::quiet_NaN(), 0};
  EXPECT_EQ(error({VertexId(12)}, {}).first, ErrorCode::kArrayLength);
  EXPECT_EQ(error({VertexId(12), VertexId(99)}, {{}, {}}),
            std::pair(ErrorCode::kIndexOutOfRange, std::int64_t{1}));
  EXPECT_EQ(error({VertexId(12), VertexId(12)}, {{}, {}}),
            std::pair(ErrorCode::kDuplicateId, std::int64_t{1}));
  EXPECT_EQ(error({VertexId(12)}, {nan}), std::pair(ErrorCode::kNotFinite, std::int64_t{0}));
}

/// A session that is at rest for a front, its vertices around that, and tensors once it has moved.
struct FrontSession {
  std::unique_ptr<Remesher> remesher;
  std::vector<VertexId> front;
  std::vector<Vec2> by;
  std::shared_ptr<const MetricField> now;

  [[nodiscard]] std::vector<Metric> TensorsNow() const {
    std::vector<Metric> tensors;
    std::int32_t hint = MetricField::kNoHint;
    for (const VertexId v : testing::LiveVertices(remesher->mesh())) {
      tensors.push_back(now->At(remesher->mesh().position(v), hint));
    }
    return tensors;
  }
};

FrontSession MakeFrontSession(double nodes) {
  testing::Case shock = testing::ShockCase(nodes, 0.4);
  FrontSession made{.remesher = Remesher::Create(shock.domain, std::move(shock.field), {}).value(),
                    .front = {},
                    .by = {},
                    .now = testing::ShockCase(nodes, 0.42).field};
  EXPECT_TRUE(made.remesher->Step({}).ok());
  (void)made.remesher->Commit();
  for (const VertexId v : testing::LiveVertices(made.remesher->mesh())) {
    const Vec2 p = made.remesher->mesh().position(v);
    const double far = p.x - (std::sqrt(0.25 + 0.25 * (p.y - 0.5) * (p.y - 0.5)) - 0.1);
    if (std::fabs(far) < 0.15) made.front.push_back(v);
  }
  made.by.assign(made.front.size(), Vec2{0.02, 0});
  return made;
}

// Goal: tensors for all vertices replace what vertices carried along, whoever took that over before
// them; if they are what these have anyway, the metric goes along as if none had been sent.
TEST(DisplaceVertices, IsFollowedByTheTensorsThatAreSentForAll) {
  for (const bool same : {false, true}) {
    std::vector<std::uint64_t> hashes;
    for (const bool takes_over_before : {false, true}) {
      const FrontSession made = MakeFrontSession(1000);
      DisplaceVertices displace(made.front, made.by);
      ASSERT_TRUE(made.remesher->Apply(displace).ok());
      std::vector<Metric> tensors = made.TensorsNow();
      if (same) {
        tensors.clear();
        for (const VertexId v : testing::LiveVertices(made.remesher->mesh())) {
          tensors.push_back(made.remesher->mesh().metric(v));
        }
      }
      if (takes_over_before) {
        // Says nothing new, but not of all vertices.
        const VertexId one = made.front[0];
        const Metric its = made.remesher->mesh().metric(one);
        ASSERT_TRUE(made.remesher->SetTensors({{one}}, {{its}}).ok());
      }
      if (!(same && takes_over_before)) {
        ASSERT_TRUE(made.remesher->SetTensors({}, tensors).ok());
      }
      ASSERT_TRUE(made.remesher->Step({}).ok());
      hashes.push_back(made.remesher->Commit().summary.state_hash);
      EXPECT_EQ(Faults(made.remesher->mesh()), "");
    }
    EXPECT_EQ(hashes[0], hashes[1]);
  }
}

// Goal: a client that says how its front moves gets a mesh for the new metric at a small part of
// the visits, also when it sends tensors at the vertices, which alone would not show the front
// between them.
TEST(DisplaceVertices, CarriesAFrontForTensorsAtVertices) {
  FrontSession made = MakeFrontSession(3000);
  Remesher& session = *made.remesher;
  const auto nodes = static_cast<double>(session.mesh().vertex_count());
  DisplaceVertices displace(made.front, made.by);
  ASSERT_TRUE(session.Apply(displace).ok());
  EXPECT_GT(displace.displaced_count(), static_cast<std::int64_t>(nodes / 3));
  EXPECT_EQ(Faults(session.mesh()), "");

  ASSERT_TRUE(session.SetTensors({}, made.TensorsNow()).ok());
  const Result<Progress> progress = session.Step({});
  ASSERT_TRUE(progress.ok());
  EXPECT_LT(static_cast<double>(progress->counts.visits), 2.5 * nodes);
  (void)session.Commit();
  EXPECT_EQ(Faults(session.mesh()), "");
  const Quality quality = MeasureQuality(session.mesh(), *made.now);
  EXPECT_GT(quality.q_mean, 0.975);
  EXPECT_GT(quality.integrated.share_125, 0.97);
}

}  // namespace
}  // namespace pliant
