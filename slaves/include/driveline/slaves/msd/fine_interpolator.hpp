#pragma once

#include <array>
#include <cstdint>
#include <limits>

namespace driveline::slaves::msd {

/// Turns the setpoints of the bus cycle into setpoints of the control cycle (MSD manual 11.2, P 370).
///
/// Each new sample starts a segment from where the output is now, so the output has no jump when samples come early or
/// late. When the next sample is missing, the output goes on with its last speed for one more period and then slows
/// down to a standstill (ours). Delay against the samples: kNone 0, kLinear, kExternal and kCosine 1, the splines 2
/// periods. Which curve the real drive calls "cubic spline" is not described; here it passes through the samples with
/// central-difference slopes, while the approximation is the uniform cubic B-spline of the samples (continuous
/// acceleration, does not pass through them). With external feed-forward the curve is a cubic that has the samples and
/// the speeds sent with them at its ends; the cosine goes from sample to sample in half a period of a cosine, standing
/// still at each (both: names of the manual, curves ours).
class FineInterpolator {
 public:
  /// Numbers as in P 370.
  enum class Method : std::uint8_t {
    kNone = 0,
    kLinear = 1,
    kExternal = 2,
    kSpline = 3,
    kApproximation = 4,
    kCosine = 5
  };

  /// `steps`: control cycles per sample, at least 1; `step_s`: length of the control cycle. \rtsafe
  void configure(Method method, std::uint32_t steps, double step_s) noexcept;
  /// How fast an output that samples no longer come for stops, per square second; at once if 0 or never set. \rtsafe
  void set_stop_rate(double rate) noexcept;
  /// Starts at `value`, moving with `velocity` as if the samples before had. \rtsafe
  void reset(double value, double velocity) noexcept;
  /// A new sample has arrived, with the speed at it if the method is kExternal. \rtsafe
  void push(double sample, double velocity = 0.0) noexcept;
  /// One control cycle. \rtsafe
  void step() noexcept;

  /// Setpoint of this control cycle, in the unit of the samples. \rtsafe
  [[nodiscard]] double value() const noexcept { return value_; }
  /// Slope of value() at this control cycle, per second. \rtsafe
  [[nodiscard]] double velocity() const noexcept { return velocity_; }
  /// Slope of velocity(), per second; 0 with kNone and kLinear. \rtsafe
  [[nodiscard]] double acceleration() const noexcept { return acceleration_; }

 private:
  void start_line(double end) noexcept;
  void step_cosine(double t) noexcept;
  void start_cubic(double end, double end_velocity) noexcept;

  Method method_ = Method::kLinear;
  std::uint32_t steps_ = 2;
  std::uint32_t elapsed_ = 0;
  double stop_rate_ = std::numeric_limits<double>::infinity();
  double step_s_ = 62.5e-6;
  double period_s_ = 125e-6;
  std::array<double, 3> samples_{};     ///< newest first
  std::array<double, 4> polynomial_{};  ///< of the time since the segment's start, constant term first
  double rise_ = 0.0;                   ///< of the cosine
  double value_ = 0.0;
  double velocity_ = 0.0;
  double acceleration_ = 0.0;
};

}  // namespace driveline::slaves::msd
