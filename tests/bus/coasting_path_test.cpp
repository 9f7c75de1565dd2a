// Axes of a path that coast when they are switched on, judged by the demands of their drives.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "demand_watch.hpp"
#include "late_line.hpp"

namespace driveline::bus_test {
namespace {

using motion::MotionPhase;
using slaves::msd::Fault;

/// A path that is ended by a fault of the first axis, which then coasts, and is restarted at once.
class CoastingLine : public LateLine {
 public:
  explicit CoastingLine(const RunOptions& options = fast_path()) : LateLine(options, 2) {
    for (std::size_t i = 0; i < 2; ++i) watches_.emplace_back(drives.drive(i), LineOperation::axis(i, options).limits);
  }

  [[nodiscard]] MotionPhase phase() { return operation.motion().phase(); }
  [[nodiscard]] double velocity() { return drives.drive(0).velocity_rad_s(); }
  /// Distance of the target (607Ah) of the first drive from its actual position, in rad.
  [[nodiscard]] double told_beside() {
    const auto& values = drives.drive(0).dictionary();
    const auto target = values.get(slaves::msd::kValue.target_position);
    return static_cast<double>(target - values.get(slaves::msd::kValue.position_actual)) / kDemandIncrements;
  }
  void watched_cycle() {
    cycle();
    watch();
  }
  void miss(int periods) {
    for (int i = 0; i < periods; ++i) {
      drives.leave_alone(kLatePeriod);
      watch();
    }
    drives.leave_alone(microseconds{15});
    watched_cycle();
  }
  void fail() {
    drives.drive(0).raise(Fault::kOvercurrent);
    for (int i = 0; i < 4000 && phase() != MotionPhase::kIdle; ++i) watched_cycle();
    ASSERT_EQ(phase(), MotionPhase::kIdle);
  }
  void fail_and_start() {
    fail();
    operation.motion().request_start();
  }
  /// Fails and restarts at more than half of the highest velocity.
  CoastingLine& started_fast() {
    cycles(400);
    for (int i = 0; i < 3000 && std::abs(velocity()) < 30.0; ++i) watched_cycle();
    fail_and_start();
    return *this;
  }
  /// Number of cycles until the first drive has power.
  [[nodiscard]] int cycles_until_on() {
    int passed = 0;
    for (; passed < 100 && !drives.drive(0).power_on(); ++passed) watched_cycle();
    return passed;
  }
  /// Findings of both axes; empty: none.
  [[nodiscard]] std::string finding() const { return watches_[0].finding() + watches_[1].finding(); }

 private:
  void watch() {
    for (auto& watch : watches_) watch.look(drives.clock.now());
  }
  std::vector<DemandWatch> watches_;
};

/// Frames are lost and periods missed from before the axis is switched on until it is at standstill.
TEST(CoastingPath, IsBrakedWithinItsLimitsBeforeThePathBegins) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    CoastingLine line;
    line.cycles(400 + static_cast<int>(random() % 3000));
    for (int i = 0; i < 3000 && std::abs(line.velocity()) < 20.0; ++i) line.watched_cycle();
    line.fail_and_start();
    const double before = line.velocity();
    bool seen = false;
    double caught = 0.0;
    int lost = 0;
    for (int i = 0; i < 8000 && line.phase() != MotionPhase::kFollowing; ++i) {
      if (!seen && line.drives.drive(0).power_on()) {
        seen = true;
        caught = line.velocity();
      }
      if (seed > 10 && random() % 40 == 0) {
        line.miss(1 + static_cast<int>(random() % 5));
        continue;
      }
      lost = seed > 10 && lost == 0 && random() % 15 == 0 ? 1 + static_cast<int>(random() % 4) : std::max(lost - 1, 0);
      line.lose_out = lost > 0 && random() % 2 == 0;
      line.lose_back = lost > 0;
      line.watched_cycle();
    }
    EXPECT_EQ(line.phase(), MotionPhase::kFollowing)
        << "failed by " << static_cast<int>(line.operation.motion().failure().cause);
    EXPECT_GT(std::abs(before), 8.0) << "it does not coast";
    EXPECT_GT(std::abs(caught), 4.0) << "it does not coast any more when it is switched on";
    EXPECT_EQ(line.finding(), "");
  }
}

