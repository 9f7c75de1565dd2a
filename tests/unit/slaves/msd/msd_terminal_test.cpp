// Digital inputs and outputs (MSD manual 10.4), limit switches in the modes, motor brake.
#include "drive_rig.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::array kAllInputs = {Input::kEnpo,  Input::kIsd00, Input::kIsd01, Input::kIsd02,
                                   Input::kIsd03, Input::kIsd04, Input::kIsd05, Input::kIsd06,
                                   Input::kIsdsh, Input::kIsa00, Input::kIsa01};
constexpr std::array<unsigned, 11> kInputBits = {0, 1, 2, 3, 4, 5, 6, 16, 7, 18, 19};  // MSD manual Table 10.6

TEST(MsdTerminal, InputImageHasTheBitsOfTheManual) {
  DriveRig rig;
  for (const auto input : kAllInputs) rig.drive.set_input(input, false);
  for (std::size_t i = 0; i < kAllInputs.size(); ++i) {
    rig.drive.set_input(kAllInputs[i], true);
    rig.pass(250us);
    EXPECT_EQ(rig.read(0x2079), 1U << kInputBits[i]);
    rig.drive.set_input(kAllInputs[i], false);
  }
}

TEST(MsdTerminal, FunctionImageDoesNotDependOnTheTerminal) {
  struct Function {
    std::uint32_t code;
    std::uint32_t bit;
  };
  DriveRig rig;
  for (unsigned selector = 1; selector <= 10; ++selector) {
    if (selector == 8) continue;  // ISDSH, whose own function is checked below
    for (const auto& f : {Function{6, 1U << 0U}, Function{5, 1U << 1U}, Function{10, 1U << 2U}}) {
      ASSERT_EQ(rig.write(static_cast<std::uint16_t>(0x2064 + selector), 0, f.code, 2), 0U);
      rig.drive.set_input(kAllInputs[selector], true);
      rig.pass(250us);
      EXPECT_EQ(rig.read(0x60FD), f.bit | 1U << 19U) << selector;
      rig.drive.set_input(kAllInputs[selector], false);
      rig.pass(250us);
      EXPECT_EQ(rig.read(0x60FD), 1U << 19U);
      ASSERT_EQ(rig.write(static_cast<std::uint16_t>(0x2064 + selector), 0, 0, 2), 0U);
    }
  }
}

TEST(MsdTerminal, SelectorsWithoutATerminalAreStoredAndActOnNothing) {
  DriveRig rig;
  for (const auto selector : {std::uint16_t{0x206F}, std::uint16_t{0x2070}}) {  // P 111, P 112
    ASSERT_EQ(rig.write(selector, 0, 5, 2), 0U);
    EXPECT_EQ(rig.read(selector), 5U);
    EXPECT_EQ(rig.write(selector, 0, 15, 2), 0x06090030U) << "no probe either";
  }
  for (unsigned i = 1; i < std::size(kAllInputs); ++i) rig.drive.set_input(kAllInputs[i], true);
  rig.pass(250us);
  EXPECT_EQ(rig.read(0x60FD) & 7U, 0U);
}

TEST(MsdTerminal, SelectorsTakeOnlyFunctionsThatExist) {
  DriveRig rig;
  for (std::uint32_t code = 0; code < 16; ++code) {
    const bool known = code == 0 || code == 1 || code == 5 || code == 6 || code == 10;
    EXPECT_EQ(rig.write(0x2065, 0, code, 2), known ? 0U : 0x06090030U) << code;
    EXPECT_EQ(rig.write(0x206A, 0, code, 2), known || code == 15 ? 0U : 0x06090030U) << code;
  }
  for (std::uint32_t code = 0; code < 41; ++code) {
    const bool known = code == 0 || code == 14 || code == 39 || code == 40;
    EXPECT_EQ(rig.write(0x207A, 0, code, 2), known ? 0U : 0x06090030U) << code;
  }
}

TEST(MsdTerminal, ImagesCanBeMapped) {
  DriveRig rig;
  rig.map(0x1A00, {0x20790020, 0x208F0020});
  rig.map(0x1600, {0x60FE0120});
  EXPECT_EQ(rig.device.process_data_size(3), 8U);
  EXPECT_EQ(rig.device.process_data_size(2), 4U);
}

struct BusOutput {
  std::uint16_t selector;
  unsigned bit;    ///< in 60FEh
  unsigned image;  ///< in 208Fh
};
constexpr std::array kBusOutputs = {BusOutput{0x207A, 16, 0}, BusOutput{0x207B, 17, 1}, BusOutput{0x207C, 18, 2},
                                    BusOutput{0x207D, 22, 6}, BusOutput{0x207E, 23, 7}};

