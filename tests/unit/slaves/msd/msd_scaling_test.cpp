// Factor group: user units, polarity, calculated factors.
#include "driveline/slaves/msd/core/scaling.hpp"

#include <limits>

#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

TEST(MsdScaling, PositionsInMillidegreesOfALoadBehindAGear) {
  DriveRig rig;
  rig.set({{0x6091, 1, 5, 4},        // 5 motor revolutions
           {0x6091, 2, 2, 4},        // for 2 of the shaft
           {0x6092, 1, 360'000, 4},  // units
           {0x6092, 2, 7, 4}});      // per 7 shaft revolutions
  rig.start(9);
  EXPECT_EQ(rig.read(0x6093, 1), 1048576U * 35U / 640U);  // 2^20 * 5 * 7 / (2 * 360000), reduced
  EXPECT_EQ(rig.read(0x6093, 2), 1125U);
  EXPECT_EQ(rig.read(0x6094, 1) * std::uint64_t{rig.read(0x6093, 2)},
            rig.read(0x6093, 1) * std::uint64_t{rig.read(0x6094, 2)});
  rig.target_velocity = 72'000;  // 1.4 shaft revolutions per second: 3.5 of the motor
  rig.cycles(4000);
  EXPECT_NEAR(rig.drive.velocity_rad_s(), 3.5 * 2.0 * std::numbers::pi, 0.05);
  EXPECT_NEAR(rig.velocity, 72'000, 170);
  EXPECT_NEAR(rig.position, rig.drive.position_rad() / (2.0 * std::numbers::pi) / 2.5 / 7.0 * 360'000, 2.0);
}

TEST(MsdScaling, PolarityTurnsSetpointsAndActualValues) {
  DriveRig rig;
  ASSERT_EQ(rig.write(0x607E, 0, 0xC0, 1), 0U);
  rig.start(9);
  rig.turn(2'000'000, 1600);
  EXPECT_LT(rig.drive.velocity_rad_s(), -11.0);
  EXPECT_NEAR(rig.velocity, 2'000'000, 4000);
  EXPECT_GT(rig.position, 0);
  rig.mode = 8;
  rig.target_position = rig.position;
  rig.cycles(4000);
  EXPECT_NEAR(rig.position, rig.target_position, 100);
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
}

/// The other bits of 607Eh are reserved (MSD manual, object 607Eh) and turn nothing.
TEST(MsdScaling, PolarityBitsAreOneForPositionsAndOneForSpeeds) {
  constexpr std::int32_t kWay = 400'000;
  for (const unsigned polarity : {0x00U, 0x3FU, 0x40U, 0x95U, 0xC0U, 0xEAU}) {
    const int speeds = (polarity & 0x40U) != 0 ? -1 : 1;
    const int positions = (polarity & 0x80U) != 0 ? -1 : 1;
    SCOPED_TRACE(polarity);
    DriveRig rig;
    ASSERT_EQ(rig.write(0x607E, 0, polarity, 1), 0U);
    ASSERT_EQ(rig.write(0x6065, 0, 0xFFFFFFFF, 4), 0U);
    rig.start(9);
    rig.turn(2'000'000, 1600);
    EXPECT_NEAR(rig.drive.velocity_rad_s() * speeds, 2'000'000 / kIncrementsPerRadian, 0.1);
    EXPECT_NEAR(rig.velocity, 2'000'000, 4000);
    EXPECT_GT(rig.position * speeds * positions, 100'000);
    EXPECT_EQ(rig.read(0x606B), 2'000'000U);
    rig.turn(0, 1600);
    const double before = rig.drive.position_rad();
    rig.enable(8);
    const std::int32_t begin = rig.target_position;
    for (int i = 0; i < 1600; ++i) {
      rig.target_position = begin + kWay / 1600 * (i + 1);
      rig.cycle();
    }
    rig.cycles(800);
    EXPECT_NEAR(rig.position, begin + kWay, 100);
    EXPECT_NEAR((rig.drive.position_rad() - before) * positions, kWay / kIncrementsPerRadian, 1e-3);
  }
}

TEST(MsdScaling, ChangesOnlyWithThePowerStageOff) {
  EnabledRig rig(9);
  EXPECT_EQ(rig.write(0x6091, 1, 5, 4), 0x08000022U);
  EXPECT_EQ(rig.write(0x607E, 0, 0x80, 1), 0x08000022U);
  rig.command(0x06, 2);
  EXPECT_EQ(rig.write(0x6091, 1, 5, 4), 0U);
}

TEST(MsdScaling, NoDivisorCanBeZero) {
  DriveRig rig;
  for (const std::uint16_t index :
       {std::uint16_t{0x608F}, std::uint16_t{0x6090}, std::uint16_t{0x6091}, std::uint16_t{0x6092}}) {
    for (const unsigned sub : {1U, 2U}) EXPECT_EQ(rig.write(index, sub, 0, 4), 0x06090032U);
  }
}

TEST(MsdScaling, ExtremeFactorsStayFinite) {
  DriveRig rig;
  for (const std::uint16_t index : {std::uint16_t{0x608F}, std::uint16_t{0x6091}, std::uint16_t{0x6092}}) {
    ASSERT_EQ(rig.write(index, 1, index == 0x6092 ? 1 : 0xFFFFFFFF, 4), 0U);
    ASSERT_EQ(rig.write(index, 2, index == 0x6092 ? 0xFFFFFFFF : 1, 4), 0U);
  }
  rig.start(8);
  rig.cycles(100);
  EXPECT_TRUE(std::isfinite(rig.drive.position_rad()));
  EXPECT_GE(rig.read(0x6093, 2), 1U);
}

TEST(MsdScaling, FactorsFollowTheFormulasOfTheManual) {
  DriveRig rig;
  rig.set({{0x608F, 1, 4096, 4},  // increments per
           {0x608F, 2, 3, 4},     // revolutions
           {0x6090, 1, 8191, 4},
           {0x6090, 2, 7, 4},
           {0x6091, 1, 7, 4},
           {0x6091, 2, 2, 4},
           {0x6092, 1, 1000, 4},
           {0x6092, 2, 9, 4},
           {0x608B, 0, 2, 1},
           {0x6089, 0, 0xFF, 1},  // 10^-1
           {0x608D, 0, 1, 1}});
  rig.start(9);  // the control starts
  const auto fraction = [&](std::uint16_t index) {
    return static_cast<double>(rig.read(index, 1)) / static_cast<double>(rig.read(index, 2));
  };
  // 6093h = 608Fh * 6091h / 6092h; 6094h with 10^(2 - -1); 6097h with 10^(1 - 2) on top
  constexpr double kFeed = 1000.0 / 9.0;
  EXPECT_NEAR(fraction(0x6093), 4096.0 / 3.0 * 3.5 / kFeed, 1e-9);
  EXPECT_NEAR(fraction(0x6094), 8191.0 / 7.0 * 3.5 / kFeed * 1000.0, 1e-6);
  EXPECT_NEAR(fraction(0x6097), 8191.0 / 7.0 * 3.5 / kFeed * 100.0, 1e-6);
}

TEST(MsdScaling, DimensionIndicesOnlySayWhatTheUnitsAreCalled) {
  const auto run = [](std::uint32_t dimension) {
    DriveRig rig;
    for (const std::uint16_t index : {std::uint16_t{0x608A}, std::uint16_t{0x608C}, std::uint16_t{0x608E}}) {
      EXPECT_EQ(rig.write(index, 0, dimension, 1), 0U);
    }
    rig.start(9);
    rig.turn(1'000'000, 400);
    return rig.drive.position_rad();
  };
  EXPECT_EQ(run(0), run(0x41));
}

TEST(MsdScaling, NewUnitsCountFromTheNextStartOfTheControl) {
  MsdParameters parameters;
  parameters.initial_position_rad = 2.0 * std::numbers::pi;
  DriveRig rig(parameters);
  rig.set({{0x6092, 1, 1080, 4}, {0x6092, 2, 3, 4}});
  rig.pass(5ms);
  EXPECT_NEAR(rig.read(0x6064), 1048576, 1);
  EXPECT_EQ(rig.read(0x6093, 1), 1U) << "calculated with the start of the control, not before";
  EXPECT_EQ(rig.read(0x6093, 2), 1U);
  rig.start(9);
  EXPECT_NEAR(rig.position, 360, 1);
  EXPECT_EQ(rig.read(0x6093, 1) * 45U, rig.read(0x6093, 2) * 131072U) << "2^20 / 360";
  rig.command(0x06, 4);
  ASSERT_EQ(rig.write(0x6092, 1, 10'800, 4), 0U);
  rig.cycles(4);
  EXPECT_NEAR(rig.position, 360, 1);
  ASSERT_EQ(rig.write(0x200B, 1, 1, 1), 0U);
  rig.restart();
  rig.pass(5ms);
  EXPECT_NEAR(rig.position, 3600, 1);
}

TEST(MsdScaling, NoDriftOverTheWholeRangeAndBack) {
  // 1/3 of a unit per increment, which no double represents.
  const Ratio units = Ratio::of(1, 3);
  for (std::int64_t increments = -(std::int64_t{1} << 40); increments <= (std::int64_t{1} << 40);
       increments += 987'654'321) {
    const std::int64_t third = units.apply(increments);
    EXPECT_LE(std::abs(increments - 3 * third), 1) << increments;
  }
  EXPECT_EQ(units.apply(3 * ((std::int64_t{1} << 31) + 7)), (std::int64_t{1} << 31) + 7);
  EXPECT_EQ(units.inverse().apply((std::int64_t{1} << 60)), 3 * (std::int64_t{1} << 60)) << "needs more than 64 bits";
}

/// A round table of 7 motor revolutions in 1000 units turns by more than 2^32 increments and back, in CSP: the shaft is
/// where exact fractions predict, and the position object never makes a step.
TEST(MsdScaling, NoDriftInMotionPastTheEndsOf32Bits) {
  DriveRig rig;
  rig.set({{0x6091, 1, 7, 4},
           {0x6092, 1, 9000, 4},
           {0x6092, 2, 9, 4},
           {0x607B, 1, 0, 4},
           {0x607B, 2, 999, 4},
           {0x6065, 0, 0xFFFFFFFF, 4}});
  rig.start(8, 1000);
  constexpr std::int64_t kTurns = 620;  // * 7 * 2^20 increments = 4.55e9
  constexpr std::int64_t kStep = 8;     // units per cycle: 56 motor revolutions per second
  std::int64_t target = 0;
  std::int32_t last = rig.position;
  const auto run_to = [&](std::int64_t end) {
    const std::int64_t step = end > target ? kStep : -kStep;
    while (target != end) {
      target += step;
      const auto wrapped = ((target % 1000) + 1000) % 1000;
      rig.target_position = static_cast<std::int32_t>(wrapped);
      rig.cycle();
      const std::int32_t moved = std::abs(rig.position - last);
      ASSERT_LE(std::min(moved, 1000 - moved), 40) << "at " << target;
      ASSERT_TRUE(rig.position >= 0 && rig.position < 1000);
      last = rig.position;
    }
    rig.cycles(500);
    const double revolutions = rig.drive.position_rad() / (2.0 * std::numbers::pi);
    EXPECT_NEAR(revolutions, static_cast<double>(target) * 7.0 / 1000.0, 2e-5) << "20 increments";
    EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
  };
  run_to(kTurns * 1000);
  run_to(-kTurns * 1000);
  run_to(0);
}

TEST(MsdScaling, RatioRoundsHalvesAwayFromZeroAndSaturates) {
  const Ratio half = Ratio::of(10, 20);
  EXPECT_EQ(half.numerator(), 1);
  EXPECT_EQ(half.divisor(), 2);
  EXPECT_EQ(half.apply(3), 2);
  EXPECT_EQ(half.apply(-3), -2);
  EXPECT_EQ(half.apply(2), 1);
  EXPECT_EQ(Ratio::of(1000, 1).apply(std::int64_t{1} << 60), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(Ratio::of(0, 0).apply(5), 5) << "zeros count as 1";
}

TEST(MsdScaling, SaturateRoundsAndKeepsTheRange) {
  EXPECT_EQ(saturate<std::int16_t>(2.6), 3);
  EXPECT_EQ(saturate<std::int16_t>(-1e9), -32768);
  EXPECT_EQ(saturate<std::int32_t>(1e300), 2147483647);
  EXPECT_EQ(saturate<std::uint32_t>(-1.0), 0U);
  EXPECT_EQ(saturate<std::int32_t>(std::numeric_limits<double>::quiet_NaN()), 0);
}

}  // namespace
}  // namespace driveline::slaves::msd
