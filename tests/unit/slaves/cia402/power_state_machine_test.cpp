#include "driveline/slaves/cia402/power_state_machine.hpp"

#include <gmock/gmock.h>

#include <array>
#include <string_view>

namespace driveline::slaves {
namespace {

using namespace std::chrono_literals;
constexpr auto kDt = 125us;

constexpr std::array kStates = {PowerState::kNotReadyToSwitchOn,  PowerState::kSwitchOnDisabled,
                                PowerState::kReadyToSwitchOn,     PowerState::kSwitchedOn,
                                PowerState::kOperationEnabled,    PowerState::kQuickStopActive,
                                PowerState::kFaultReactionActive, PowerState::kFault};

/// Options with which every transition is immediate.
constexpr OptionCodes kImmediate{.quick_stop = 6, .shutdown = 0, .disable_operation = 0, .fault_reaction = 2};

struct Machine {
  PowerStateMachine machine;
  PowerStateMachine::Conditions conditions{.power_ready = true, .options = kImmediate};

  void word(std::uint16_t control_word, bool standstill = false) {
    conditions.control_word = control_word;
    conditions.standstill = standstill;
    machine.step(conditions, kDt);
  }
  void words(std::initializer_list<std::uint16_t> list) {
    for (const auto value : list) word(value);
  }
  void enable() { words({0x00, 0x06, 0x07, 0x0F}); }
};

Machine in_state(PowerState state) {
  Machine m;
  switch (state) {
    case PowerState::kNotReadyToSwitchOn:
      break;
    case PowerState::kSwitchOnDisabled:
      m.word(0x00);
      break;
    case PowerState::kReadyToSwitchOn:
      m.words({0x00, 0x06});
      break;
    case PowerState::kSwitchedOn:
      m.words({0x00, 0x06, 0x07});
      break;
    case PowerState::kOperationEnabled:
      m.enable();
      break;
    case PowerState::kQuickStopActive:
      m.enable();
      m.word(0x02);
      break;
    case PowerState::kFaultReactionActive:
      m.enable();
      m.machine.fault(kImmediate, false);
      break;
    case PowerState::kFault:
      m.enable();
      m.machine.fault(kImmediate, true);
      m.word(0x0F);
      break;
  }
  EXPECT_EQ(m.machine.state(), state);
  return m;
}

/// MSD manual Table 11.4 (bits 7, 3, 2, 1, 0; x: irrelevant) with the transitions of 10.1.3, by state. Words that match
/// no row do not change the state.
struct Row {
  PowerState from;
  std::string_view bits;
  PowerState to;
};
constexpr std::array kTable = {
    Row{PowerState::kSwitchOnDisabled, "0x110", PowerState::kReadyToSwitchOn},   // 2
    Row{PowerState::kReadyToSwitchOn, "00111", PowerState::kSwitchedOn},         // 3
    Row{PowerState::kReadyToSwitchOn, "01111", PowerState::kSwitchedOn},         // 3
    Row{PowerState::kSwitchedOn, "01111", PowerState::kOperationEnabled},        // 4
    Row{PowerState::kOperationEnabled, "00111", PowerState::kSwitchedOn},        // 5
    Row{PowerState::kSwitchedOn, "0x110", PowerState::kReadyToSwitchOn},         // 6
    Row{PowerState::kReadyToSwitchOn, "0xx0x", PowerState::kSwitchOnDisabled},   // 7
    Row{PowerState::kReadyToSwitchOn, "0x01x", PowerState::kSwitchOnDisabled},   // 7
    Row{PowerState::kOperationEnabled, "0x110", PowerState::kReadyToSwitchOn},   // 8
    Row{PowerState::kOperationEnabled, "0xx0x", PowerState::kSwitchOnDisabled},  // 9
    Row{PowerState::kSwitchedOn, "0xx0x", PowerState::kSwitchOnDisabled},        // 10
    Row{PowerState::kSwitchedOn, "0x01x", PowerState::kSwitchOnDisabled},        // 10
    Row{PowerState::kOperationEnabled, "0x01x", PowerState::kQuickStopActive},   // 11
    Row{PowerState::kQuickStopActive, "0xx0x", PowerState::kSwitchOnDisabled},   // 12
    Row{PowerState::kQuickStopActive, "01111", PowerState::kOperationEnabled},   // 16, quick stop code 6
};

bool matches(std::string_view bits, std::uint16_t word) {
  constexpr std::array kBits = {7, 3, 2, 1, 0};
  for (std::size_t i = 0; i < kBits.size(); ++i) {
    const char bit = ((word >> kBits[i]) & 1) != 0 ? '1' : '0';
    if (bits[i] != 'x' && bits[i] != bit) return false;
  }
  return true;
}

PowerState expected(PowerState from, std::uint16_t word) {
  if (from == PowerState::kNotReadyToSwitchOn) return PowerState::kSwitchOnDisabled;  // 1, automatic
  for (const auto& row : kTable) {
    if (row.from == from && matches(row.bits, word)) return row.to;
  }
  return from;
}

TEST(PowerStateMachine, EveryControlWordInEveryStateFollowsTheManual) {
  for (const auto state : kStates) {
    for (unsigned word = 0; word < 0x10000; word += word < 0x200 ? 1 : 0x7F) {
      Machine m = in_state(state);
      m.word(static_cast<std::uint16_t>(word));
      ASSERT_EQ(m.machine.state(), expected(state, static_cast<std::uint16_t>(word)))
          << "state " << static_cast<int>(state) << " control word " << std::hex << word;
    }
  }
}

TEST(PowerStateMachine, NothingRunsWithoutPowerReady) {
  for (const auto state : {PowerState::kReadyToSwitchOn, PowerState::kSwitchedOn, PowerState::kOperationEnabled,
                           PowerState::kQuickStopActive}) {
    Machine m = in_state(state);
    m.conditions.power_ready = false;
    m.word(0x0F);
    EXPECT_EQ(m.machine.state(), PowerState::kSwitchOnDisabled);
    EXPECT_FALSE(m.machine.power_on());
    m.word(0x06);
    EXPECT_EQ(m.machine.state(), PowerState::kSwitchOnDisabled);
  }
}

TEST(PowerStateMachine, EnableOperationFromReadyPassesSwitchedOn) {
  Machine m = in_state(PowerState::kReadyToSwitchOn);
  m.word(0x0F);
  EXPECT_EQ(m.machine.state(), PowerState::kSwitchedOn);
  m.word(0x0F);
  EXPECT_EQ(m.machine.state(), PowerState::kOperationEnabled);
}

TEST(PowerStateMachine, PowersTheMotorOnlyFromOperationEnabled) {
  for (const auto state : kStates) {
    const bool powered = state == PowerState::kOperationEnabled || state == PowerState::kQuickStopActive ||
                         state == PowerState::kFaultReactionActive;
    EXPECT_EQ(in_state(state).machine.power_on(), powered) << static_cast<int>(state);
  }
}

struct QuickStopCase {
  std::int16_t code;
  MotionCommand motion;
  bool stays;
};

TEST(PowerStateMachine, QuickStopOptionCodes) {
  constexpr std::array kCases = {
      QuickStopCase{1, MotionCommand::kSlowDownRamp, false}, QuickStopCase{2, MotionCommand::kQuickStopRamp, false},
      QuickStopCase{3, MotionCommand::kTorqueLimit, false},  QuickStopCase{4, MotionCommand::kTorqueLimit, false},
      QuickStopCase{5, MotionCommand::kSlowDownRamp, true},  QuickStopCase{6, MotionCommand::kQuickStopRamp, true},
      QuickStopCase{7, MotionCommand::kTorqueLimit, true},   QuickStopCase{8, MotionCommand::kTorqueLimit, true}};
  for (const auto& c : kCases) {
    Machine m;
    m.conditions.options.quick_stop = c.code;
    m.enable();
    m.word(0x02);
    EXPECT_EQ(m.machine.state(), PowerState::kQuickStopActive) << c.code;
    EXPECT_EQ(m.machine.motion(), c.motion) << c.code;
    m.word(0x02, false);
    EXPECT_FALSE(m.machine.quick_stop_finished()) << c.code;
    m.word(0x02, true);
    EXPECT_EQ(m.machine.state(), c.stays ? PowerState::kQuickStopActive : PowerState::kSwitchOnDisabled) << c.code;
    EXPECT_EQ(m.machine.quick_stop_finished(), c.stays) << c.code;
    EXPECT_EQ(m.machine.power_on(), c.stays) << c.code;
    m.word(0x0F);
    EXPECT_EQ(m.machine.state(), c.stays ? PowerState::kOperationEnabled : PowerState::kSwitchOnDisabled) << c.code;
  }
}

TEST(PowerStateMachine, QuickStopCodeZeroSwitchesOffAtOnce) {
  Machine m;
  m.conditions.options.quick_stop = 0;
  m.enable();
  m.word(0x02);
  EXPECT_FALSE(m.machine.power_on());
  m.word(0x02);
  EXPECT_EQ(m.machine.state(), PowerState::kSwitchOnDisabled);
}

TEST(PowerStateMachine, ALeavingQuickStopCannotBeCalledBack) {
  Machine m;
  m.conditions.options.quick_stop = 2;
  m.enable();
  m.words({0x02, 0x0F});
  EXPECT_EQ(m.machine.state(), PowerState::kQuickStopActive);
  m.word(0x0F, true);
  EXPECT_EQ(m.machine.state(), PowerState::kSwitchOnDisabled);
}

TEST(PowerStateMachine, DisableOperationWithRampEndsInSwitchedOn) {
  Machine m;
  m.conditions.options.disable_operation = 1;
  m.enable();
  m.word(0x07);
  EXPECT_EQ(m.machine.state(), PowerState::kOperationEnabled);
  EXPECT_EQ(m.machine.motion(), MotionCommand::kSlowDownRamp);
  m.word(0x07, true);
  EXPECT_EQ(m.machine.state(), PowerState::kSwitchedOn);
  EXPECT_FALSE(m.machine.power_on());
}

TEST(PowerStateMachine, ShutdownOptionCodes) {
  const auto motion_after_shutdown = [](std::int16_t shutdown, std::int16_t quick_stop) {
    Machine m;
    m.conditions.options.shutdown = shutdown;
    m.conditions.options.quick_stop = quick_stop;
    m.enable();
    m.word(0x06);
    const auto motion = m.machine.motion();
    m.word(0x06, true);
    EXPECT_EQ(m.machine.state(), PowerState::kReadyToSwitchOn);
    return motion;
  };
  EXPECT_EQ(motion_after_shutdown(0, 2), MotionCommand::kOff);
  EXPECT_EQ(motion_after_shutdown(1, 2), MotionCommand::kSlowDownRamp);
  EXPECT_EQ(motion_after_shutdown(-1, 2), MotionCommand::kQuickStopRamp);
  EXPECT_EQ(motion_after_shutdown(-1, 7), MotionCommand::kTorqueLimit);
  EXPECT_EQ(motion_after_shutdown(-1, 0), MotionCommand::kOff);
}

TEST(PowerStateMachine, AStopInProgressYieldsToHarderCommands) {
  Machine m;
  m.conditions.options.disable_operation = 1;
  m.enable();
  m.words({0x07, 0x00});
  EXPECT_EQ(m.machine.state(), PowerState::kSwitchOnDisabled);
  EXPECT_FALSE(m.machine.power_on());

  Machine q;
  q.conditions.options.disable_operation = 1;
  q.enable();
  q.words({0x07, 0x02});
  EXPECT_EQ(q.machine.state(), PowerState::kQuickStopActive);
}

TEST(PowerStateMachine, FaultReactionOptionCodes) {
  const auto motion = [](std::int16_t code) {
    Machine m;
    m.enable();
    OptionCodes options = kImmediate;
    options.fault_reaction = code;
    options.external_reaction_time = 1ms;
    m.machine.fault(options, false);
    EXPECT_EQ(m.machine.state(), PowerState::kFaultReactionActive);
    return m.machine.motion();
  };
  EXPECT_EQ(motion(0), MotionCommand::kOff);
  EXPECT_EQ(motion(1), MotionCommand::kSlowDownRamp);
  EXPECT_EQ(motion(2), MotionCommand::kQuickStopRamp);
  EXPECT_EQ(motion(3), MotionCommand::kTorqueLimit);
  EXPECT_EQ(motion(4), MotionCommand::kTorqueLimit);
  EXPECT_EQ(motion(-1), MotionCommand::kFollow);
  EXPECT_EQ(motion(-2), MotionCommand::kFollow);
}

TEST(PowerStateMachine, ExternalFaultReactionEndsByTimeOrStandstill) {
  for (const std::int16_t code : {std::int16_t{-2}, std::int16_t{-1}}) {
    Machine m;
    m.enable();
    OptionCodes options = kImmediate;
    options.fault_reaction = code;
    options.external_reaction_time = 1ms;
    m.machine.fault(options, false);
    m.word(0x0F, true);  // standstill
    EXPECT_EQ(m.machine.state(), code == -1 ? PowerState::kFault : PowerState::kFaultReactionActive);
    for (int i = 1; i < 8; ++i) m.word(0x0F, false);
    EXPECT_EQ(m.machine.state(), PowerState::kFault);
  }
}

TEST(PowerStateMachine, FaultFromAnyStateEndsInFaultAndOnlyAcknowledgementLeavesIt) {
  for (const auto state : kStates) {
    Machine m = in_state(state);
    m.machine.fault(kImmediate, true);
    m.word(0x0F);
    ASSERT_EQ(m.machine.state(), PowerState::kFault);
    for (unsigned word = 0; word < 0x100; ++word) {
      m.word(static_cast<std::uint16_t>(word), true);
      ASSERT_EQ(m.machine.state(), PowerState::kFault);
    }
    EXPECT_TRUE(m.machine.acknowledge());
    EXPECT_EQ(m.machine.state(), PowerState::kSwitchOnDisabled);
    EXPECT_FALSE(m.machine.acknowledge());
  }
}

TEST(PowerStateMachine, ASecondFaultDoesNotSoftenTheReaction) {
  Machine m = in_state(PowerState::kFaultReactionActive);
  OptionCodes soft = kImmediate;
  soft.fault_reaction = -2;
  m.machine.fault(soft, false);
  EXPECT_EQ(m.machine.motion(), MotionCommand::kQuickStopRamp);
  m.machine.fault(soft, true);
  EXPECT_EQ(m.machine.motion(), MotionCommand::kOff);
}

TEST(PowerStateMachine, AFaultWithoutPowerHasNoReaction) {
  Machine m = in_state(PowerState::kSwitchedOn);
  m.machine.fault(kImmediate, false);
  EXPECT_FALSE(m.machine.power_on());
  m.word(0x07);
  EXPECT_EQ(m.machine.state(), PowerState::kFault);
}

/// MSD manual Table 11.8: bits 6, 5, 3, 2, 1, 0; x: irrelevant. Bit 4 is not part of the state.
TEST(StatusBits, AreThoseOfTheManual) {
  constexpr std::array<std::string_view, 8> kPatterns = {"0x0000", "1x0000", "010001", "010011",
                                                         "010111", "000111", "0x1111", "0x1000"};
  constexpr std::array kBits = {6, 5, 3, 2, 1, 0};
  for (std::size_t i = 0; i < kStates.size(); ++i) {
    const auto bits = status_bits(kStates[i]);
    for (std::size_t k = 0; k < kBits.size(); ++k) {
      if (kPatterns[i][k] == 'x') continue;
      EXPECT_EQ((bits >> kBits[k]) & 1, kPatterns[i][k] - '0') << "state " << i + 1 << " bit " << kBits[k];
    }
    EXPECT_EQ(bits & ~0x6F, 0);
  }
}

}  // namespace
}  // namespace driveline::slaves
