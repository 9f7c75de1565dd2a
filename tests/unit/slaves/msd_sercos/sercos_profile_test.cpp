// A whole drive with the profile SERCOS: enabling, status word, display, stops, halts, faults.
#include "sercos_rig.hpp"

namespace driveline::slaves::msd::profile_test {
namespace {

constexpr std::uint16_t kEnable = 0x4000;
constexpr std::uint16_t kHalted = 0xC000;
constexpr std::uint16_t kFollow = 0xE000;
constexpr std::int32_t kSpeed = 2'500'000;  ///< 250 rpm
constexpr double kSpeedRad = kSpeed * kSpeedUnit;

/// A drive that runs at kSpeed.
class Running : public SercosRig {
 public:
  explicit Running(std::uint16_t mode = 0x0006) : SercosRig(mode) {
    enable();
    send(kSercosValue.velocity_command, kSpeed);
    cycles(2400);
    EXPECT_NEAR(drive.velocity_rad_s(), kSpeedRad, 0.05 * kSpeedRad);
  }
};

struct Row {
  const char* what;
  std::uint16_t word;
  std::uint16_t status;  ///< bits 15 to 13 and 3
  const char* display;
};

TEST(SercosProfile, ShowsItsStatesInStatusWordAndDisplay) {
  SercosRig rig(0x0006);
  constexpr std::uint16_t kMask = 0xE008;
  for (const auto& [what, word, status, display] : std::vector<Row>{
           {"starting lockout", 0, 0x8000, "2"},
           {"ready", kEnable, 0x8000, "3"},
           {"in control", kFollow, 0xC008, "5."},
           {"halted", kHalted, 0xC000, "5."},
           {"in control again", kFollow, 0xC008, "5."},
           {"off", kEnable, 0x8000, "3"},
           {"without enable", 0xA000, 0x8000, "2"},
       }) {
    SCOPED_TRACE(what);
    rig.control(word, 40);
    EXPECT_EQ(rig.status() & kMask, status);
    EXPECT_EQ(rig.drive.display(), display);
  }
  rig.drive.set_dc_link(false);
  rig.control(0, 40);
  EXPECT_EQ(rig.status() & kMask, 0x4000);
  EXPECT_EQ(rig.drive.display(), "1");
}

TEST(SercosProfile, IsNotReadyDuringTheSelfTest) {
  MsdParameters slow;
  slow.start_up_time = 50ms;
  SercosRig rig(0x0006, slow);
  EXPECT_EQ(rig.status() & 0xE008, 0x0000);
}

struct Wrong {
  const char* what;
  std::function<void(SercosRig&)> setting;
};

TEST(SercosProfile, IsEnabledUnderAllItsConditionsAlone) {
  for (const auto& [what, setting] : std::vector<Wrong>{
           {"phase 3", [](auto& rig) { rig.drive.enter_network_state(NetworkState::kSafeOperational); }},
           {"P 159", [](auto& rig) { rig.write(kValue.control_location, std::uint16_t{5}); }},
           {"P 165", [](auto& rig) { rig.write(kValue.reference_source, std::uint16_t{7}); }},
           {"ENPO", [](auto& rig) { rig.drive.set_enpo(false); }},
           {"ISDSH", [](auto& rig) { rig.drive.set_isdsh(false); }},
           {"DC link", [](auto& rig) { rig.drive.set_dc_link(false); }},
       }) {
    SCOPED_TRACE(what);
    SercosRig rig(0x0006);
    setting(rig);
    for (const std::uint16_t word : {std::uint16_t{0}, kEnable, kFollow}) rig.control(word, 8);
    EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
    EXPECT_FALSE(rig.drive.power_on());
  }
}

TEST(SercosProfile, P144ChoosesEdgeOrLevel) {
  for (const bool level : {false, true}) {
    SercosRig rig(0x0006);
    rig.write(kSercosValue.level_control, static_cast<std::uint16_t>(level ? 1 : 0));
    rig.control(kFollow, 40);
    EXPECT_EQ(rig.drive.power_on(), level);
    rig.control(kEnable, 4);
    rig.control(kFollow, 40);
    EXPECT_TRUE(rig.drive.power_on());
  }
}

TEST(SercosProfile, Bit14RemovesTheTorqueAtOnce) {
  for (const std::uint16_t word : {std::uint16_t{0xA000}, std::uint16_t{0x8000}, std::uint16_t{0}}) {
    Running rig;
    rig.control(word, 1);
    EXPECT_FALSE(rig.drive.power_on());
    EXPECT_GT(rig.drive.velocity_rad_s(), 0.9 * kSpeedRad) << "it coasts";
  }
}

TEST(SercosProfile, Bit15StopsByP2219ThenRemovesTheTorque) {
  Running rig;
  rig.write(kValue.shutdown_option, std::int16_t{1});
  rig.write(kSercosValue.quick_stop_acceleration, 150'000U);  // 150 rad/s2
  rig.cycles(1);
  rig.control(kEnable, 1);
  EXPECT_EQ(rig.status() & 0xE008, 0xC000);
  rig.cycles(800);
  EXPECT_NEAR(rig.drive.velocity_rad_s(), kSpeedRad - 150.0 * 0.1, 0.7);
  EXPECT_TRUE(rig.drive.power_on());
  rig.cycles(1600);
  EXPECT_NEAR(rig.drive.velocity_rad_s(), 0.0, 0.1);
  EXPECT_EQ(rig.drive.state(), PowerState::kReadyToSwitchOn);
}

struct Halt {
  const char* what;
  std::uint16_t mode;
  std::int16_t option;  ///< P 2221
  double deceleration;  ///< rad/s2 to be seen
};

/// The last acceleration in force: that of the mode's profile, P 2242 where the mode has none.
TEST(SercosProfile, Bit13HaltsWithTheAccelerationInForce) {
  for (const auto& [what, mode, option, deceleration] : std::vector<Halt>{
           {"cyclic speed", 0x0006, 1, 150.0},
           {"speed with ramps", 0x0002, 1, 90.0},
           {"speed with ramps, quick stop", 0x0002, 2, 150.0},
       }) {
    SCOPED_TRACE(what);
    SercosRig rig(mode);
    rig.write(kSercosValue.quick_stop_acceleration, 150'000U);
    rig.write(kSercosValue.speed_acceleration, 400'000U);
    rig.write(kSercosValue.speed_deceleration, 90'000U);
    rig.write(kValue.halt_option, option);
    rig.enable();
    rig.send(kSercosValue.velocity_command, kSpeed);
    rig.cycles(2400);
    rig.control(kHalted, 1);
    const double begin = rig.drive.velocity_rad_s();
    rig.cycles(800);
    EXPECT_NEAR(rig.drive.velocity_rad_s(), begin - deceleration * 0.1, 0.06 * deceleration * 0.1);
    EXPECT_EQ(rig.status() & 0xE008, 0xC000);
    rig.cycles(4000);
    EXPECT_NEAR(rig.drive.velocity_rad_s(), 0.0, 0.1);
    EXPECT_TRUE(rig.drive.power_on()) << "it stays under control";
    rig.control(kFollow, 2400);
    EXPECT_NEAR(rig.drive.velocity_rad_s(), kSpeedRad, 0.05 * kSpeedRad) << "the function goes on";
    EXPECT_EQ(rig.status() & 0xE008, 0xC008);
  }
}

TEST(SercosProfile, APositionHaltsWithTheDecelerationOfItsProfile) {
  SercosRig rig(0x001B);
  rig.write(kSercosValue.positioning_velocity, static_cast<std::uint32_t>(kSpeed));
  rig.write(kSercosValue.positioning_acceleration, 400'000U);
  rig.write(kSercosValue.positioning_deceleration, 70'000U);
  rig.enable();
  rig.send(kSercosValue.target_position, 5 * kTurn);
  rig.cycles(1200);
  rig.control(kHalted, 1);
  const double begin = rig.drive.velocity_rad_s();
  rig.cycles(800);
  EXPECT_NEAR(rig.drive.velocity_rad_s(), begin - 7.0, 0.5);
  rig.cycles(4000);
  const double stopped = rig.drive.position_rad();
  EXPECT_LT(stopped, 4.0 * kTurnRad);
  rig.control(kFollow, 16'000);
  EXPECT_NEAR(rig.drive.position_rad(), 5 * kTurnRad, 1e-3) << "the movement goes on";
}

TEST(SercosProfile, AFaultIsResetByTheCommandAlone) {
  Running rig;
  rig.drive.set_cause(Fault::kMotorTemperature, true);
  rig.cycles(16);
  EXPECT_EQ(rig.status() & 0xE008, 0xE000);
  rig.cycles(4000);
  EXPECT_EQ(rig.status() & 0xE008, 0x2000);
  EXPECT_EQ(rig.drive.display().substr(0, 2), "Er");
  rig.write(kSercosValue.reset_class_1, std::uint16_t{3});
  rig.cycles(4);
  EXPECT_EQ(rig.status() & 0xE008, 0x2000) << "its cause stands";
  rig.write(kSercosValue.reset_class_1, std::uint16_t{0});
  rig.drive.set_cause(Fault::kMotorTemperature, false);
  rig.drive.press_buttons();
  rig.drive.set_enpo(false);
  rig.cycles(4);
  rig.drive.set_enpo(true);
  rig.control(0, 4);
  EXPECT_EQ(rig.status() & 0xE008, 0x2000);
  rig.write(kSercosValue.reset_class_1, std::uint16_t{1});
  EXPECT_TRUE(rig.drive.fault()) << "set, not enabled";
  rig.write(kSercosValue.reset_class_1, std::uint16_t{3});
  rig.cycles(4);
  EXPECT_EQ(rig.drive.fault(), std::nullopt);
  EXPECT_EQ(rig.status() & 0xE008, 0x8000);
}

TEST(SercosProfile, TheReactionToAFaultIsThatOfP2222) {
  for (const bool coasts : {true, false}) {
    Running rig;
    rig.write(kValue.fault_reaction_option, static_cast<std::int16_t>(coasts ? 0 : 2));
    rig.drive.set_cause(Fault::kMotorTemperature, true);
    rig.cycles(160);
    EXPECT_EQ(rig.drive.velocity_rad_s() > 0.5 * kSpeedRad, coasts);
  }
}

TEST(SercosProfile, State4LastsUntilTheBrakeIsOpen) {
  SercosRig rig(0x0006);
  rig.write(kValue.output_functions[3], std::uint16_t{1});
  rig.write(kValue.brake_lift_time, 20.0F);
  for (const std::uint16_t word : {std::uint16_t{0}, kEnable, kFollow}) rig.control(word, 8);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchedOn);
  EXPECT_EQ(rig.status() & 0xE008, 0x8000);
  EXPECT_EQ(rig.drive.display(), "4.");
  rig.cycles(200);
  EXPECT_EQ(rig.status() & 0xE008, 0xC008);
}

/// With P 2222 = -2 the master stops the axis: the setpoints act until the time of P 154 is over.
TEST(SercosProfile, TheMasterStopsTheAxisAfterAFault) {
  Running rig;
  rig.write(kValue.fault_reaction_option, std::int16_t{-2});
  rig.write(kValue.external_reaction_time, 200U);
  rig.drive.set_cause(Fault::kMotorTemperature, true);
  rig.cycles(400);
  EXPECT_EQ(rig.status() & 0xE008, 0xE000);
  EXPECT_NEAR(rig.drive.velocity_rad_s(), kSpeedRad, 0.05 * kSpeedRad);
  rig.send(kSercosValue.velocity_command, 0);
  rig.cycles(800);
  EXPECT_NEAR(rig.drive.velocity_rad_s(), 0.0, 0.2);
  rig.cycles(600);
  EXPECT_EQ(rig.status() & 0xE008, 0x2000);
}

TEST(SercosProfile, AQuietDriveIsSwitchedOffWhenItLeavesPhase4) {
  SercosRig rig(0x0006);
  rig.enable();
  rig.cycles(100);
  ASSERT_TRUE(rig.drive.quiet());
  rig.drive.enter_network_state(NetworkState::kSafeOperational);
  rig.pass(250us);
  EXPECT_FALSE(rig.drive.power_on());
}

TEST(SercosProfile, AQuietDriveHearsItsControlWord) {
  SercosRig rig(0x0006);
  rig.enable();
  for (int i = 0; i < 100; ++i) {
    rig.drive.outputs_written();
    rig.pass(125us);
  }
  ASSERT_TRUE(rig.drive.quiet());
  rig.send(kSercosValue.control_word, kEnable);
  rig.cycles(2);
  EXPECT_EQ(rig.drive.state(), PowerState::kReadyToSwitchOn);
}

}  // namespace
}  // namespace driveline::slaves::msd::profile_test
