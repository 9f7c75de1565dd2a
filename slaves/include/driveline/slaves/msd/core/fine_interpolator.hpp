#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "driveline/trajectory/rejoin.hpp"

namespace driveline::slaves::msd {

/// Turns the setpoints of the bus cycle into setpoints of the control cycle (MSD manual 11.2, P 370).
///
/// Each new sample starts a segment at the present output, so the output does not jump when samples come early or late.
/// A sample that is missing is made up for by the straight line through the two before, for as many periods as
/// set_limits() says; then the output slows down to a standstill. Samples that were written over before they were taken
/// are put between. When samples return, or some were written over, and the output could meet their curve only with a
/// jump in speed, it approaches the curve within its rate limit (all ours). Delay against the samples: kNone 0,
/// kLinear, kExternal and kCosine 1, the splines 2 periods. Which curve the real drive calls "cubic spline" is not
/// described; here it passes through the samples with central-difference slopes, while the approximation is the uniform
/// cubic B-spline of the samples (continuous acceleration, does not pass through them). With external feed-forward the
/// curve is a cubic that has the samples and the speeds sent with them at its ends; the cosine goes from sample to
/// sample in half a period of a cosine, standing still at each (both: names of the manual, curves ours).
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
  /// `periods`: for how many periods missing samples are extrapolated; `rate`: limit of the change of speed when
  /// samples have not come in time, per square second, 0 for none; `speed`: highest speed while catching up. Without a
  /// call one period, a stop at once and no limit. \rtsafe
  void set_limits(std::uint16_t periods, double rate, double speed = std::numeric_limits<double>::infinity()) noexcept;
  /// Periods in which the output arrives at a sample. \rtsafe
  [[nodiscard]] double periods_ahead() const noexcept;
  /// Starts at `value`, as if earlier samples had moved with `velocity`. \rtsafe
  void reset(double value, double velocity) noexcept;
  /// A new sample has arrived, with the speed at it if the method is kExternal. \rtsafe
  void push(double sample, double velocity = 0.0) noexcept;
  /// One control cycle. \rtsafe
  void step() noexcept;

  /// Setpoint of this control cycle, in the unit of the samples. \rtsafe
  [[nodiscard]] double value() const noexcept { return output_.position; }
  /// Slope of value() at this control cycle, per second. \rtsafe
  [[nodiscard]] double velocity() const noexcept { return output_.velocity; }
  /// Slope of velocity(), per second; 0 with kNone and kLinear. \rtsafe
  [[nodiscard]] double acceleration() const noexcept { return output_.acceleration; }

 private:
  void start_line(double end) noexcept;
  void step_cosine(double t) noexcept;
  void start_cubic(double end, double end_velocity) noexcept;
  void start_segment(double velocity) noexcept;
  [[nodiscard]] std::uint32_t samples_in(double rise) const noexcept;
  [[nodiscard]] bool take_on_time(double sample) noexcept;
  void take_late(double sample) noexcept;
  [[nodiscard]] bool leaps() const noexcept;
  void begin_pursuit() noexcept;
  [[nodiscard]] bool makes_up() const noexcept;
  void step_curve() noexcept;
  [[nodiscard]] double period_s() const noexcept { return steps_ * step_s_; }

  Method method_ = Method::kLinear;
  bool late_ = false;  ///< the last sample came late
  std::uint32_t steps_ = 2;
  std::uint32_t elapsed_ = 0;
  std::uint16_t bridged_ = 1;  ///< periods
  std::uint16_t made_up_ = 0;  ///< samples since the last that came
  double stop_rate_ = std::numeric_limits<double>::infinity();
  double top_speed_ = std::numeric_limits<double>::infinity();
  double step_s_ = 62.5e-6;
  std::array<double, 3> samples_{};  ///< newest first
  std::array<double, 4>
      polynomial_{};          ///< of the time since the segment's start, constant term first; or rise of the cosine
  double last_sample_ = 0.0;  ///< that came
  double value_ = 0.0;        ///< of the curve through the samples, and its slopes
  double velocity_ = 0.0;
  double acceleration_ = 0.0;
  std::optional<trajectory::Rejoin> pursuit_;  ///< on the way back to the curve
  trajectory::AxisSetpoint output_{};
};

}  // namespace driveline::slaves::msd
