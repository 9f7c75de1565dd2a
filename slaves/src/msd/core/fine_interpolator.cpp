#include "driveline/slaves/msd/core/fine_interpolator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace driveline::slaves::msd {
namespace {

/// Maximum change of a steady rise from period to period, as a multiple of the change that the rate limit allows:
/// controllers have larger limits.
constexpr double kSteady = 2.0;
/// Change of speed in a period that counts as a leap, as a multiple of the change at the rate limit. Samples are
/// whole increments, so that a controller that uses all of the rate limit asks for a little more: at 2 ms and 2^20
/// increments per turn the change of two rises is up to two increments beyond it, 6 mrad/s, 0.3 % of that of 1000
/// rad/s^2. An output that took it for a leap would follow at the same rate, which the curve uses as well: it would be
/// behind until the curve has its highest speed, and catch up beyond that.
constexpr double kLeap = 1.01;
/// Change from rise to rise, as such a multiple, that counts as a leap behind an extrapolated sample, which is beside
/// the curve by the change of speed in its own period. The slope at a sample is the mean of two rises, so that half
/// of what one change has beyond the limit is in the slope.
constexpr double kLeapOfRise = 1.02;
/// Rise, in such changes, above which a double rise cannot be acceleration: twice the rise minus (1 + 2) changes
/// exceeds the rise plus one change.
constexpr double kFast = 4.0;
/// A sample that is late by up to this share of a period is jitter of the bus: a frame that has just begun delays SYNC
/// on CAN by up to 135 us. The control cycles of a drive are synchronised to the mean of SYNC, so its segments stay
/// where they are in time, and the next sample is on time again. Otherwise a period would become as much longer, and
/// the next one as much shorter: at 2 ms the speed would rise by 9 %.
constexpr std::uint32_t kJitterShare = 8;

}  // namespace

void FineInterpolator::configure(Method method, std::uint32_t steps, double step_s) noexcept {
  const std::uint32_t count = std::max(steps, 1U);
  if (method == method_ && count == steps_ && !(step_s < step_s_ || step_s > step_s_)) return;
  method_ = method;
  steps_ = count;
  step_s_ = step_s;
  period_s_ = count * step_s;
  find_steady_change();
  reset(output_.position, output_.velocity);
}

void FineInterpolator::set_limits(std::uint16_t periods, double rate, double speed) noexcept {
  bridged_ = periods;
  stop_rate_ = rate > 0.0 ? rate : std::numeric_limits<double>::infinity();
  top_speed_ = speed;
  find_steady_change();
}

void FineInterpolator::find_steady_change() noexcept {
  steady_change_ = kSteady * stop_rate_ * period_s_ * period_s_;
}

void FineInterpolator::reset(double value, double velocity) noexcept {
  value_ = value;
  velocity_ = velocity;
  acceleration_ = 0.0;
  elapsed_ = steps_;
  made_up_ = 0;
  late_ = false;
  pursuit_.reset();
  output_ = {value, velocity, 0.0};
  polynomial_ = {value, 0.0, 0.0, 0.0};
  const double ahead = periods_ahead();
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    samples_[i] = value + (ahead - 1.0 - static_cast<double>(i)) * velocity * period_s_;
  }
  last_sample_ = samples_[0];
}

/// The splines lag by two periods: the newest samples are ahead of the output.
double FineInterpolator::periods_ahead() const noexcept {
  if (method_ == Method::kSpline || method_ == Method::kApproximation) return 2.0;
  return method_ == Method::kNone ? 0.0 : 1.0;
}

void FineInterpolator::start_line(double end) noexcept {
  const double slope = (end - value_) / ((steps_ - elapsed_) * step_s_);
  polynomial_ = {value_ - slope * elapsed_ * step_s_, slope, 0.0, 0.0};
}

/// Starts a cubic from the current value and speed to these at the end of the period. With samples on time this is
/// exactly the segment of the spline that starts at this knot.
void FineInterpolator::start_cubic(double end, double end_velocity) noexcept {
  const double rise = end - value_;
  const double t = elapsed_ == 0 ? period_s_ : (steps_ - elapsed_) * step_s_;
  const double square = (3.0 * rise - (2.0 * velocity_ + end_velocity) * t) / (t * t);
  const double cube = ((velocity_ + end_velocity) * t - 2.0 * rise) / (t * t * t);
  polynomial_ = {value_, velocity_, square, cube};
  if (elapsed_ != 0) begin_segment_earlier();
}

