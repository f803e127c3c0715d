#include "server/convert_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;

constexpr RequestLimits kOptionLimits{.vertices_max = 1000};

// Every option that the wire has, each with a value of its own.
v1::SessionOptions Everything() {
  v1::SessionOptions wire;
  wire.set_seed(9);
  wire.set_variant(v1::VARIANT_COOLED);
  wire.set_smoothing(v1::SMOOTHING_LAPLACIAN);
  wire.set_step(0.25);
  wire.set_speed_threshold(0.01);
  wire.set_age_cooling(20);
  wire.set_age_max(60);
  wire.set_hops_max(5);
  wire.set_metric_tolerance(0.1);
  wire.set_boundary_tolerance(0.02);
  wire.set_vertices_max(1000);
  wire.set_visits_per_vertex_max(77);
  return wire;
}

TEST(ConvertOptions, AnUpdateChangesWhatItSetsAndNothingElse) {
  const Result<OptionsUpdate> all = ConvertOptionsUpdate(Everything(), kOptionLimits);
  ASSERT_TRUE(all.ok());
  const Options expected{.variant = Variant::kCooled,
                         .smoothing = Smoothing::kLaplacian,
                         .seed = 9,
                         .step = 0.25,
                         .speed_threshold = 0.01,
                         .age_cooling = 20,
                         .age_max = 60,
                         .hops_max = 5,
                         .metric_tolerance = 0.1,
                         .boundary_tolerance = 0.02,
                         .vertices_max = 1000,
                         .visits_per_vertex_max = 77};
  EXPECT_EQ(all->AppliedTo({}), expected);
  v1::SessionOptions one;
  one.set_hops_max(7);
  Options after = expected;
  after.hops_max = 7;
  EXPECT_EQ(ConvertOptionsUpdate(one, kOptionLimits)->AppliedTo(expected), after);
  EXPECT_EQ(ConvertOptionsUpdate({}, kOptionLimits)->AppliedTo(expected), expected);
}

TEST(ConvertOptions, ASessionBeginsWithRestrictions) {
  v1::SessionOptions wire;
  wire.add_restrictions(v1::RESTRICTION_NO_SURFACE);
  wire.add_restrictions(v1::RESTRICTION_NO_MOVE);
  const Result<Options> options = ConvertOptions(wire, kOptionLimits);
  ASSERT_TRUE(options.ok());
  EXPECT_EQ(options->permissions, (Permissions{.move = false, .surface = false}));
  EXPECT_EQ(options->vertices_max, 1000);
}

TEST(ConvertOptions, AnUpdateKeepsToTheServersLimitAndLeavesRestrictionsToConstraints) {
  v1::SessionOptions wire;
  wire.set_vertices_max(1001);
  EXPECT_EQ(ConvertOptionsUpdate(wire, kOptionLimits).error().field, "options.vertices_max");
  wire.Clear();
  wire.add_restrictions(v1::RESTRICTION_NO_SWAP);
  EXPECT_EQ(ConvertOptionsUpdate(wire, kOptionLimits).error().field, "options.restrictions");
  wire.Clear();
  wire.set_durability(v1::DURABILITY_NONE);
  EXPECT_EQ(ConvertOptionsUpdate(wire, kOptionLimits).error().field, "options.durability");
}

TEST(ConvertConstraints, ReadsEveryKind) {
  v1::ConstraintUpdate wire;
  *wire.mutable_frozen_vertices() = test::Ints({4, 2});
  *wire.mutable_frozen_edges() = test::Ints({7});
  wire.add_frozen_regions(-3);
  for (const v1::Restriction one : {v1::RESTRICTION_NO_INSERT, v1::RESTRICTION_NO_SWAP,
                                    v1::RESTRICTION_NO_MOVE, v1::RESTRICTION_NO_SURFACE}) {
    wire.add_restrictions(one);
  }
  wire.set_revision(5);
  const Result<ConstraintsUpdate> update = ConvertConstraints(wire);
  ASSERT_TRUE(update.ok());
  EXPECT_EQ(update->revision, Revision(5));
  EXPECT_THAT(update->constraints.vertices, ElementsAre(VertexId(4), VertexId(2)));
  EXPECT_THAT(update->constraints.edges, ElementsAre(EdgeId(7)));
  EXPECT_THAT(update->constraints.regions, ElementsAre(-3));
  EXPECT_EQ(update->constraints.permissions, (Permissions{false, false, false, false}));
}

TEST(ConvertConstraints, RefusesWhatItDoesNotKnow) {
  v1::ConstraintUpdate wire;
  *wire.mutable_frozen_vertices() = test::Ints({4});
  EXPECT_EQ(ConvertConstraints(wire).error().code, ErrorCode::kRevisionMismatch);
  wire.set_revision(1);
  *wire.mutable_frozen_vertices() = test::Doubles({1, 2}, 1);
  EXPECT_EQ(ConvertConstraints(wire).error().code, ErrorCode::kArrayType);
  EXPECT_EQ(ConvertConstraints(wire).error().field, "constraints.frozen_vertices");
  wire.Clear();
  wire.add_restrictions(v1::RESTRICTION_UNSPECIFIED);
  EXPECT_EQ(ConvertConstraints(wire).error().field, "constraints.restrictions");
  EXPECT_TRUE(ConvertConstraints({}).ok()) << "lifts all";
}

}  // namespace
}  // namespace pliant::server
