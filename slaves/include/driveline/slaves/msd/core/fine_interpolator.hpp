#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "driveline/trajectory/rejoin.hpp"

namespace driveline::slaves::msd {

/// Converts the setpoints of the bus cycle to setpoints of the control cycle (MSD manual 11.2, P 370).
///
/// Each new sample starts a segment at the current output, so the output does not jump when samples arrive early or
/// late. A missing sample is extrapolated linearly from the two previous ones, for as many periods as set_limits()
/// specifies; then the output decelerates to standstill. Samples that were overwritten before they were read are
/// interpolated. When samples return or some were overwritten, and the output could meet their curve only with a jump
/// in speed, it approaches the curve within its rate limit (all ours). Delay relative to the samples: kNone 0, kLinear,
/// kExternal and kCosine 1, the splines 2 periods. Which curve the real drive calls "cubic spline" is not described;
/// here it passes through the samples with central-difference slopes, while the approximation is the uniform cubic
/// B-spline of the samples (continuous acceleration, does not pass through them). With external feed-forward the curve
/// is a cubic whose ends have the samples and the speeds sent with them; the cosine moves from sample to sample in half
/// a cosine period, with standstill at each sample (both: names of the manual, curves ours).
class FineInterpolator {
 public:
  /// Interpolation methods, numbered as in P 370.
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
  /// samples were not on time, per square second, 0 for none; `speed`: maximum speed while catching up. Defaults: one
  /// period, immediate stop, no speed limit. \rtsafe
  void set_limits(std::uint16_t periods, double rate, double speed = std::numeric_limits<double>::infinity()) noexcept;
  /// Returns after how many periods the output reaches a sample. \rtsafe
  [[nodiscard]] double periods_ahead() const noexcept;
  /// Starts at `value`, as if earlier samples had moved with `velocity`. \rtsafe
  void reset(double value, double velocity) noexcept;
  /// Adds a new sample, with its speed if the method is kExternal. \rtsafe
  void push(double sample, double velocity = 0.0) noexcept;
  /// Runs one control cycle. \rtsafe
  void step() noexcept;

  /// Returns the setpoint of this control cycle, in the unit of the samples. \rtsafe
  [[nodiscard]] double value() const noexcept { return output_.position; }
  /// Returns the slope of value() at this control cycle, per second. \rtsafe
  [[nodiscard]] double velocity() const noexcept { return output_.velocity; }
  /// Returns the slope of velocity(), per second; 0 with kNone and kLinear. \rtsafe
  [[nodiscard]] double acceleration() const noexcept { return output_.acceleration; }

 private:
  void start_line(double end) noexcept;
  [[gnu::cold]] void step_cosine(double t) noexcept;
  void start_cubic(double end, double end_velocity) noexcept;
  [[gnu::cold]] void begin_segment_earlier() noexcept;
  void start_segment(double velocity) noexcept;
  void find_steady_change() noexcept;
  [[nodiscard]] std::uint32_t samples_in(double rise) const noexcept;
  [[nodiscard]] bool take_on_time(double sample) noexcept;
  [[gnu::cold]] void take_late(double sample) noexcept;
  [[nodiscard, gnu::cold]] bool leaps() const noexcept;
  [[gnu::cold]] void begin_pursuit() noexcept;
  [[nodiscard]] bool makes_up() const noexcept;
  [[gnu::cold]] void end_segment() noexcept;
  void step_segment() noexcept;
  [[gnu::cold]] void step_beyond() noexcept;
  [[gnu::cold]] void pursue() noexcept;

  // What the steps within a segment use comes last, so that it shares few cache lines.
  std::uint16_t bridged_ = 1;  ///< maximum number of extrapolated periods
  double top_speed_ = std::numeric_limits<double>::infinity();
  double stop_rate_ = std::numeric_limits<double>::infinity();
  std::optional<trajectory::Rejoin> pursuit_;  ///< return to the curve, while in progress
  Method method_ = Method::kLinear;
  bool late_ = false;          ///< the last sample was late
  std::uint16_t made_up_ = 0;  ///< extrapolated samples since the last received sample
  std::uint32_t steps_ = 2;
  std::uint32_t elapsed_ = 0;
  double step_s_ = 62.5e-6;
  double period_s_ = 125e-6;                                        ///< steps_ * step_s_
  double steady_change_ = std::numeric_limits<double>::infinity();  ///< a steady rise changes no more
  double last_sample_ = 0.0;                                        ///< last received sample
  std::array<double, 3> samples_{};                                 ///< newest first
  /// Coefficients over the time in the segment, constant term first; or start and rise of the cosine.
  std::array<double, 4> polynomial_{};
  double value_ = 0.0;  ///< position on the curve; the next two are its derivatives
  double velocity_ = 0.0;
  double acceleration_ = 0.0;
  trajectory::AxisSetpoint output_{};
};

}  // namespace driveline::slaves::msd
