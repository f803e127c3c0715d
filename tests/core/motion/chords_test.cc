#include "core/motion/chords.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/metric/metric.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

/// A square with `count` segments on its lower side, between (0, 0) and (1, 0), of which every
/// second corner is lowered by `depth`; the other sides are one segment each.
Domain WithTeeth(int count, double depth) {
  Domain domain;
  for (int i = 0; i <= count; ++i) {
    domain.points.push_back({static_cast<double>(i) / count, i % 2 == 1 ? -depth : 0.0});
  }
  domain.points.push_back({1, 1});
  domain.points.push_back({0, 1});
  const auto size = static_cast<std::int32_t>(domain.points.size());
  for (std::int32_t i = 0; i < size; ++i) domain.segments.push_back({i, (i + 1) % size, 1});
  return domain;
}

class Chords : public ::testing::Test {
 protected:
  void Start(const Domain& domain, double size) {
    edited_ = testing::DomainMesh(domain);
    for (const VertexId id : testing::LiveVertices(edited_->mesh)) {
      edited_->edit.SetMetric(id, Metric::Isotropic(size));
    }
  }

  /// All soft corners may go.
  [[nodiscard]] std::vector<Chord> Choose(double tolerance) const {
    std::vector<VertexId> corners;
    for (const VertexId id : testing::LiveVertices(mesh())) {
      if (IsSoftCorner(mesh(), id)) corners.push_back(id);
    }
    return ChooseChords(mesh(), corners, tolerance);
  }
  [[nodiscard]] const Mesh& mesh() const { return edited_->mesh; }
  [[nodiscard]] MeshEdit& edit() { return edited_->edit; }

 private:
  std::unique_ptr<testing::EditedMesh> edited_;
};

TEST_F(Chords, AStretchThatIsTooDenseGetsFewerEdges) {
  ASSERT_NO_FATAL_FAILURE(Start(WithTeeth(16, 0), 0.125));
  const std::vector<Chord> chords = Choose(1e-9);
  double length = 0;
  int edges = 0;
  for (const Chord& chord : chords) {
    ASSERT_EQ(chord.corners.size(), chord.segments.size() + 1);
    ASSERT_EQ(chord.parameters.size(), chord.corners.size());
    EXPECT_EQ(chord.parameters.front(), 0);
    EXPECT_EQ(chord.parameters.back(), 1);
    for (std::size_t i = 1; i < chord.parameters.size(); ++i) {
      EXPECT_GT(chord.parameters[i], chord.parameters[i - 1]);
    }
    length += std::fabs(mesh().position(chord.corners.back()).x -
                        mesh().position(chord.corners.front()).x);
    edges += static_cast<int>(chord.segments.size());
  }
  EXPECT_NEAR(length, 1, 1e-12) << "the whole side";
  EXPECT_EQ(edges, 16);
}

TEST_F(Chords, WhatIsAsDenseAsItShouldBeStays) {
  ASSERT_NO_FATAL_FAILURE(Start(WithTeeth(16, 0), 1.0 / 16));
  EXPECT_TRUE(Choose(0.1).empty());
  ASSERT_NO_FATAL_FAILURE(Start(WithTeeth(16, 0), 1.0 / 30));
  EXPECT_TRUE(Choose(0.1).empty());
}

// Edges of 0.9 each: only a long stretch has one too many.
TEST_F(Chords, SeveralEdgesThatAreALittleTooShortAreOneTooMany) {
  ASSERT_NO_FATAL_FAILURE(Start(WithTeeth(16, 0), 1 / (0.9 * 16)));
  const std::vector<Chord> chords = Choose(1e-9);
  ASSERT_FALSE(chords.empty());
  for (const Chord& chord : chords) EXPECT_GE(chord.segments.size(), 5U);
}

TEST_F(Chords, NoCornerIsFartherOffThanTheTolerance) {
  ASSERT_NO_FATAL_FAILURE(Start(WithTeeth(16, 0.01), 0.25));
  EXPECT_TRUE(Choose(0.0049).empty());
  const std::vector<Chord> chords = Choose(0.0101);
  ASSERT_FALSE(chords.empty());
  for (const Chord& chord : chords) {
    for (std::size_t i = 0; i < chord.corners.size(); ++i) {
      const Vec2 moved = chord.PositionOf(mesh(), i) - mesh().position(chord.corners[i]);
      EXPECT_LE(Length(moved), 0.0101);
    }
  }
}

TEST_F(Chords, AnotherTagWhatIsFrozenAndABranchAreNotSoft) {
  Domain domain = WithTeeth(16, 0);
  domain.segments[3].tag = 2;
  domain.points.push_back({0.5, 0.5});
  domain.segments.push_back({8, static_cast<std::int32_t>(domain.points.size()) - 1, 1});
  ASSERT_NO_FATAL_FAILURE(Start(domain, 0.5));
  EXPECT_FALSE(IsSoftCorner(mesh(), VertexId(3)));
  EXPECT_FALSE(IsSoftCorner(mesh(), VertexId(4)));
  EXPECT_FALSE(IsSoftCorner(mesh(), VertexId(8))) << "three edges";
  EXPECT_FALSE(IsSoftCorner(mesh(), VertexId(19))) << "one edge";
  EXPECT_TRUE(IsSoftCorner(mesh(), VertexId(12)));
  edit().SetHold(VertexId(12), MeshEdit::Hold::kFrozen);
  EXPECT_FALSE(IsSoftCorner(mesh(), VertexId(12)));
  EXPECT_TRUE(IsSoftCorner(mesh(), VertexId(14)));
  edit().SetHold(mesh().FindEdge(VertexId(14), VertexId(15)), MeshEdit::Hold::kFrozen);
  EXPECT_FALSE(IsSoftCorner(mesh(), VertexId(14)));
}

// A loop all of whose corners may go does not fold onto itself, whatever the tolerance.
TEST_F(Chords, ALoopStaysALoop) {
  Domain domain = testing::Rectangle({-1, -1}, {1, 1});
  const int count = 12;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * 3.14159265358979 * i / count;
    domain.points.push_back({0.1 * std::cos(angle), 0.1 * std::sin(angle)});
    domain.segments.push_back({4 + i, 4 + (i + 1) % count, 7});
  }
  ASSERT_NO_FATAL_FAILURE(Start(domain, 3));
  std::size_t gone = 0;
  for (const Chord& chord : Choose(100)) {
    EXPECT_NE(chord.corners.front(), chord.corners.back());
    if (mesh().edge(mesh().FindEdge(chord.corners[0], chord.corners[1])).tag == 7) {
      gone += chord.corners.size() - 2;
    }
  }
  EXPECT_LE(gone, 9U) << "three corners at least are left";
}

}  // namespace
}  // namespace pliant