/// The coefficients are over the time in the segment, of which a part has passed.
void FineInterpolator::begin_segment_earlier() noexcept {
  const auto [value, velocity, square, cube] = polynomial_;
  const double past = elapsed_ * step_s_;
  polynomial_ = {value - past * (velocity - past * (square - past * cube)),
                 velocity - past * (2.0 * square - past * 3.0 * cube), square - 3.0 * cube * past, cube};
}

/// Whether to extrapolate a missing sample; not on a curve that stands still at every sample, or without a curve.
bool FineInterpolator::makes_up() const noexcept {
  return made_up_ < bridged_ && method_ != Method::kNone && method_ != Method::kCosine;
}

/// Returns the number of samples that arrived with this sample, which is on time: more than one if others were
/// overwritten before they were read, because frames arrive at about the time of reading, some just before and some
/// just after it. In this case the sample is as far away as that many of the previous, steady rises, and no
/// acceleration explains this as a single rise.
std::uint32_t FineInterpolator::samples_in(double rise) const noexcept {
  const double change = steady_change_;
  const double last = samples_[0] - samples_[1];
  if (std::abs(rise) < 1.25 * std::abs(last)) return 1;  // usual case
  const double before = samples_[1] - samples_[2];
  if (!(std::abs(last) > kFast * change) || std::abs(last - before) > change) return 1;
  const double count = std::round(rise / last);
  const bool possible =
      count >= 2.0 && count <= bridged_ && std::abs(rise - count * last) <= 0.5 * count * (count + 1.0) * change;
  return possible ? static_cast<std::uint32_t>(count) : 1;
}

/// Returns true if other samples before it were overwritten unread.
bool FineInterpolator::take_on_time(double sample) noexcept {
  const double rise = sample - last_sample_;
  const auto count = samples_in(rise);
  if (count == 1) {
    samples_ = {sample, samples_[0], samples_[1]};
    return false;
  }
  samples_ = {sample, sample - rise / count, sample - 2.0 * rise / count};
  return true;
}

void FineInterpolator::take_late(double sample) noexcept {
  // Late by up to half a period: the sample replaces the last extrapolated one.
  const bool replaces = made_up_ > 0 && elapsed_ <= steps_ / 2;
  const std::uint32_t periods = made_up_ + elapsed_ / steps_;
  if (replaces) {
    samples_[0] = sample;
  } else if (elapsed_ > steps_ && periods > 1) {  // place the missing samples in between
    const double rise = (sample - last_sample_) / periods;
    samples_ = {sample, sample - rise, sample - 2.0 * rise};
  } else {
    samples_ = {sample, samples_[0], samples_[1]};
  }
}

void FineInterpolator::push(double sample, double velocity) noexcept {
  const bool late = made_up_ > 0 || elapsed_ > steps_;
  // After a late sample, a punctual one appears early and follows an extrapolated sample.
  bool off_time = late || late_;
  late_ = late;
  if (late) {
    take_late(sample);
  } else if (take_on_time(sample)) {
    off_time = true;
  }
  last_sample_ = sample;
  const bool jitter = late && made_up_ > 0 && elapsed_ * kJitterShare <= steps_;
  made_up_ = 0;
  if (!jitter) elapsed_ = 0;
  if (off_time && leaps()) {
    elapsed_ = 0;
    begin_pursuit();
  }
  start_segment(velocity);
}

