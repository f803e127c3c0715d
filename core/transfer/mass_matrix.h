#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace pliant {

/// The mass matrix of linear elements over some of a mesh's vertices, the unknowns; what belongs to
/// the other vertices is left out.
class MassMatrix {
 public:
  /// @param unknown_count  unknowns are numbered from 0.
  explicit MassMatrix(std::size_t unknown_count)
      : diagonal_(unknown_count), lumped_(unknown_count) {}

  /// @param corners  unknowns at the triangle's corners, -1 where the vertex is none.
  /// @param area     one that rounding made 0 or negative adds nothing.
  void AddTriangle(const std::array<std::int32_t, 3>& corners, double area);

  /// Integral of each unknown's hat function: row sums of the mass matrix of all vertices.
  [[nodiscard]] std::span<const double> lumped() const { return lumped_; }

  /// Solves M x = b by Chebyshev's semi-iteration, scaled by the diagonal, whose eigenvalues then
  /// lie in [1/2, 2] on any triangles [Wathen1987]. Unlike conjugate gradients it takes no inner
  /// product, so that what happens in one part of the mesh never reaches another. Every step
  /// gains a factor of 3; the count of steps is fixed and gains all digits. [WathenRees2009]
  /// An unknown without area is 0.
  [[nodiscard]] std::vector<double> Solve(std::span<const double> b) const;

 private:
  struct Element {
    std::array<std::int32_t, 3> corners;
    double area = 0;
  };

  void SubtractProduct(std::span<const double> x, std::span<double> result) const;

  std::vector<Element> elements_;
  std::vector<double> diagonal_;
  std::vector<double> lumped_;
};

}  // namespace pliant
