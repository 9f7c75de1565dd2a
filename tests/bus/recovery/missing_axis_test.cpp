// Behaviour of the other axes while one is missing, and its return to the path.
#include <gmock/gmock.h>

#include <cmath>
#include <utility>

#include "drive_line.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::LineSupervisor;
using motion::AxisPresence;
using motion::LossPolicy;
using motion::MotionFailure;
using motion::MotionPhase;
using wire::AlState;

constexpr std::size_t kDrives = 4;
constexpr std::size_t kLast = kDrives - 1;

class MissingAxis : public testing::Test {
 protected:
  void start(LossPolicy policy, bool repeat = true, bool relative = false,
             motion::cia402::Mode mode = motion::cia402::Mode::kCyclicPosition) {
    RunOptions options;
    options.on_loss = policy;
    options.repeat = repeat;
    options.relative = relative;
    options.mode = mode;
    options.amplitude_rad = 0.5;
    operation = std::make_unique<LineOperation>(drives, options);
    ASSERT_EQ(sentence(operation->to_motion()), "");
    ASSERT_TRUE(operation->run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
    LineSupervisor::Settings settings;
    settings.state_timeout = std::chrono::seconds{1};
    supervisor = std::make_unique<LineSupervisor>(operation->master(), nullptr, settings);
    operation->run(milliseconds{150});
    remember();
  }
  /// Discards earlier setpoints.
  void remember() {
    operation->axis_samples.clear();
    seen.fill({});
  }
  /// The setpoints of an enabled drive must not jump from one cycle to the next, nor when it is enabled.
  void check_setpoints() {
    for (const auto& sample : operation->axis_samples) {
      auto& last = seen[sample.axis];
      const double speed = (sample.target_position - last.position) / 125e-6;
      const bool enabled = sample.state == snapshot::AxisState::kOperationEnabled;
      const auto before = std::exchange(last, {sample.target_position, enabled ? speed : 0.0, last.samples + 1});
      // The second sample has no meaningful speed.
      if (!enabled || before.samples < 2) continue;
      const auto& limits = operation->motion().axes()[sample.axis].config().limits;
      ASSERT_LE(std::abs(speed), limits.max_velocity) << "axis " << sample.axis << ", cycle " << sample.cycle;
      ASSERT_LE(std::abs(speed - before.velocity) / 125e-6, 1.9 * limits.max_acceleration)
          << "axis " << sample.axis << ", cycle " << sample.cycle;
    }
    operation->axis_samples.clear();
    for (std::size_t i = 0; i < kDrives; ++i) position[i] = seen[i].position;
  }
  void live(nanoseconds duration) {
    const auto end = drives.clock.now() + duration;
    while (drives.clock.now() < end && !HasFatalFailure()) {
      operation->run(milliseconds{5});
      supervisor->poll();
      check_setpoints();
    }
  }
  bool live_until(const std::function<bool()>& done, nanoseconds limit) {
    const auto end = drives.clock.now() + limit;
    while (!done() && drives.clock.now() < end && !HasFatalFailure()) live(milliseconds{5});
    return done();
  }
  [[nodiscard]] AxisPresence presence(std::size_t axis) const { return operation->motion().presence(axis); }
  motion::Motion& motion() { return operation->motion(); }

  DriveLine drives{kDrives};
  std::unique_ptr<LineOperation> operation;
  std::unique_ptr<LineSupervisor> supervisor;
  std::array<double, kDrives> position{};
  struct Seen {
    double position = 0.0;
    double velocity = 0.0;
    unsigned samples = 0;
  };
  std::array<Seen, kDrives> seen{};
};

TEST_F(MissingAxis, StopsAllUnlessToldOtherwise) {
  start(LossPolicy::kStop);
  drives.line().set_power(kLast, false);
  operation->run(milliseconds{5});
  EXPECT_EQ(motion().failure().cause, MotionFailure::Cause::kAxisLost);
  EXPECT_EQ(motion().failure().axis, kLast);
  EXPECT_EQ(presence(kLast), AxisPresence::kPresent) << "nobody is waited for";
}

TEST_F(MissingAxis, IsWaitedForByTheOthersAtRestOnThePath) {
  start(LossPolicy::kHold);
  drives.line().set_power(kLast, false);
  live(milliseconds{200});
  ASSERT_EQ(motion().phase(), MotionPhase::kWaiting);
  EXPECT_EQ(presence(kLast), AxisPresence::kMissing);
  EXPECT_EQ(motion().axes()[kLast].inputs().state, snapshot::AxisState::kUnavailable);
  const auto rest = position;
  live(milliseconds{300});
  for (std::size_t i = 0; i < kLast; ++i) {
    EXPECT_EQ(position[i], rest[i]) << "axis " << i;
    EXPECT_TRUE(motion().axes()[i].enabled()) << "axis " << i;
    EXPECT_NEAR(drives.drive(i).position_rad(), rest[i], 1e-3);
  }
  // All axes have the same path except for their amplitudes, so they are on it together even at rest.
  for (std::size_t i = 1; i < kLast; ++i) {
    EXPECT_NEAR((position[i] - 0.1) * static_cast<double>(1 + i), position[0] - 0.1, 1e-6) << "axis " << i;
  }
  drives.line().set_power(kLast, true);
  ASSERT_TRUE(live_until([&] { return presence(kLast) == AxisPresence::kPresent; }, std::chrono::seconds{8}));
  ASSERT_TRUE(live_until([&] { return motion().phase() == MotionPhase::kFollowing; }, std::chrono::seconds{1}));
  live(milliseconds{100});
  EXPECT_NEAR((position[kLast] - 0.1) * 4.0, position[0] - 0.1, 1e-6);
  EXPECT_NEAR(drives.drive(kLast).position_rad(), position[kLast], 0.02);
  EXPECT_EQ(motion().failure().cause, MotionFailure::Cause::kNone);
}

TEST_F(MissingAxis, IsLeftBehindByTheOthersAndCatchesUp) {
  start(LossPolicy::kContinue);
  drives.line().set_power(kLast, false);
  live(milliseconds{200});
  EXPECT_NE(motion().phase(), MotionPhase::kWaiting);
  EXPECT_EQ(presence(kLast), AxisPresence::kMissing);
  for (std::size_t i = 0; i < kLast; ++i) EXPECT_EQ(presence(i), AxisPresence::kPresent);
  const auto before = position;
  live(milliseconds{60});
  EXPECT_NE(position[0], before[0]) << "they go on";
  drives.line().set_power(kLast, true);
  ASSERT_TRUE(live_until([&] { return presence(kLast) == AxisPresence::kPresent; }, std::chrono::seconds{8}));
  live(milliseconds{50});
  if (motion().phase() == MotionPhase::kFollowing) {
    EXPECT_NEAR((position[kLast] - 0.1) * 4.0, position[0] - 0.1, 1e-6);
  }
  EXPECT_EQ(motion().failure().cause, MotionFailure::Cause::kNone);
}

/// The master closes its loops, with a delay.
TEST_F(MissingAxis, InCstComesBackGently) {
  start(LossPolicy::kContinue, true, false, motion::cia402::Mode::kCyclicTorque);
  drives.line().set_power(kLast, false);
  live(milliseconds{260});
  drives.line().set_power(kLast, true);
  ASSERT_TRUE(live_until([&] { return presence(kLast) == AxisPresence::kReturning; }, std::chrono::seconds{8}));
  double place = motion().setpoints()[kLast].position;
  double velocity = 0.0;
  double hardest = 0.0;
  int cycles = 0;
  for (; cycles < 40000 && presence(kLast) == AxisPresence::kReturning; ++cycles) {
    operation->cycle();
    const double step =
        motion().setpoints()[kLast].position - std::exchange(place, motion().setpoints()[kLast].position);
    const double change = step / 125e-6 - std::exchange(velocity, step / 125e-6);
    if (cycles > 0) hardest = std::max(hardest, std::abs(change) / 125e-6);
  }
  EXPECT_EQ(presence(kLast), AxisPresence::kPresent);
  EXPECT_GT(cycles, 100) << "it has a way to go";
  EXPECT_LE(hardest, 160.0) << "a tenth of what it may, and what the path takes";
  EXPECT_EQ(motion().failure().cause, MotionFailure::Cause::kNone);
}

TEST_F(MissingAxis, BehindABrokenCableComesBackFromItsFault) {
  for (const auto policy : {LossPolicy::kHold, LossPolicy::kContinue}) {
    DriveLine& line = drives;
    start(policy);
    ASSERT_TRUE(line.line().break_cable({1, 1}));
    live(milliseconds{400});
    EXPECT_EQ(presence(2), AxisPresence::kMissing);
    EXPECT_EQ(presence(3), AxisPresence::kMissing);
    EXPECT_EQ(line.state(2), AlState::kSafeOp) << "its watchdog";
    ASSERT_TRUE(line.line().break_cable({1, 1}, false));
    ASSERT_TRUE(
        live_until([&] { return presence(2) == AxisPresence::kPresent && presence(3) == AxisPresence::kPresent; },
                   std::chrono::seconds{8}));
    live(milliseconds{100});
    EXPECT_EQ(motion().failure().cause, MotionFailure::Cause::kNone);
    motion().request_stop();
    ASSERT_TRUE(operation->run_until(MotionPhase::kIdle, std::chrono::seconds{3}));
    ASSERT_EQ(sentence(operation->master().shut_down()), "");
  }
}

TEST_F(MissingAxis, OfTheWholeLineIsWaitedForUnderEitherPolicy) {
  start(LossPolicy::kContinue);
  for (std::size_t i = 0; i < kDrives; ++i) drives.line().set_power(i, false);
  operation->run(milliseconds{50});
  EXPECT_EQ(motion().phase(), MotionPhase::kWaiting);
  for (std::size_t i = 0; i < kDrives; ++i) drives.line().set_power(i, true);
  remember();
  const auto all_present = [&] {
    for (std::size_t i = 0; i < kDrives; ++i) {
      if (presence(i) != AxisPresence::kPresent) return false;
    }
    return true;
  };
  ASSERT_TRUE(live_until(all_present, std::chrono::seconds{10}));
  EXPECT_EQ(motion().phase(), MotionPhase::kFollowing);
}

TEST_F(MissingAxis, AFaultOfADriveStopsAllUnderEveryPolicy) {
  start(LossPolicy::kContinue);
  drives.drive(1).set_dc_link(false);
  operation->run(milliseconds{20});
  EXPECT_EQ(motion().failure().cause, MotionFailure::Cause::kAxisFault);
  EXPECT_EQ(motion().failure().axis, 1U);
}

TEST_F(MissingAxis, TheOthersComeToRestAndSwitchOffWithoutIt) {
  for (const auto policy : {LossPolicy::kHold, LossPolicy::kContinue}) {
    start(policy);
    drives.line().set_power(kLast, false);
    live(milliseconds{20});
    motion().request_stop();
    EXPECT_TRUE(operation->run_until(MotionPhase::kIdle, std::chrono::seconds{3}));
    EXPECT_EQ(motion().failure().cause, MotionFailure::Cause::kNone);
    drives.line().set_power(kLast, true);
    ASSERT_TRUE(live_until([&] { return supervisor->all_operational(); }, std::chrono::seconds{5}));
    ASSERT_EQ(sentence(operation->master().shut_down()), "");
  }
}

TEST_F(MissingAxis, AtTheStartIsLeftOutOrWaitedFor) {
  for (const auto policy : {LossPolicy::kHold, LossPolicy::kContinue}) {
    RunOptions options;
    options.on_loss = policy;
    options.repeat = true;
    operation = std::make_unique<LineOperation>(drives, options);
    ASSERT_EQ(sentence(operation->to_op()), "");
    supervisor = std::make_unique<LineSupervisor>(operation->master());
    drives.line().set_power(kLast, false);
    operation->run(milliseconds{20});
    remember();
    motion().request_start();
    live(std::chrono::seconds{3});
    EXPECT_EQ(motion().phase() == MotionPhase::kEnabling, policy == LossPolicy::kHold);
    drives.line().set_power(kLast, true);
    EXPECT_TRUE(live_until(
        [&] { return presence(kLast) == AxisPresence::kPresent && motion().phase() == MotionPhase::kFollowing; },
        std::chrono::seconds{8}));
    EXPECT_EQ(motion().failure().cause, MotionFailure::Cause::kNone);
    motion().request_stop();
    ASSERT_TRUE(operation->run_until(MotionPhase::kIdle, std::chrono::seconds{3}));
    ASSERT_EQ(sentence(operation->master().shut_down()), "");
  }
}

TEST_F(MissingAxis, OnARelativePathComesBackToThePlaceItHad) {
  start(LossPolicy::kContinue, true, true);
  drives.line().set_power(kLast, false);
  live(milliseconds{200});
  drives.line().set_power(kLast, true);
  ASSERT_TRUE(live_until([&] { return presence(kLast) == AxisPresence::kPresent; }, std::chrono::seconds{8}));
  live(milliseconds{100});
  // Drive n is at -0.25 n rad at power-on; the paths are alike except for their amplitudes.
  EXPECT_NEAR((position[kLast] + 0.75) * 4.0, position[0], 1e-4) << "but for the increment at which it stood";
  EXPECT_NEAR(drives.drive(kLast).position_rad(), position[kLast], 0.02);
}

TEST_F(MissingAxis, ThatJoinsLateBeginsARelativePathWhereItIs) {
  RunOptions options;
  options.on_loss = LossPolicy::kContinue;
  options.relative = true;
  options.repeat = true;
  options.amplitude_rad = 0.5;
  operation = std::make_unique<LineOperation>(drives, options);
  ASSERT_EQ(sentence(operation->to_op()), "");
  supervisor = std::make_unique<LineSupervisor>(operation->master());
  drives.line().set_power(kLast, false);
  operation->run(milliseconds{20});
  motion().request_start();
  ASSERT_TRUE(operation->run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
  remember();
  live(milliseconds{300});
  EXPECT_EQ(presence(kLast), AxisPresence::kMissing);
  drives.line().set_power(kLast, true);
  ASSERT_TRUE(live_until([&] { return presence(kLast) == AxisPresence::kPresent; }, std::chrono::seconds{8}));
  live(milliseconds{100});
  EXPECT_NEAR((position[kLast] + 0.75) * 4.0, position[0], 1e-4);
  EXPECT_NEAR(drives.drive(kLast).position_rad(), position[kLast], 0.02);
}

}  // namespace
}  // namespace driveline::bus_test
