// Faults caused by the machine of the simulation: the drive detects them, and display, emergency, 603Fh, 1001h and
// 1003h agree.
#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

using testing::ElementsAre;

class MsdMachineFault : public testing::Test {
 protected:
  explicit MsdMachineFault(const MsdParameters& parameters = {}) : rig(parameters) {
    EXPECT_EQ(rig.write(0x6065, 0, 0xFFFFFFFF, 4), 0U);
    rig.operate();
  }
  void set(std::string_view input, double value) { set(rig, input, value); }
  static void set(DriveRig& rig, std::string_view input, double value) {
    const auto place = rig.drive.signals().find_signal(SignalId::Direction::kInput, input);
    ASSERT_TRUE(place) << input;
    ASSERT_TRUE(rig.drive.signals().check_signal_value(place->number, value));
    rig.drive.signals().set_signal(place->number, value);
  }
  double level(std::string_view input) {
    return rig.drive.signals().signal(*rig.drive.signals().find_signal(SignalId::Direction::kInput, input));
  }
  /// The fault as reported to the master and shown on the display.
  void expect_fault(Fault fault, bool lasting) {
    const FaultFacts& f = facts(fault);
    rig.pass(500ms);
    ASSERT_EQ(rig.drive.fault(), fault) << facts(rig.drive.fault().value_or(Fault::kLocalError)).text;
    ASSERT_EQ(rig.drive.state(), PowerState::kFault);
    rig.fetch_emergencies();
    const unsigned error_register = f.error_register | 1U;
    EXPECT_THAT(rig.emergencies, ElementsAre(ElementsAre(f.error_code & 0xFFU, f.error_code >> 8U, error_register,
                                                         f.number, f.location, 0, 0, 0)));
    EXPECT_EQ(rig.read(0x603F), f.error_code);
    EXPECT_EQ(rig.read(0x1001), error_register);
    EXPECT_EQ(rig.read(0x1003), 1U);
    EXPECT_EQ(rig.read(0x1003, 1), f.error_code | f.number << 16U | f.location << 24U);
    EXPECT_EQ(rig.status & 0x4F, 0x08);
    const auto digits = [](unsigned value) {
      return std::string{static_cast<char>('0' + value / 10), static_cast<char>('0' + value % 10)};
    };
    std::vector<std::string> shown;
    for (int ms = 0; ms < 9000; ++ms) {
      rig.pass(1ms);
      const auto now = to_text(rig.drive.display_now());
      if (shown.empty() || shown.back() != now) shown.push_back(now);
    }
    const std::vector<std::string> round = {lasting ? "Er." : "Er", digits(f.number), digits(f.location)};
    const auto first = std::find(shown.begin(), shown.end(), round[0]);
    ASSERT_GE(shown.end() - first, 6) << testing::PrintToString(shown);
    for (int i = 0; i < 6; ++i)
      EXPECT_EQ(first[i], round[static_cast<std::size_t>(i % 3)]) << testing::PrintToString(shown);
    acknowledge();
    EXPECT_EQ(rig.drive.state() == PowerState::kFault, lasting);
  }
  void acknowledge() {
    rig.command(0, 2);
    rig.command(0x80, 4);
    rig.command(0, 2);
    rig.fetch_emergencies();
    rig.emergencies.clear();
  }
  /// The cause has ended: the fault is acknowledged, and the axis runs again.
  void expect_good_again() {
    acknowledge();
    ASSERT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
    rig.target_velocity = 0;
    rig.run_at(5'000'000);
  }
  DriveRig rig;
};

TEST_F(MsdMachineFault, MotorShortIsOvercurrentAsSoonAsThePowerStageDrivesIt) {
  set("MOTOR_SHORT", 1);
  rig.pass(100ms);
  EXPECT_FALSE(rig.drive.fault().has_value()) << "without power there is nothing to see";
  for (const std::uint16_t word : {std::uint16_t{0x06}, std::uint16_t{0x07}, std::uint16_t{0x0F}}) {
    rig.mode = 9;
    rig.command(word, 2);
  }
  expect_fault(Fault::kOvercurrent, false);
  set("MOTOR_SHORT", 0);
  expect_good_again();
  const double speed = rig.drive.velocity_rad_s();
  set("MOTOR_SHORT", 1);
  rig.cycle();
  EXPECT_EQ(rig.drive.fault(), Fault::kOvercurrent);
  rig.cycles(80);
  EXPECT_LT(rig.drive.velocity_rad_s(), 0.9 * speed) << "short-circuited windings brake";
}

