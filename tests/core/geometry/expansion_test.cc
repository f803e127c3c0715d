#include "core/geometry/expansion.h"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/rng.h"

namespace pliant::internal {
namespace {

template <std::size_t kCapacity>
mpq_class Sum(const Expansion<kCapacity>& e) {
  mpq_class sum = 0;
  for (std::size_t i = 0; i < e.size(); ++i) sum += e[i];
  return sum;
}

// The components grow, none is zero, and each is larger than the sum of all before it.
template <std::size_t kCapacity>
void ExpectWellFormed(const Expansion<kCapacity>& e) {
  mpq_class below = 0;
  for (std::size_t i = 0; i < e.size(); ++i) {
    ASSERT_NE(e[i], 0);
    ASSERT_GT(abs(mpq_class(e[i])), abs(below));
    below += e[i];
  }
  ASSERT_EQ(e.Sign(), sgn(below));
}

// A number of few or many bits, of any magnitude that leaves room for products of eight.
double Component(Rng& rng) {
  const double value = std::ldexp(rng.Uniform(-1, 1), static_cast<int>(rng.Below(160)) - 80);
  switch (rng.Below(4)) {
    case 0:
      return static_cast<double>(rng.Below(5)) - 2;
    case 1:
      return static_cast<double>(static_cast<float>(value));
    default:
      return value;
  }
}

// Goal: no operation loses a bit, and all of them keep the form that the next one relies on.
// Method: random expressions of the shapes of the predicates, against rational numbers.
TEST(Expansion, IsExactAndWellFormed) {
  Rng rng(61);
  for (int trial = 0; trial < 3000; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed 61, trial " << trial);
    double x[8];
    for (double& component : x) component = Component(rng);
    if (trial % 3 == 0) x[1] = x[0] + std::ldexp(x[0], -50);  // Cancels to almost nothing.
    const auto a = Difference(x[0], x[1]);
    const auto b = Difference(x[2], x[3]);
    const auto c = Difference(x[4], x[5]);
    const auto d = Difference(x[6], x[7]);
    const mpq_class ra = mpq_class(x[0]) - x[1];
    const mpq_class rb = mpq_class(x[2]) - x[3];
    const mpq_class rc = mpq_class(x[4]) - x[5];
    const mpq_class rd = mpq_class(x[6]) - x[7];
    ASSERT_EQ(Sum(a), ra);
    const auto minor = a * d - b * c;
    ASSERT_EQ(Sum(minor), ra * rd - rb * rc);
    const auto lift = a * a + b * b;
    ASSERT_EQ(Sum(lift), ra * ra + rb * rb);
    const auto product = minor * lift + -minor;
    ASSERT_EQ(Sum(product), (ra * rd - rb * rc) * (ra * ra + rb * rb - 1));
    ASSERT_NO_FATAL_FAILURE(ExpectWellFormed(minor));
    ASSERT_NO_FATAL_FAILURE(ExpectWellFormed(lift));
    ASSERT_NO_FATAL_FAILURE(ExpectWellFormed(product));
    ASSERT_EQ((product - product).Sign(), 0);
  }
}

TEST(TwoProduct, SplitsOffTheRoundingError) {
  const double x = 1 + 0x1p-30;
  const Rounded square = TwoProduct(x, x);
  EXPECT_EQ(square.value, 1 + 0x1p-29);
  EXPECT_EQ(square.error, 0x1p-60);
}

}  // namespace
}  // namespace pliant::internal
