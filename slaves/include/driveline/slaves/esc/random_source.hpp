#pragma once

#include <cstdint>

namespace driveline::slaves {

/// Random numbers from a seed, identical on every machine (SplitMix64, Steele et al. 2014). \rtsafe throughout.
class RandomSource {
 public:
  /// Equal seeds give equal numbers; every seed is allowed, including 0.
  constexpr explicit RandomSource(std::uint64_t seed) noexcept : state_(seed) {}

  /// Returns 64 uniformly distributed bits.
  constexpr std::uint64_t next() noexcept {
    state_ += 0x9E3779B97F4A7C15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31);
  }
  /// Returns a number from 0 up to, but not including, 1.
  constexpr double uniform() noexcept { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  /// Returns a whole number from -limit to limit; precondition: limit >= 0.
  constexpr std::int64_t within(std::int64_t limit) noexcept {
    const auto width = static_cast<std::uint64_t>(2 * limit + 1);
    return static_cast<std::int64_t>(next() % width) - limit;
  }

 private:
  std::uint64_t state_;
};

}  // namespace driveline::slaves
