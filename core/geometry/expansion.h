#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace pliant::internal {

/// A number held exactly as the unevaluated sum of up to `kCapacity` doubles of growing magnitude,
/// none of them zero and no two of them sharing a bit position. [Shewchuk1997]
///
/// *Invariants*: strongly non-overlapping, which the operations below preserve under rounding to
/// nearest even; exact as long as no component over- or underflows, which is for the caller to see
/// to. Lives on the stack; nothing allocates.
template <std::size_t kCapacity>
class Expansion {
 public:
  Expansion() = default;

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] double operator[](std::size_t i) const { return components_[i]; }

  /// Appends a component larger than all before it; a zero is dropped.
  void Append(double component) {
    if (component != 0) components_[size_++] = component;
  }

  /// The largest component outweighs the rest, so it alone has the sign of the sum.
  [[nodiscard]] int Sign() const {
    if (size_ == 0) return 0;
    return components_[size_ - 1] > 0 ? 1 : -1;
  }

 private:
  std::array<double, kCapacity> components_;
  std::size_t size_ = 0;
};

/// A rounded result and the exact error that the rounding made.
struct Rounded {
  double value;
  double error;
};

/// a + b without loss. [Knuth1997]
inline Rounded TwoSum(double a, double b) {
  const double sum = a + b;
  const double b_seen = sum - a;
  const double a_seen = sum - b_seen;
  return {sum, (a - a_seen) + (b - b_seen)};
}

/// a + b without loss if |a| >= |b|. [Dekker1971]
inline Rounded FastTwoSum(double a, double b) {
  const double sum = a + b;
  return {sum, b - (sum - a)};
}

/// a * b without loss: each factor is cut in halves of 26 bits, whose products are exact. Not
/// std::fma, which is a slow library call on machines without it. [Dekker1971]
inline Rounded TwoProduct(double a, double b) {
  constexpr double kSplitter = 0x1p27 + 1;
  const double a_scaled = kSplitter * a;
  const double a_high = a_scaled - (a_scaled - a);
  const double a_low = a - a_high;
  const double b_scaled = kSplitter * b;
  const double b_high = b_scaled - (b_scaled - b);
  const double b_low = b - b_high;
  const double product = a * b;
  const double error =
      a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low);
  return {product, error};
}

/// a - b without loss.
inline Expansion<2> Difference(double a, double b) {
  const Rounded difference = TwoSum(a, -b);
  Expansion<2> result;
  result.Append(difference.error);
  result.Append(difference.value);
  return result;
}

/// Merges the components by magnitude and adds them up, smallest first.
template <std::size_t kA, std::size_t kB>
Expansion<kA + kB> operator+(const Expansion<kA>& a, const Expansion<kB>& b) {
  Expansion<kA + kB> result;
  std::size_t i = 0;
  std::size_t j = 0;
  const auto next = [&] {
    const bool take_a = j == b.size() || (i < a.size() && std::fabs(a[i]) <= std::fabs(b[j]));
    return take_a ? a[i++] : b[j++];
  };
  const std::size_t count = a.size() + b.size();
  if (count == 0) return result;
  double carry = next();
  for (std::size_t k = 1; k < count; ++k) {
    const Rounded sum = TwoSum(carry, next());
    result.Append(sum.error);
    carry = sum.value;
  }
  result.Append(carry);
  return result;
}

template <std::size_t kA>
Expansion<kA> operator-(const Expansion<kA>& a) {
  Expansion<kA> result;
  for (std::size_t i = 0; i < a.size(); ++i) result.Append(-a[i]);
  return result;
}

template <std::size_t kA, std::size_t kB>
Expansion<kA + kB> operator-(const Expansion<kA>& a, const Expansion<kB>& b) {
  return a + -b;
}

/// Shewchuk's scale-expansion: a times one double.
template <std::size_t kA>
Expansion<2 * kA> Scale(const Expansion<kA>& a, double factor) {
  Expansion<2 * kA> result;
  if (a.size() == 0) return result;
  const Rounded first = TwoProduct(a[0], factor);
  result.Append(first.error);
  double carry = first.value;
  for (std::size_t i = 1; i < a.size(); ++i) {
    const Rounded product = TwoProduct(a[i], factor);
    const Rounded low = TwoSum(carry, product.error);
    result.Append(low.error);
    const Rounded high = FastTwoSum(product.value, low.value);
    result.Append(high.error);
    carry = high.value;
  }
  result.Append(carry);
  return result;
}

/// Cuts b in halves until single components are left: the sums stay balanced.
template <std::size_t kA, std::size_t kB>
Expansion<2 * kA * kB> operator*(const Expansion<kA>& a, const Expansion<kB>& b) {
  if constexpr (kB == 1) {
    return b.size() == 0 ? Expansion<2 * kA>() : Scale(a, b[0]);
  } else {
    constexpr std::size_t kLow = kB / 2;
    Expansion<kLow> low;
    Expansion<kB - kLow> high;
    for (std::size_t i = 0; i < b.size(); ++i) {
      i < kLow ? low.Append(b[i]) : high.Append(b[i]);
    }
    return a * low + a * high;
  }
}

}  // namespace pliant::internal
