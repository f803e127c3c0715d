#pragma once

#include <array>
#include <cstdint>

namespace pliant {

/// xoshiro256** seeded through splitmix64 ([Blackman2021]): the one source of randomness of the
/// core. The standard library's distributions differ between implementations, so the few that are
/// needed are members here; the same seed gives the same numbers everywhere.
class Rng {
 public:
  explicit Rng(std::uint64_t seed) {
    for (std::uint64_t& word : state_) word = SplitMix(seed);
  }

  /// Where the sequence stands, and a generator that goes on from there.
  [[nodiscard]] const std::array<std::uint64_t, 4>& state() const { return state_; }
  static Rng At(const std::array<std::uint64_t, 4>& state) {
    Rng rng(0);
    rng.state_ = state;
    return rng;
  }

  /// A uniform 64-bit word.
  std::uint64_t Next() {
    const std::uint64_t result = Rotate(state_[1] * 5, 7) * 9;
    const std::uint64_t t = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= t;
    state_[3] = Rotate(state_[3], 45);
    return result;
  }

  /// A uniform integer in [0, bound), by rejection. @pre bound > 0
  std::uint64_t Below(std::uint64_t bound) {
    const std::uint64_t threshold = (0 - bound) % bound;
    for (;;) {
      const std::uint64_t word = Next();
      if (word >= threshold) return word % bound;
    }
  }

  /// A uniform double in [0, 1), a multiple of 2^-53.
  double Unit() { return static_cast<double>(Next() >> 11) * 0x1p-53; }

  /// A uniform double in [low, high).
  double Uniform(double low, double high) { return low + (high - low) * Unit(); }

 private:
  static std::uint64_t Rotate(std::uint64_t x, int count) {
    return (x << count) | (x >> (64 - count));
  }
  static std::uint64_t SplitMix(std::uint64_t& seed) {
    std::uint64_t z = (seed += 0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }

  std::array<std::uint64_t, 4> state_{};
};

}  // namespace pliant
