// The state machine of the profile SERCOS by bits 15 and 14 of S-0-0134, one row per transition.
#include "driveline/slaves/msd/core/sercos/sercos_states.hpp"

#include <gmock/gmock.h>

#include <string_view>
#include <vector>

#include "driveline/slaves/msd/core/sercos/sercos_words.hpp"

namespace driveline::slaves::msd::states_test {
namespace {

using namespace std::chrono_literals;
using enum PowerState;
using enum MotionCommand;
using Control = SercosStates::Control;

constexpr std::uint16_t kEnable = 0x4000;
constexpr std::uint16_t kOn = 0xC000;     ///< with enable
constexpr std::uint16_t kAlone = 0x8000;  ///< bit 15 without bit 14
constexpr std::uint16_t kStart = 0x2000;

/// Conditions in which a drive stays ready.
SercosStates::Conditions with(std::uint16_t word) {
  SercosStates::Conditions conditions;
  conditions.control_word = word;
  conditions.power_ready = true;
  return conditions;
}

/// A drive in state 5.
SercosStates running(const OptionCodes& options = {}) {
  SercosStates states;
  for (const std::uint16_t word : {std::uint16_t{0}, kEnable, kOn, kOn}) {
    auto conditions = with(word);
    conditions.options = options;
    states.step(conditions, 125us);
  }
  EXPECT_EQ(states.state(), kOperationEnabled);
  return states;
}

struct Step {
  std::string_view what;
  std::vector<std::uint16_t> words;  ///< one per cycle after power-on
  Control control;
  PowerState state;
  MotionCommand command;
};

TEST(SercosStates, SwitchOnByBits14And15) {
  const std::vector<Step> steps{
      {"after the start", {0}, Control::kEdge, kSwitchOnDisabled, kOff},
      {"2 to 3 by bit 14", {0, kEnable}, Control::kEdge, kReadyToSwitchOn, kOff},
      {"not by bit 15", {0, kAlone}, Control::kEdge, kSwitchOnDisabled, kOff},
      {"not by bit 13", {0, kStart}, Control::kLevel, kSwitchOnDisabled, kOff},
      {"3 to 4 by the rise of bit 15", {0, kEnable, kOn}, Control::kEdge, kSwitchedOn, kFollow},
      {"4 to 5 by itself", {0, kEnable, kOn, kOn}, Control::kEdge, kOperationEnabled, kFollow},
      {"both bits at once: no edge in state 3", {0, kOn, kOn, kOn}, Control::kEdge, kReadyToSwitchOn, kOff},
      {"both bits at once by level", {0, kOn, kOn, kOn}, Control::kLevel, kOperationEnabled, kFollow},
      {"bit 15 before bit 14", {0, kAlone, kOn, kOn}, Control::kEdge, kReadyToSwitchOn, kOff},
      {"bit 15 before bit 14, by level", {0, kAlone, kOn, kOn}, Control::kLevel, kSwitchedOn, kFollow},
      {"a second edge", {0, kOn, kEnable, kOn}, Control::kEdge, kSwitchedOn, kFollow},
      {"3 to 2", {0, kEnable, 0}, Control::kEdge, kSwitchOnDisabled, kOff},
      {"4 to 2 without bit 14", {0, kEnable, kOn, kAlone}, Control::kEdge, kSwitchOnDisabled, kOff},
      {"4 to 3 without bit 15", {0, kEnable, kOn, kEnable}, Control::kEdge, kReadyToSwitchOn, kOff},
      {"5 to 2 without bit 14, whatever bit 15",
       {0, kEnable, kOn, kOn, kAlone},
       Control::kLevel,
       kSwitchOnDisabled,
       kOff},
      {"bit 13 does not matter to the state",
       {0, kEnable, kOn, kOn, kOn | kStart},
       Control::kEdge,
       kOperationEnabled,
       kFollow},
  };
  for (const auto& [what, words, control, state, command] : steps) {
    SCOPED_TRACE(what);
    SercosStates states;
    for (const auto word : words) {
      auto conditions = with(word);
      conditions.control = control;
      states.step(conditions, 125us);
    }
    EXPECT_EQ(states.state(), state);
    EXPECT_EQ(states.command(), command);
  }
}

TEST(SercosStates, TheHardwareEndsEveryStateAtOnce) {
  for (const std::uint16_t word : {kEnable, kOn}) {
    auto states = running();
    auto conditions = with(word);
    states.step(conditions, 125us);
    conditions.power_ready = false;
    states.step(conditions, 125us);
    EXPECT_EQ(states.state(), kSwitchOnDisabled);
    EXPECT_EQ(states.command(), kOff);
  }
}

TEST(SercosStates, State4LastsUntilTheAxisIsInPlace) {
  SercosStates states;
  for (const std::uint16_t word : {std::uint16_t{0}, kEnable, kOn}) states.step(with(word), 125us);
  auto waiting = with(kOn);
  waiting.in_place = false;
  for (int i = 0; i < 1000; ++i) states.step(waiting, 125us);
  EXPECT_EQ(states.state(), kSwitchedOn);
  EXPECT_EQ(states.command(), kFollow);
  EXPECT_FALSE(states.in_control());
  states.step(with(kOn), 125us);
  EXPECT_EQ(states.state(), kOperationEnabled);
  EXPECT_TRUE(states.in_control());
}

struct Stop {
  std::int16_t shutdown;
  std::int16_t quick_stop;
  MotionCommand command;
};

TEST(SercosStates, Bit15StopsByP2219) {
  const std::vector<Stop> stops{{0, 2, kOff},           {1, 2, kSlowDownRamp},   {-1, 0, kOff},
                                {-1, 1, kSlowDownRamp}, {-1, 2, kQuickStopRamp}, {-1, 3, kTorqueLimit}};
  for (const auto& [shutdown, quick_stop, command] : stops) {
    SCOPED_TRACE(testing::Message() << shutdown << ' ' << quick_stop);
    OptionCodes options;
    options.shutdown = shutdown;
    options.quick_stop = quick_stop;
    auto states = running(options);
    auto conditions = with(kEnable);
    conditions.options = options;
    states.step(conditions, 125us);
    EXPECT_EQ(states.command(), command);
    EXPECT_EQ(states.state(), command == kOff ? kReadyToSwitchOn : kOperationEnabled);
    EXPECT_EQ(states.powers_off_at_standstill(), command != kOff);
    conditions.control_word = kOn;  // too late: the stop ends first
    states.step(conditions, 125us);
    conditions.control_word = kEnable;
    EXPECT_EQ(states.command(), command == kOff ? kFollow : command);
    if (command == kOff) continue;
    conditions.standstill = true;
    states.step(conditions, 125us);
    EXPECT_EQ(states.state(), kReadyToSwitchOn);
    EXPECT_EQ(states.command(), kOff);
  }
}

TEST(SercosStates, FaultsReactByP2222) {
  const std::vector<Stop> reactions{{0, 0, kOff}, {0, 1, kSlowDownRamp}, {0, 2, kQuickStopRamp}, {0, 4, kTorqueLimit}};
  for (const auto& reaction : reactions) {
    OptionCodes options;
    options.fault_reaction = reaction.quick_stop;
    for (const bool coast : {false, true}) {
      auto states = running();
      states.fault(options, coast);
      EXPECT_EQ(states.state(), kFaultReactionActive);
      EXPECT_EQ(states.command(), coast ? kOff : reaction.command);
      EXPECT_FALSE(states.acknowledge());
      auto conditions = with(kOn);
      conditions.standstill = true;
      states.step(conditions, 125us);
      EXPECT_EQ(states.state(), kFault);
      states.step(with(0), 125us);
      EXPECT_EQ(states.state(), kFault) << "left by the command alone";
      EXPECT_TRUE(states.acknowledge());
      EXPECT_EQ(states.state(), kSwitchOnDisabled);
    }
  }
}

TEST(SercosStates, TheMasterStopsTheAxisInTime) {
  for (const auto& [option, standstill, cycles] : std::vector<std::tuple<std::int16_t, bool, int>>{
           {std::int16_t{-2}, true, 24}, {std::int16_t{-1}, true, 1}, {std::int16_t{-1}, false, 24}}) {
    auto states = running();
    OptionCodes options;
    options.fault_reaction = option;
    options.external_reaction_time = 3ms;
    states.fault(options, false);
    EXPECT_EQ(states.command(), kFollow);
    auto conditions = with(kOn);
    conditions.standstill = standstill;
    int passed = 0;
    for (; states.state() == kFaultReactionActive; ++passed) states.step(conditions, 125us);
    EXPECT_EQ(passed, cycles) << option;
  }
}

TEST(SercosStates, AFaultOfADriveWithoutTorqueHasNoReaction) {
  SercosStates states;
  states.step(with(0), 125us);
  states.fault({}, false);
  EXPECT_EQ(states.command(), kOff);
  states.step(with(0), 125us);
  EXPECT_EQ(states.state(), kFault);
}

struct Shown {
  PowerState state;
  bool dc_link;
  std::uint16_t word;
};

/// Table 4.3 of the manual.
TEST(SercosWords, StatesAreShownInBits15To13) {
  const std::vector<Shown> rows{
      {kNotReadyToSwitchOn, true, 0x0000}, {kSwitchOnDisabled, false, 0x4000},   {kSwitchOnDisabled, true, 0x8000},
      {kReadyToSwitchOn, true, 0x8000},    {kSwitchedOn, true, 0x8000},          {kOperationEnabled, true, 0xC000},
      {kQuickStopActive, true, 0xC000},    {kFaultReactionActive, true, 0xE000}, {kFault, true, 0x2000}};
  for (const auto& [state, dc_link, word] : rows) {
    EXPECT_EQ(drive_status::of(state, dc_link), word) << static_cast<int>(state);
  }
}

TEST(SercosWords, Bits11And9And8ChooseTheMode) {
  constexpr std::uint16_t kOthers = 0xF4FF;  // bits that do not matter, 10 and 12 among them
  for (unsigned choice = 0; choice < 8; ++choice) {
    const auto word = static_cast<std::uint16_t>((choice & 4U) << 9U | (choice & 3U) << 8U);
    const auto expected = choice < 4 ? std::optional<std::uint8_t>(static_cast<std::uint8_t>(choice)) : std::nullopt;
    EXPECT_EQ(master_control::mode(word), expected) << choice;
    EXPECT_EQ(master_control::mode(static_cast<std::uint16_t>(word | kOthers)), expected) << choice;
  }
}

}  // namespace
}  // namespace driveline::slaves::msd::states_test
