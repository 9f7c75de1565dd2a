// Quiet control cycles: a drive that follows cyclic setpoints leaves out what could change nothing. Its twin, whose
// dictionary is touched before every control cycle, leaves out nothing; both must report the same in every cycle.
#include <functional>
#include <ostream>
#include <string>

#include "drive_rig.hpp"
#include "driveline/slaves/msd/core/drive_values.hpp"

namespace driveline::slaves::msd {
namespace {

constexpr std::int8_t kCyclicPosition = 8;
constexpr std::int8_t kInterpolated = 7;
constexpr std::int32_t kStepIncrements = 400;  ///< the target position moves by this in 125 us
constexpr auto kControlCycle = 62'500ns;

/// Everything that the bus and the machine see of a drive.
struct Report {
  std::uint16_t status;
  std::int8_t mode;
  std::int32_t position;
  std::int32_t velocity;
  std::int16_t torque;
  std::uint16_t error_code;
  std::int32_t following_error;
  PowerState state;
  std::optional<Fault> fault;
  double position_rad;
  double torque_nm;
  std::uint32_t outputs;
  std::uint16_t probe_status;
  std::int32_t latched;
  friend bool operator==(const Report&, const Report&) = default;
};

std::uint32_t outputs_of(const DriveCore& drive) {
  std::uint32_t outputs = 0;
  for (const Output output : {Output::kOsd00, Output::kOsd01, Output::kBrake, Output::kRelay, Output::kStoRelay}) {
    outputs = outputs << 1U | (drive.output(output) ? 1U : 0U);
  }
  return outputs;
}

Report report_of(const DriveRig& rig) {
  const DriveCore& drive = rig.drive;
  const ObjectDictionary& values = drive.complete_values();
  return {rig.status,
          rig.mode_display,
          rig.position,
          rig.velocity,
          rig.torque,
          rig.error_code,
          rig.following_error,
          drive.state(),
          drive.fault(),
          drive.position_rad(),
          drive.torque_nm(),
          outputs_of(drive),
          values.get(kValue.touch_probe_status),
          values.get(kValue.touch_probe_values[TouchProbe::kFirstPositive])};
}

/// A drive and its twin, which take the same commands.
class Twins {
 public:
  Twins(const std::vector<ObjectValue>& settings, std::int8_t mode) {
    for (DriveRig* rig : {&quick, &thorough}) {
      rig->set(settings);
      rig->operate();
      rig->enable(mode);
    }
    command_word(mode == kInterpolated ? 0x1F : kEnabled);
    run(400);
  }
  void both(const std::function<void(DriveRig&)>& act) {
    act(quick);
    act(thorough);
  }
  void command_word(std::uint16_t word) {
    both([word](DriveRig& rig) { rig.control = word; });
  }
  /// Moves both for this many bus cycles; returns the control cycle in which their reports differ first, -1 for none.
  int run(int cycles) {
    int different = -1;
    for (int i = 0; i < 2 * cycles; ++i) {
      both([i](DriveRig& rig) {
        if (i % 2 == 0) rig.target_position += kStepIncrements;
      });
      static_cast<void>(thorough.drive.dictionary());
      both([i](DriveRig& rig) { i % 2 == 0 ? rig.cycle(kControlCycle) : rig.pass(kControlCycle); });
      if (different < 0 && !(report_of(quick) == report_of(thorough))) different = i;
    }
    return different;
  }

  DriveRig quick{with_brake()};
  DriveRig thorough{with_brake()};

