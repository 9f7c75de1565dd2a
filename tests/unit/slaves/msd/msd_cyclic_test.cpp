// The cyclic modes: tracking, feed-forward, limits, changes of mode in motion.
#include <algorithm>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

struct Tracking {
  double peak_following_error = 0.0;  ///< increments, as the drive reports it
  double peak_torque_permille = 0.0;
};

/// Follows amplitude * (1 - cos wt) and reports the worst of the second half.
Tracking follow_sine(DriveRig& rig, double amplitude_rev, double frequency_hz, double cycle_s = 125e-6) {
  const double start = rig.position;
  const double w = 2.0 * std::numbers::pi * frequency_hz;
  Tracking result;
  const int count = static_cast<int>(2.0 / cycle_s);
  for (int i = 0; i < count; ++i) {
    const double t = i * cycle_s;
    rig.target_position =
        static_cast<std::int32_t>(std::lrint(start + amplitude_rev * 1048576.0 * (1.0 - std::cos(w * t))));
    rig.cycle();
    if (i < count / 2) continue;
    result.peak_following_error = std::max(result.peak_following_error, std::abs(double{0} + rig.following_error));
    result.peak_torque_permille = std::max(result.peak_torque_permille, std::abs(double{0} + rig.torque));
  }
  return result;
}

TEST(MsdCyclic, PositionModeTracksASine) {
  EnabledRig rig(8);
  const auto tracking = follow_sine(rig, 1.0, 2.0);
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
  EXPECT_LT(tracking.peak_following_error, 150.0);  // 0.05 degrees, at the reversals where the friction turns
  EXPECT_GT(tracking.peak_following_error, 0.0);
  // inertia * acceleration + friction: 3e-4 * 2 pi * (2 pi 2)^2 + 0.03 = 0.33 Nm of 2.4
  EXPECT_NEAR(tracking.peak_torque_permille, 137.0, 25.0);
}

/// The reports of the drive during a second of motion in this mode, with a bus cycle of 1 ms; with `sdos`, every
/// setpoint object that the mode does not use is written by SDO in the middle of each cycle.
std::vector<std::array<std::int64_t, 4>> run_with_sdos(std::int8_t mode, bool sdos) {
  constexpr std::int32_t kStepIncrements = 10'485;  // 10 rev/s
  EnabledRig rig(mode, 1000);
  std::vector<std::array<std::int64_t, 4>> seen;
  for (std::uint32_t i = 0; i < 1000; ++i) {
    rig.target_position += kStepIncrements;
    rig.target_velocity = 1000 * kStepIncrements;
    rig.target_torque = 100;
    rig.cycle(500us);
    if (sdos) {
      const std::uint32_t other = i * 1000;
      std::uint32_t abort = rig.write(0x60C1, 1, other, 4) | rig.write(0x60B1, 0, other, 4);
      if (mode != 8) abort |= rig.write(0x607A, 0, other, 4);
      if (mode != 9) abort |= rig.write(0x60FF, 0, other, 4);
      if (mode != 10) abort |= rig.write(0x6071, 0, i % 300, 2) | rig.write(0x60B2, 0, i % 300, 2);
      EXPECT_EQ(abort, 0U);
    }
    rig.pass(500us);
    seen.push_back({rig.status, rig.position, rig.velocity, rig.torque});
  }
  return seen;
}

TEST(MsdCyclic, SetpointsOfOtherModesBySdoDoNotDisturbTheAxis) {
  for (const auto mode : {std::int8_t{8}, std::int8_t{9}, std::int8_t{10}}) {
    const auto alone = run_with_sdos(mode, false);
    EXPECT_GT(std::abs(alone.back()[2]), 2'000'000) << "moves in mode " << int{mode};
    EXPECT_TRUE(alone.back()[0] & 0x8000) << "synchronised in mode " << int{mode};
    EXPECT_EQ(run_with_sdos(mode, true), alone) << "mode " << int{mode};
  }
}

TEST(MsdCyclic, SplinesTrackBetterThanLinearAtAMillisecond) {
  const auto error = [](std::uint32_t type) {
    DriveRig rig;
    EXPECT_EQ(rig.write(0x2172, 0, type, 1), 0U);
    rig.start(8, 1000);
    return follow_sine(rig, 0.5, 5.0, 1e-3).peak_following_error;  // 3100 rad/s2
  };
  const double linear = error(1);
  const double spline = error(3);
  const double approximation = error(4);
  EXPECT_LT(spline, 0.8 * linear);
  EXPECT_LT(approximation, 0.8 * linear);
  EXPECT_LT(linear, 2000.0);
}

