// Random sequences of requests, faults, lost frames and missed periods: the setpoints sent to the drives obey the
// limits of their axes in any case. The drives here are minimal; tests/bus has realistic ones.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "driveline/motion/single_axis/single_axes.hpp"
#include "support/campaign.hpp"
#include "support/motion_trace.hpp"

namespace driveline::motion {
namespace {

constexpr std::size_t kAxes = 3;
constexpr std::size_t kOutputs = 19;  // of axis_pdo_configuration()
constexpr std::size_t kInputs = 19;
constexpr double kIncrements = 1e6;  // per rad
constexpr double kPeriod = 125e-6;
constexpr int kCycles = 8000;
constexpr trajectory::AxisLimits kLimits{50.0, 1000.0};

template <typename T>
T load(std::span<const std::byte> image, std::size_t at) {
  return PdoEntry<T>(at).get(image);
}

/// The setpoints that a drive has received, with their times. Between them it moves linearly, whether it interpolates
/// or extrapolates.
class Told {
 public:
  /// Why the setpoint is wrong; empty: it is right.
  [[nodiscard]] std::string hear(std::int64_t cycle, double position) {
    const double dt = kPeriod * static_cast<double>(cycle - last_cycle_);
    std::string wrong;
    if (count_ >= 1) {
      const double velocity = (position - last_) / dt;
      // Positions are whole increments.
      const double grain = 2.0 / kIncrements / std::min(dt, before_dt_);
      if (std::abs(velocity) > 1.0001 * kLimits.max_velocity + grain)
        wrong = "velocity " + std::to_string(velocity) + " in cycle " + std::to_string(cycle);
      const double change = std::abs(velocity - velocity_);
      const double allowed = 1.0001 * kLimits.max_acceleration * 0.5 * (dt + before_dt_) + 2.0 * grain;
      if (count_ >= 2 && change > allowed)
        wrong = "velocity changed by " + std::to_string(change) + ", " + std::to_string(allowed) +
                " allowed, in cycle " + std::to_string(cycle);
      velocity_ = velocity;
      before_dt_ = dt;
    }
    last_ = position;
    last_cycle_ = cycle;
    ++count_;
    return wrong;
  }
  void forget() {
    count_ = 0;
    before_dt_ = kPeriod;
  }

 private:
  int count_ = 0;
  double last_ = 0.0;
  double velocity_ = 0.0;
  double before_dt_ = kPeriod;
  std::int64_t last_cycle_ = 0;
};

/// Follows its control word at once and its target position exactly. Homing takes a while and sets a new zero.
class IdealDrive {
 public:
  explicit IdealDrive(double position) : position_(static_cast<std::int32_t>(std::llround(position * kIncrements))) {}

  [[nodiscard]] std::string outputs(std::int64_t cycle, std::span<const std::byte> image) {
    const auto control = load<std::uint16_t>(image, 0);
    const auto mode_before = std::exchange(mode_, load<std::int8_t>(image, 2));
    const auto target = load<std::int32_t>(image, 3);
    if ((control & 0x80U) != 0 && status_ == kFault) status_ = kSwitchOnDisabled;
    if (status_ == kFault) return {};
    const bool enabled = status_ == kEnabled;
    switch (control & 0x0FU) {
      case 0x06:
        status_ = kReady;
        break;
      case 0x07:
        status_ = status_ == kSwitchOnDisabled ? kSwitchOnDisabled : kSwitchedOn;
        break;
      case 0x0F:
        status_ = status_ == kSwitchedOn || enabled ? kEnabled : kSwitchedOn;
        break;
      default:  // quick stop, or no voltage: at once
        status_ = kSwitchOnDisabled;
    }
    if (status_ != kEnabled) {
      told_.forget();
      return {};
    }
    if (mode_ == kHomingMode) return home(control);
    const bool led_anew = !enabled || mode_before == kHomingMode;
    if (led_anew && std::abs(static_cast<double>(target) - position_) > 2.0) return "enabled at another place";
    position_ = target;
    return told_.hear(cycle, target / kIncrements);
  }
  std::string home(std::uint16_t control) {
    told_.forget();
    const bool start = (control & 0x10U) != 0;
    if (start && !homing_) {
      result_ = 0;
      left_ = 60;
    }
    homing_ = start;
    if (!homing_) {
      result_ |= kReached;
    } else if (left_ > 0 && --left_ == 0) {
      position_ = kHome;
      result_ = kAttained | kReached;
    }
    return {};
  }
  void fail() {
    status_ = kFault;
    told_.forget();
  }
  void inputs(std::span<std::byte> image) const {
    PdoEntry<std::uint16_t>(0).set(image, mode_ == kHomingMode ? status_ | result_ : status_);
    PdoEntry<std::int8_t>(2).set(image, mode_);
    PdoEntry<std::int32_t>(3).set(image, position_);
  }

