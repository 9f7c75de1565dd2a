#pragma once

#include <chrono>
#include <cstdint>

/// Arithmetic on the system time of distributed clocks: nanoseconds as unsigned 64-bit numbers; some slaves have only
/// the lower half. \rtsafe throughout.
namespace driveline::ecat_master::dc {

/// The time with the lower half `low` that is nearest to `expected`: correct if the expectation is off by less than
/// 2^31 ns (2.1 s).
[[nodiscard]] constexpr std::uint64_t extend(std::uint32_t low, std::uint64_t expected) noexcept {
  const auto ahead = static_cast<std::int32_t>(low - static_cast<std::uint32_t>(expected));
  return expected + static_cast<std::uint64_t>(std::int64_t{ahead});
}

/// a - b for two times less than 2^63 ns apart, correct across a wrap-around.
[[nodiscard]] constexpr std::chrono::nanoseconds difference(std::uint64_t a, std::uint64_t b) noexcept {
  return std::chrono::nanoseconds{static_cast<std::int64_t>(a - b)};
}

/// a + b modulo 2^64, for times from external clocks, which may jump by any amount.
[[nodiscard]] constexpr std::chrono::nanoseconds wrapped_sum(std::chrono::nanoseconds a,
                                                             std::chrono::nanoseconds b) noexcept {
  return std::chrono::nanoseconds{
      static_cast<std::int64_t>(static_cast<std::uint64_t>(a.count()) + static_cast<std::uint64_t>(b.count()))};
}
/// a - b modulo 2^64, see wrapped_sum().
[[nodiscard]] constexpr std::chrono::nanoseconds wrapped_difference(std::chrono::nanoseconds a,
                                                                    std::chrono::nanoseconds b) noexcept {
  return difference(static_cast<std::uint64_t>(a.count()), static_cast<std::uint64_t>(b.count()));
}

/// Moves `value` into -cycle/2 .. cycle/2 by whole cycles (cycle > 0).
[[nodiscard]] constexpr std::chrono::nanoseconds wrap_to_cycle(std::chrono::nanoseconds value,
                                                               std::chrono::nanoseconds cycle) noexcept {
  auto rest = value % cycle;
  if (rest < std::chrono::nanoseconds{0}) rest += cycle;
  return rest > cycle / 2 ? rest - cycle : rest;
}

/// Decodes register 0x092C: bit 31 set means that the local copy of the system time lags the received time; the other
/// bits are the magnitude (ETG.1000.4 Table 60). Positive result: the slave's clock is ahead.
[[nodiscard]] constexpr std::chrono::nanoseconds decode_difference(std::uint32_t raw) noexcept {
  const auto magnitude = static_cast<std::int64_t>(raw & 0x7FFF'FFFFU);
  return std::chrono::nanoseconds{(raw & 0x8000'0000U) != 0 ? -magnitude : magnitude};
}

/// Relation of the reference clock to the master's clock: one instant on both clocks, and the frequency difference.
struct ClockMapping {
  std::chrono::nanoseconds local{0};  ///< master's clock when the frame was sent
  std::uint64_t reference = 0;        ///< system time when the frame passed the reference clock
  double ppm = 0.0;                   ///< frequency of the reference clock relative to the master's clock

  /// System time at which a frame sent at `sent` meets the reference clock.
  [[nodiscard]] constexpr std::uint64_t at(std::chrono::nanoseconds sent) const noexcept {
    const auto elapsed = sent - local;
    const auto extra = static_cast<std::int64_t>(static_cast<double>(elapsed.count()) * ppm * 1e-6);
    return reference + static_cast<std::uint64_t>(elapsed.count() + extra);
  }
};

}  // namespace driveline::ecat_master::dc
