#include "core/metric/hessian.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/rng.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

/// The unit square in n x n cells, inner points shaken by a tenth of a cell, y scaled.
MeshData ShakenSquare(std::int32_t n, double height) {
  MeshData mesh = testing::GridData(n, n);
  Rng rng(5);
  for (Vec2& p : mesh.points) {
    const bool inner = p.x > 0 && p.x < n && p.y > 0 && p.y < n;
    const Vec2 shake{0.2 * rng.Unit() - 0.1, 0.2 * rng.Unit() - 0.1};
    if (inner) p += shake;
    p = {p.x / n, height * p.y / n};
  }
  return mesh;
}

template <class Function>
std::vector<double> ValuesOf(const MeshData& mesh, Function f) {
  std::vector<double> values;
  for (const Vec2 p : mesh.points) values.push_back(f(p));
  return values;
}

// Goal: exact for quadratic polynomials everywhere, corners too, and on thin meshes.
TEST(RecoverHessians, GivesQuadraticFunctionsBack) {
  for (const double height : {1.0, 1e-3}) {
    const MeshData mesh = ShakenSquare(7, height);
    const auto values = ValuesOf(mesh, [&](Vec2 p) {
      const double y = p.y / height;
      return 1 + p.x - 2 * y + 3 * p.x * p.x - 5 * p.x * y + 2 * y * y;
    });
    for (const Metric& hessian : RecoverHessians(mesh, values)) {
      EXPECT_NEAR(hessian.m11, 6, 1e-9);
      EXPECT_NEAR(hessian.m12 * height, -5, 1e-9);
      EXPECT_NEAR(hessian.m22 * height * height, 4, 1e-9);
    }
  }
}

// Goal: first order or better on irregular meshes, in the largest norm, boundary included.
TEST(RecoverHessians, ConvergesToTheAnalyticHessian) {
  const auto error = [](std::int32_t n) {
    const MeshData mesh = ShakenSquare(n, 1);
    const auto values = ValuesOf(mesh, [](Vec2 p) { return std::sin(3 * p.x) * std::exp(p.y); });
    const std::vector<Metric> hessians = RecoverHessians(mesh, values);
    double most = 0;
    for (std::size_t i = 0; i < hessians.size(); ++i) {
      const Vec2 p = mesh.points[i];
      const double s = std::sin(3 * p.x) * std::exp(p.y);
      const double c = 3 * std::cos(3 * p.x) * std::exp(p.y);
      most = std::max({most, std::fabs(hessians[i].m11 + 9 * s), std::fabs(hessians[i].m12 - c),
                       std::fabs(hessians[i].m22 - s)});
    }
    return most;
  };
  EXPECT_GT(std::log2(error(20) / error(80)) / 2, 0.9);
}

TEST(RecoverHessians, IsZeroWhereAMeshIsTooSmallToTell) {
  const MeshData mesh = testing::GridData(1, 1);
  for (const Metric& hessian : RecoverHessians(mesh, std::vector<double>{0, 1, 2, 5})) {
    EXPECT_EQ(hessian, (Metric{0, 0, 0}));
  }
}

TEST(AbsoluteValue, KeepsAxesAndTakesAbsoluteEigenvalues) {
  Rng rng(6);
  for (int trial = 0; trial < 1000; ++trial) {
    const double angle = 7 * rng.Unit();
    const double a = 2 * rng.Unit() - 1;
    const double b = 2 * rng.Unit() - 1;
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    const auto tensor = [&](double x, double y) {
      return Metric{x * c * c + y * s * s, (x - y) * c * s, x * s * s + y * c * c};
    };
    const Metric absolute = AbsoluteValue(1e-200 * tensor(a, b));
    const Metric expected = tensor(std::fabs(a), std::fabs(b));
    EXPECT_NEAR(1e200 * absolute.m11, expected.m11, 1e-14);
    EXPECT_NEAR(1e200 * absolute.m12, expected.m12, 1e-14);
    EXPECT_NEAR(1e200 * absolute.m22, expected.m22, 1e-14);
  }
  EXPECT_EQ(AbsoluteValue({0, 0, 0}), (Metric{0, 0, 0}));
}

}  // namespace
}  // namespace pliant