TEST(MsdTerminal, OutputsFollow60FEOnlyWithSelector39Or40) {
  for (const auto& o : kBusOutputs) {
    for (const std::uint32_t function : {0U, 14U, 39U, 40U}) {
      DriveRig rig;
      ASSERT_EQ(rig.write(o.selector, 0, function, 2), 0U);
      ASSERT_EQ(rig.write(0x60FE, 1, 1U << o.bit, 4), 0U);
      rig.pass(2ms);
      EXPECT_EQ(rig.read(0x208F), function >= 39 ? 1U << o.image : 0U) << std::hex << o.selector << ' ' << function;
      ASSERT_EQ(rig.write(0x60FE, 1, ~(1U << o.bit), 4), 0U);
      rig.pass(2ms);
      EXPECT_EQ(rig.read(0x208F), 0U);
    }
  }
}

TEST(MsdTerminal, MaskKeepsAnOutput) {
  DriveRig rig;
  rig.set({{0x207A, 0, 40, 2}, {0x60FE, 1, 0x10000, 4}});
  rig.pass(250us);
  rig.set({{0x60FE, 2, 0, 4}, {0x60FE, 1, 0, 4}});
  rig.pass(2ms);
  EXPECT_TRUE(rig.drive.output(Output::kOsd00));
}

TEST(MsdTerminal, Selector40UpdatesEveryControlCycleAnd39EveryMillisecond) {
  DriveRig rig;
  rig.pass(10ms);
  rig.set({{0x207A, 0, 39, 2}, {0x207B, 0, 40, 2}});
  int changes_ms = 0;
  int changes_step = 0;
  bool last_ms = false;
  bool last_step = false;
  rig.pass(1ms);
  for (int i = 0; i < 160; ++i) {  // 10 ms, a new level in every control cycle
    ASSERT_EQ(rig.write(0x60FE, 1, i % 2 == 0 ? 0x30000 : 0, 4), 0U);
    rig.pass(62500ns);
    changes_step += rig.drive.output(Output::kOsd01) != last_step ? 1 : 0;
    last_step = rig.drive.output(Output::kOsd01);
    changes_ms += rig.drive.output(Output::kOsd00) != last_ms ? 1 : 0;
    last_ms = rig.drive.output(Output::kOsd00);
  }
  EXPECT_EQ(changes_step, 160);
  EXPECT_LE(changes_ms, 10);
}

TEST(MsdTerminal, LimitOutputShowsAnInternalLimit) {
  DriveRig rig;
  rig.set({{0x207C, 0, 14, 2}, {0x607F, 0, kRevolution, 4}});
  rig.start(3);
  EXPECT_FALSE(rig.drive.output(Output::kOsd02));
  rig.turn(5 * kRevolution, 4);
  EXPECT_TRUE(rig.drive.output(Output::kOsd02));
}

TEST(MsdTerminal, StoRelayFollowsIsdsh) {
  DriveRig rig;
  rig.pass(250us);
  EXPECT_EQ(rig.read(0x208F) & 0x8000U, 0U);
  rig.drive.set_isdsh(false);
  rig.pass(250us);
  EXPECT_EQ(rig.read(0x208F) & 0x8000U, 0x8000U);
}

/// A broken wire of a limit switch with a break contact stops the axis, which is the purpose of break contacts.
TEST(MsdTerminal, P120InvertsInputsSoThatABrokenWireIsALimit) {
  MsdParameters parameters;
  parameters.switches = {{Input::kIsd01, 1e6, 1e7, true}};  // far away: the contact is closed
  DriveRig rig(parameters);
  rig.set({{0x2078, 0, 0x04, 4}, {0x2066, 0, 5, 2}});  // ISD01: positive limit
  rig.operate();
  rig.run_at(5'000'000);
  EXPECT_EQ(rig.read(0x60FD) & 7U, 0U);
  EXPECT_EQ(rig.read(0x2079) & 4U, 4U);
  rig.drive.signals().set_signal(rig.drive.signals().find_signal(SignalId::Direction::kInput, "ISD01")->number, 0.0);
  rig.pass(500ms);
  EXPECT_EQ(rig.drive.fault(), Fault::kPositiveLimitSwitch);
  EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0);
  EXPECT_EQ(rig.write(0x2078, 0, 0x80, 4), 0x06090030U) << "safe torque off cannot be inverted";
  EXPECT_EQ(rig.write(0x2078, 0, 0x01, 4), 0x06090030U) << "nor the hardware enable";
  EXPECT_EQ(rig.write(0x2078, 0, 0x20000, 4), 0x06090031U);
  EXPECT_EQ(rig.write(0x2078, 0, 0x1007E, 4), 0U);
}

class MsdLimitSwitch : public testing::TestWithParam<int> {};

