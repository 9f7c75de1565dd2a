#include "driveline/motion/cia402/cia402.hpp"

#include <gmock/gmock.h>

#include <map>

namespace driveline::motion::cia402 {
namespace {

constexpr std::array kAllStates = {AxisState::kNotReadyToSwitchOn,  AxisState::kSwitchOnDisabled,
                                   AxisState::kReadyToSwitchOn,     AxisState::kSwitchedOn,
                                   AxisState::kOperationEnabled,    AxisState::kQuickStopActive,
                                   AxisState::kFaultReactionActive, AxisState::kFault,
                                   AxisState::kUnavailable};

/// CiA 402-2, Table "State coding", as printed: most significant bit first.
struct Coding {
  std::string_view pattern;
  AxisState state;
};
constexpr std::array kCodings = {
    Coding{"xxxxxxxxx0xx0000", AxisState::kNotReadyToSwitchOn},
    Coding{"xxxxxxxxx1xx0000", AxisState::kSwitchOnDisabled},
    Coding{"xxxxxxxxx01x0001", AxisState::kReadyToSwitchOn},
    Coding{"xxxxxxxxx01x0011", AxisState::kSwitchedOn},
    Coding{"xxxxxxxxx01x0111", AxisState::kOperationEnabled},
    Coding{"xxxxxxxxx00x0111", AxisState::kQuickStopActive},
    Coding{"xxxxxxxxx0xx1111", AxisState::kFaultReactionActive},
    Coding{"xxxxxxxxx0xx1000", AxisState::kFault},
};

bool matches(std::string_view pattern, unsigned word) {
  for (unsigned bit = 0; bit < 16; ++bit) {
    const char wanted = pattern[15 - bit];
    if (wanted != 'x' && wanted != ((word >> bit & 1U) != 0 ? '1' : '0')) return false;
  }
  return true;
}

TEST(StatusWord, DecodesAsTheStandardCodesItForAll65536Words) {
  std::map<AxisState, unsigned> seen;
  for (unsigned word = 0; word <= 0xFFFF; ++word) {
    auto expected = AxisState::kUnavailable;
    for (const auto& coding : kCodings) {
      if (matches(coding.pattern, word)) expected = coding.state;
    }
    ASSERT_EQ(decode_state(static_cast<std::uint16_t>(word)), expected) << std::hex << word;
    ++seen[expected];
  }
  EXPECT_EQ(seen.size(), 9U);
}

/// Reaction of a drive to a control word (CiA 402-2, Table "Command coding", and the transitions of its state machine).
AxisState obey(AxisState state, unsigned word) {
  const bool disable_voltage = (word & 0x82U) == 0x00;
  const bool quick_stop = (word & 0x86U) == 0x02;
  const bool shutdown = (word & 0x87U) == 0x06;
  const bool switch_on = (word & 0x8FU) == 0x07;
  const bool enable = (word & 0x8FU) == 0x0F;
  switch (state) {
    case AxisState::kSwitchOnDisabled:
      return shutdown ? AxisState::kReadyToSwitchOn : state;
    case AxisState::kReadyToSwitchOn:
      if (disable_voltage || quick_stop) return AxisState::kSwitchOnDisabled;
      return switch_on || enable ? AxisState::kSwitchedOn : state;
    case AxisState::kSwitchedOn:
      if (disable_voltage || quick_stop) return AxisState::kSwitchOnDisabled;
      if (shutdown) return AxisState::kReadyToSwitchOn;
      return enable ? AxisState::kOperationEnabled : state;
    case AxisState::kOperationEnabled:
      if (disable_voltage) return AxisState::kSwitchOnDisabled;
      if (quick_stop) return AxisState::kQuickStopActive;
      if (shutdown) return AxisState::kReadyToSwitchOn;
      return switch_on ? AxisState::kSwitchedOn : state;
    case AxisState::kQuickStopActive:
      return disable_voltage ? AxisState::kSwitchOnDisabled : state;
    default:
      return state;
  }
}

std::vector<AxisState> way(AxisState from, Goal goal) {
  std::vector<AxisState> states;
  for (int step = 0; step < 10; ++step) {
    const auto next = obey(from, next_control_word(from, goal));
    if (next == from) break;
    states.push_back(next);
    from = next;
  }
  return states;
}

TEST(ControlWord, LeadsThroughEveryStateUp) {
  using S = AxisState;
  EXPECT_THAT(way(S::kSwitchOnDisabled, Goal::kEnabled),
              testing::ElementsAre(S::kReadyToSwitchOn, S::kSwitchedOn, S::kOperationEnabled));
  EXPECT_THAT(way(S::kQuickStopActive, Goal::kEnabled),
              testing::ElementsAre(S::kSwitchOnDisabled, S::kReadyToSwitchOn, S::kSwitchedOn, S::kOperationEnabled));
  EXPECT_THAT(way(S::kOperationEnabled, Goal::kEnabled), testing::IsEmpty());
}

TEST(ControlWord, LeadsThroughEveryStateDown) {
  using S = AxisState;
  EXPECT_THAT(way(S::kOperationEnabled, Goal::kDisabled),
              testing::ElementsAre(S::kSwitchedOn, S::kReadyToSwitchOn, S::kSwitchOnDisabled));
  EXPECT_THAT(way(S::kSwitchOnDisabled, Goal::kDisabled), testing::IsEmpty());
}

TEST(ControlWord, LeavesTheQuickStopToTheDrive) {
  using S = AxisState;
  EXPECT_THAT(way(S::kOperationEnabled, Goal::kQuickStop), testing::ElementsAre(S::kQuickStopActive));
  EXPECT_THAT(way(S::kSwitchedOn, Goal::kQuickStop), testing::ElementsAre(S::kSwitchOnDisabled));
  EXPECT_THAT(way(S::kReadyToSwitchOn, Goal::kQuickStop), testing::ElementsAre(S::kSwitchOnDisabled));
}

TEST(ControlWord, OfAllStatesAndGoals) {
  struct Row {
    AxisState state;
    unsigned enabled, disabled, quick_stop;
  };
  const Row rows[] = {
      {AxisState::kNotReadyToSwitchOn, 0x00, 0x00, 0x00},  {AxisState::kSwitchOnDisabled, 0x06, 0x00, 0x00},
      {AxisState::kReadyToSwitchOn, 0x07, 0x00, 0x00},     {AxisState::kSwitchedOn, 0x0F, 0x06, 0x00},
      {AxisState::kOperationEnabled, 0x0F, 0x07, 0x02},    {AxisState::kQuickStopActive, 0x00, 0x00, 0x02},
      {AxisState::kFaultReactionActive, 0x00, 0x00, 0x00}, {AxisState::kFault, 0x00, 0x00, 0x00},
      {AxisState::kUnavailable, 0x00, 0x00, 0x02},
  };
  ASSERT_EQ(std::size(rows), kAllStates.size());
  for (const auto& row : rows) {
    EXPECT_EQ(next_control_word(row.state, Goal::kEnabled), row.enabled) << to_text(row.state);
    EXPECT_EQ(next_control_word(row.state, Goal::kDisabled), row.disabled) << to_text(row.state);
    EXPECT_EQ(next_control_word(row.state, Goal::kQuickStop), row.quick_stop) << to_text(row.state);
  }
}

TEST(ControlWord, NeverResetsAFaultUnasked) {
  for (const auto state : kAllStates) {
    for (const auto goal : {Goal::kEnabled, Goal::kDisabled, Goal::kQuickStop}) {
      EXPECT_EQ(next_control_word(state, goal) & 0x80, 0);
    }
  }
}

TEST(StateNames, AreThoseOfTheStandardAndAllDifferent) {
  std::map<std::string_view, int> names;
  for (const auto state : kAllStates) ++names[to_text(state)];
  EXPECT_EQ(names.size(), kAllStates.size());
  EXPECT_EQ(to_text(AxisState::kReadyToSwitchOn), "Ready to switch on");
}

}  // namespace
}  // namespace driveline::motion::cia402