/// An axis that is faster than its limit is not switched on before it is slower.
TEST(CoastingPath, FasterThanItsLimitIsSwitchedOnWhenItIsSlower) {
  CoastingLine line;
  line.cycles(400);
  for (int i = 0; i < 3000 && std::abs(line.velocity()) < 20.0; ++i) line.watched_cycle();
  line.fail();
  const double most = LineOperation::axis(0, CoastingLine::fast_path()).limits.max_velocity;
  line.drives.drive(0).set_machine_input(slaves::msd::MachineInput::kLoad, line.velocity() > 0.0 ? -0.6 : 0.6);
  for (int i = 0; i < 8000 && std::abs(line.velocity()) < 1.2 * most; ++i) line.watched_cycle();
  ASSERT_GE(std::abs(line.velocity()), 1.2 * most);
  line.drives.drive(0).set_machine_input(slaves::msd::MachineInput::kLoad, 0.0);
  line.operation.motion().request_start();
  for (int i = 0; i < 400; ++i) {
    line.watched_cycle();
    ASSERT_FALSE(line.drives.drive(0).power_on() && std::abs(line.velocity()) > most);
  }
  ASSERT_GT(std::abs(line.velocity()), most);
  line.drives.drive(0).set_machine_input(slaves::msd::MachineInput::kLoad, line.velocity() > 0.0 ? 0.6 : -0.6);
  bool on = false;
  for (int i = 0; i < 8000 && !on; ++i) {
    line.watched_cycle();
    on = line.drives.drive(0).power_on();
  }
  EXPECT_TRUE(on);
  EXPECT_LE(std::abs(line.velocity()), most);
}

/// The outputs that switch the axis on may have been computed before the master was away, for the position at that
/// time. Judged by the target sent to the drive, because a simulated drive tolerates a stale one.
TEST(CoastingPath, IsToldWhereItIsThoughTheMasterWasAway) {
  constexpr double kStale = 4.0;  // periods of motion; the master was away for seven
  for (int moment = 0; moment < 60; ++moment) {
    SCOPED_TRACE(moment);
    CoastingLine line;
    line.cycles(400);
    for (int i = 0; i < 3000 && std::abs(line.velocity()) < 20.0; ++i) line.watched_cycle();
    line.fail_and_start();
    for (int i = 0; i < moment; ++i) line.watched_cycle();
    const bool before = !line.drives.drive(0).power_on();
    line.miss(7);
    for (int i = 0; i < 2000 && !line.drives.drive(0).power_on(); ++i) line.watched_cycle();
    ASSERT_TRUE(line.drives.drive(0).power_on());
    if (before) {
      const double way = std::abs(line.velocity()) * kStale * 125e-6;
      EXPECT_LE(std::abs(line.told_beside()), way);
    }
    for (int i = 0; i < 8000 && line.phase() != MotionPhase::kFollowing; ++i) line.watched_cycle();
    EXPECT_EQ(line.finding(), "");
  }
}

/// The drive is on but its answer is lost, or the command is lost and the master does not know.
TEST(CoastingPath, IsCaughtThoughFramesAreLostWhenItIsSwitchedOn) {
  const int on = CoastingLine().started_fast().cycles_until_on();
  ASSERT_LT(on, 100);
  for (const int frames : {1, 2, 4, 7}) {
    for (const unsigned outwards : {0U, 0xFFU, 0xAAU, 0x55U, 0x0EU}) {
      for (int moment = on - 5; moment < on + 3; ++moment) {
        SCOPED_TRACE(testing::Message() << frames << " frames, outwards " << outwards << ", moment " << moment - on);
        CoastingLine line;
        line.started_fast();
        for (int i = 0; i < moment; ++i) line.watched_cycle();
        line.lose_back = true;
        for (int i = 0; i < frames; ++i) {
          line.lose_out = (outwards >> i & 1U) != 0;
          line.watched_cycle();
        }
        line.lose_out = line.lose_back = false;
        for (int i = 0; i < 800 && line.phase() == MotionPhase::kEnabling; ++i) line.watched_cycle();
        ASSERT_EQ(line.finding(), "");
      }
    }
  }
}

