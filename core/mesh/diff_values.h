#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/ids.h"

namespace pliant {

/// How the value at one vertex follows from values at old ones. core/transfer/README.md
struct TransferRow {
  std::array<VertexId, 3> sources;  ///< Old slots, ascending; none for an unused entry, at the end.
  /// Whole multiples of 2^-53, >= 0; 0 for an unused entry. So they add up to 1 exactly: as real
  /// numbers, and in floating point in whatever order.
  std::array<double, 3> weights{};

  friend bool operator==(const TransferRow&, const TransferRow&) = default;
};

/// A sparse matrix from nodal values of one revision to those of the next.
struct TransferRows {
  std::vector<VertexId> vertex_ids;  ///< New and moved vertices, ascending.
  std::vector<TransferRow> rows;     ///< One for each.

  friend bool operator==(const TransferRows&, const TransferRows&) = default;
};

/// The value that a row gives: v0 + (w1 (v1 - v0) + w2 (v2 - v0)), which for weights that add up
/// to 1 is the weighted sum, and for three equal values that value to the bit.
/// @param value  called with an old slot, returns the value there.
template <class Value>
[[nodiscard]] double ApplyRow(const TransferRow& row, Value value) {
  const double first = value(row.sources[0]);
  if (!row.sources[1].valid()) return first;
  double change = row.weights[1] * (value(row.sources[1]) - first);
  if (row.sources[2].valid()) change += row.weights[2] * (value(row.sources[2]) - first);
  return first + change;
}

/// Where the values of a field live.
enum class FieldLocation : std::uint8_t { kVertex, kTriangle };

/// Values at some elements.
struct FieldRows {
  std::vector<std::int32_t> slots;  ///< Ascending.
  std::vector<double> values;       ///< Row after row.

  friend bool operator==(const FieldRows&, const FieldRows&) = default;
};

/// What a commit did to one field: its values at elements that are new, were set or changed.
struct FieldChange {
  std::string name;
  FieldLocation location = FieldLocation::kVertex;
  std::size_t column_count = 1;
  FieldRows rows;

  friend bool operator==(const FieldChange&, const FieldChange&) = default;
};

/// What a commit did to all fields.
struct FieldChanges {
  std::vector<FieldChange> changed;  ///< In the order of their names.
  /// Ascending. Dropped before anything is written: a name may stand in both lists.
  std::vector<std::string> dropped_names;

  friend bool operator==(const FieldChanges&, const FieldChanges&) = default;
};

}  // namespace pliant
