// Invalid cyclic positions: beyond the software limits, or missing.
#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

/// An axis three turns outside, with limits at one turn, in CSP or in interpolated position mode.
class MsdSoftwareLimit : public testing::TestWithParam<std::tuple<int, std::int8_t>> {
 protected:
  MsdSoftwareLimit() : rig_(parameters()) {}

  static MsdParameters parameters() {
    MsdParameters p;
    p.initial_position_rad = std::get<0>(GetParam()) * 3.0 * 2.0 * std::numbers::pi;
    return p;
  }
  void SetUp() override {
    rig_.set({{0x607D, 2, kRevolution, 4}, {0x607D, 1, static_cast<std::uint32_t>(-kRevolution), 4}});
    rig_.operate();
    const std::int8_t mode = std::get<1>(GetParam());
    target(3.0);
    rig_.enable(mode);
    if (mode == 7) rig_.control = 0x1F;
  }
  /// Positive values are outwards.
  void target(double turns) {
    rig_.target_position = static_cast<std::int32_t>(side_ * turns * kRevolution);
    if (std::get<1>(GetParam()) == 7) {
      ASSERT_EQ(rig_.write(0x60C1, 1, static_cast<std::uint32_t>(rig_.target_position), 4), 0U);
    }
    rig_.cycle();
  }
  void go(double from, double to) {
    const double step = from < to ? 0.001 : -0.001;
    for (int i = 0; i < std::abs(from - to) / 0.001; ++i) target(from + i * step);
    target(to);
    rig_.cycles(400);
  }
  [[nodiscard]] double turns() const { return side_ * static_cast<double>(rig_.position) / kRevolution; }
  [[nodiscard]] bool limited() const { return (rig_.status & 0x0800) != 0; }

  const int side_ = std::get<0>(GetParam());
  DriveRig rig_;
};

TEST_P(MsdSoftwareLimit, AnAxisBeyondItStandsAndMayOnlyGoBack) {
  for (int i = 0; i < 800; ++i) {
    target(3.0);
    ASSERT_NEAR(turns(), 3.0, 0.001) << "the limit is no reason to leap";
    ASSERT_LT(std::abs(rig_.torque), 200);
  }
  EXPECT_TRUE(limited());
  go(3.0, 3.2);
  EXPECT_NEAR(turns(), 3.0, 0.001) << "not further out";
  go(3.2, 2.0);
  EXPECT_NEAR(turns(), 2.0, 0.001) << "back it follows";
  EXPECT_TRUE(limited());
  go(2.0, 2.5);
  EXPECT_NEAR(turns(), 2.0, 0.001) << "and not out again";
  go(2.5, 0.5);
  EXPECT_NEAR(turns(), 0.5, 0.001);
  EXPECT_FALSE(limited());
  go(0.5, 2.0);
  EXPECT_NEAR(turns(), 1.0, 0.001) << "from inside the limit is the limit";
  EXPECT_TRUE(limited());
  EXPECT_FALSE(rig_.drive.fault().has_value());
}

INSTANTIATE_TEST_SUITE_P(SidesAndModes, MsdSoftwareLimit,
                         testing::Combine(testing::Values(1, -1), testing::Values(std::int8_t{7}, std::int8_t{8})));

/// Moves at this number of revolutions per second in CSP.
double run_csp(DriveRig& rig, double speed) {
  rig.operate();
  EXPECT_EQ(rig.write(0x6085, 0, 400 << 20, 4), 0U);
  rig.enable(8);
  double target = rig.position;
  for (double now = 0.0; now < speed; now += 0.02) {
    target += now * kRevolution * 125e-6;
    rig.target_position = static_cast<std::int32_t>(std::lrint(target));
    rig.cycle();
  }
  return target;
}

TEST(MsdLostCycles, AFewAreNoReasonForAFullStop) {
  for (const std::uint32_t type : {1U, 3U, 4U}) {
    SCOPED_TRACE(type);
    DriveRig rig;
    ASSERT_EQ(rig.write(0x2172, 0, type, 1), 0U);
    constexpr double kSpeed = 30.0;
    double target = run_csp(rig, kSpeed);
    int most = 0;
    for (int i = 0; i < 1000; ++i) {
      target += kSpeed * kRevolution * 125e-6;
      rig.target_position = static_cast<std::int32_t>(std::lrint(target));
      const bool lost = i >= 400 && i < 405;
      lost ? rig.pass(125us) : rig.cycle();
      if (i >= 400) most = std::max(most, std::abs(int{rig.torque}));
    }
    EXPECT_LT(most, 1500) << "peak torque is 3000";
    EXPECT_NEAR(rig.drive.velocity_rad_s(), kSpeed * 2.0 * std::numbers::pi, 0.5);
  }
}

TEST(MsdLostCycles, AMasterThatFallsSilentStopsTheAxisAsAQuickStopDoes) {
  DriveRig rig;
  run_csp(rig, 20.0);
  rig.pass(25ms);  // half of 20 / 400 s
  EXPECT_NEAR(rig.drive.velocity_rad_s(), 62.8, 4.0);
  rig.pass(50ms);
  EXPECT_NEAR(rig.drive.velocity_rad_s(), 0.0, 0.5);
}

}  // namespace
}  // namespace driveline::slaves::msd