/// Share of the rise from a setpoint to the next that the position demand (6062h) has made, every 125 us: linear
/// interpolation with setpoints that come every `period`, which 60C2h says.
std::vector<double> shares_of_the_rise(std::chrono::microseconds period) {
  DriveRig rig;
  EXPECT_EQ(rig.write(0x2172, 0, 1, 1), 0U);
  rig.operate(static_cast<unsigned>(period.count()));
  rig.enable(8);
  const std::int32_t start = rig.target_position;
  const auto setpoint_of = [&](int sample) { return start + 37 * sample * sample; };
  std::vector<double> shares;
  for (int sample = 1; sample <= 60; ++sample) {
    rig.target_position = setpoint_of(sample);
    for (auto passed = 125us; passed <= period; passed += 125us) {
      passed == 125us ? rig.cycle(125us) : rig.pass(125us);
      const auto demand = rig.drive.dictionary().get(kValue.position_demand);
      const double rise = setpoint_of(sample) - setpoint_of(sample - 1);
      if (sample == 60) shares.push_back((demand - setpoint_of(sample - 1)) / rise);
    }
  }
  return shares;
}

TEST(MsdCyclic, SetpointsAreInterpolatedOverTheTimeThatIsIn60C2) {
  for (const auto period : {250us, 1000us, 3000us}) {
    const auto shares = shares_of_the_rise(period);
    ASSERT_EQ(shares.size(), static_cast<std::size_t>(period / 125us));
    for (std::size_t i = 0; i < shares.size(); ++i) {
      // The demand is in whole increments, the rise has thousands.
      EXPECT_NEAR(shares[i], (static_cast<double>(i) + 1.0) / static_cast<double>(shares.size()), 1e-3)
          << period.count();
    }
  }
}

TEST(MsdCyclic, ConstantSpeedHasNoFollowingError) {
  for (const std::uint32_t type : {1U, 3U, 4U}) {
    DriveRig rig;
    ASSERT_EQ(rig.write(0x2172, 0, type, 1), 0U);
    rig.start(8);
    double target = rig.position;
    for (int i = 0; i < 8000; ++i) {  // up to ten revolutions per second in half a second
      target += std::min(i / 4000.0, 1.0) * 10.0 * 1048576.0 * 125e-6;
      rig.target_position = static_cast<std::int32_t>(std::lrint(target));
      rig.cycle();
    }
    EXPECT_NEAR(rig.following_error, 0, 30) << type;
  }
}

TEST(MsdCyclic, WithoutFeedForwardTheErrorIsSpeedOverGain) {
  OperatingRig rig;
  rig.set({real_value(0x2177, 0, 0.0F), real_value(0x2178, 0, 0.0F)});
  rig.enable(8);
  const auto tracking = follow_sine(rig, 0.1, 1.0);
  const double peak_speed = 0.1 * 1048576 * 2.0 * std::numbers::pi;
  EXPECT_NEAR(tracking.peak_following_error, peak_speed / 150.0, 0.05 * peak_speed / 150.0);
}

TEST(MsdCyclic, ExternalFeedForwardReplacesTheInternalOne) {
  OperatingRig rig;
  ASSERT_EQ(rig.write(0x217B, 1, 1, 2), 0U);
  rig.enable(8);
  // External source selected but nothing sent: the error is as without feed-forward.
  const double speed = 1048576.0;  // one revolution per second
  const double start = rig.position;
  const auto run = [&] {
    for (int i = 0; i < 4000; ++i) {
      rig.target_position = static_cast<std::int32_t>(std::lrint(rig.target_position + speed * 125e-6));
      rig.cycle();
    }
    return rig.following_error;
  };
  EXPECT_NEAR(run(), speed / 150.0, 0.05 * speed / 150.0);
  rig.velocity_offset = static_cast<std::int32_t>(speed);
  EXPECT_NEAR(run(), 0.0, 0.02 * speed / 150.0);
  EXPECT_GT(rig.position, start);
}