TEST_F(MsdMachineFault, BrokenEncoderCable) {
  rig.run_at(5'000'000);
  const double speed = rig.drive.velocity_rad_s();
  set("ENCODER_CABLE", 0);
  rig.cycles(16);
  const auto seen = rig.position;
  rig.cycles(16);
  EXPECT_EQ(rig.position, seen) << "the drive sees no motion";
  EXPECT_GT(rig.drive.velocity_rad_s(), 0.8 * speed) << "but there is: it coasts";
  expect_fault(Fault::kEncoder, true);
  set("ENCODER_CABLE", 1);
  expect_good_again();
}

/// Er 14 03 (MSD manual 5.3.3), which also a restart does not mend.
TEST_F(MsdMachineFault, RamThatDoesNotHoldItsValue) {
  rig.run_at(5'000'000);
  set("RAM", 0);
  rig.cycles(16);
  expect_fault(Fault::kInternalRam, true);
  EXPECT_EQ(rig.drive.display(), "Er. 14 03");
  rig.device.restart();
  rig.pass(5ms);
  EXPECT_EQ(rig.drive.display(), "Er. 14 03");
  set("RAM", 1);
  EXPECT_EQ(rig.drive.display(), "Er 14 03") << "the cause is gone, the fault is not acknowledged";
}

TEST_F(MsdMachineFault, MainsOffIsUndervoltageWhenTheCapacitorIsEmpty) {
  rig.run_at(10'000'000);
  set("MAINS", 0);
  rig.pass(100ms);
  EXPECT_FALSE(rig.drive.fault().has_value()) << "the capacitor bridges a dip";
  EXPECT_LT(level("DC_LINK"), 560.0);
  EXPECT_GT(level("DC_LINK"), 400.0);
  rig.pass(4s);
  EXPECT_LT(level("DC_LINK"), 250.0);
  expect_fault(Fault::kDcLinkUndervoltage, true);
  EXPECT_EQ(rig.status & 0x10, 0) << "voltage enabled";
  set("MAINS", 1);
  rig.pass(2ms);
  EXPECT_EQ(level("DC_LINK"), 560.0);
  expect_good_again();
}

TEST_F(MsdMachineFault, ADipOfTheMainsIsBridged) {
  rig.run_at(10'000'000);
  set("MAINS", 0);
  rig.pass(50ms);
  set("MAINS", 1);
  rig.pass(1s);
  EXPECT_FALSE(rig.drive.fault().has_value());
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
}

TEST(MsdMachineFaults, HeavyAxisThatBrakesNeedsItsBrakeResistor) {
  for (const bool connected : {true, false}) {
    MsdParameters parameters;
    parameters.motor.inertia_kg_m2 = 8e-3;  // 394 J at 50 rev/s; half of it becomes heat in the windings
    OperatingRig rig(parameters);
    const auto set = [&rig](std::string_view input, double value) {
      rig.drive.signals().set_signal(rig.drive.signals().find_signal(SignalId::Direction::kInput, input)->number,
                                     value);
    };
    set("BRAKE_RESISTOR", connected ? 1 : 0);
    rig.enable(9);
    rig.turn(50 * 1048576, 8000);
    ASSERT_NEAR(rig.velocity, 50 * 1048576, 1e6);
    ASSERT_FALSE(rig.drive.fault().has_value());
    rig.target_velocity = 0;
    double highest = 0.0;
    for (int i = 0; i < 8000 && !rig.drive.fault(); ++i) {
      rig.cycle();
      highest = std::max(highest, rig.read(0x6079) * 1e-3);
    }
    if (connected) {
      EXPECT_FALSE(rig.drive.fault().has_value());
      EXPECT_GT(highest, 700.0) << "it comes back";
      EXPECT_LT(highest, 850.0);
    } else {
      EXPECT_EQ(rig.drive.fault(), Fault::kDcLinkOvervoltage);
      EXPECT_EQ(rig.drive.display().substr(0, 3), "7") << "reaction first: " << rig.drive.display();
    }
  }
}

