#pragma once

#include "core/geometry/expansion.h"

namespace pliant {

/// A sum of products of two doubles with about twice their precision, so that what two sums of
/// many terms differ by is not the rounding of the sums. [OgitaRumpOishi2005, Dot2]
class ExactSum {
 public:
  void Add(double a, double b) {
    const internal::Rounded product = internal::TwoProduct(a, b);
    const internal::Rounded sum = internal::TwoSum(high_, product.value);
    high_ = sum.value;
    low_ += sum.error + product.error;
  }

  [[nodiscard]] double value() const { return high_ + low_; }

 private:
  double high_ = 0;
  double low_ = 0;
};

}  // namespace pliant