TEST(MsdCyclic, OffsetsWithoutSelectionDoNothing) {
  EnabledRig rig(9);
  rig.velocity_offset = 1'000'000;
  rig.torque_offset = 500;
  rig.cycles(800);
  EXPECT_NEAR(rig.velocity, 0, 2000);
  ASSERT_EQ(rig.write(0x217B, 1, 1, 2), 0U);
  rig.torque_offset = 0;
  rig.cycles(1600);
  EXPECT_NEAR(rig.velocity, 1'000'000, 3000);
}

TEST(MsdCyclic, VelocityModeReachesItsTarget) {
  EnabledRig rig(9);
  rig.turn(-20'000'000, 8);
  EXPECT_EQ(rig.status & 0x0400, 0) << "a new setpoint is not reached yet";
  rig.cycles(1600);
  EXPECT_NEAR(rig.velocity, -20'000'000, 3000);
  EXPECT_NEAR(rig.drive.velocity_rad_s() * kIncrementsPerRadian, -20e6, 3000);
  EXPECT_TRUE(rig.status & 0x0400);
  EXPECT_EQ(rig.status & 0x4000, 0) << "ROT_0";
  rig.turn(0, 1600);
  EXPECT_TRUE(rig.status & 0x4000);
}

TEST(MsdCyclic, TorqueModeAcceleratesByTorqueOverInertia) {
  EnabledRig rig(10);
  rig.target_torque = 100;  // 0.24 Nm
  rig.cycles(8);
  const double before = rig.drive.velocity_rad_s();
  rig.cycles(80);  // 10 ms
  EXPECT_NEAR(rig.drive.velocity_rad_s() - before, (0.24 - 0.03) / 3e-4 * 0.01, 0.1);
  EXPECT_EQ(rig.torque, 100);
  rig.torque_offset = -100;
  rig.cycles(20);
  EXPECT_EQ(rig.torque, 0) << "the torque offset adds up in torque mode";
}

TEST(MsdCyclic, TorqueModeDoesNotRunAway) {
  OperatingRig rig;
  ASSERT_EQ(rig.write(0x6080, 0, 3000, 4), 0U);
  rig.enable(10);
  rig.target_torque = 500;
  rig.cycles(8000);
  EXPECT_NEAR(rig.drive.velocity_rad_s(), 314.16, 5.0);
  EXPECT_TRUE(rig.status & 0x0800) << "internal limit";
}

TEST(MsdCyclic, MaxTorqueLimitsEveryMode) {
  OperatingRig rig;
  ASSERT_EQ(rig.write(0x6072, 0, 200, 2), 0U);
  rig.enable(9);
  rig.turn(50'000'000, 40);
  EXPECT_NEAR(rig.torque, 200, 1);
  EXPECT_TRUE(rig.status & 0x0800);
  rig.target_torque = 1000;
  rig.mode = 10;
  rig.cycles(40);
  EXPECT_NEAR(rig.torque, 200, 1);
}

TEST(MsdCyclic, MaxMotorSpeedLimitsTheVelocitySetpoint) {
  OperatingRig rig;
  ASSERT_EQ(rig.write(0x6080, 0, 600, 4), 0U);
  rig.enable(9);
  rig.turn(100'000'000, 1600);
  EXPECT_NEAR(rig.velocity, 10 * 1048576, 5000);
  EXPECT_TRUE(rig.status & 0x0800);
}

TEST(MsdCyclic, SoftwareLimitsCutThePositionSetpoint) {
  OperatingRig rig;
  rig.set({{0x607D, 1, static_cast<std::uint32_t>(-5000), 4}, {0x607D, 2, 5000, 4}});
  rig.enable(8);
  rig.target_position = 20'000;
  rig.cycles(1600);
  EXPECT_NEAR(rig.position, 5000, 60);
  EXPECT_TRUE(rig.status & 0x0800);
  rig.target_position = 1000;
  rig.cycles(1600);
  EXPECT_NEAR(rig.position, 1000, 60);
  EXPECT_EQ(rig.status & 0x0800, 0);
}

TEST(MsdCyclic, TargetReachedNeedsWindowAndTime) {
  OperatingRig rig;
  ASSERT_EQ(rig.write(0x6068, 0, 20, 2), 0U);
  rig.enable(8);
  rig.cycles(400);
  EXPECT_TRUE(rig.status & 0x0400);
  rig.target_position += 30'000;
  rig.cycle();
  EXPECT_EQ(rig.status & 0x0400, 0);
  int inside = 0;  // cycles within the window
  for (int i = 0; i < 8000 && (rig.status & 0x0400) == 0; ++i) {
    rig.cycle();
    inside = std::abs(rig.position - rig.target_position) <= 1000 ? inside + 1 : 0;
  }
  EXPECT_NEAR(inside * 0.125, 20.0, 0.5);
  EXPECT_NEAR(rig.position, rig.target_position, 1000);
}

