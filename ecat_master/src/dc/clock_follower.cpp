#include "driveline/ecat_master/dc/clock_follower.hpp"

#include <algorithm>
#include <cmath>

#include "driveline/wire/registers.hpp"

namespace driveline::ecat_master::dc {
namespace {

using std::chrono::nanoseconds;

/// A larger change between two cycles is not drift: the clock has been set.
constexpr auto kTimeJump = std::chrono::milliseconds{1};
constexpr double kLateShare = 1.0 / 64.0;

PhaseController::Settings with_period(PhaseController::Settings settings, nanoseconds period) noexcept {
  settings.period = period;
  return settings;
}

}  // namespace

ReferenceClock ClockFollower::reference_of(const LineClocks& clocks) noexcept {
  // The reference clock reads and every other clock writes, also those in front of it: each adds 1 (ETG.1000.4 Table
  // 17).
  const auto all =
      std::count_if(clocks.slaves.begin(), clocks.slaves.end(), [](const SlaveClock& clock) { return clock.present; });
  return {clocks.station, 0, static_cast<std::uint16_t>(all)};
}

ClockFollower::ClockFollower(const LineClocks& clocks, PhaseController::Settings control)
    : mode_(clocks.mode),
      period_(clocks.period),
      arrival_(clocks.start - static_cast<std::uint64_t>(clocks.frame_lead.count())),
      mapping_(clocks.mapping),
      time_(clocks.mode == FollowMode::kReferenceFollows ? clocks.time : nullptr),
      controller_(with_period(control, clocks.period)),
      detector_(LockDetector::Settings::for_period(clocks.period)),
      reference_(reference_of(clocks)) {
  controller_.reset(mapping_.ppm);
}

ClockFollower::Nanoseconds ClockFollower::first_grid(Nanoseconds earliest) const noexcept {
  auto wait = difference(arrival_, mapping_.at(earliest)) % period_;
  if (wait < Nanoseconds{0}) wait += period_;
  return earliest + wait;
}

DriftDatagram ClockFollower::next(Nanoseconds now) noexcept {
  reference_.update();
  const auto& reference = reference_.read();
  sends_time_ = mode_ == FollowMode::kReferenceFollows && !sends_time_;
  sent_ = {};
  if (reference.station == 0) return sent_;
  sent_.command = sends_time_ ? wire::Command::kFpwr : wire::Command::kFrmw;
  // After a missing answer the reference clock is only read: the route of the frames may have changed, and a time sent
  // on another route than the measured one would shift all clocks.
  if (silent_ > 0 && !sends_time_) sent_.command = wire::Command::kFprd;
  sent_.address = wire::DatagramAddress::physical(reference.station, wire::reg::kSystemTime.address);
  datagram_time_ = now;
  const auto time =
      sends_time_ ? time_to_send(now) : mapping_.at(now) + static_cast<std::uint64_t>(std::llround(late_ns_));
  sent_.time = static_cast<std::uint32_t>(time + static_cast<std::uint64_t>(reference.delay_ns));
  // Add one nanosecond every other time, so that the reference clock's own time cannot equal this time permanently.
  dither_ = !dither_ && !sends_time_;
  sent_.time += dither_ ? 1U : 0U;
  return sent_;
}

ClockFollower::Nanoseconds ClockFollower::finish(const rt::CycleStart& start, Nanoseconds sent,
                                                 const std::optional<DriftAnswer>& answer) noexcept {
  if (sends_time_) return time_ != nullptr ? controller_.update(std::nullopt) : Nanoseconds{0};
  const auto error = measure(start, sent, answer);
  auto shift = Nanoseconds{0};
  if (grid_follows()) {
    const auto outliers = controller_.outliers();
    shift = controller_.update(error);
    // Outliers are not used for predictions either.
    if (error && controller_.outliers() == outliers) learn(sent, *answer);
  } else {
    detector_.update(error ? std::optional(static_cast<double>(error->count())) : std::nullopt);
  }
  publish(error);
  return shift;
}

/// The external time without its jumps.
std::uint64_t ClockFollower::time_to_send(Nanoseconds now) noexcept {
  if (time_ == nullptr) return mapping_.at(now);
  const auto ahead = wrapped_difference(wrapped_difference(time_->now(), now), jumped_);
  const auto change = time_ahead_ ? wrapped_difference(ahead, *time_ahead_) : Nanoseconds{0};
  if (change > kTimeJump || change < -kTimeJump) {
    jumped_ = wrapped_sum(jumped_, change);
    ++jumps_;
  } else {
    time_ahead_ = ahead;
  }
  return static_cast<std::uint64_t>(wrapped_sum(now, *time_ahead_).count());
}

/// Updates the prediction with an answer that is not an outlier.
void ClockFollower::learn(Nanoseconds sent, const DriftAnswer& answer) noexcept {
  const auto delay = static_cast<std::uint64_t>(reference_.read().delay_ns);
  const auto met = extend(answer.time, mapping_.at(sent) + delay) - delay;
  late_ns_ += kLateShare * (static_cast<double>(difference(met, mapping_.at(datagram_time_)).count()) - late_ns_);
  mapping_ = {sent, met, controller_.ppm()};
}

/// How late the frame would have met the reference clock if it had been sent at the grid instant.
std::optional<nanoseconds> ClockFollower::measure(const rt::CycleStart& start, Nanoseconds sent,
                                                  const std::optional<DriftAnswer>& answer) noexcept {
  if (!answer) return std::nullopt;
  if (!reference_answered(*answer)) {
    ++silent_;
    return std::nullopt;
  }
  silent_ = 0;
  const auto delay = static_cast<std::uint64_t>(reference_.read().delay_ns);
  const auto time = extend(answer->time, mapping_.at(sent) + delay) - delay;
  const auto late = static_cast<std::uint64_t>((sent - start.grid).count());
  return wrap_to_cycle(difference(time - late, arrival_), period_);
}

/// The working counter does not distinguish the slaves. Without the reference clock it is lower by one and the time
/// returns as it was sent.
bool ClockFollower::reference_answered(const DriftAnswer& answer) const noexcept {
  if (sent_.command == wire::Command::kNop || answer.working_counter == 0) return false;
  if (sent_.command == wire::Command::kFprd) return true;
  return answer.time != sent_.time || answer.working_counter >= reference_.read().working_counter;
}

void ClockFollower::publish(std::optional<Nanoseconds> error) noexcept {
  Status status;
  const bool follows = grid_follows();
  status.locked = follows ? controller_.locked() : detector_.locked();
  status.cause = follows ? controller_.cause() : detector_.cause();
  status.ppm = follows ? controller_.ppm() : 0.0;
  status.mean_error_ns = follows ? controller_.mean_error_ns() : detector_.mean_error_ns();
  status.noise_ns = follows ? controller_.noise_ns() : 0.0;
  status.silent = silent_;
  if (locked_ && !status.locked) ++unlocks_;
  locked_ = status.locked;
  last_error_ = error.value_or(last_error_);
  status.unlocks = unlocks_;
  status.time_jumps = jumps_;
  status.time_jumped_ns = jumped_.count();
  if (status.locked && error) phase_errors_.record(std::chrono::abs(*error));
  status_.write(status);
}

ClockFollower::Status ClockFollower::status() noexcept {
  status_.update();
  return status_.read();
}

Error not_locked(const ClockFollower::Status& status, const ClockFollower& follower) noexcept {
  return {facts::NotLocked{.cause = status.cause,
                           .noise_ns = static_cast<std::uint32_t>(std::clamp(status.noise_ns, 0.0, 1e9)),
                           .mean_error = nanoseconds{std::llround(status.mean_error_ns)},
                           .window = nanoseconds{static_cast<std::int64_t>(follower.lock_window_ns())}}};
}

}  // namespace driveline::ecat_master::dc
