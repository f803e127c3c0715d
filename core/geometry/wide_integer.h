#pragma once

#include <cstdint>
#include <vector>

namespace pliant::internal {

/// A signed integer of any size, for the few predicates whose products leave the range of a double.
///
/// Every finite double is a whole multiple of 2^-1074; FromDouble counts in that unit, so sums and
/// products of doubles become sums and products of integers. Slow and short on purpose.
class WideInteger {
 public:
  WideInteger() = default;

  /// value * 2^1074, exactly. @pre value is finite
  [[nodiscard]] static WideInteger FromDouble(double value);

  [[nodiscard]] int Sign() const { return magnitude_.empty() ? 0 : (negative_ ? -1 : 1); }

  friend WideInteger operator-(WideInteger a);
  friend WideInteger operator+(const WideInteger& a, const WideInteger& b);
  friend WideInteger operator-(const WideInteger& a, const WideInteger& b);
  friend WideInteger operator*(const WideInteger& a, const WideInteger& b);

 private:
  void Trim();

  bool negative_ = false;
  std::vector<std::uint32_t> magnitude_;  ///< Least significant first, no leading zeros.
};

}  // namespace pliant::internal