TEST(MsdCyclic, PositionWrapsAt32Bits) {
  MsdParameters parameters;
  parameters.initial_position_rad = 2147483647.0 / kIncrementsPerRadian - 0.5;
  EnabledRig rig(parameters, 8);
  const auto before = rig.drive.position_rad();
  ASSERT_GT(rig.position, 2147000000);
  for (int i = 0; i < 2000; ++i) {
    rig.target_position = static_cast<std::int32_t>(static_cast<std::uint32_t>(rig.target_position) + 200U);
    rig.cycle();
  }
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
  EXPECT_LT(rig.position, -2147000000);
  EXPECT_NEAR((rig.drive.position_rad() - before) * kIncrementsPerRadian, 400'000.0, 1500.0);
}

TEST(MsdCyclic, ModesChangeInMotionWithoutAJump) {
  OperatingRig rig;
  rig.run_at(5'000'000);
  double last_speed = rig.drive.velocity_rad_s();
  double worst = 0.0;
  const auto observe = [&](int count, auto&& before_cycle) {
    for (int i = 0; i < count; ++i) {
      before_cycle();
      rig.cycle();
      worst = std::max(worst, std::abs(rig.drive.velocity_rad_s() - last_speed));
      last_speed = rig.drive.velocity_rad_s();
    }
  };
  // The master sends setpoints that continue from the present position, as these modes require.
  rig.mode = 8;
  double target = rig.position;
  observe(800, [&] {
    target += 5e6 * 125e-6;
    rig.target_position = static_cast<std::int32_t>(std::lrint(target));
  });
  EXPECT_EQ(rig.mode_display, 8);
  rig.mode = 10;
  rig.target_torque = rig.torque;
  observe(100, [] {});
  EXPECT_EQ(rig.mode_display, 10);
  rig.mode = 9;
  rig.target_velocity = rig.velocity;
  observe(800, [] {});
  EXPECT_EQ(rig.mode_display, 9);
  // 30 rad/s; the speed never changes by more than a good percent in a cycle
  EXPECT_LT(worst, 0.4);
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
}

TEST(MsdCyclic, UnsupportedModeInTheProcessDataIsIgnored) {
  EnabledRig rig(9);
  for (const std::int8_t mode : {std::int8_t{4}, std::int8_t{5}, std::int8_t{-1}, std::int8_t{11}}) {
    rig.mode = mode;
    rig.cycles(2);
    EXPECT_EQ(rig.mode_display, 9);
  }
}

TEST(MsdCyclic, NoModeHoldsTheAxis) {
  OperatingRig rig;
  rig.run_at(5'000'000);
  rig.mode = 0;
  rig.cycles(1600);
  EXPECT_NEAR(rig.velocity, 0, 2000);
  EXPECT_EQ(rig.status & 0x1000, 0);
}

TEST(MsdCyclic, MissingSetpointsStopThePositionDemand) {
  EnabledRig rig(8);
  for (int i = 0; i < 800; ++i) {
    rig.target_position += 200;
    rig.cycle();
  }
  const auto last = rig.target_position;
  rig.pass(50ms);
  const double speed = 200.0 / 125e-6;
  // eight periods further, then on the ramp of 6085h
  EXPECT_NEAR(rig.position, last + 8 * 200 + speed * speed / (2.0 * 419430400.0), 300);
}

TEST(MsdCyclic, RunsAreBitIdentical) {
  const auto run = [] {
    EnabledRig rig(8);
    follow_sine(rig, 0.3, 3.0);
    return rig.drive.position_rad();
  };
  EXPECT_EQ(run(), run());
}

TEST(MsdCyclic, StateDependsOnTimeNotOnHowOftenAdvanceIsCalled) {
  const auto run = [](std::chrono::nanoseconds call) {
    OperatingRig rig;
    rig.run_at(1'000'000);
    rig.command(0x02);
    for (std::chrono::nanoseconds t{0}; t < 20ms; t += call) rig.pass(call);
    return rig.drive.position_rad();
  };
  EXPECT_EQ(run(125us), run(20ms));
}

}  // namespace
}  // namespace driveline::slaves::msd