 private:
  static constexpr std::uint16_t kSwitchOnDisabled = 0x40;
  static constexpr std::uint16_t kReady = 0x21;
  static constexpr std::uint16_t kSwitchedOn = 0x23;
  static constexpr std::uint16_t kEnabled = 0x27;
  static constexpr std::uint16_t kFault = 0x08;
  static constexpr std::uint16_t kReached = 0x0400;
  static constexpr std::uint16_t kAttained = 0x1000;
  static constexpr std::int8_t kHomingMode = 6;
  static constexpr std::int32_t kHome = 1'234'567;

  std::uint16_t status_ = kSwitchOnDisabled;
  std::int8_t mode_ = 8;
  bool homing_ = false;
  std::uint16_t result_ = kReached;
  int left_ = 0;  ///< cycles until home
  std::int32_t position_;
  Told told_;
};

/// Makes random steps, which no feed should.
class WildFeed final : public SetpointFeed {
 public:
  explicit WildFeed(unsigned seed) : random_(seed) {}
  [[nodiscard]] std::size_t axis_count() const noexcept override { return 2; }
  void join(std::size_t axis, const trajectory::AxisSetpoint& from) noexcept override { at_[axis] = from; }
  void leave(std::size_t) noexcept override {}
  [[nodiscard]] bool next(double period_s, std::span<trajectory::AxisSetpoint> setpoints) noexcept override {
    for (std::size_t i = 0; i < setpoints.size(); ++i) {
      if (random_() % 200 == 0) at_[i].velocity = static_cast<double>(random_() % 121) - 60.0;
      if (random_() % 500 == 0) at_[i].position += static_cast<double>(random_() % 21) - 10.0;
      at_[i].position += at_[i].velocity * period_s;
      setpoints[i] = at_[i];
    }
    return random_() % 2000 != 0;
  }

 private:
  std::mt19937 random_;
  std::array<trajectory::AxisSetpoint, 2> at_{};
};

/// One second of three axes.
class Sequence {
 public:
  explicit Sequence(unsigned seed) : random_(seed), feed_(seed + 1), axes_(make_axes(), settings()) {
    axes_.add_feed(feed_, {0, 2});
    for (auto& drive : drives_) drive = std::make_unique<IdealDrive>(number(-3.0, 3.0));
  }

  [[nodiscard]] std::string execute() {
    for (std::size_t axis = 0; axis < kAxes; ++axis) submit(axis, AxisCommand::kPower);
    while (cycle_ < kCycles) {
      if (chance(60)) ask();
      if (chance(1500)) drives_[pick(kAxes)]->fail();
      if (chance(150)) {
        if (auto wrong = miss(1 + static_cast<std::int64_t>(pick(10))); !wrong.empty()) return wrong;
        continue;
      }
      lost_ = chance(40) ? 1 + static_cast<int>(pick(chance(8) ? 12 : 4)) : std::max(lost_ - 1, 0);
      if (auto wrong = cycle(0); !wrong.empty()) return wrong;
    }
    return {};
  }
  [[nodiscard]] std::size_t moved() const noexcept { return moved_; }

 private:
  static SingleAxis::Settings settings() {
    SingleAxis::Settings settings;
    settings.enable_timeout = std::chrono::milliseconds{100};
    settings.quick_stop_time = std::chrono::milliseconds{20};
    settings.reset_timeout = std::chrono::milliseconds{50};
    return settings;
  }
  static std::vector<Axis> make_axes() {
    std::vector<Axis> axes;
    for (std::size_t i = 0; i < kAxes; ++i) {
      AxisConfig config;
      config.name = "axis" + std::to_string(i);
      config.slave = i;
      config.increments_per_unit = kIncrements;
      config.limits = kLimits;
      if (i == 1) config.max_jerk = 5e4;
      ImagePlace place;
      place.output_offset = i * kOutputs;
      place.input_offset = i * kInputs;
      axes.emplace_back(config, place, axis_pdo_configuration());
    }
    return axes;
  }

  [[nodiscard]] std::size_t pick(std::size_t of) { return random_() % of; }
  [[nodiscard]] bool chance(std::size_t one_in) { return pick(one_in) == 0; }
  [[nodiscard]] double number(double from, double to) { return std::uniform_real_distribution(from, to)(random_); }

  void submit(std::size_t axis, AxisCommand command) {
    AxisRequest request;
    request.command = command;
    static_cast<void>(axes_.submit(axis, request));
  }

