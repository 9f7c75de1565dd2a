// Faults, emergencies, acknowledgement, fall-back of the slave controller.
#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

using testing::ElementsAre;
constexpr std::int32_t kFaultSpeed = 10'000'000;

TEST(MsdFault, WatchdogStopsTheAxisByItself) {
  OperatingRig rig;
  rig.run_at(kFaultSpeed);
  rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
  rig.pass(10ms);  // 9.5 rev/s on the quick stop ramp of 400 rev/s2: 24 ms
  EXPECT_EQ(rig.drive.state(), PowerState::kFaultReactionActive);
  EXPECT_NEAR(rig.velocity, kFaultSpeed - 419430400.0 * 0.01, 0.05 * kFaultSpeed);
  EXPECT_EQ(rig.status & 0x4F, 0x0F);
  rig.pass(40ms);
  EXPECT_EQ(rig.drive.state(), PowerState::kFault);
  EXPECT_EQ(rig.status & 0x4F, 0x08);
  EXPECT_EQ(rig.error_code, 0xFF00);
  EXPECT_EQ(rig.drive.display(), "Er 14 01");
  rig.pass(400ms);
  EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0);
  rig.fetch_emergencies();
  // error code FF00h, register generic + communication, number 14, location 1, hours
  EXPECT_THAT(rig.emergencies, ElementsAre(ElementsAre(0x00, 0xFF, 0x11, 0x0E, 0x01, 0, 0, 0)));
  EXPECT_EQ(rig.read(0x1001), 0x11U);
  EXPECT_EQ(rig.read(0x1003), 1U);
  EXPECT_EQ(rig.read(0x1003, 1), 0x010EFF00U);
}

TEST(MsdFault, FaultReactionOptionCodesInThePhysics) {
  const auto speed_after_10_ms = [](std::uint32_t code) {
    OperatingRig rig;
    EXPECT_EQ(rig.write(0x605E, 0, code, 2), 0U);
    rig.run_at(kFaultSpeed);
    rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
    rig.pass(10ms);
    return rig.drive.velocity_rad_s() * kIncrementsPerRadian;
  };
  EXPECT_NEAR(speed_after_10_ms(0), kFaultSpeed, 0.03 * kFaultSpeed);                     // coasts
  EXPECT_NEAR(speed_after_10_ms(1), kFaultSpeed - 104857600 * 0.01, 0.03 * kFaultSpeed);  // 6084h
  EXPECT_NEAR(speed_after_10_ms(2), kFaultSpeed - 419430400 * 0.01, 0.03 * kFaultSpeed);  // 6085h
  EXPECT_NEAR(speed_after_10_ms(3), 0.0, 0.08 * kFaultSpeed);               // full torque: swings through standstill
  EXPECT_NEAR(speed_after_10_ms(0xFFFE), kFaultSpeed, 0.01 * kFaultSpeed);  // left to the controller
}

TEST(MsdFault, ExternalReactionEndsAfterP154) {
  OperatingRig rig;
  rig.set({{0x605E, 0, 0xFFFE, 2}, {0x209A, 0, 20, 4}});
  rig.run_at(kFaultSpeed);
  rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
  rig.pass(19ms);
  EXPECT_EQ(rig.drive.state(), PowerState::kFaultReactionActive);
  rig.pass(2ms);
  EXPECT_EQ(rig.drive.state(), PowerState::kFault);
}

TEST(MsdFault, FallBackForOtherReasonsIsALocalError) {
  OperatingRig rig;
  rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSynchronizationError);
  rig.pass(1ms);
  EXPECT_EQ(rig.drive.display(), "Er 14 06");
}

TEST(MsdFault, FallBackOutsideOpIsNoFault) {
  DriveRig rig;
  rig.device.fall_back(AlState::kSafeOp, AlState::kInit, AlStatusCode::kUnspecifiedError);
  rig.pass(1ms);
  EXPECT_FALSE(rig.drive.fault().has_value());
}