 private:
  static MsdParameters with_brake() {
    MsdParameters parameters;
    parameters.motor.brake_torque_nm = 20.0;
    return parameters;
  }
};

/// What ends quiet operation, and how its effect is seen.
struct Disturbance {
  const char* name;
  std::function<void(DriveRig&)> act;
  std::function<bool(const DriveRig&)> acted;  ///< 75 ms later
  std::int8_t mode = kCyclicPosition;
  std::vector<ObjectValue> settings{};
};
std::ostream& operator<<(std::ostream& out, const Disturbance& disturbance) {
  return out << disturbance.name;
}

bool not_enabled(const DriveRig& rig) {
  return rig.drive.state() != PowerState::kOperationEnabled;
}
std::function<void(DriveRig&)> sends(std::uint16_t word) {
  return [word](DriveRig& rig) { rig.control = word; };
}
std::function<void(DriveRig&)> switches_to(std::int8_t mode) {
  return [mode](DriveRig& rig) {
    rig.mode = mode;
    rig.target_velocity = kStepIncrements * 8000;
  };
}
std::function<void(DriveRig&)> writes(const ObjectValue& value) {
  return [value](DriveRig& rig) { rig.set({value}); };
}
std::function<void(DriveRig&)> sets(Input input, bool level) {
  return [=](DriveRig& rig) { rig.drive.set_input(input, level); };
}
std::function<void(DriveRig&)> sets(MachineInput input, double value) {
  return [=](DriveRig& rig) { rig.drive.set_machine_input(input, value); };
}
std::function<bool(const DriveRig&)> has(Fault fault) {
  return [fault](const DriveRig& rig) { return rig.drive.fault() == fault; };
}
bool output_on(const DriveRig& rig) {
  return rig.drive.output(Output::kOsd00);
}

const std::vector<Disturbance> kDisturbances = {
    // The control word and the mode, in the process data.
    {"Shutdown", sends(0x06), not_enabled},
    {"DisableVoltage", sends(0x00), not_enabled},
    {"QuickStop", sends(0x0B), not_enabled},
    {"DisableOperation", sends(0x07), not_enabled},
    {"Halt", sends(0x11F),
     [](const DriveRig& rig) { return (rig.status & status_word::kIpActive) == 0 && !rig.drive.quiet(); },
     kInterpolated},
    {"InterpolationDisabled", sends(0x0F),
     [](const DriveRig& rig) { return (rig.status & status_word::kIpActive) == 0; }, kInterpolated},
    {"VelocityMode", switches_to(9), [](const DriveRig& rig) { return rig.mode_display == 9; }},
    {"ProfilePositionMode", switches_to(1), [](const DriveRig& rig) { return std::abs(rig.velocity) < 10'000; }},
    // The same by SDO.
    {"ControlWordBySdo",
     [](DriveRig& rig) {
       rig.set({{0x6040, 0, 0x06, 2}});
       rig.control = 0x06;
     },
     not_enabled},
    // Settings.
    {"MaxTorque", writes({0x6072, 0, 5, 2}), [](const DriveRig& rig) { return (rig.status & 0x0800U) != 0; }},
    {"ControlLocation", writes({0x209F, 0, 4, 2}), not_enabled},
    {"ReferenceSource", writes({0x20A5, 0, 3, 2}), [](const DriveRig& rig) { return std::abs(rig.velocity) < 10'000; }},
    {"FollowingErrorWindow",
     writes({0x6065, 0, 0, 4}),
     has(Fault::kFollowingError),
     kCyclicPosition,
     {{0x6066, 0, 0, 2}}},
    {"BrakeFunction", writes({0x207D, 0, 0, 2}), [](const DriveRig& rig) { return rig.following_error > 100'000; },
     kCyclicPosition},
    {"ParameterSet",
     [](DriveRig& rig) {
       ObjectDictionary changed = rig.drive.complete_values();
       changed.set(kValue.max_torque, std::uint16_t{5});
       ASSERT_TRUE(rig.drive.take_parameter_set(write_parameters(changed)));
     },
     [](const DriveRig& rig) { return (rig.status & 0x0800U) != 0; }},
    {"DictionaryWithoutNotice",
     [](DriveRig& rig) { rig.drive.dictionary().set(kValue.control_location, std::uint16_t{4}); }, not_enabled},
    // Faults.
    {"FaultOfTheBus", [](DriveRig& rig) { rig.drive.raise(Fault::kLocalError); }, has(Fault::kLocalError)},
    {"FaultWithExternalReaction",
     [](DriveRig& rig) { rig.drive.raise(Fault::kLocalError); },
     [](const DriveRig& rig) { return rig.drive.state() == PowerState::kFault; },
     kCyclicPosition,
     {{0x605E, 0, 0xFFFE, 2}, {0x209A, 0, 10, 4}}},
    {"CauseOfAFault", sets(MachineInput::kRam, 0.0), has(Fault::kInternalRam)},
    {"EncoderCable", sets(MachineInput::kEncoderCable, 0.0), has(Fault::kEncoder)},
    {"ShortCircuit", sets(MachineInput::kMotorShort, 1.0), has(Fault::kOvercurrent)},
    {"DcLinkForced", [](DriveRig& rig) { rig.drive.set_dc_link(false); }, has(Fault::kDcLinkUndervoltage)},
    {"DcLinkEmpty",
     [](DriveRig& rig) { rig.drive.set_machine_input(MachineInput::kMains, 0.0); },
     has(Fault::kDcLinkUndervoltage),
     kCyclicPosition,
     {real_value(0x22BD, 12, 559.0F)}},
    {"BlockedAxis",
     sets(MachineInput::kAxisBlocked, 1.0),
     has(Fault::kFollowingError),
     kCyclicPosition,
     {{0x6065, 0, 3000, 4}, {0x6066, 0, 1, 2}}},
    // Inputs.
    {"Enpo", sets(Input::kEnpo, false), not_enabled},
    {"SafeTorqueOff", sets(Input::kIsdsh, false),
     [](const DriveRig& rig) { return not_enabled(rig) && rig.drive.output(Output::kStoRelay); }},
    {"LimitSwitch", sets(Input::kIsd00, true), has(Fault::kPositiveLimitSwitch), kCyclicPosition, {{0x2065, 0, 5, 2}}},
    {"ScheduledInput", [](DriveRig& rig) { rig.drive.schedule_input(Input::kEnpo, false, rig.now + 90us); },
     not_enabled},
    // Touch probe: switched on, latching an edge, latching the index pulse.
    {"ProbeOn", writes({0x60B8, 0, 0x11, 2}),
     [](const DriveRig& rig) { return rig.drive.complete_values().get(kValue.touch_probe_status) == 1; }},
    {"ProbeEdge",
     sets(Input::kIsd05, true),
     [](const DriveRig& rig) { return rig.drive.complete_values().get(kValue.touch_probe_status) == 3; },
     kCyclicPosition,
     {{0x206A, 0, 15, 2}, {0x60B8, 0, 0x11, 2}}},
    // Outputs by 60FEh in every control cycle, by SDO.
    {"Outputs", writes({0x60FE, 1, 0x10000, 4}), output_on, kCyclicPosition, {{0x207A, 0, 40, 2}}},
    {"BrakeByBus",
     writes({0x60FE, 1, 0, 4}),
     [](const DriveRig& rig) { return !rig.drive.output(Output::kBrake); },
     kCyclicPosition,
     {{0x207D, 0, 40, 2}, {0x60FE, 1, 0x400000, 4}}},
    {"Restart", [](DriveRig& rig) { rig.restart(); }, not_enabled},
};

class MsdQuiet : public testing::TestWithParam<Disturbance> {};

TEST_P(MsdQuiet, ADisturbanceActsInTheSameControlCycle) {
  for (const int half_cycles : {0, 1}) {
    Twins twins(GetParam().settings, GetParam().mode);
    if (half_cycles != 0) {
      twins.both([](DriveRig& rig) { rig.pass(kControlCycle); });
      ASSERT_EQ(twins.run(20), -1);
    }
    ASSERT_TRUE(twins.quick.drive.quiet());
    ASSERT_EQ(twins.quick.drive.state(), PowerState::kOperationEnabled);
    ASSERT_FALSE(GetParam().acted(twins.quick));
    twins.both(GetParam().act);
    EXPECT_EQ(twins.run(600), -1);
    EXPECT_TRUE(GetParam().acted(twins.quick));
    EXPECT_TRUE(GetParam().acted(twins.thorough));
  }
}

INSTANTIATE_TEST_SUITE_P(Disturbances, MsdQuiet, testing::ValuesIn(kDisturbances),
                         [](const auto& test) { return std::string(test.param.name); });

/// What a drive needs in every control cycle.
struct Demand {
  const char* name;
  std::vector<ObjectValue> settings;
  std::int8_t mode = kCyclicPosition;
};
std::ostream& operator<<(std::ostream& out, const Demand& demand) {
  return out << demand.name;
}

class MsdNeverQuiet : public testing::TestWithParam<Demand> {};

TEST_P(MsdNeverQuiet, LeavesOutNothing) {
  Twins twins(GetParam().settings, GetParam().mode);
  for (int i = 0; i < 200; ++i) {
    EXPECT_EQ(twins.run(1), -1);
    EXPECT_FALSE(twins.quick.drive.quiet());
  }
}

INSTANTIATE_TEST_SUITE_P(Demands, MsdNeverQuiet,
                         testing::Values(Demand{"OutputThatShowsTheLimit", {{0x207A, 0, 14, 2}}},
                                         Demand{"OutputOfTheBusEachMillisecond", {{0x207A, 0, 39, 2}}},
                                         Demand{"ProbeOfAManufacturer", {{0x28ED, 0, 2, 2}}},
                                         Demand{"ProfilePosition", {}, 1}, Demand{"ProfileVelocity", {}, 3},
                                         Demand{"Velocity", {}, 2}, Demand{"Homing", {}, 6}, Demand{"NoMode", {}, 0}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(MsdQuietCycles, OnlyAnEnabledDriveIsQuiet) {
  OperatingRig rig;
  rig.mode = kCyclicPosition;
  for (const std::uint16_t word : {std::uint16_t{0x00}, std::uint16_t{0x06}, std::uint16_t{0x07}}) {
    rig.command(word, 4);
    EXPECT_FALSE(rig.drive.quiet()) << word;
  }
  rig.command(kEnabled, 4);
  EXPECT_TRUE(rig.drive.quiet());
}

/// The setpoints are followed when P 213 has passed; until then nothing may be left out.
TEST(MsdQuietCycles, NotBeforeTheBrakeIsOpen) {
  MsdParameters parameters;
  parameters.motor.brake_torque_nm = 5.0;
  DriveRig rig(parameters);
  rig.set({real_value(0x20D5, 0, 30.0F)});
  rig.operate();
  rig.enable(kCyclicPosition);
  for (int i = 0; i < 160; ++i) {  // 20 ms
    rig.cycle();
    ASSERT_FALSE(rig.drive.quiet());
  }
  rig.cycles(160);
  EXPECT_TRUE(rig.drive.quiet());
}

/// The brake closes in P 214 when the output that it is connected to is switched off by the bus.
TEST(MsdQuietCycles, TheBrakeClosesInItsTime) {
  Twins twins({{0x207D, 0, 40, 2}, {0x60FE, 1, 0x400000, 4}, real_value(0x20D6, 0, 5.0F)}, kCyclicPosition);
  ASSERT_TRUE(twins.quick.drive.quiet());
  const std::int32_t error = twins.quick.following_error;
  twins.both(writes({0x60FE, 1, 0, 4}));
  EXPECT_EQ(twins.run(32), -1);
  EXPECT_LT(std::abs(twins.quick.following_error - error), 200) << "4 ms: still open";
  EXPECT_EQ(twins.run(32), -1);
  EXPECT_GT(twins.quick.following_error, 5000) << "8 ms: closed";
}

/// Commands that only process data bring: 60B8h and 60FEh:01 in the fourth RxPDO.
TEST(MsdQuietCycles, ObjectsInTheProcessDataAct) {
  OperatingRig rig;
  ASSERT_EQ(rig.to(AlState::kOp, AlState::kPreOp), AlStatusCode::kNoError);
  ASSERT_EQ(rig.write(0x207A, 0, 40, 2), 0U);
  rig.map(0x1603, {0x60FE0120, 0x60B80010});
  ASSERT_EQ(rig.to(AlState::kPreOp, AlState::kSafeOp), AlStatusCode::kNoError);
  ASSERT_EQ(rig.to(AlState::kSafeOp, AlState::kOp), AlStatusCode::kNoError);
  std::array<std::byte, 26> out{};
  const std::span bytes(out);
  const auto cycle = [&] {
    rig.device.write_outputs(2, out);
    rig.pass(125us);
  };
  bytes::store_le(bytes.subspan(2), kCyclicPosition);
  for (const std::uint16_t word : {std::uint16_t{0x06}, std::uint16_t{0x07}, kEnabled}) {
    bytes::store_le(bytes, word);
    for (int i = 0; i < 4; ++i) cycle();
  }
  ASSERT_TRUE(rig.drive.quiet());
  bytes::store_le(bytes.subspan(20), std::uint32_t{0x10000});
  cycle();
  EXPECT_TRUE(output_on(rig));
  cycle();
  ASSERT_TRUE(rig.drive.quiet());
  bytes::store_le(bytes.subspan(24), std::uint16_t{0x11});
  cycle();
  EXPECT_EQ(rig.drive.complete_values().get(kValue.touch_probe_status), 1);
}

/// The encoder's index pulse is latched in a quiet cycle.
TEST(MsdQuietCycles, TheIndexPulseIsLatched) {
  Twins twins({{0x60B8, 0, 0x15, 2}}, kCyclicPosition);
  ASSERT_TRUE(twins.quick.drive.quiet());
  EXPECT_EQ(twins.run(3000), -1);  // more than a revolution
  EXPECT_EQ(twins.quick.drive.complete_values().get(kValue.touch_probe_status), 3);
}

/// Target reached, following error, standstill and warnings need no order.
TEST(MsdQuietCycles, TheStatusWordIsWatched) {
  Twins twins({{0x6067, 0, 100, 4}}, kCyclicPosition);
  ASSERT_TRUE(twins.quick.drive.quiet());
  unsigned seen = 0;
  unsigned missing = 0;
  for (int i = 0; i < 400; ++i) {
    if (i >= 100) twins.both([](DriveRig& rig) { rig.target_position -= kStepIncrements; });  // stands
    if (i == 300) twins.both([](DriveRig& rig) { rig.drive.heat(1.04, 1000s); });
    EXPECT_EQ(twins.run(1), -1);
    EXPECT_TRUE(twins.quick.drive.quiet());
    seen |= twins.quick.status;
    missing |= ~twins.quick.status;
  }
  EXPECT_EQ(seen & missing & (status_word::kTargetReached | status_word::kStandstill),
            status_word::kTargetReached | status_word::kStandstill);
}

}  // namespace
}  // namespace driveline::slaves::msd
