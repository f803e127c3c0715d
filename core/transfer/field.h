#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/diff_values.h"

namespace pliant {

/// How a field follows the mesh. core/transfer/README.md says what each does exactly.
enum class TransferKind : std::uint8_t {
  kLinear,        ///< Exact for linear functions.
  kBounded,       ///< As linear, but without new extrema.
  kConservative,  ///< Keeps the integral.
};

/// A solution field of a session.
struct Field {
  std::string name;
  FieldLocation location = FieldLocation::kVertex;
  TransferKind transfer = TransferKind::kLinear;
  std::size_t column_count = 1;  ///< 1 scalar, 2 vector, 3 symmetric tensor (11, 12, 22).
  /// One row per slot of the last commit, row after row; what stands in free slots means nothing.
  std::vector<double> values = {};

  [[nodiscard]] std::span<const double> row(std::size_t slot) const {
    return {values.data() + slot * column_count, column_count};
  }
};

}  // namespace pliant