TEST_F(MsdMachineFault, BlockedAxisIsAFollowingError) {
  ASSERT_EQ(rig.write(0x6065, 0, 100'000, 4), 0U);
  rig.enable(8);
  set("AXIS_BLOCKED", 1);
  for (int i = 0; i < 4000 && !rig.drive.fault(); ++i) {
    rig.target_position += 500;
    rig.cycle();
  }
  EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0);
  expect_fault(Fault::kFollowingError, false);
  set("AXIS_BLOCKED", 0);
  expect_good_again();
}

/// The drive reports a wrong position but moves correctly.
TEST_F(MsdMachineFault, WrongActualPositionIsForTheMasterToFind) {
  rig.enable(8);
  rig.cycles(8);
  const auto place = rig.position;
  const double shaft = rig.drive.position_rad();
  set("POSITION_ERROR", -2e6);
  rig.cycles(8);
  EXPECT_EQ(rig.position, place - 2'000'000);
  set("POSITION_HELD", 1);
  set("POSITION_ERROR", 0);
  rig.cycles(8);
  EXPECT_EQ(rig.position, place - 2'000'000);
  EXPECT_EQ(level("POSITION_HELD"), 1.0);
  set("POSITION_HELD", 0);
  rig.cycles(8);
  EXPECT_EQ(rig.position, place);
  EXPECT_NEAR(rig.drive.position_rad(), shaft, 1e-5);
  EXPECT_FALSE(rig.drive.fault().has_value());
}

TEST_F(MsdMachineFault, LoadAboveTheRatedTorqueOverloadsTheMotor) {
  ASSERT_EQ(rig.write_real(0x22DD, 7, 2.0F), 0U);  // thermal time constant of the I2t model
  rig.enable(9);
  set("LOAD", 2.45);
  rig.pass(20s);
  EXPECT_FALSE(rig.drive.fault().has_value()) << "rated torque for ever";
  EXPECT_NEAR(rig.torque, 1015, 10);
  EXPECT_TRUE(rig.status & 0x80) << "but near the limit: warning";
  set("LOAD", 4.0);
  rig.pass(2s);
  rig.pass(1s);
  ASSERT_TRUE(rig.drive.fault().has_value());
  EXPECT_EQ(rig.drive.fault(), Fault::kMotorOverload);
  set("LOAD", 0.0);
  rig.fetch_emergencies();
  EXPECT_THAT(rig.emergencies, ElementsAre(ElementsAre(0x50, 0x23, 0x03, 9, 1, 0, 0, 0)));
  rig.pass(10s);
  expect_good_again();
}

TEST(MsdMachineFaults, HotAirHeatsPowerStageAndMotor) {
  for (const bool motor : {false, true}) {
    MsdParameters parameters;
    (motor ? parameters.thermal.motor_time_constant_s : parameters.thermal.amplifier_time_constant_s) = 2.0;
    EnabledRig rig(parameters, 9);
    const auto set = [&rig](std::string_view input, double value) {
      rig.drive.signals().set_signal(rig.drive.signals().find_signal(SignalId::Direction::kInput, input)->number,
                                     value);
    };
    set("AMBIENT", 120.0);
    rig.pass(500ms);
    EXPECT_FALSE(rig.drive.fault().has_value()) << "it takes its time";
    rig.pass(9s);
    EXPECT_EQ(rig.drive.fault(), motor ? Fault::kMotorTemperature : Fault::kAmplifierTemperature);
    EXPECT_TRUE(rig.status & 0x80) << "and warned before";
    EXPECT_EQ(rig.drive.display(), motor ? "Er. 06 01" : "Er. 07 01");
    set("AMBIENT", 25.0);
    rig.pass(10s);
    EXPECT_EQ(rig.drive.display(), motor ? "Er 06 01" : "Er 07 01");
    set("BUTTONS", 1);
    rig.pass(1ms);
    EXPECT_EQ(rig.drive.state(), PowerState::kSwitchOnDisabled);
  }
}

TEST(MsdMachineFaults, ScriptsOfTheLineFileMakeThemToo) {
  MsdParameters parameters;
  Signal cable;
  cable.shape = Signal::Shape::kSteps;
  cable.low = 1.0;
  cable.steps = {{50ms, 0.0}, {100ms, 1.0}};
  parameters.inputs = {{find_drive_signal(SignalId::Direction::kInput, "ENCODER_CABLE")->number, cable}};
  DriveRig rig(parameters);
  rig.pass(40ms);
  EXPECT_FALSE(rig.drive.fault().has_value());
  rig.pass(20ms);
  EXPECT_EQ(rig.drive.display(), "Er. 10 01");
  rig.pass(50ms);
  EXPECT_EQ(rig.drive.display(), "Er 10 01") << "the cable is back";
}

}  // namespace
}  // namespace driveline::slaves::msd