TEST_P(MsdLimitSwitch, StopsTheMotionTowardsItAndLetsItGoAway) {
  const auto mode = static_cast<std::int8_t>(GetParam());
  for (const int sign : {1, -1}) {
    MsdParameters parameters;
    const double far = 1000.0 * std::numbers::pi;
    const double at = 2.0 * std::numbers::pi;
    parameters.switches = {{Input::kIsd00, at, far}, {Input::kIsd01, -far, -at}};
    DriveRig rig(parameters);
    rig.set({{0x2065, 0, 5, 2}, {0x2066, 0, 6, 2}});
    rig.start(mode);
    const auto drive_on = [&](int direction) {
      rig.target_velocity = direction * 2 * kRevolution;
      rig.target_torque = static_cast<std::int16_t>(direction * 50);
      rig.control = 0x0F;
      if (mode == 1) {
        rig.target_position = rig.position + direction * 3 * kRevolution;
        rig.cycles(2);
        rig.control = 0x1F;
      }
      for (int i = 0; i < 12000 && rig.drive.state() == PowerState::kOperationEnabled; ++i) {
        if (mode == 8) rig.target_position += direction * 300;
        rig.cycle();
      }
    };
    drive_on(sign);
    EXPECT_EQ(rig.drive.fault(), sign > 0 ? Fault::kPositiveLimitSwitch : Fault::kNegativeLimitSwitch);
    rig.cycles(800);
    EXPECT_EQ(rig.drive.state(), PowerState::kFault);
    EXPECT_NEAR(rig.drive.position_rad(), sign * at, 1.0) << "stops close behind the switch";
    rig.target_velocity = 0;
    rig.target_torque = 0;
    rig.command(0x80, 4);
    rig.enable(mode);
    rig.cycles(80);
    EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled) << "standing on the switch is allowed";
    drive_on(-sign);
    EXPECT_NE(rig.drive.fault(), sign > 0 ? Fault::kPositiveLimitSwitch : Fault::kNegativeLimitSwitch);
    EXPECT_LT(sign * rig.drive.position_rad(), 0.5 * at);
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, MsdLimitSwitch, testing::Values(1, 3, 8, 9, 10));

TEST(MsdBrake, OpensBeforeMotionAndClosesBeforeTheTorqueGoes) {
  MsdParameters parameters;
  parameters.motor.brake_torque_nm = 10.0;
  DriveRig rig(parameters);
  rig.set({real_value(0x20D5, 0, 20.0F),    // lift time
           real_value(0x20D6, 0, 30.0F)});  // close time
  rig.operate();
  rig.target_velocity = 2 * kRevolution;
  rig.mode = 9;
  for (const std::uint16_t word : {std::uint16_t{0x06}, std::uint16_t{0x07}, std::uint16_t{0x0F}}) {
    EXPECT_FALSE(rig.drive.output(Output::kBrake));
    rig.command(word, 2);
  }
  EXPECT_TRUE(rig.drive.output(Output::kBrake));
  rig.cycles(140);  // not yet 20 ms
  EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0);
  EXPECT_EQ(rig.status & 0x1000, 0) << "setpoints are not followed yet";
  rig.cycles(400);
  EXPECT_NEAR(rig.velocity, 2 * kRevolution, 5000);
  rig.control = 0x07;  // disable operation, slow down ramp
  while (rig.drive.output(Output::kBrake)) rig.cycle();
  EXPECT_NEAR(rig.velocity, 0, 20'000);
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled) << "torque until the brake has closed";
  rig.cycles(200);
  EXPECT_EQ(rig.drive.state(), PowerState::kOperationEnabled);
  rig.cycles(60);
  EXPECT_EQ(rig.drive.state(), PowerState::kSwitchedOn);
}

TEST(MsdBrake, ClosesWhenThePowerIsTakenAway) {
  MsdParameters parameters;
  parameters.motor.brake_torque_nm = 10.0;
  OperatingRig rig(parameters);
  rig.run_at(5 * kRevolution);
  EXPECT_TRUE(rig.drive.output(Output::kBrake));
  rig.drive.set_enpo(false);
  rig.cycles(4);
  EXPECT_FALSE(rig.drive.output(Output::kBrake));
  rig.cycles(80);
  EXPECT_EQ(rig.drive.velocity_rad_s(), 0.0) << "10 Nm stop 31 rad/s within a millisecond";
}

TEST(MsdBrake, StaysOpenInAQuickStopThatStays) {
  DriveRig rig;
  ASSERT_EQ(rig.write(0x605A, 0, 6, 2), 0U);
  rig.operate();
  rig.run_at(5 * kRevolution);
  rig.command(0x02, 1600);
  EXPECT_EQ(rig.drive.state(), PowerState::kQuickStopActive);
  EXPECT_TRUE(rig.drive.output(Output::kBrake));
}

}  // namespace
}  // namespace driveline::slaves::msd