TEST(MsdFault, LeavingOpWithPowerOnIsMissingOutputs) {
  OperatingRig rig;
  rig.run_at(kFaultSpeed);
  EXPECT_EQ(rig.to(AlState::kOp, AlState::kSafeOp), AlStatusCode::kNoError);
  rig.pass(500ms);
  EXPECT_EQ(rig.drive.display(), "Er 14 05");
  EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0);
}

TEST(MsdFault, LeavingOpWithPowerOffIsNone) {
  OperatingRig rig;
  rig.command(0x07, 4);
  rig.to(AlState::kOp, AlState::kSafeOp);
  rig.to(AlState::kSafeOp, AlState::kInit);
  rig.pass(1ms);
  EXPECT_FALSE(rig.drive.fault().has_value());
}

TEST(MsdFault, ResetEdgeWithinOneCycleOfTheDriveIsSeen) {
  OperatingRig rig;
  rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
  rig.pass(1ms);
  rig.to(AlState::kSafeOp, AlState::kOp);
  const std::array<std::byte, 2> set = {std::byte{0x80}, std::byte{0}};
  const std::array<std::byte, 2> clear = {std::byte{0}, std::byte{0}};
  rig.device.write_outputs(2, set);
  rig.device.write_outputs(2, clear);
  rig.pass(250us);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
}

TEST(MsdFault, TimingParametersMustAgreeBeforeOp) {
  DriveRig rig;
  ASSERT_EQ(rig.write(0x60C2, 1, 2, 1), 0U);  // 2 ms, P 306 still 1 ms
  rig.to(AlState::kPreOp, AlState::kSafeOp);
  EXPECT_EQ(rig.to(AlState::kSafeOp, AlState::kOp), AlStatusCode::kInconsistentSettings);
  rig.pass(1ms);
  EXPECT_EQ(rig.drive.display(), "Er. 14 04");  // the point: the cause persists
  // Acknowledged while the cause persists: back in fault with a new emergency (MSD manual 13.3).
  ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
  rig.pass(1ms);
  EXPECT_EQ(rig.drive.state(), PowerState::kFault);
  rig.fetch_emergencies();
  EXPECT_THAT(rig.emergencies,
              ElementsAre(ElementsAre(0x00, 0xFF, 0x11, 14, 4, 0, 0, 0), ElementsAre(0, 0, 0, 0, 0, 0, 0, 0),
                          ElementsAre(0x00, 0xFF, 0x11, 14, 4, 0, 0, 0)));
  ASSERT_EQ(rig.write_real(0x2132, 0, 2.0F), 0U);
  EXPECT_EQ(rig.drive.display(), "Er 14 04");
  ASSERT_EQ(rig.write(0x2099, 0, 1, 1), 0U);
  rig.pass(1ms);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(rig.to(AlState::kSafeOp, AlState::kOp), AlStatusCode::kNoError);
}

TEST(MsdFault, CycleMustBeAMultipleOf125Microseconds) {
  DriveRig rig;
  rig.set({{0x60C2, 1, 200, 1}, {0x60C2, 2, 0xFA, 1}, real_value(0x2132, 0, 0.2F)});
  rig.to(AlState::kPreOp, AlState::kSafeOp);
  EXPECT_EQ(rig.to(AlState::kSafeOp, AlState::kOp), AlStatusCode::kInconsistentSettings);
}

/// A drive set to 1 ms in this mode, enabled, that then gets 600 frames with the two distances alternating.
std::optional<Fault> fault_of_rhythm(std::int8_t mode, std::chrono::nanoseconds odd, std::chrono::nanoseconds even) {
  EnabledRig rig(mode, 1000);
  for (int i = 0; i < 300; ++i) {
    rig.cycle(odd);
    rig.cycle(even);
  }
  return rig.drive.fault();
}

