#pragma once

#include <chrono>
#include <cstdint>

namespace driveline::slaves {

/// The oscillator of an emulated slave, and how it differs from the line's clock. Deterministic: the same options give
/// the same times.
struct ClockOptions {
  std::chrono::nanoseconds start{0};  ///< local time at power-on
  double drift_ppm = 0.0;             ///< how much too fast the oscillator runs; within ±500
  /// Slow change with temperature: the rate wanders up and down at this speed ...
  double temperature_ppm_per_s = 0.0;
  /// ... within plus and minus this, beginning somewhere (seed). 0: none.
  double temperature_span_ppm = 0.0;
  /// Largest error of the time stamp of a frame, either way; each stamp draws one.
  std::chrono::nanoseconds receive_jitter{0};
  /// Period of the oscillator: times advance in steps of it.
  std::chrono::nanoseconds resolution{10};
  std::uint64_t seed = 1;  ///< of jitter and temperature
};

}  // namespace driveline::slaves
