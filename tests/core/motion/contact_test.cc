#include "core/motion/contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/base/rng.h"
#include "core/geometry/segments.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

/// The square [0, 10]^2 with the internal constraints given, tagged 5, 6, ...
std::unique_ptr<testing::EditedMesh> Board(const std::vector<std::array<Vec2, 2>>& lines) {
  Domain domain = testing::Rectangle({0, 0}, {10, 10});
  std::int32_t tag = 5;
  for (const auto& [a, b] : lines) {
    const auto first = static_cast<std::int32_t>(domain.points.size());
    domain.points.push_back(a);
    domain.points.push_back(b);
    domain.segments.push_back({first, first + 1, tag++});
  }
  return testing::DomainMesh(domain);
}

std::optional<Contact> ContactOf(const Mesh& mesh, const MotionRequest& request) {
  auto plan = MotionPlan::Make(mesh, request);
  PLIANT_CHECK(plan.ok(), "error", plan.error().message);
  plan->FindRiders(mesh);
  return FindContact(mesh, *plan);
}

MotionRequest Moves(std::int32_t tag, PathShape shape) {
  MotionRequest request;
  request.tags.push_back({{tag}, std::move(shape)});
  return request;
}

TEST(Contact, IsFoundAtItsTime) {
  const auto board = Board({{Vec2{2, 2}, Vec2{2, 4}}, {Vec2{6, 3}, Vec2{8, 3}}});
  // Straight on: 4 of 5 units.
  auto contact = ContactOf(board->mesh, Moves(5, Translation{{5, 0}}));
  ASSERT_TRUE(contact.has_value());
  EXPECT_NEAR(contact->time, 0.8, 1e-12);
  EXPECT_EQ(board->mesh.edge(contact->first).tag + board->mesh.edge(contact->second).tag, 11);
  // Over it.
  EXPECT_FALSE(ContactOf(board->mesh, Moves(5, Translation{{5, 1.3}})).has_value());
  // An end of the mover hits the inside of the other.
  contact = ContactOf(board->mesh, Moves(5, Translation{{5, 2}}));
  EXPECT_FALSE(contact.has_value());
  contact = ContactOf(board->mesh, Moves(6, Translation{{-5, 0.9}}));
  ASSERT_TRUE(contact.has_value());
  EXPECT_NEAR(contact->time, 0.8, 1e-12);
  // Into the wall.
  contact = ContactOf(board->mesh, Moves(6, Translation{{0, 14}}));
  ASSERT_TRUE(contact.has_value());
  EXPECT_NEAR(contact->time, 0.5, 1e-12);
  EXPECT_EQ(std::min(board->mesh.edge(contact->first).tag, board->mesh.edge(contact->second).tag),
            3);
}

TEST(Contact, OfATurnIsFoundWithinTheChord) {
  const auto board = Board({{Vec2{5, 5}, Vec2{8, 5}}, {Vec2{5, 7}, Vec2{5, 9}}});
  const auto contact = ContactOf(board->mesh, Moves(5, Rotation{{5, 5}, std::numbers::pi}));
  ASSERT_TRUE(contact.has_value());
  EXPECT_NEAR(contact->time, 0.5, 0.002);
  EXPECT_FALSE(ContactOf(board->mesh, Moves(5, Rotation{{5, 5}, -std::numbers::pi})).has_value());
}

// A vertex that slides along the line of its own wall meets the next corner, and not the line.
TEST(Contact, OfASlidingFootIsTheCorner) {
  Domain domain;
  domain.points = {{0, 0}, {2, 0}, {2, 2}, {4, 2}, {4, 0}, {10, 0}, {10, 10}, {0, 10}};
  for (std::int32_t i = 0; i < 8; ++i) {
    domain.segments.push_back({i, (i + 1) % 8, i >= 1 && i <= 3 ? 7 : 1});
  }
  // Turned, so that nothing is exactly on a line.
  for (Vec2& p : domain.points) p = {0.8 * p.x - 0.6 * p.y, 0.6 * p.x + 0.8 * p.y};
  const auto mesh = testing::DomainMesh(domain);
  EXPECT_FALSE(ContactOf(mesh->mesh, Moves(7, Translation{{0.8 * 5.99, 0.6 * 5.99}})).has_value());
  const auto contact = ContactOf(mesh->mesh, Moves(7, Translation{{0.8 * 8, 0.6 * 8}}));
  ASSERT_TRUE(contact.has_value());
  EXPECT_NEAR(contact->time, 0.75, 1e-9);
}

// Goal: the time is right for any two segments. Method: an oracle that knows only whether two
// segments cross at a time, asked 20,000 times along the way.
TEST(Contact, AgreesWithLookingAtManyTimes) {
  Rng rng(17);
  const auto draw = [&](double low, double high) { return rng.Uniform(low, high); };
  int met = 0;
  for (int trial = 0; trial < 200; ++trial) {
    SCOPED_TRACE(trial);
    std::array<Vec2, 4> from;
    std::array<Vec2, 4> to;
    for (std::size_t k = 0; k < 4; ++k) {
      from[k] = {draw(1, 9), draw(1, 9)};
      to[k] = {draw(1, 9), draw(1, 9)};
    }
    if (CrossOrOverlap(from[0], from[1], from[2], from[3])) continue;
    const auto board = Board({{from[0], from[1]}, {from[2], from[3]}});
    MotionRequest request;
    for (std::int32_t k = 0; k < 4; ++k) {
      request.vertices.emplace_back(4 + k);
      request.positions.push_back(to[static_cast<std::size_t>(k)]);
    }
    const auto cross_at = [&](double s) {
      std::array<Vec2, 4> at;
      for (std::size_t k = 0; k < 4; ++k) at[k] = from[k] + s * (to[k] - from[k]);
      return CrossOrOverlap(at[0], at[1], at[2], at[3]);
    };
    const auto contact = ContactOf(board->mesh, request);
    const double found = contact ? contact->time : 2;
    constexpr int kLooks = 20000;
    for (int look = 1; look <= kLooks; ++look) {
      const double s = static_cast<double>(look) / kLooks;
      if (s >= found - 1e-9) break;
      ASSERT_FALSE(cross_at(s)) << "at " << s << ", found " << found;
    }
    if (!contact) continue;
    ++met;
    // A moment later they cross, unless the contact was the very end.
    bool crossed = false;
    for (double later = 1e-12; later < 1e-3; later *= 2) crossed |= cross_at(found + later);
    EXPECT_TRUE(crossed) << "found " << found;
  }
  EXPECT_GT(met, 30);
}

}  // namespace
}  // namespace pliant