TEST(MsdFault, SetpointsInAnotherCycleThanTheDriveIsSetTo) {
  for (const auto mode : {std::int8_t{8}, std::int8_t{9}, std::int8_t{10}}) {
    for (const auto cycle : {125us, 250us, 500us, 1500us, 2000us, 4000us}) {
      EXPECT_EQ(fault_of_rhythm(mode, cycle, cycle), Fault::kInvalidConfiguration)
          << cycle.count() << " us, mode " << int{mode};
    }
    EXPECT_EQ(fault_of_rhythm(mode, 1ms, 1ms), std::nullopt);
    EXPECT_EQ(fault_of_rhythm(mode, 500us, 1500us), std::nullopt) << "jitter";
    EXPECT_EQ(fault_of_rhythm(mode, 0us, 1ms), std::nullopt) << "doubled frames";
    EXPECT_EQ(fault_of_rhythm(mode, 1ms, 4ms), std::nullopt) << "lost frames";
  }
  EXPECT_EQ(fault_of_rhythm(1, 250us, 250us), std::nullopt) << "the profile generator needs no cycle";
}

TEST(MsdFault, WrongSetpointCycleStaysUntilItIsPutRight) {
  EnabledRig rig(8, 1000);
  for (int i = 0; i < 600; ++i) rig.cycle(2ms);
  EXPECT_EQ(rig.drive.display(), "Er. 14 04");
  rig.control = 0x80;
  for (int i = 0; i < 4; ++i) rig.cycle(2ms);
  EXPECT_EQ(rig.drive.fault(), Fault::kInvalidConfiguration);
  rig.set({{0x60C2, 1, 2, 1}, real_value(0x2132, 0, 2.0F)});
  rig.control = 0;
  for (int i = 0; i < 4; ++i) rig.cycle(2ms);
  EXPECT_EQ(rig.drive.display(), "Er 14 04");
  rig.control = 0x80;
  for (int i = 0; i < 4; ++i) rig.cycle(2ms);
  EXPECT_EQ(rig.drive.fault(), std::nullopt);
}

TEST(MsdFault, TimingParametersChangedInOperation) {
  for (const std::int8_t mode : {std::int8_t{1}, std::int8_t{8}}) {
    EnabledRig rig(mode, 1000);
    ASSERT_EQ(rig.write_real(0x2132, 0, 5.0F), 0U);
    rig.cycles(20);
    const auto expected = mode == 8 ? std::optional(Fault::kInvalidConfiguration) : std::nullopt;
    EXPECT_EQ(rig.drive.fault(), expected) << "mode " << int{mode};
  }
}

TEST(MsdFault, UndervoltageStaysUntilTheVoltageIsBack) {
  EnabledRig rig(9);
  rig.drive.set_dc_link(false);
  rig.cycles(4);
  EXPECT_EQ(rig.drive.display(), "Er. 05 01");
  rig.fetch_emergencies();
  rig.emergencies.clear();
  rig.command(0x80, 4);
  EXPECT_EQ(rig.drive.state(), PowerState::kFault);
  EXPECT_EQ(rig.error_code, 0x3220);
  rig.fetch_emergencies();
  ASSERT_EQ(rig.emergencies.size(), 2U) << "acknowledgement, and the fault again";
  EXPECT_THAT(rig.emergencies[0], ElementsAre(0, 0, 0, 0, 0, 0, 0, 0));
  rig.drive.set_dc_link(true);
  rig.command(0, 4);
  EXPECT_EQ(rig.drive.display(), "Er 05 01");
  rig.command(0x80, 4);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
}

TEST(MsdFault, FollowingErrorTripsAfterItsTime) {
  OperatingRig rig;
  ASSERT_EQ(rig.write(0x6065, 0, 2000, 4), 0U);
  rig.enable(8);
  rig.target_position += 200'000;
  rig.cycles(70);  // under 10 ms
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
  EXPECT_GT(std::abs(rig.following_error), 2000);
  ASSERT_EQ(rig.write(0x6066, 0, 1, 2), 0U);
  rig.cycles(8);
  EXPECT_EQ(rig.error_code, 0x8611);
  EXPECT_TRUE(rig.status & 0x2000);
  rig.cycles(4000);
  EXPECT_EQ(rig.drive.state(), PowerState::kFault);
  EXPECT_EQ(rig.drive.display(), "Er 17 01");
  rig.fetch_emergencies();
  EXPECT_THAT(rig.emergencies, ElementsAre(ElementsAre(0x11, 0x86, 0x21, 17, 1, 0, 0, 0)));
}

