#include "core/geometry/wide_integer.h"

#include <cmath>
#include <compare>
#include <cstddef>

namespace pliant::internal {
namespace {

using Words = std::vector<std::uint32_t>;

std::strong_ordering CompareMagnitudes(const Words& a, const Words& b) {
  if (a.size() != b.size()) return a.size() <=> b.size();
  for (std::size_t i = a.size(); i-- > 0;) {
    if (a[i] != b[i]) return a[i] <=> b[i];
  }
  return std::strong_ordering::equal;
}

Words AddMagnitudes(const Words& a, const Words& b) {
  Words sum;
  std::uint64_t carry = 0;
  for (std::size_t i = 0; i < a.size() || i < b.size(); ++i) {
    if (i < a.size()) carry += a[i];
    if (i < b.size()) carry += b[i];
    sum.push_back(static_cast<std::uint32_t>(carry));
    carry >>= 32;
  }
  sum.push_back(static_cast<std::uint32_t>(carry));
  return sum;
}

/// @pre a >= b
Words SubtractMagnitudes(const Words& a, const Words& b) {
  Words difference;
  std::uint64_t borrow = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::uint64_t taken = borrow + (i < b.size() ? b[i] : 0);
    borrow = a[i] < taken ? 1 : 0;
    difference.push_back(static_cast<std::uint32_t>((borrow << 32) + a[i] - taken));
  }
  return difference;
}

}  // namespace

WideInteger WideInteger::FromDouble(double value) {
  WideInteger result;
  if (value == 0) return result;
  int exponent = 0;
  const double fraction = std::frexp(std::fabs(value), &exponent);  // In [1/2, 1).
  auto mantissa = static_cast<std::uint64_t>(std::ldexp(fraction, 53));
  int shift = exponent - 53 + 1074;
  if (shift < 0) {
    mantissa >>= -shift;  // A subnormal number: these bits are zero.
    shift = 0;
  }
  result.negative_ = value < 0;
  result.magnitude_.assign(static_cast<std::size_t>(shift / 32), 0);
  const int bits = shift % 32;
  const std::uint64_t low = mantissa << bits;
  const std::uint64_t high = bits == 0 ? 0 : mantissa >> (64 - bits);
  result.magnitude_.push_back(static_cast<std::uint32_t>(low));
  result.magnitude_.push_back(static_cast<std::uint32_t>(low >> 32));
  result.magnitude_.push_back(static_cast<std::uint32_t>(high));
  result.Trim();
  return result;
}

void WideInteger::Trim() {
  while (!magnitude_.empty() && magnitude_.back() == 0) magnitude_.pop_back();
}

WideInteger operator-(WideInteger a) {
  a.negative_ = !a.negative_;
  return a;
}

WideInteger operator+(const WideInteger& a, const WideInteger& b) {
  WideInteger result;
  if (a.negative_ == b.negative_) {
    result.magnitude_ = AddMagnitudes(a.magnitude_, b.magnitude_);
    result.negative_ = a.negative_;
  } else {
    const bool a_larger = CompareMagnitudes(a.magnitude_, b.magnitude_) >= 0;
    const WideInteger& larger = a_larger ? a : b;
    const WideInteger& smaller = a_larger ? b : a;
    result.magnitude_ = SubtractMagnitudes(larger.magnitude_, smaller.magnitude_);
    result.negative_ = larger.negative_;
  }
  result.Trim();
  return result;
}

WideInteger operator-(const WideInteger& a, const WideInteger& b) { return a + -b; }

WideInteger operator*(const WideInteger& a, const WideInteger& b) {
  WideInteger result;
  result.magnitude_.assign(a.magnitude_.size() + b.magnitude_.size(), 0);
  for (std::size_t i = 0; i < a.magnitude_.size(); ++i) {
    std::uint64_t carry = 0;
    for (std::size_t j = 0; j < b.magnitude_.size(); ++j) {
      carry += result.magnitude_[i + j] + std::uint64_t{a.magnitude_[i]} * b.magnitude_[j];
      result.magnitude_[i + j] = static_cast<std::uint32_t>(carry);
      carry >>= 32;
    }
    result.magnitude_[i + b.magnitude_.size()] = static_cast<std::uint32_t>(carry);
  }
  result.negative_ = a.negative_ != b.negative_;
  result.Trim();
  return result;
}

}  // namespace pliant::internal
