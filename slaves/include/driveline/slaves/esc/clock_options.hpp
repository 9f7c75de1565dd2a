#pragma once

#include <chrono>
#include <cstdint>

namespace driveline::slaves {

/// Oscillator of an emulated slave, with its deviation from the line's clock. Equal options give equal times.
struct ClockOptions {
  std::chrono::nanoseconds start{0};  ///< local time at power-on
  double drift_ppm = 0.0;             ///< rate error of the oscillator, positive: too fast; within ±500
  /// Slow change with temperature: the rate rises and falls with this slope ...
  double temperature_ppm_per_s = 0.0;
  /// ... between plus and minus this value; the seed determines the initial value. 0: no change.
  double temperature_span_ppm = 0.0;
  /// Largest error of a frame's time stamp in either direction; random for each stamp.
  std::chrono::nanoseconds receive_jitter{0};
  /// Period of the oscillator: times advance in steps of this.
  std::chrono::nanoseconds resolution{10};
  std::uint64_t seed = 1;  ///< seed of jitter and temperature
};

}  // namespace driveline::slaves