TEST(MsdFault, FollowingErrorCountsOnBothSides) {
  for (const std::int32_t step : {200'000, -200'000}) {
    OperatingRig rig;
    rig.set({{0x6065, 0, 2000, 4}, {0x6066, 0, 1, 2}});
    rig.enable(8);
    rig.target_position += step;
    rig.cycles(40);
    EXPECT_EQ(rig.error_code, 0x8611) << step;
  }
}

/// Each excursion has the full time of 6066h.
TEST(MsdFault, FollowingErrorsThatEndInTimeDoNotAddUp) {
  OperatingRig rig;
  rig.set({{0x6065, 0, 2000, 4}, {0x6066, 0, 10, 2}});
  rig.enable(8);
  int outside = 0;
  for (int excursion = 0; excursion < 8; ++excursion) {
    rig.target_position += 6000;
    for (int i = 0; i < 400; ++i) {
      rig.cycle();
      outside += std::abs(rig.following_error) > 2000 ? 1 : 0;
    }
  }
  EXPECT_GT(outside, 160) << "twice as long as they may last at a time";
  EXPECT_EQ(rig.error_code, 0);
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
}

/// A motor without torque stays where it is, so the error grows with the target: by one unit in a cycle.
TEST(MsdFault, FollowingErrorTripsAtItsWindow) {
  for (const std::uint32_t window : {3U, 41U, 700U}) {
    for (const std::uint32_t polarity : {0U, 0xC0U}) {
      for (const std::int32_t direction : {1, -1}) {
        OperatingRig rig;
        rig.set({{0x6091, 1, 5, 4}, {0x6091, 2, 3, 4}, {0x607E, 0, polarity, 1}, {0x6072, 0, 0, 2}});
        rig.set({{0x6065, 0, window, 4}, {0x6066, 0, 0, 2}});
        rig.enable(8);
        std::int32_t before = 0;
        for (std::uint32_t i = 0; i < window + 20 && rig.error_code == 0; ++i) {
          before = std::abs(rig.following_error);
          rig.target_position += direction;
          rig.cycle();
        }
        EXPECT_EQ(rig.error_code, 0x8611) << window << ' ' << polarity << ' ' << direction;
        EXPECT_NEAR(before, window, 1.0) << polarity << ' ' << direction;
      }
    }
  }
}

TEST(MsdFault, FollowingErrorMonitoringCanBeSwitchedOff) {
  OperatingRig rig;
  ASSERT_EQ(rig.write(0x6065, 0, 0xFFFFFFFF, 4), 0U);
  rig.enable(8);
  rig.target_position += 10'000'000;
  rig.cycles(400);
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
  EXPECT_EQ(rig.status & 0x2000, 0);
}

TEST(MsdFault, LossOfTheDcLinkInOperationIsUndervoltage) {
  OperatingRig rig;
  rig.run_at(kFaultSpeed);
  rig.drive.set_dc_link(false);
  rig.cycles(4);
  EXPECT_EQ(rig.drive.state(), PowerState::kFault);
  EXPECT_EQ(rig.error_code, 0x3220);
  EXPECT_EQ(rig.status & 0x10, 0);
}

TEST(MsdFault, HistoryHasOneSubEntry) {
  DriveRig rig;
  EXPECT_EQ(rig.sdo({0x40, 0x03, 0x10, 1, 0, 0, 0, 0}).at(0), 0x43U);
  const auto answer = rig.sdo({0x40, 0x03, 0x10, 2, 0, 0, 0, 0});
  EXPECT_EQ(answer.at(0), 0x80U);
  EXPECT_EQ(DriveRig::number(answer, 4), 0x06090011U) << "no such sub-index";
}

TEST(MsdFault, TheFirstFaultStands) {
  OperatingRig rig;
  rig.run_at(kFaultSpeed);
  rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSyncManagerWatchdog);
  rig.device.fall_back(AlState::kOp, AlState::kSafeOp, AlStatusCode::kSynchronizationError);
  rig.pass(1ms);
  rig.fetch_emergencies();
  EXPECT_EQ(rig.emergencies.size(), 1U);
  EXPECT_EQ(rig.drive.fault(), Fault::kBusWatchdog);
}

}  // namespace
}  // namespace driveline::slaves::msd