/// Whether the output would need a larger change of speed than allowed in a period to reach the curve at the end of the
/// next period, or the curve itself has such a change after an extrapolated sample.
bool FineInterpolator::leaps() const noexcept {
  if (method_ == Method::kNone || method_ == Method::kCosine || !std::isfinite(stop_rate_)) return false;
  const double most = kLeap * stop_rate_ * period_s_;
  const bool ends_at_newest = method_ == Method::kLinear || method_ == Method::kExternal;
  const double end = ends_at_newest ? samples_[0] : samples_[1];
  if (std::abs((end - output_.position) / ((steps_ - elapsed_) * step_s_) - output_.velocity) > most) return true;
  if (ends_at_newest) return false;
  const double slope = (samples_[0] - samples_[2]) / (2.0 * period_s_);
  if (std::abs(slope - output_.velocity) > most) return true;
  const double change_of_rise = std::abs(samples_[0] - 2.0 * samples_[1] + samples_[2]) / period_s_;
  return change_of_rise > kLeapOfRise * stop_rate_ * period_s_;
}

/// Restarts the curve at the samples; the output then approaches it.
void FineInterpolator::begin_pursuit() noexcept {
  if (!pursuit_) pursuit_.emplace(output_.position, output_.velocity, trajectory::AxisLimits{top_speed_, stop_rate_});
  const bool ends_at_newest = method_ == Method::kLinear || method_ == Method::kExternal;
  value_ = ends_at_newest ? samples_[1] : samples_[2];
  velocity_ = (samples_[0] - samples_[2]) / (2.0 * period_s_);
}

/// Starts a segment to the newest sample, or as close to it as the method gets.
void FineInterpolator::start_segment(double velocity) noexcept {
  const double slope = (samples_[0] - samples_[2]) / (2.0 * period_s_);
  switch (method_) {
    case Method::kNone:
      polynomial_ = {samples_[0], 0.0, 0.0, 0.0};
      return;
    case Method::kLinear:
      return start_line(samples_[0]);
    case Method::kExternal:
      return start_cubic(samples_[0], velocity);
    case Method::kSpline:
      return start_cubic(samples_[1], slope);
    case Method::kApproximation:
      return start_cubic((samples_[0] + 4.0 * samples_[1] + samples_[2]) / 6.0, slope);
    case Method::kCosine:
      polynomial_ = {value_, samples_[0] - value_, 0.0, 0.0};
      return;
  }
}

void FineInterpolator::step_cosine(double t) noexcept {
  const double rise = polynomial_[1];
  const double w = std::numbers::pi / period_s_;
  const double cosine = std::cos(w * t);
  value_ = polynomial_[0] + 0.5 * rise * (1.0 - cosine);
  velocity_ = 0.5 * rise * w * std::sin(w * t);
  acceleration_ = 0.5 * rise * w * w * cosine;
}

void FineInterpolator::step() noexcept {
  if (elapsed_ == steps_) end_segment();
  if (elapsed_ < steps_) {
    step_segment();
  } else {
    step_beyond();
  }
  output_ = {value_, velocity_, acceleration_};
  if (pursuit_) pursue();
}

/// The next sample is missing: extrapolates it, if the method does so and not too many were missing already.
void FineInterpolator::end_segment() noexcept {
  if (!makes_up()) return;
  samples_ = {2.0 * samples_[0] - samples_[1], samples_[0], samples_[1]};
  ++made_up_;
  elapsed_ = 0;
  start_segment((samples_[0] - samples_[1]) / period_s_);
}

void FineInterpolator::pursue() noexcept {
  output_ = pursuit_->step(output_, step_s_);
  if (pursuit_->joined()) pursuit_.reset();
}

void FineInterpolator::step_segment() noexcept {
  ++elapsed_;
  const double t = elapsed_ * step_s_;
  if (method_ == Method::kCosine) return step_cosine(t);
  const auto& c = polynomial_;
  value_ = c[0] + t * (c[1] + t * (c[2] + t * c[3]));
  velocity_ = c[1] + t * (2.0 * c[2] + t * 3.0 * c[3]);
  acceleration_ = 2.0 * c[2] + t * 6.0 * c[3];
}

/// Brakes the output, because no sample has come in time.
void FineInterpolator::step_beyond() noexcept {
  acceleration_ = 0.0;
  elapsed_ += elapsed_ < std::numeric_limits<std::uint32_t>::max() ? 1 : 0;
  if (elapsed_ > steps_) {
    const double change = std::min(std::abs(velocity_), stop_rate_ * step_s_);
    velocity_ -= std::copysign(change, velocity_);
  }
  value_ += velocity_ * step_s_;
}

}  // namespace driveline::slaves::msd
