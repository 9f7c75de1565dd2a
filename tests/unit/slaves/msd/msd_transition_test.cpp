// Motion of the shaft during transitions: every value of the option codes 605Ah-605Eh, every change of mode under load.
#include <algorithm>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr double kSlowDownRamp = 100.0 * kTurnRad;   ///< 6084h in this file, rad/s2
constexpr double kQuickStopRamp = 300.0 * kTurnRad;  ///< 6085h
constexpr double kFriction = 0.03 / 3.0e-4;          ///< deceleration while coasting, rad/s2; the viscous part is small
constexpr double kTorqueLimit = 7.2 / 3.0e-4;        ///< acceleration at the current limit, rad/s2

/// How the axis is stopped.
enum class Stop : std::uint8_t { kCoasts, kSlowDown, kQuickStop, kCurrentLimit };

/// Runs at 10 rev/s in mode 3, with the two ramps far apart.
void run_fast(DriveRig& rig) {
  rig.operate();
  ASSERT_EQ(rig.write(0x6084, 0, 100 * kRevolution, 4), 0U);
  ASSERT_EQ(rig.write(0x6085, 0, 300 * kRevolution, 4), 0U);
  rig.enable(3);
  rig.turn(10 * kRevolution, 4000);
  ASSERT_NEAR(rig.velocity, 10 * kRevolution, 20'000);
}

/// Deceleration over the middle half of the stop, in rad/s2; 0 if it takes longer than half a second.
double deceleration(DriveRig& rig) {
  const double speed = rig.drive.velocity_rad_s();
  int begin = -1;
  for (int i = 0; i < 4000; ++i) {
    const double now = rig.drive.velocity_rad_s();
    if (begin < 0 && now <= 0.75 * speed) begin = i;
    if (now <= 0.25 * speed) return 0.5 * speed / ((i - begin) * kCycleS);
    rig.cycle();
  }
  return 0.0;
}

void expect_stop(DriveRig& rig, Stop stop) {
  // Ramps as exactly as the samples allow; the controller is at its limit for part of a stop on the current limit.
  switch (stop) {
    case Stop::kSlowDown:
      EXPECT_NEAR(deceleration(rig), kSlowDownRamp, 0.06 * kSlowDownRamp);
      break;
    case Stop::kQuickStop:
      EXPECT_NEAR(deceleration(rig), kQuickStopRamp, 0.06 * kQuickStopRamp);
      break;
    case Stop::kCurrentLimit:
      EXPECT_GT(deceleration(rig), 0.3 * kTorqueLimit);
      break;
    case Stop::kCoasts:
      EXPECT_LT(deceleration(rig), 2.0 * kFriction);
      EXPECT_EQ(rig.torque, 0);
      break;
  }
}

struct QuickStopCode {
  int value;
  Stop stop;
  PowerState end;
};

TEST(MsdOptionCode, QuickStopEveryValue605A) {
  constexpr auto kOff = PowerState::kSwitchOnDisabled;
  constexpr auto kStays = PowerState::kQuickStopActive;
  for (const auto& code : {QuickStopCode{0, Stop::kCoasts, kOff}, QuickStopCode{1, Stop::kSlowDown, kOff},
                           QuickStopCode{2, Stop::kQuickStop, kOff}, QuickStopCode{3, Stop::kCurrentLimit, kOff},
                           QuickStopCode{4, Stop::kCurrentLimit, kOff}, QuickStopCode{5, Stop::kSlowDown, kStays},
                           QuickStopCode{6, Stop::kQuickStop, kStays}, QuickStopCode{7, Stop::kCurrentLimit, kStays},
                           QuickStopCode{8, Stop::kCurrentLimit, kStays}}) {
    SCOPED_TRACE(code.value);
    DriveRig rig;
    run_fast(rig);
    ASSERT_EQ(rig.write(0x605A, 0, static_cast<std::uint32_t>(code.value), 2), 0U);
    rig.control = 0x02;
    expect_stop(rig, code.stop);
    rig.cycles(16'000);
    EXPECT_EQ(rig.drive.state(), code.end);
    if (code.end != kStays) continue;
    EXPECT_TRUE(rig.status & 0x0400) << "the quick stop is over";
    rig.command(0x0F, 4);
    EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled) << "transition 16";
  }
}

/// A stop on the current limit from here on: how far the axis turns back, and its speed at the end.
struct LimitStop {
  double backwards_rad_s = 0.0;
  double at_end_rad_s = 1e9;
  double time_s = 0.0;
};
template <typename Over>
LimitStop stop_on_the_limit(DriveRig& rig, Over over) {
  LimitStop stop;
  const double sign = rig.drive.velocity_rad_s() > 0.0 ? 1.0 : -1.0;
  for (int i = 0; i < 4000; ++i) {
    rig.cycle();
    if (over()) {
      stop.at_end_rad_s = std::abs(rig.drive.velocity_rad_s());
      stop.time_s = i * kCycleS;
      return stop;
    }
    stop.backwards_rad_s = std::max(stop.backwards_rad_s, -sign * rig.drive.velocity_rad_s());
  }
  return stop;
}

TEST(MsdOptionCode, StopOnTheCurrentLimitEndsAtZeroWithoutTurningRound) {
  for (const std::uint32_t code : {3U, 4U, 7U, 8U}) {
    for (const int turns : {2, 10, 40, -40, 80}) {
      for (const bool winding : {false, true}) {
        SCOPED_TRACE(testing::Message() << "605Ah = " << code << ", " << turns << " rev/s" << (winding ? ", dq" : ""));
        MsdParameters parameters;
        parameters.motor.winding.simulated = winding;
        OperatingRig rig(parameters);
        ASSERT_EQ(rig.write(0x605A, 0, code, 2), 0U);
        rig.run_at(turns * kRevolution);
        rig.control = 0x02;
        const auto stop =
            stop_on_the_limit(rig, [&] { return (rig.status & 0x0400) != 0 || (rig.status & 0x6F) == 0x40; });
        EXPECT_LT(stop.backwards_rad_s, 0.2);
        EXPECT_LT(stop.at_end_rad_s, 0.5);
        EXPECT_LT(stop.time_s, std::abs(turns) * kTurnRad / kTorqueLimit + 0.02)
            << "not much longer than the limit takes";
      }
    }
  }
}

TEST(MsdOptionCode, StopOnTheCurrentLimitOfAVerticalAxisEndsAtZero) {
  for (const int turns : {10, -10, 40}) {
    SCOPED_TRACE(turns);
    MsdParameters parameters;
    parameters.motor.load.gravity_nm = 1.0;
    parameters.motor.brake_torque_nm = 5.0;
    OperatingRig rig(parameters);
    ASSERT_EQ(rig.write(0x605A, 0, 3, 2), 0U);
    rig.run_at(turns * kRevolution);
    rig.control = 0x02;
    const auto stop = stop_on_the_limit(rig, [&] { return !rig.drive.output(Output::kBrake); });
    EXPECT_LT(stop.backwards_rad_s, 0.5);
    EXPECT_LT(stop.at_end_rad_s, 0.5) << "the brake closes at rest";
  }
}

/// From torque control and from an acceleration, where the present torque pushes on.
TEST(MsdOptionCode, StopOnTheCurrentLimitTakesOverAnyTorque) {
  for (const std::int8_t mode : {std::int8_t{9}, std::int8_t{10}}) {
    SCOPED_TRACE(int{mode});
    OperatingRig rig;
    ASSERT_EQ(rig.write(0x605A, 0, 7, 2), 0U);
    rig.enable(mode);
    rig.target_velocity = 80 * kRevolution;
    rig.target_torque = 2000;
    rig.cycles(80);
    ASSERT_GT(rig.drive.velocity_rad_s(), 100.0);
    rig.command(0x02, 8);
    const auto stop = stop_on_the_limit(rig, [&] { return (rig.status & 0x0400) != 0; });
    EXPECT_LT(stop.backwards_rad_s, 1.0);
    EXPECT_LT(stop.at_end_rad_s, 0.5);
  }
}

TEST(MsdOptionCode, ShutdownEveryValue605B) {
  struct Code {
    std::uint32_t value;
    Stop stop;
  };
  for (const auto& code : {Code{0xFFFF, Stop::kQuickStop}, Code{0, Stop::kCoasts}, Code{1, Stop::kSlowDown}}) {
    SCOPED_TRACE(code.value);
    DriveRig rig;
    run_fast(rig);
    ASSERT_EQ(rig.write(0x605B, 0, code.value, 2), 0U);  // -1: as 605Ah, whose default is the quick stop ramp
    rig.control = 0x06;
    expect_stop(rig, code.stop);
    rig.cycles(4000);
    EXPECT_FALSE(rig.drive.state() == PowerState::kOperationEnabled);
    EXPECT_EQ(rig.torque, 0);
  }
}

TEST(MsdOptionCode, DisableOperationEveryValue605C) {
  for (const std::uint32_t value : {0U, 1U}) {
    SCOPED_TRACE(value);
    DriveRig rig;
    run_fast(rig);
    ASSERT_EQ(rig.write(0x605C, 0, value, 2), 0U);
    rig.control = 0x07;
    expect_stop(rig, value == 0 ? Stop::kCoasts : Stop::kSlowDown);
    rig.cycles(4000);
    EXPECT_EQ(rig.drive.state(), PowerState::kSwitchedOn);
  }
}

TEST(MsdOptionCode, HaltEveryValue605D) {
  constexpr std::array kStops = {Stop::kCoasts, Stop::kSlowDown, Stop::kQuickStop, Stop::kCurrentLimit,
                                 Stop::kCurrentLimit};
  for (std::uint32_t value = 0; value < kStops.size(); ++value) {
    SCOPED_TRACE(value);
    DriveRig rig;
    run_fast(rig);
    ASSERT_EQ(rig.write(0x605D, 0, value, 2), 0U);
    rig.control = 0x10F;
    expect_stop(rig, kStops[value]);
    rig.cycles(4000);
    EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled) << "halt leaves the drive enabled";
    rig.command(0x0F, 4000);
    EXPECT_NEAR(rig.velocity, 10 * kRevolution, 20'000) << "and goes on afterwards";
  }
}

TEST(MsdOptionCode, FaultReactionEveryValue605E) {
  struct Code {
    std::int16_t value;
    Stop stop;
  };
  for (const auto& code : {Code{0, Stop::kCoasts}, Code{1, Stop::kSlowDown}, Code{2, Stop::kQuickStop},
                           Code{3, Stop::kCurrentLimit}, Code{4, Stop::kCurrentLimit}}) {
    SCOPED_TRACE(code.value);
    DriveRig rig;
    run_fast(rig);
    ASSERT_EQ(rig.write(0x605E, 0, static_cast<std::uint16_t>(code.value), 2), 0U);
    ASSERT_EQ(rig.write(0x6098, 0, 0, 1), 0U);
    rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
    expect_stop(rig, code.stop);
    rig.pass(2s);
    EXPECT_EQ(rig.drive.state(), PowerState::kFault);
  }
}

/// A correct master: its setpoints continue from the position and speed of the shaft. Modes with a profile of their own
/// stop or accelerate it on their ramps.
class ModeMaster {
 public:
  ModeMaster(DriveRig& rig, std::int32_t speed, std::int16_t torque) : rig_(rig), fast_(speed), torque_(torque) {}
  void enter(std::int8_t mode) {
    rig_.mode = mode;
    target_ = rig_.position;
    speed_ = rig_.velocity;
    rig_.target_velocity = mode == 3 ? fast_ : speed_;
    rig_.target_torque = torque_;
    rig_.control = 0x0F;
    if (mode == 1) rig_.target_position = rig_.position + 100 * kRevolution;
    if (mode == 7) write_record(rig_.position);
    if (mode == 8) rig_.target_position = rig_.position;
    if (mode == 7 || mode == 2) rig_.control = mode == 7 ? 0x1F : 0x7F;
  }
  void cycle() {
    target_ += speed_ * kCycleS;
    const auto target = static_cast<std::int32_t>(std::lrint(target_));
    if (rig_.mode == 8) rig_.target_position = target;
    if (rig_.mode == 7) write_record(target);
    rig_.cycle();
    if (rig_.mode == 1 || rig_.mode == 6) rig_.control = 0x1F;  // the edge that starts it
  }

 private:
  void write_record(std::int32_t position) {
    ASSERT_EQ(rig_.write(0x60C1, 1, static_cast<std::uint32_t>(position), 4), 0U);
  }
  DriveRig& rig_;
  std::int32_t fast_;
  std::int16_t torque_;
  std::int32_t speed_ = 0;
  double target_ = 0.0;
};

struct ModeChange {
  std::int8_t from;
  std::int8_t to;
  int dwell;  ///< bus cycles in either mode
};

std::vector<ModeChange> changes_of_mode() {
  constexpr std::array<std::int8_t, 8> kModes = {1, 2, 3, 6, 7, 8, 9, 10};
  std::vector<ModeChange> changes;
  for (const int dwell : {100, 1600}) {
    for (const std::int8_t from : kModes) {
      for (const std::int8_t to : kModes) {
        if (from != to) changes.push_back({from, to, dwell});
      }
    }
  }
  return changes;
}

TEST(MsdModes, EveryChangeOfModeUnderLoadStaysWithinTheJerkLimitedRamps) {
  constexpr std::int32_t kSpeed = 3 * kRevolution;
  constexpr double kWeightNm = 0.8;
  MsdParameters parameters;
  parameters.motor.load.gravity_nm = kWeightNm;
  constexpr auto kCarries = static_cast<std::int16_t>((kWeightNm + 0.03) / 2.4 * 1000.0);  // and the friction
  // After 100 cycles the profile modes are on their ramps, after 1600 they run.
  for (const auto& [from, to, dwell] : changes_of_mode()) {
    SCOPED_TRACE(testing::Message() << int{from} << " to " << int{to} << " after " << dwell);
    OperatingRig rig(parameters);
    // Every mode moves: positioning and homing over a long distance, the velocity mode as fast as its setpoint can
    // express.
    rig.set({{0x6081, 0, kSpeed, 4},
             {0x6098, 0, 18, 1},
             {0x6099, 1, kSpeed, 4},
             {0x6042, 0, 30'000, 2},
             {0x6086, 0, 3, 2},               // jerk limited,
             real_value(0x20A6, 0, 20.0F)});  // within 20 ms
    rig.run_at(kSpeed);
    // The slowest way to run: the velocity mode's setpoint has 16 bits.
    const double least = from == 2 && dwell > 400 ? 0.1 : 3.0;
    ModeMaster master(rig, kSpeed, kCarries);
    double last = rig.drive.velocity_rad_s();
    double largest = 0.0;
    for (const std::int8_t mode : {from, to}) {
      master.enter(mode);
      for (int i = 0; i < dwell; ++i) {
        master.cycle();
        largest = std::max(largest, std::abs(rig.drive.velocity_rad_s() - last));
        last = rig.drive.velocity_rad_s();
      }
      EXPECT_EQ(rig.mode_display, mode);
      EXPECT_TRUE(mode != from || std::abs(rig.drive.velocity_rad_s()) > least) << "moves in mode " << int{mode};
      EXPECT_TRUE(mode != 7 || (rig.status & 0x1000) != 0) << "IP active";
      EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
    }
    // The steepest ramp there is, 6084h, in one cycle, and as much again for controller and encoder.
    constexpr double kRamp = 600.0 * kCycleS;
    EXPECT_LT(largest, 2.0 * kRamp);
  }
}

}  // namespace
}  // namespace driveline::slaves::msd
