#include "core/transfer/mass_matrix.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "core/base/rng.h"
#include "tests/support/random_transfer.h"

namespace pliant {
namespace {

using Dense = std::vector<std::vector<double>>;

/// Gaussian elimination with pivots.
std::vector<double> SolveDense(Dense a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k; i < n; ++i) {
      if (std::fabs(a[i][k]) > std::fabs(a[pivot][k])) pivot = i;
    }
    std::swap(a[k], a[pivot]);
    std::swap(b[k], b[pivot]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const double factor = a[i][k] / a[k][k];
      for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
      b[i] -= factor * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
  return b;
}

// Goal: all digits, on a mesh whose triangles differ in area by many orders of magnitude.
TEST(MassMatrix, SolvesToAllDigits) {
  const testing::RandomTransfer edited(testing::ThinGrid(), /*seed=*/11, /*steps=*/100);
  const RegionMesh& mesh = edited.transfer->region().after;
  const std::size_t count = mesh.vertex_ids.size();
  MassMatrix matrix(count);
  Dense dense(count, std::vector<double>(count, 0.0));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const double area = AreaOf(CornersOf(mesh, static_cast<std::int32_t>(t)));
    matrix.AddTriangle(mesh.triangles[t], area);
    for (const std::int32_t i : mesh.triangles[t]) {
      for (const std::int32_t j : mesh.triangles[t]) {
        dense[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] += area / (i == j ? 6 : 12);
      }
    }
  }
  Rng rng(3);
  std::vector<double> wanted(count);
  for (double& x : wanted) x = 2 * rng.Unit() - 1;
  std::vector<double> b(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    b[i] = std::inner_product(wanted.begin(), wanted.end(), dense[i].begin(), 0.0);
    EXPECT_NEAR(matrix.lumped()[i] / std::accumulate(dense[i].begin(), dense[i].end(), 0.0), 1,
                1e-13);
  }
  const std::vector<double> x = matrix.Solve(b);
  const std::vector<double> direct = SolveDense(dense, b);
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_NEAR(x[i], wanted[i], 1e-13);
    EXPECT_NEAR(x[i], direct[i], 1e-13);
  }
}

// Goal: what is wanted in one part of the mesh does not reach another to the bit.
TEST(MassMatrix, KeepsPartsThatShareNothingApart) {
  MassMatrix matrix(6);
  matrix.AddTriangle({0, 1, 2}, 1.0);
  matrix.AddTriangle({3, 4, 5}, 1e-9);
  const std::vector<double> one = matrix.Solve(std::vector{1.0, 2.0, 3.0, 1e-9, 0.0, 0.0});
  const std::vector<double> two = matrix.Solve(std::vector{0.0, 0.0, 0.0, 1e-9, 0.0, 0.0});
  for (std::size_t i = 3; i < 6; ++i) EXPECT_EQ(one[i], two[i]);
}

TEST(MassMatrix, LeavesOutVerticesThatAreNoUnknowns) {
  MassMatrix matrix(1);
  matrix.AddTriangle({-1, 0, -1}, 6.0);
  EXPECT_EQ(matrix.lumped()[0], 2.0);
  EXPECT_NEAR(matrix.Solve(std::vector{3.0})[0], 3.0, 1e-14);
  EXPECT_EQ(MassMatrix(1).Solve(std::vector{3.0})[0], 0) << "an unknown without area";
}

}  // namespace
}  // namespace pliant
