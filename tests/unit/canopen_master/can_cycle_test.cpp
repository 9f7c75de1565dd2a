#include "driveline/canopen_master/can_cycle.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "cycle_rig.hpp"
#include "driveline/canopen_wire/frame_bits.hpp"

namespace driveline::canopen {
namespace {

using cycle_test::axes_plan;
using cycle_test::CycleRig;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;
using namespace std::chrono_literals;
using std::chrono::nanoseconds;

/// Control word, mode and setpoint of both axes.
std::vector<std::byte> outputs(const std::string& hex) {
  return bytes_test::hex(hex);
}

const std::string kEnabled = "0F 00 07 E8 03 00 00  06 00 07 D0 07 00 00";

TEST(CanCycleTest, SyncComesFirstAndSetpointsFollowFromTheSecondPeriodOn) {
  CycleRig rig;
  rig.motion.outputs = outputs(kEnabled);
  EXPECT_THAT(rig.step(), ElementsAre("080#"));
  rig.both_answer();
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#E8030000", "304#D0070000", "203#0F0007", "204#060007"));
  ASSERT_EQ(rig.motion.calls.size(), 2U);
  EXPECT_EQ(rig.motion.calls[0].what, "read");
  // With the number of the SYNC that was answered, as on EtherCAT.
  EXPECT_EQ(rig.motion.calls[1].what, "update");
  EXPECT_EQ(rig.motion.calls[1].cycle, 0);
}

TEST(CanCycleTest, PreparedOutputsAreThoseOfTheAnswersThatCameInTime) {
  CycleRig rig;
  static_cast<void>(rig.step());
  rig.both_answer();
  rig.prepare(100us);
  EXPECT_EQ(rig.motion.calls.size(), 2U);
  EXPECT_EQ(rig.motion.inputs, bytes_test::hex("27 00 00 01 00 00 00 00 00  27 00 00 02 00 00 00 00 00"));
  EXPECT_THAT(rig.motion.valid, ElementsAre(true, true));
  EXPECT_EQ(rig.motion.last_took, 420us);
  static_cast<void>(rig.step());
  EXPECT_EQ(rig.motion.calls.size(), 2U);
}

// An answer may still come between the work before the grid instant and the next SYNC.
TEST(CanCycleTest, PreparationWaitsForAnAnswerUntilSync) {
  CycleRig rig;
  static_cast<void>(rig.step());
  rig.comes(300us, "183#270000010000");
  rig.comes(1950us, "184#270000020000");
  rig.prepare(100us);
  EXPECT_THAT(rig.motion.calls, IsEmpty());
  static_cast<void>(rig.step());
  EXPECT_THAT(rig.motion.valid, ElementsAre(true, true));
  EXPECT_EQ(rig.cycle.bad_cycles(), 0U);
}

struct AnswerRow {
  const char* what;
  std::vector<std::pair<nanoseconds, std::string>> frames;  ///< after the SYNC of period 1
  bool valid;                                               ///< axis 3 in period 1
  std::uint8_t position;                                    ///< third byte of its inputs after it
  std::uint64_t lost, wrong_length, stale, late;            ///< statistics after period 1
};

class CanCycleAnswers : public testing::TestWithParam<AnswerRow> {};

// Period 0 has no answer of axis 3, period 1 the frames of the row; axis 4 always answers.
TEST_P(CanCycleAnswers, AreJudgedBySync) {
  const auto& row = GetParam();
  CycleRig rig;
  static_cast<void>(rig.step());
  rig.comes(420us, "184#270000020000");
  static_cast<void>(rig.step());
  EXPECT_THAT(rig.motion.valid, ElementsAre(false, true));
  for (const auto& [after, frame] : row.frames) rig.comes(after, frame);
  rig.comes(1420us, "184#270000020000");
  static_cast<void>(rig.step());
  EXPECT_THAT(rig.motion.valid, ElementsAre(row.valid, true));
  EXPECT_EQ(std::to_integer<int>(rig.motion.inputs[2]), row.position);
  const auto& figures = rig.cycle.statistics();
  EXPECT_EQ(figures.lost_frames, 1 + row.lost);
  EXPECT_EQ(figures.wkc_errors, row.wrong_length);
  EXPECT_EQ(figures.stale_frames, row.stale);
  EXPECT_EQ(figures.late_frames, row.late);
  const auto report = rig.cycle.node_report(0);
  EXPECT_EQ(report.valid, row.valid);
  EXPECT_EQ(report.lost, 1 + row.lost);
  EXPECT_EQ(report.late, row.stale);
  EXPECT_EQ(report.wrong_length, row.wrong_length);
  EXPECT_EQ(report.short_pdo, row.wrong_length > 0 ? 1U : 0U);
  EXPECT_EQ(report.short_bytes, row.wrong_length > 0 ? 5U : 0U);
  EXPECT_EQ(report.mapped_bytes, row.wrong_length > 0 ? 6U : 0U);
  EXPECT_EQ(report.stale_cycles, row.valid ? 0U : 2U);
  EXPECT_EQ(rig.cycle.bad_cycles(), row.valid ? 0U : 2U);
}

// SYNC takes 47 us, and a frame of 6 bytes 92 us up to its last bit: before 139 us nothing can be an answer.
INSTANTIATE_TEST_SUITE_P(
    Frames, CanCycleAnswers,
    testing::Values(
        AnswerRow{"InTime", {{300us, "183#270000550000"}}, true, 0x00, 0, 0, 0, 0},
        AnswerRow{"Earliest", {{139us, "183#270055000000"}}, true, 0x55, 0, 0, 0, 0},
        AnswerRow{"OfThePeriodBefore", {{138us, "183#270055000000"}}, false, 0x00, 1, 0, 1, 1},
        AnswerRow{"LateAndFresh", {{100us, "183#270044000000"}, {300us, "183#270055000000"}}, true, 0x55, 0, 0, 1, 1},
        AnswerRow{"BothInABunch", {{300us, "183#270044000000"}, {301us, "183#270055000000"}}, true, 0x55, 0, 0, 1, 1},
        AnswerRow{"Longer", {{300us, "183#2700550000000708"}}, true, 0x55, 0, 0, 0, 0},
        AnswerRow{"Shorter", {{300us, "183#2700550000"}}, false, 0x00, 1, 1, 0, 0},
        AnswerRow{"Nothing", {}, false, 0x00, 1, 0, 0, 0},
        AnswerRow{"RemoteFrame", {{300us, "183#R"}}, false, 0x00, 1, 0, 0, 0},
        AnswerRow{"OtherFormat", {{300us, "00000183#270055000000"}}, false, 0x00, 1, 0, 0, 0}),
    [](const auto& row) { return row.param.what; });

// The thread was late after SYNC 1 had left: an answer to it is not taken for one to SYNC 0.
TEST(CanCycleTest, AnAnswerToTheNextSyncWaits) {
  CycleRig rig;
  static_cast<void>(rig.step());
  rig.comes(420us, "184#270000020000");
  // Cycle 1 sends SYNC at its instant; its first receive() sees what has come by then and until 200 us later.
  class Slow final : public CanPort {
   public:
    explicit Slow(CycleRig& rig) : rig_(rig) {}
    SendStatus send(const Frame& frame) noexcept override {
      const auto status = rig_.port.send(frame);
      if (frame.identifier.value == 0x080) rig_.clock.advance(200us);
      return status;
    }
    std::optional<ReceivedFrame> receive() noexcept override { return rig_.port.receive(); }
    bool wait_readable(nanoseconds deadline) noexcept override { return rig_.port.wait_readable(deadline); }
    PortStatistics statistics() const noexcept override { return rig_.port.statistics(); }

   private:
    CycleRig& rig_;
  };
  CycleRig other;
  Slow slow(other);
  const auto plan = axes_plan(1);
  CanCycle cycle(slow, other.clock, plan, *must(PdoImage::build(plan)), other.channel, &other.motion, {}, {});
  cycle.set_operational(0, true);
  const auto run = [&](std::int64_t number) {
    other.clock.sleep_until(other.grid(number));
    cycle.cycle({number, other.grid(number), other.clock.now(), 0});
  };
  run(0);
  other.port.arrives(other.grid(1) + 150us, "183#270055000000");
  run(1);
  EXPECT_THAT(other.motion.valid, ElementsAre(false));
  run(2);
  EXPECT_THAT(other.motion.valid, ElementsAre(true));
  EXPECT_EQ(std::to_integer<int>(other.motion.inputs[2]), 0x55);
}

TEST(CanCycleTest, OnChangePdosKeepTheirLastValue) {
  CycleRig rig;
  static_cast<void>(rig.step());
  rig.both_answer();
  rig.comes(1ms, "283#070130");
  static_cast<void>(rig.step());
  EXPECT_EQ(std::to_integer<int>(rig.motion.inputs[6]), 0x07);
  EXPECT_FALSE(rig.cycle.node_report(1).heard);
  EXPECT_TRUE(rig.cycle.node_report(0).heard);
  rig.both_answer();
  static_cast<void>(rig.step());
  EXPECT_EQ(std::to_integer<int>(rig.motion.inputs[6]), 0x07);
  EXPECT_THAT(rig.motion.valid, ElementsAre(true, true));
}

class CanCycleLengths : public testing::TestWithParam<std::size_t> {};

// RPDO 1 on change, RPDO 2 with SYNC, and TPDO 1, of as many bytes each.
TEST_P(CanCycleLengths, EveryBytePassesBothWays) {
  const auto length = GetParam();
  auto plan = axes_plan(1);
  std::vector<motion::MappedObject> objects;
  for (std::size_t i = 0; i < length; ++i) objects.push_back({0x2300, static_cast<std::uint8_t>(i + 1), 8});
  auto& node = plan.nodes[0];
  node.rpdos[0].objects = node.rpdos[1].objects = node.tpdos[0].objects = objects;
  node.tpdos.resize(1);
  CycleRig rig(plan);
  rig.motion.outputs.resize(2 * length);
  for (std::size_t i = 0; i < 2 * length; ++i) rig.motion.outputs[i] = static_cast<std::byte>(0x31 + i);
  const std::string bytes = "3132333435363738393A3B3C3D3E3F40";
  const auto first = bytes.substr(0, 2 * length);
  const auto second = bytes.substr(2 * length, 2 * length);
  static_cast<void>(rig.step());
  rig.comes(300us, "183#" + second);
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#" + second, "203#" + first));
  EXPECT_EQ(rig.motion.inputs, bytes_test::hex(second));
  // A change of any byte is a change.
  for (std::size_t i = 0; i < length; ++i) {
    rig.motion.outputs[i] = std::byte{0xA7};
    EXPECT_THAT(rig.step(), Contains(testing::StartsWith("203#"))) << "byte " << i;
    EXPECT_THAT(rig.step(), Not(Contains(testing::StartsWith("203#")))) << "byte " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Bytes, CanCycleLengths, testing::Range(std::size_t{1}, std::size_t{9}));

TEST(CanCycleTest, ControlWordsAreSentWhenTheyChangeAndAgain) {
  CycleRig rig;
  rig.motion.outputs = outputs(kEnabled);
  std::vector<std::string> sent;
  for (int i = 0; i < 120; ++i) {
    if (rig.number == 69) rig.motion.outputs[0] = std::byte{0x0B};
    const auto frames = rig.step();
    for (const auto& frame : frames) {
      if (frame.rfind("203#", 0) == 0) sent.push_back(std::to_string(rig.grid(rig.number) / 1ms) + " " + frame);
    }
    rig.both_answer();
  }
  // When there are outputs, when it changes, and at every 100 ms of the clock.
  EXPECT_THAT(sent, ElementsAre("12 203#0F0007", "100 203#0F0007", "150 203#0B0007", "200 203#0B0007"));
}

// At 2 ms an interval of 100 ms has 50 periods: one axis after the other, every 12.5 ms, and never two in a period.
TEST(CanCycleTest, RepeatedControlWordsOfManyAxesAreSpreadOverTheirInterval) {
  CycleRig rig(axes_plan(8));
  std::map<std::string, std::vector<std::int64_t>> sent;
  for (int i = 0; i < 300; ++i) {
    const auto frames = rig.step();
    std::vector<std::string> words;
    std::copy_if(frames.begin(), frames.end(), std::back_inserter(words), [](const auto& f) { return f[0] == '2'; });
    for (const auto& word : words) sent[word].push_back(rig.number);
    if (rig.number > 3) {
      ASSERT_LE(words.size(), 1U) << rig.number;
    }
  }
  ASSERT_EQ(sent.size(), 8U);
  std::set<std::int64_t> phases;
  for (const auto& [word, numbers] : sent) {
    ASSERT_GE(numbers.size(), 6U) << word;
    // At the start repetitions wait for control words that are sent for the first time.
    EXPECT_LE(numbers[1] - numbers[0], 50) << word;
    EXPECT_LE(numbers[2] - numbers[1], 50) << word;
    for (std::size_t k = 3; k < numbers.size(); ++k) EXPECT_EQ(numbers[k] - numbers[k - 1], 50) << word;
    phases.insert(numbers[2] % 50);
  }
  std::vector<std::int64_t> gaps;
  std::adjacent_difference(phases.begin(), phases.end(), std::back_inserter(gaps));
  EXPECT_THAT(std::vector(gaps.begin() + 1, gaps.end()), Each(AnyOf(6, 7)));
}

// The drives must hear the control word even if nothing is heard of them.
TEST(CanCycleTest, ControlWordsAreRepeatedWhateverElseFails) {
  CycleRig rig;
  rig.motion.outputs = outputs(kEnabled);
  rig.port.refusals[0x303] = SendStatus::kBusy;
  int sent = 0;
  for (int i = 0; i < 201; ++i) {
    const auto frames = rig.step(i % 7 == 0 ? 1900us : 0us);
    sent += static_cast<int>(std::count(frames.begin(), frames.end(), "203#0F0007"));
  }
  EXPECT_EQ(sent, 5);  // at 12 ms, and at 100 ms to 400 ms of the clock
}

// "New setpoint" of profile position must not come with its target: the drive applies both in its next cycle of 1 ms
// (MSD manual 8.1.1), in an order of its own.
TEST(CanCycleTest, ANewSetpointBitFollowsItsTarget) {
  auto plan = axes_plan(1);
  plan.nodes[0].rpdos.push_back(
      {.number = 3, .transmission = 255, .exchange = PdoExchange::kOnChange, .objects = {{0x607A, 0, 32}}});
  CycleRig rig(plan);
  rig.motion.outputs = outputs("0F 00 01 00 00 00 00 0A 00 00 00");
  for (int i = 0; i < 4; ++i) static_cast<void>(rig.step());
  rig.motion.outputs = outputs("1F 00 01 00 00 00 00 0B 00 00 00");
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#00000000", "403#0B000000"));
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#00000000", "203#1F0001"));
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#00000000"));
  // A target that changes in every period holds nothing up.
  rig.motion.outputs = outputs("0F 00 01 00 00 00 00 0C 00 00 00");
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#00000000", "403#0C000000"));
  rig.motion.outputs = outputs("0F 00 01 00 00 00 00 0D 00 00 00");
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#00000000", "403#0D000000", "203#0F0001"));
}

// 8 axes leave 265 bits, which are three control words of 3 bytes in the worst case.
TEST(CanCycleTest, ChangesOfManyAxesAreSpreadOverPeriods) {
  CycleRig rig(axes_plan(8));
  const auto control_words = [&] {
    const auto frames = rig.step();
    return std::count_if(frames.begin(), frames.end(), [](const auto& frame) { return frame[0] == '2'; });
  };
  EXPECT_EQ(control_words(), 0);
  EXPECT_EQ(control_words(), 3);
  EXPECT_EQ(control_words(), 3);
  EXPECT_EQ(control_words(), 3);  // two at the end, and a repetition at 12.5 ms of each 100 ms
  EXPECT_EQ(control_words(), 0);
}

TEST(CanCycleTest, FramesOfTheOwnerUseWhatIsLeftOfAPeriod) {
  CycleRig rig(axes_plan(8));
  AcyclicPort owner(rig.channel, rig.clock, rig.period);
  for (int i = 0; i < 5; ++i) static_cast<void>(rig.step());
  const auto request = *candump::parse_frame("603#4041600000000000");
  for (int i = 0; i < 3; ++i) ASSERT_EQ(owner.send(request), SendStatus::kSent);
  const auto requests = [&] {
    const auto frames = rig.step();
    return std::count(frames.begin(), frames.end(), "603#4041600000000000");
  };
  // One with its answer is all that fits.
  EXPECT_EQ(requests(), 1);
  EXPECT_EQ(requests(), 1);
  // A late period has no room for more than the one frame that always has it.
  EXPECT_EQ(requests(), 1);
}

// Nothing but SYNC on the bus: (2000 - 55) / (135 + 135) requests with their answers.
TEST(CanCycleTest, ALineThatIsNotOperationalLeavesTheBusToTheOwner) {
  CycleRig rig;
  rig.cycle.set_operational(0, false);
  rig.cycle.set_operational(1, false);
  AcyclicPort owner(rig.channel, rig.clock, rig.period);
  for (int i = 0; i < 16; ++i) ASSERT_EQ(owner.send(*candump::parse_frame("603#4041600000000000")), SendStatus::kSent);
  EXPECT_EQ(rig.step().size(), 1U + 7U);
  EXPECT_EQ(rig.step().size(), 1U + 7U);
  EXPECT_EQ(rig.step().size(), 1U + 2U);
  EXPECT_EQ(rig.cycle.bad_cycles(), 0U);
}

TEST(CanCycleTest, WhatIsNoProcessDataGoesToTheOwner) {
  CycleRig rig;
  AcyclicPort owner(rig.channel, rig.clock, rig.period);
  static_cast<void>(rig.step());
  rig.comes(100us, "703#05");
  rig.comes(200us, "185#1122");
  rig.both_answer();
  static_cast<void>(rig.step());
  EXPECT_EQ(cycle_test::text_of(owner.receive()->frame), "703#05");
  EXPECT_EQ(cycle_test::text_of(owner.receive()->frame), "185#1122");
  EXPECT_FALSE(owner.receive());
}

TEST(CanCycleTest, FramesThatOnlyThisMasterSendsAreForeign) {
  CycleRig rig;
  static_cast<void>(rig.step());
  rig.comes(100us, "080#");
  rig.comes(200us, "304#00000000");
  rig.both_answer();
  static_cast<void>(rig.step());
  EXPECT_EQ(rig.cycle.counters().foreign_frames, 2U);
  EXPECT_EQ(rig.cycle.statistics().foreign_frames, 2U);
  EXPECT_THAT(rig.motion.valid, ElementsAre(true, true));
}

// 50 ms of a period of 3 ms: never later than that.
TEST(CanCycleTest, TheHeartbeatOfTheMasterComesWithTheCycle) {
  auto plan = axes_plan(1);
  plan.period = 3ms;
  plan.master_id = 100;
  plan.master_heartbeat = 50ms;
  CycleRig rig(plan);
  std::vector<std::int64_t> sent;
  for (int i = 0; i < 51; ++i) {
    const auto frames = rig.step();
    if (std::count(frames.begin(), frames.end(), "764#05") > 0) sent.push_back(rig.number);
  }
  EXPECT_THAT(sent, ElementsAre(0, 16, 32, 48));
}

struct RefusalRow {
  const char* what;
  std::uint32_t identifier;
  SendStatus status;
  bool first_valid, second_valid;
  std::uint64_t syncs, rpdos, lost;
};

class CanCycleRefusals : public testing::TestWithParam<RefusalRow> {};

TEST_P(CanCycleRefusals, CostAPeriodItsValidityAndNothingElse) {
  const auto& row = GetParam();
  CycleRig rig;
  rig.motion.outputs = outputs(kEnabled);
  static_cast<void>(rig.step());
  rig.both_answer();
  rig.port.refusals[row.identifier] = row.status;
  static_cast<void>(rig.step());
  EXPECT_THAT(rig.motion.valid, ElementsAre(true, true));
  if (row.syncs == 0) rig.both_answer();
  rig.port.refusals.clear();
  const auto sent = rig.step();
  EXPECT_THAT(rig.motion.valid, ElementsAre(row.first_valid, row.second_valid));
  EXPECT_EQ(sent.front(), "080#");
  EXPECT_EQ(rig.cycle.counters().syncs_unsent, row.syncs);
  EXPECT_EQ(rig.cycle.counters().rpdos_unsent, row.rpdos);
  EXPECT_EQ(rig.cycle.statistics().lost_frames, row.lost);
  EXPECT_EQ(rig.cycle.bad_cycles(), row.first_valid && row.second_valid ? 0U : 1U);
  rig.both_answer();
  static_cast<void>(rig.step());
  EXPECT_THAT(rig.motion.valid, ElementsAre(true, true));
  EXPECT_EQ(rig.cycle.bad_cycles(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Frames, CanCycleRefusals,
                         testing::Values(RefusalRow{"Sync", 0x080, SendStatus::kBusy, false, false, 1, 0, 0},
                                         RefusalRow{"Setpoint", 0x303, SendStatus::kBusy, false, true, 0, 1, 0},
                                         RefusalRow{"SetpointDown", 0x304, SendStatus::kDown, true, false, 0, 1, 0},
                                         RefusalRow{"ControlWord", 0x203, SendStatus::kBusy, true, true, 0, 0, 0}),
                         [](const auto& row) { return row.param.what; });

TEST(CanCycleTest, AControlWordThatWasNotTakenIsSentInTheNextPeriod) {
  CycleRig rig;
  rig.motion.outputs = outputs(kEnabled);
  static_cast<void>(rig.step());
  rig.port.refusals[0x203] = SendStatus::kBusy;
  EXPECT_THAT(rig.step(), Not(Contains("203#0F0007")));
  rig.port.refusals.clear();
  EXPECT_THAT(rig.step(), Contains("203#0F0007"));
}

TEST(CanCycleTest, AFrameThatTheAdapterCannotCarryIsCountedAndLeftOut) {
  CycleRig rig;
  AcyclicPort owner(rig.channel, rig.clock, rig.period);
  rig.port.refusals[0x705] = SendStatus::kNotValid;
  ASSERT_EQ(owner.send(*candump::parse_frame("705#R")), SendStatus::kSent);
  ASSERT_EQ(owner.send(*candump::parse_frame("000#0103")), SendStatus::kSent);
  EXPECT_THAT(rig.step(), ElementsAre("080#", "000#0103"));
  EXPECT_EQ(rig.cycle.counters().acyclic_unsent, 1U);
}

// A node that is not operational gets nothing and is not missed.
TEST(CanCycleTest, OnlyNodesInUseTakePart) {
  CycleRig rig;
  rig.motion.outputs = outputs(kEnabled);
  rig.cycle.set_operational(0, false);
  static_cast<void>(rig.step());
  rig.comes(420us, "184#270000020000");
  EXPECT_THAT(rig.step(), ElementsAre("080#", "304#D0070000", "204#060007"));
  EXPECT_THAT(rig.motion.valid, ElementsAre(false, true));
  EXPECT_EQ(rig.cycle.bad_cycles(), 0U);
  EXPECT_EQ(rig.cycle.statistics().lost_frames, 0U);
  rig.cycle.set_operational(0, true);
  rig.comes(420us, "184#270000020000");
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#E8030000", "304#D0070000", "203#0F0007"));
  EXPECT_THAT(rig.motion.valid, ElementsAre(false, true));
  rig.both_answer();
  static_cast<void>(rig.step());
  EXPECT_THAT(rig.motion.valid, ElementsAre(true, true));
}

// Restarted between two cycles: its control word is sent although it has not changed.
TEST(CanCycleTest, ANodeThatComesBackGetsItsControlWord) {
  CycleRig rig;
  rig.motion.outputs = outputs(kEnabled);
  for (int i = 0; i < 4; ++i) static_cast<void>(rig.step());
  rig.cycle.set_operational(1, false);
  rig.cycle.set_operational(1, true);
  EXPECT_THAT(rig.step(), Contains("204#060007"));
  EXPECT_THAT(rig.step(), Not(Contains("204#060007")));
}

// With SYNC the drives would act on setpoints that have waited in them for three periods.
TEST(CanCycleTest, BehindMissedPeriodsSetpointsComeBeforeSync) {
  CycleRig rig;
  rig.motion.outputs = outputs(kEnabled);
  static_cast<void>(rig.step());
  rig.both_answer();
  static_cast<void>(rig.step());
  rig.both_answer();
  rig.prepare(0us);
  rig.motion.resumed = outputs("0F 00 07 99 03 00 00  06 00 07 99 07 00 00");
  rig.motion.calls.clear();
  EXPECT_THAT(rig.step(300us, 3), ElementsAre("303#99030000", "304#99070000"));
  ASSERT_EQ(rig.motion.calls.size(), 1U);
  EXPECT_EQ(rig.motion.calls[0].what, "resume");
  EXPECT_EQ(rig.motion.calls[0].cycle, 5);
  EXPECT_EQ(rig.motion.calls[0].missed, 3);
  motion::MasterAbsence absence;
  ASSERT_TRUE(rig.cycle.take_absence(absence));
  EXPECT_EQ(absence.since, rig.grid(2));
  EXPECT_EQ(absence.duration, 6300us);
  EXPECT_EQ(absence.path_late, 7ms);
  EXPECT_EQ(absence.cycle, 5U);
  EXPECT_EQ(absence.effect, motion::AbsenceEffect::kBridged);
  EXPECT_FALSE(rig.cycle.take_absence(absence));
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#E8030000", "304#D0070000"));
  EXPECT_THAT(rig.motion.valid, ElementsAre(false, false)) << "nobody answers without SYNC";
  EXPECT_EQ(rig.cycle.statistics().lost_frames, 0U);
  EXPECT_EQ(rig.cycle.counters().syncs_unsent, 0U);
}

// The setpoints sent behind the last SYNC wait in the drives until the next one: no drive acts on them. The motion has
// to know that before it looks for the way on, so it is told when the cycle knows how long it was away.
TEST(CanCycleTest, WhatWasSentBeforeMissedPeriodsHasNotReachedTheDrives) {
  CycleRig rig;
  rig.motion.outputs = outputs(kEnabled);
  static_cast<void>(rig.step());
  rig.both_answer();
  static_cast<void>(rig.step());
  rig.both_answer();
  rig.motion.calls.clear();
  rig.prepare(-2100us);
  EXPECT_THAT(rig.motion.calls, IsEmpty()) << "a period too late";
  static_cast<void>(rig.step(100us, 1));
  ASSERT_EQ(rig.motion.calls.size(), 3U);
  EXPECT_EQ(rig.motion.calls[1].what, "update");
  EXPECT_EQ(rig.motion.calls[2].what, "resume");
  EXPECT_THAT(rig.motion.valid, ElementsAre(false, false));
}

TEST(CanCycleTest, SyncWaitsForTheSetpointsOfEveryNodeInUse) {
  CycleRig rig;
  static_cast<void>(rig.step());
  static_cast<void>(rig.step());
  rig.port.refusals[0x304] = SendStatus::kBusy;
  EXPECT_THAT(rig.step(0us, 2), ElementsAre("303#00000000"));
  EXPECT_THAT(rig.step(), ElementsAre("303#00000000"));
  EXPECT_THAT(rig.step(), ElementsAre("303#00000000"));
  rig.port.refusals.clear();
  EXPECT_THAT(rig.step(), ElementsAre("303#00000000", "304#00000000"));
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#00000000", "304#00000000"));
  rig.port.refusals[0x304] = SendStatus::kBusy;
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#00000000")) << "without missed periods nothing old waits anywhere";
  static_cast<void>(rig.step(0us, 2));
  rig.cycle.set_operational(1, false);
  EXPECT_THAT(rig.step(), ElementsAre("303#00000000"));
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#00000000")) << "a node that is not in use";
}

TEST(CanCycleTest, SyncWaitsForNoNodeForEver) {
  CycleRig rig;
  static_cast<void>(rig.step());
  static_cast<void>(rig.step());
  rig.port.refusals[0x304] = SendStatus::kBusy;
  EXPECT_THAT(rig.step(0us, 2), Not(Contains("080#")));
  for (int i = 1; i < 8; ++i) EXPECT_THAT(rig.step(), Not(Contains("080#"))) << i;
  EXPECT_THAT(rig.step(), Contains("080#"));
}

// The adapter repeats a frame until it is acknowledged: what was sent has arrived, though its answer is missing.
TEST(CanCycleTest, AnAnswerThatIsMissingDoesNotMeanThatTheOutputsAre) {
  CycleRig rig;
  static_cast<void>(rig.step());
  static_cast<void>(rig.step());
  rig.comes(300us, "183#270000010000");
  static_cast<void>(rig.step());
  EXPECT_THAT(rig.motion.valid, ElementsAre(true, false));
  EXPECT_THAT(rig.motion.supplied, ElementsAre(true, true));
  rig.port.refusals[0x303] = SendStatus::kBusy;
  static_cast<void>(rig.step());
  rig.both_answer();
  static_cast<void>(rig.step());
  EXPECT_THAT(rig.motion.valid, ElementsAre(false, true));
  EXPECT_THAT(rig.motion.supplied, ElementsAre(false, true));
}

// A drive that is switched on begins with the setpoints that it acts on: those must be there. A stop waits for nothing.
TEST(CanCycleTest, AControlWordThatSwitchesOnWaitsForTheSetpoints) {
  CycleRig rig;
  static_cast<void>(rig.step());
  static_cast<void>(rig.step());
  rig.port.refusals[0x303] = SendStatus::kBusy;
  rig.motion.outputs = outputs("0F 00 07 E8 03 00 00  02 00 07 D0 07 00 00");
  EXPECT_THAT(rig.step(), ElementsAre("080#", "304#D0070000", "203#0F0007", "204#020007")) << "has those of before";
  rig.motion.outputs = outputs("1F 00 07 E8 03 00 00  0F 00 07 D0 07 00 00");
  EXPECT_THAT(rig.step(), ElementsAre("080#", "304#D0070000", "204#0F0007"));
  rig.port.refusals.clear();
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#E8030000", "304#D0070000")) << "wait in the drive until SYNC";
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#E8030000", "304#D0070000", "203#1F0007"));
  rig.motion.outputs = outputs("0F 00 07 E8 03 00 00  0F 01 07 D0 07 00 00");
  EXPECT_THAT(rig.step(0us, 2), ElementsAre("303#E8030000", "304#D0070000", "204#0F0107")) << "halt";
  EXPECT_THAT(rig.step(), ElementsAre("080#", "303#E8030000", "304#D0070000", "203#0F0007"));
}

// A request of before bus off would be answered when the owner has given it up.
TEST(CanCycleTest, FramesOfTheOwnerDoNotWaitForTheEndOfBusOff) {
  CycleRig rig;
  static_cast<void>(rig.step());
  rig.port.counters.state = BusState::kBusOff;
  static_cast<void>(rig.step());
  ASSERT_TRUE(rig.channel.request(Frame::of(0x603, std::array{std::byte{0x40}})));
  EXPECT_THAT(rig.step(), Not(Contains("603#40")));
  rig.port.counters.state = BusState::kErrorActive;
  static_cast<void>(rig.step());
  EXPECT_THAT(rig.step(), Not(Contains("603#40")));
  EXPECT_EQ(rig.cycle.counters().acyclic_unsent, 1U);
  ASSERT_TRUE(rig.channel.request(Frame::of(0x603, std::array{std::byte{0x40}})));
  EXPECT_THAT(rig.step(), Contains("603#40"));
}

// The suspended thread had not prepared anything: the answers to its last SYNC come first.
TEST(CanCycleTest, AnAbsenceBeforeThePreparationUsesTheAnswersToTheLastSync) {
  CycleRig rig;
  static_cast<void>(rig.step());
  rig.both_answer();
  static_cast<void>(rig.step(0us, 2));
  ASSERT_EQ(rig.motion.calls.size(), 3U);
  EXPECT_EQ(rig.motion.calls[0].what, "read");
  EXPECT_EQ(rig.motion.calls[1].what, "update");
  EXPECT_EQ(rig.motion.calls[1].cycle, 0);
  EXPECT_EQ(rig.motion.calls[2].what, "resume");
  EXPECT_EQ(rig.motion.calls[2].cycle, 3);
  EXPECT_THAT(rig.motion.valid, ElementsAre(true, true));
}

TEST(CanCycleTest, ALateSyncIsToldToTheMotion) {
  CycleRig rig;
  static_cast<void>(rig.step(700us));
  rig.comes(1100us, "183#270000010000");
  rig.comes(1200us, "184#270000020000");
  static_cast<void>(rig.step());
  EXPECT_EQ(rig.motion.last_late, 700us);
  EXPECT_EQ(rig.motion.last_took, 1200us);
  EXPECT_EQ(rig.cycle.statistics().wake_latency.max(), 700us);
}

TEST(CanCycleTest, TakesNoMoreFramesThanACycleHasTimeFor) {
  CycleRig rig;
  static_cast<void>(rig.step());
  for (int i = 0; i < 300; ++i) rig.comes(100us, "705#05");
  static_cast<void>(rig.step());
  static_cast<void>(rig.step());
  static_cast<void>(rig.step());
  EXPECT_EQ(rig.cycle.counters().flooded_cycles, 2U);
  EXPECT_EQ(rig.cycle.statistics().flooded_cycles, 2U);
  EXPECT_EQ(rig.channel.lost(), 300U - 16U);
}

TEST(CanCycleTest, CountingBeginsAnewWhenItIsSwitchedOn) {
  CycleRig rig;
  for (int i = 0; i < 5; ++i) static_cast<void>(rig.step());
  EXPECT_EQ(rig.cycle.statistics().cycles, 4U);
  rig.cycle.count(false);
  rig.cycle.count(true);
  static_cast<void>(rig.step());
  EXPECT_EQ(rig.cycle.statistics().cycles, 0U);
  for (int i = 0; i < 3; ++i) static_cast<void>(rig.step());
  EXPECT_EQ(rig.cycle.statistics().cycles, 3U);
  EXPECT_EQ(rig.cycle.statistics().lost_frames, 6U);
  rig.cycle.count(false);
  for (int i = 0; i < 3; ++i) static_cast<void>(rig.step());
  EXPECT_EQ(rig.cycle.statistics().cycles, 4U);
  EXPECT_EQ(rig.cycle.cycles(), 11U);
}

/// Bits of a data frame with those behind the CRC and the interframe space, bit by bit, as the cycle does not count.
std::size_t bits_one_by_one(const Frame& frame) {
  const FrameBits bits(frame);
  return bits.size() + bits.stuff_bits() + 10 + 3;
}

/// Random content with runs that need stuff bits.
TEST(CanCycleTest, SamplesHaveTheLoadOfEachPeriodWithItsStuffBits) {
  rt::SpscRing<snapshot::LineSample> lines(512);
  motion::SampleRings rings;
  rings.lines = &lines;
  CycleRig rig(axes_plan(2), {}, rings);
  rig.port.counters.send_errors = 17;
  rig.port.counters.receive_errors = 131;
  std::uint32_t random = 0x1234'5678;
  const auto next_byte = [&] {
    random = random * 1664525 + 1013904223;
    constexpr std::array<unsigned, 4> kLong{0x00, 0xFF, 0x0F, 0x83};
    const auto pick = random >> 24;
    return static_cast<std::byte>((pick & 1U) != 0 ? kLong[pick >> 1U & 3U] : random >> 16 & 0xFFU);
  };
  std::vector<double> expected;
  for (int i = 0; i < 300; ++i) {
    std::size_t bits = 0;
    rig.motion.outputs.resize(14);
    for (auto& byte : rig.motion.outputs) byte = next_byte();
    for (const auto& frame : rig.step()) bits += bits_one_by_one(*candump::parse_frame(frame));
    for (const char* identifier : {"183#", "184#", "283#", "703#"}) {
      Frame frame = *candump::parse_frame(identifier);
      frame.length = identifier[0] == '1' ? 6 : identifier[0] == '2' ? 3 : 1;
      for (std::size_t place = 0; place < frame.length; ++place) frame.data[place] = next_byte();
      rig.comes(400us, cycle_test::text_of(frame));
      bits += bits_one_by_one(frame);
    }
    expected.push_back(static_cast<double>(bits) / 2000.0);
  }
  snapshot::LineSample line;
  for (std::size_t i = 0; i + 1 < expected.size(); ++i) {
    ASSERT_TRUE(lines.try_pop(line));
    ASSERT_EQ(line.cycle, i);
    ASSERT_NEAR(line.bus_load, expected[i], 1e-6) << i;
    ASSERT_EQ(line.working_counter, 2);
    ASSERT_EQ(line.expected_working_counter, 2);
    ASSERT_TRUE(line.frame_received);
    ASSERT_EQ(line.round_trip_ns, 400'000);
  }
  EXPECT_EQ(line.bus_send_errors, 17);
  EXPECT_EQ(line.bus_receive_errors, 131);
  EXPECT_EQ(line.time_ns, rig.grid(298).count());
}

TEST(CanCycleTest, TheGridIsAMultipleOfThePeriod) {
  CycleRig rig;
  EXPECT_EQ(rig.cycle.first_grid(7001us), 8ms);
  EXPECT_EQ(rig.cycle.first_grid(8ms), 8ms);
  EXPECT_EQ(rig.cycle.period(), 2ms);
}

/// Writes the first byte of the outputs from the inputs.
class Echo final : public motion::CycleTask {
 public:
  void update(const motion::TaskCycle& cycle) noexcept override {
    cycles.push_back(cycle.cycle);
    valid = cycle.valid[0];
    cycle.outputs[3] = cycle.inputs[2];
  }
  std::vector<std::int64_t> cycles;
  bool valid = false;
};

TEST(CanCycleTest, TasksAndCopiesRunBetweenAnswersAndOutputs) {
  Echo echo;
  motion::TaskSchedule tasks;
  tasks.add(echo, {.divider = 2, .order = motion::TaskTiming::Order::kAfterMotion});
  CanCycle::Settings settings;
  settings.tasks = &tasks;
  // The second byte of the actual position of axis 3 becomes that of the setpoint of axis 4.
  settings.copies = {{0, 8 * 3, 8 * 11, 8}};
  CycleRig rig(axes_plan(2), settings);
  rig.motion.outputs = outputs(kEnabled);
  static_cast<void>(rig.step());
  rig.comes(300us, "183#270011220000");
  rig.comes(420us, "184#270000020000");
  EXPECT_THAT(rig.step(), Contains("303#11030000"));
  EXPECT_TRUE(echo.valid);
  static_cast<void>(rig.step());
  EXPECT_THAT(echo.cycles, ElementsAre(0));
  rig.comes(300us, "183#270011330000");
  rig.comes(420us, "184#270000020000");
  EXPECT_THAT(rig.step(), Contains("304#D0330000"));
  EXPECT_THAT(echo.cycles, ElementsAre(0, 2));
}

TEST(CanCycleTest, TheTraceHasAllWorkOfAPeriod) {
  motion::CycleTrace trace(16);
  CanCycle::Settings settings;
  settings.trace = &trace;
  CycleRig rig(axes_plan(2), settings);
  static_cast<void>(rig.step(30us));
  rig.both_answer();
  static_cast<void>(rig.step());
  const auto cycles = trace.cycles();
  ASSERT_EQ(cycles.size(), 1U);
  EXPECT_EQ(cycles[0].stamps.cycle, 0);
  EXPECT_EQ(cycles[0].stamps.due, rig.grid(0));
  EXPECT_EQ(cycles[0].stamps.wake, rig.grid(0) + 30us);
  EXPECT_GE(cycles[0].stamps.end.back(), cycles[0].stamps.wake);
}

}  // namespace
}  // namespace driveline::canopen