  /// Submits any request, valid or not.
  void ask() {
    static constexpr std::array kStrange{
        0.0, -1.0, 1e9, -1e12, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()};
    AxisRequest request;
    request.command = static_cast<AxisCommand>(pick(static_cast<std::size_t>(AxisCommand::kSetMode)));
    request.buffer = static_cast<BufferMode>(pick(6));
    request.on = !chance(4);
    request.target_si = request.command == AxisCommand::kSetOverride ? number(-0.1, 2.1) : number(-30.0, 30.0);
    if (chance(2)) request.velocity_si = number(0.01, 50.0);
    if (chance(3)) request.acceleration_si = number(1.0, 1000.0);
    if (chance(3)) request.deceleration_si = number(1.0, 1000.0);
    if (chance(3)) request.jerk_si = std::exp(number(4.0, 10.8));
    if (chance(30)) request.target_si = kStrange[pick(kStrange.size())];
    if (chance(60)) request.velocity_si = kStrange[pick(kStrange.size())];
    static_cast<void>(axes_.submit(pick(kAxes), request));
    // Re-enable axes, because a campaign whose axes are off has nothing to judge.
    const auto axis = pick(kAxes);
    const auto state = axes_.axis_report(axis).state;
    if (state == PlcopenState::kErrorStop) submit(axis, AxisCommand::kReset);
    if (state == PlcopenState::kDisabled) submit(axis, AxisCommand::kPower);
    if (state == PlcopenState::kStopping && chance(3)) submit(axis, AxisCommand::kReleaseStop);
  }

  [[nodiscard]] std::string miss(std::int64_t periods) {
    cycle_ += periods;
    return cycle(periods);
  }

  /// Sends the outputs to the drives and returns the inputs, unless the frame is lost on its way out or back.
  [[nodiscard]] std::string cycle(std::int64_t missed) {
    if (missed > 0) static_cast<void>(axes_.resume(cycle_, missed, outputs_));
    const bool out = lost_ > 0 && chance(2);
    for (std::size_t i = 0; i < kAxes && !out; ++i) {
      auto wrong = drives_[i]->outputs(cycle_, std::span(outputs_).subspan(i * kOutputs, kOutputs));
      if (!wrong.empty()) return "axis " + std::to_string(i) + ": " + wrong;
      drives_[i]->inputs(std::span(inputs_).subspan(i * kInputs, kInputs));
    }
    const bool lost = lost_ > 0;
    const std::array<bool, kAxes> valid{!lost, !lost, !lost};
    axes_.read_inputs(inputs_, valid, valid, {}, {});
    axes_.update(cycle_++, outputs_);
    trace_.add_bytes(outputs_);
    for (std::size_t i = 0; i < kAxes; ++i) moved_ += axes_.axis_report(i).state > PlcopenState::kStandstill ? 1U : 0U;
    return {};
  }

  std::mt19937 random_;
  WildFeed feed_;
  SingleAxes axes_;
  std::array<std::unique_ptr<IdealDrive>, kAxes> drives_;
  std::array<std::byte, kAxes * kOutputs> outputs_{};
  MotionTrace trace_;
  std::array<std::byte, kAxes * kInputs> inputs_{};
  std::int64_t cycle_ = 0;
  int lost_ = 0;
  std::size_t moved_ = 0;
};

TEST(SingleAxesCampaign, WhatDrivesAreToldObeysTheLimits) {
  const auto runs = test::environment("DRIVELINE_CAMPAIGN_RUNS", test::share_of(100U));
  const auto first = test::environment("DRIVELINE_CAMPAIGN_SEED", 1);
  std::size_t moved = 0;
  for (unsigned seed = first; seed < first + runs; ++seed) {
    Sequence sequence(seed);
    ASSERT_EQ(sequence.execute(), "") << "seed " << seed;
    moved += sequence.moved();
  }
  EXPECT_GT(moved, std::size_t{runs} * kCycles) << "the axes hardly moved: nothing was judged";
}

/// Seeds of former violations. 10573 and 13915: after a gap an axis continued on the return path of another Rejoin,
/// whose velocities are those of its steps. 243 and 6006: a request in the first cycle after a gap, with a distance
/// superimposed on a velocity or on standstill. 6151: an override that left less for such a distance than it had been
/// given. 2983: a motion forgotten behind a stop that had waited itself, and then sent to the drive.
TEST(SingleAxesCampaign, WhatWasOnceBeyondTheLimitsIsNotAnyMore) {
  for (const unsigned seed : {10573U, 13915U, 243U, 6006U, 6151U, 2983U}) {
    Sequence sequence(seed);
    EXPECT_EQ(sequence.execute(), "") << "seed " << seed;
  }
}

}  // namespace
}  // namespace driveline::motion
