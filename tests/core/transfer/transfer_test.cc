// Fields over whole updates of a session: what the transfer promises its users.

#include "core/transfer/transfer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/field_testing.h"

namespace pliant {
namespace {

using testing::Case;
using testing::FieldOf;
using testing::IntegralOf;

std::unique_ptr<Remesher> Start(Case from) {
  auto made = Remesher::Create(from.domain, std::move(from.field), {});
  PLIANT_CHECK(made.ok(), "error", made.error().message);
  PLIANT_CHECK((*made)->Step({}).ok());
  (void)(*made)->Commit();
  return std::move(*made);
}

std::unique_ptr<Remesher> StartWithSize(double size) {
  MetricSpec spec;
  spec.source = SizeMetric{std::to_string(size)};
  auto made = Remesher::Create(testing::Rectangle({0, 0}, {1, 1}), spec, {});
  PLIANT_CHECK(made.ok(), "error", made.error().message);
  PLIANT_CHECK((*made)->Step({}).ok());
  (void)(*made)->Commit();
  return std::move(*made);
}

void Set(Remesher& remesher, const char* name, FieldLocation location, TransferKind kind,
         const std::function<double(Vec2)>& f) {
  const Status status =
      remesher.SetFields({.values = {testing::ValuesOf(remesher.mesh(), name, location, f)},
                          .transfer = kind,
                          .dropped_names = {}});
  PLIANT_CHECK(status.ok(), "error", status.error().message);
  (void)remesher.Commit();
}

constexpr std::array kKinds{TransferKind::kLinear, TransferKind::kBounded,
                            TransferKind::kConservative};
constexpr std::array kLocations{FieldLocation::kVertex, FieldLocation::kTriangle};

// Goal: the promises of every kind over 50 steps of a front that crosses the domain: the integral
// of conservative fields to 1e-12, constants to the bit, no new extrema of bounded ones.
TEST(Transfer, KeepsItsPromisesOverFiftyStepsOfAFront) {
  const auto remesher = Start(testing::ShockCase(1000, 0.2));
  const auto wave = [](Vec2 p) { return p.x < 0.4 ? 1 + p.y : -2.0; };
  Set(*remesher, "nodal_mass", FieldLocation::kVertex, TransferKind::kConservative, wave);
  Set(*remesher, "cell_mass", FieldLocation::kTriangle, TransferKind::kConservative, wave);
  Set(*remesher, "nodal_bounded", FieldLocation::kVertex, TransferKind::kBounded, wave);
  Set(*remesher, "cell_bounded", FieldLocation::kTriangle, TransferKind::kBounded, wave);
  for (const TransferKind kind : kKinds) {
    for (const FieldLocation location : kLocations) {
      const std::string name = "constant" + std::to_string(static_cast<int>(kind)) +
                               std::to_string(static_cast<int>(location));
      Set(*remesher, name.c_str(), location, kind, [](Vec2) { return 0.1; });
    }
  }
  const auto nodal = IntegralOf(remesher->mesh(), *remesher->fields().Find("nodal_mass"));
  const auto cell = IntegralOf(remesher->mesh(), *remesher->fields().Find("cell_mass"));
  for (int step = 1; step <= 50; ++step) {
    SCOPED_TRACE(::testing::Message() << "step " << step);
    ASSERT_TRUE(remesher->SetField(testing::ShockCase(1000, 0.2 + 0.012 * step).field).ok());
    ASSERT_TRUE(remesher->Step({}).ok());
    const MeshDiff commit = remesher->CommitAndTransfer();
    ASSERT_GT(commit.transfer->rows.size(), 10U);
    const Mesh& mesh = remesher->mesh();
    EXPECT_NEAR(IntegralOf(mesh, *remesher->fields().Find("nodal_mass")).value, nodal.value,
                1e-12 * nodal.magnitude);
    EXPECT_NEAR(IntegralOf(mesh, *remesher->fields().Find("cell_mass")).value, cell.value,
                1e-12 * cell.magnitude);
    for (const Field& field : remesher->fields().fields()) {
      const bool constant = field.name.starts_with("constant");
      if (!constant && !field.name.ends_with("bounded") && field.name != "cell_mass") continue;
      const double low = constant ? 0.1 : -2;
      const double high = constant ? 0.1 : 2;
      const auto check = [&](std::int32_t slot) {
        const double value = field.values[static_cast<std::size_t>(slot)];
        EXPECT_TRUE(low <= value && value <= high) << field.name << " " << value;
      };
      if (field.location == FieldLocation::kVertex) {
        for (const VertexId id : testing::LiveVertices(mesh)) check(id.value());
      } else {
        for (const TriangleId id : testing::LiveTriangles(mesh)) check(id.value());
      }
    }
  }
}

/// L2 error of the field after one update that touches the whole mesh, by the middles of sides.
double ErrorAfterUpdate(double size, FieldLocation location, TransferKind kind) {
  const auto smooth = [](Vec2 p) { return std::sin(5 * p.x) * std::cos(4 * p.y) + p.x * p.x; };
  const auto remesher = StartWithSize(size);
  Set(*remesher, "f", location, kind, smooth);
  MetricSpec spec;
  spec.source = SizeMetric{std::to_string(0.85 * size)};
  PLIANT_CHECK(remesher->SetMetric(spec).ok());
  PLIANT_CHECK(remesher->Step({}).ok());
  const auto rows = *remesher->CommitAndTransfer().transfer;
  EXPECT_GT(2 * rows.rows.size(), static_cast<std::size_t>(remesher->mesh().vertex_count()))
      << "most vertices must have changed for this to say something";
  const Field& field = *remesher->fields().Find("f");
  const Mesh& mesh = remesher->mesh();
  double sum = 0;
  for (const TriangleId id : testing::LiveTriangles(mesh)) {
    const auto corners = testing::CornersIn(mesh, id);
    const double area = AreaOf(corners);
    if (location == FieldLocation::kTriangle) {
      const double d = field.values[id.index()] - smooth(CenterOf(corners));
      sum += area * d * d;
      continue;
    }
    const auto& v = mesh.triangle(id).vertices;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const double d = 0.5 * (field.values[v[i].index()] + field.values[v[j].index()]) -
                       smooth(0.5 * (corners[i] + corners[j]));
      sum += area / 3 * d * d;
    }
  }
  return std::sqrt(sum);
}

// Goal: halving the size divides the error by 4: nodal fields, and cells that are reconstructed;
// by 2 for cells that are averaged.
TEST(Transfer, ConvergesAtTheOrderOfItsKind) {
  for (const FieldLocation location : kLocations) {
    for (const TransferKind kind : kKinds) {
      const double order = std::log2(ErrorAfterUpdate(0.08, location, kind) /
                                     ErrorAfterUpdate(0.02, location, kind)) /
                           2;
      const bool averaged =
          location == FieldLocation::kTriangle && kind == TransferKind::kConservative;
      EXPECT_GT(order, averaged ? 0.9 : 1.8)
          << "location " << static_cast<int>(location) << " kind " << static_cast<int>(kind);
    }
  }
}

// Goal: rows and fields cost what was touched.
// Method: the same change of about 40 vertices in meshes of 1000 and 16000: as many old and new
// triangles are looked at.
TEST(Transfer, CostsWhatWasTouched) {
  std::array<std::size_t, 2> touched{};
  std::array<std::int32_t, 2> counts{};
  const std::array sizes{0.04, 0.01};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto remesher = StartWithSize(sizes[i]);
    counts[i] = remesher->mesh().vertex_count();
    Set(*remesher, "f", FieldLocation::kVertex, TransferKind::kConservative,
        [](Vec2 p) { return p.x * p.y; });
    std::vector<VertexId> near;
    std::vector<Metric> finer;
    for (const VertexId id : testing::LiveVertices(remesher->mesh())) {
      if (Length(remesher->mesh().position(id) - Vec2{0.5, 0.5}) > 3 * sizes[i]) continue;
      near.push_back(id);
      finer.push_back(Metric::Isotropic(sizes[i] / 1.6));
    }
    ASSERT_TRUE(remesher->SetTensors(near, finer).ok());
    ASSERT_TRUE(remesher->Step({}).ok());
    const MeshDiff commit = remesher->CommitAndTransfer();
    touched[i] = commit.triangle_ids.size();
    // The values told are those of vertices at changed triangles and no others.
    ASSERT_EQ(commit.fields.changed.size(), 1U);
    EXPECT_LE(commit.fields.changed[0].rows.slots.size(), 3 * touched[i]);
    EXPECT_EQ(commit.transfer->vertex_ids, commit.vertex_ids);
  }
  EXPECT_GT(counts[1], 10 * counts[0]);
  EXPECT_LT(static_cast<double>(touched[1]), 3 * static_cast<double>(touched[0]));
}

TEST(Transfer, RefusesFieldsBeforeTheFirstCommitAndForgetsThemAtRollback) {
  MetricSpec spec;
  spec.source = SizeMetric{"0.5"};
  auto made = Remesher::Create(testing::Rectangle({0, 0}, {1, 1}), spec, {});
  ASSERT_TRUE(made.ok());
  Remesher& remesher = **made;
  EXPECT_EQ(remesher.SetFields({}).error().code, ErrorCode::kRevisionNotFound);
  ASSERT_TRUE(remesher.Step({}).ok());
  (void)remesher.Commit();
  const FieldUpdate update{
      .values = {testing::ValuesOf(remesher.mesh(), "f", FieldLocation::kVertex,
                                   [](Vec2 p) { return p.x; })},
      .transfer = {},
      .dropped_names = {}};
  ASSERT_TRUE(remesher.SetFields(update).ok());
  remesher.Rollback();
  (void)remesher.Commit();
  EXPECT_TRUE(remesher.fields().fields().empty());
}

}  // namespace
}  // namespace pliant
