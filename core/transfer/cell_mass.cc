#include "core/transfer/cell_mass.h"

#include <algorithm>
#include <cmath>

#include "core/transfer/exact_sum.h"

namespace pliant {
namespace {

std::vector<double> AreasOf(const RegionMesh& region) {
  std::vector<double> areas;
  areas.reserve(region.triangles.size());
  for (std::size_t t = 0; t < region.triangles.size(); ++t) {
    areas.push_back(AreaOf(CornersOf(region, static_cast<std::int32_t>(t))));
  }
  return areas;
}

/// What one piece of the region lacks, and what its triangles can take.
struct Balance {
  ExactSum missing;       // Old integral less the new one.
  double magnitude = 0;   // Old integral of the absolute value.
  double room_above = 0;  // Integral of what values lie below their upper bounds.
  double room_below = 0;
  double integral = 0;    // New integral.
  double area = 0;        // Of the new triangles.
  bool positive = false;  // Some new value is > 0.
  bool negative = false;
};

double Corrected(double value, const Balance& balance) {
  const double missing = balance.missing.value();
  if (std::fabs(missing) <= kRoundingShare * balance.magnitude) return value;
  const bool one_sign = balance.positive != balance.negative;
  if (one_sign) return value * (1 + missing / balance.integral);
  return value + missing / balance.area;
}

}  // namespace

CellMass::CellMass(const Field& field, const TouchedRegion& region)
    : field_(field),
      region_(region),
      old_areas_(AreasOf(region.before)),
      new_areas_(AreasOf(region.after)),
      entries_(region.after.triangles.size() * field.column_count) {}

double CellMass::OldValue(std::int32_t before, std::size_t column) const {
  return field_.row(region_.before.triangle_ids[static_cast<std::size_t>(before)].index())[column];
}

void CellMass::Add(std::int32_t after, const OverlapFinder& found) {
  const auto t = static_cast<std::size_t>(after);
  for (std::size_t column = 0; column < field_.column_count; ++column) {
    // Differences to one of the values, so that equal values stay what they are to the bit, and
    // what is not covered takes that value.
    const double own = OldValue(found.nearest(), column);
    Entry entry{own, own, own};
    double change = 0;
    for (const Overlap& overlap : found.overlaps()) {
      const double other = OldValue(overlap.before, column);
      entry.low = std::min(entry.low, other);
      entry.high = std::max(entry.high, other);
      change += (other - own) * overlap.polygon.Area();
    }
    // A triangle whose area is lost in rounding has no mean.
    if (new_areas_[t] > 0) {
      entry.value = std::clamp(own + change / new_areas_[t], entry.low, entry.high);
    }
    entries_[t * field_.column_count + column] = entry;
  }
}

FieldRows CellMass::Finish(const OverlapComponents& components) {
  for (std::size_t column = 0; column < field_.column_count; ++column) {
    Correct(components, column);
  }
  FieldRows result;
  for (const TriangleId id : region_.after.triangle_ids) result.slots.push_back(id.value());
  for (const Entry& entry : entries_) result.values.push_back(entry.value);
  return result;
}

void CellMass::Correct(const OverlapComponents& components, std::size_t column) {
  std::vector<Balance> balances(components.count());
  for (std::size_t t = 0; t < old_areas_.size(); ++t) {
    Balance& balance = balances[components.of_before(t)];
    const double value = OldValue(static_cast<std::int32_t>(t), column);
    balance.missing.Add(value, old_areas_[t]);
    balance.magnitude += std::fabs(value) * old_areas_[t];
  }
  for (std::size_t t = 0; t < new_areas_.size(); ++t) {
    Balance& balance = balances[components.of_after(t)];
    const Entry& entry = entries_[t * field_.column_count + column];
    balance.missing.Add(-entry.value, new_areas_[t]);
    balance.room_above += (entry.high - entry.value) * new_areas_[t];
    balance.room_below += (entry.value - entry.low) * new_areas_[t];
    balance.integral += entry.value * new_areas_[t];
    balance.area += new_areas_[t];
    balance.positive = balance.positive || entry.value > 0;
    balance.negative = balance.negative || entry.value < 0;
  }
  for (std::size_t t = 0; t < new_areas_.size(); ++t) {
    const Balance& balance = balances[components.of_after(t)];
    Entry& entry = entries_[t * field_.column_count + column];
    const double missing = balance.missing.value();
    if (missing > 0 && missing <= balance.room_above) {
      entry.value += missing / balance.room_above * (entry.high - entry.value);
    } else if (missing < 0 && -missing <= balance.room_below) {
      entry.value += missing / balance.room_below * (entry.value - entry.low);
    } else {
      entry.value = Corrected(entry.value, balance);
      continue;
    }
    entry.value = std::clamp(entry.value, entry.low, entry.high);
  }
}

}  // namespace pliant