/// Following errors are also detected before the path has begun.
TEST(CoastingPath, ThatDoesNotFollowWhileItIsBrakedIsAFollowingError) {
  auto options = CoastingLine::fast_path();
  options.following_error_window = 0.05;
  CoastingLine line(options);
  line.cycles(400);
  for (int i = 0; i < 3000 && std::abs(line.velocity()) < 25.0; ++i) line.watched_cycle();
  line.fail_and_start();
  for (int i = 0; i < 3000 && !line.drives.drive(0).power_on(); ++i) line.watched_cycle();
  ASSERT_GT(std::abs(line.velocity()), 15.0);
  line.drives.drive(0).set_machine_input(slaves::msd::MachineInput::kAxisBlocked, 1.0);
  for (int i = 0; i < 400 && line.phase() == MotionPhase::kEnabling; ++i) line.watched_cycle();
  EXPECT_EQ(line.phase(), MotionPhase::kQuickStop);
  EXPECT_EQ(line.operation.motion().failure().cause, motion::MotionFailure::Cause::kFollowingError);
  EXPECT_EQ(line.operation.motion().failure().axis, 0);
}

TEST(CoastingPath, IsNotSwitchedOffByAStopWhileItIsBraked) {
  CoastingLine line;
  line.cycles(400);
  for (int i = 0; i < 3000 && std::abs(line.velocity()) < 20.0; ++i) line.watched_cycle();
  line.fail_and_start();
  for (int i = 0; i < 3000 && !line.drives.drive(0).power_on(); ++i) line.watched_cycle();
  for (int i = 0; i < 10; ++i) line.watched_cycle();
  ASSERT_GT(std::abs(line.velocity()), 8.0);
  line.operation.motion().request_stop();
  line.watched_cycle();
  EXPECT_EQ(line.phase(), MotionPhase::kQuickStop);
  for (int i = 0; i < 8000 && line.phase() != MotionPhase::kIdle; ++i) {
    line.watched_cycle();
    ASSERT_TRUE(line.drives.drive(0).power_on() || std::abs(line.velocity()) < 1.0) << "it coasts again";
  }
  EXPECT_EQ(line.phase(), MotionPhase::kIdle);
  EXPECT_EQ(line.finding(), "");
}

/// The position of the other axis, which stands, leaps meanwhile.
TEST(CoastingPath, IsNotSwitchedOffByALeapWhileItIsBraked) {
  CoastingLine line;
  line.cycles(400);
  for (int i = 0; i < 3000 && std::abs(line.velocity()) < 20.0; ++i) line.watched_cycle();
  line.fail_and_start();
  auto& other = line.drives.drive(1);
  for (int i = 0; i < 3000 && !(line.drives.drive(0).power_on() && other.power_on()); ++i) line.watched_cycle();
  for (int i = 0; i < 10; ++i) line.watched_cycle();
  ASSERT_EQ(line.phase(), MotionPhase::kEnabling);
  ASSERT_GT(std::abs(line.velocity()), 8.0);
  const auto leap = other.signals().find_signal(slaves::SignalId::Direction::kInput, "POSITION_ERROR");
  ASSERT_TRUE(leap);
  other.signals().set_signal(leap->number, 2e6);
  for (int i = 0; i < 4; ++i) line.watched_cycle();
  EXPECT_EQ(line.phase(), MotionPhase::kQuickStop);
  EXPECT_EQ(line.operation.motion().failure().cause, motion::MotionFailure::Cause::kPositionLeap);
  EXPECT_EQ(line.operation.motion().failure().axis, 1);
  for (int i = 0; i < 8000 && line.phase() != MotionPhase::kIdle; ++i) {
    line.watched_cycle();
    ASSERT_TRUE(line.drives.drive(0).power_on() || std::abs(line.velocity()) < 1.0) << "it coasts again";
  }
  EXPECT_EQ(line.phase(), MotionPhase::kIdle);
}

}  // namespace
}  // namespace driveline::bus_test
