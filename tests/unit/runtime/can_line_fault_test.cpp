// Faults of a CAN line, as users write them in its description and on the command line, and what they do in time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "driveline/runtime/can_line/can_line.hpp"
#include "support/scripted_node.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using slaves::can::BusEnd;
using slaves::can::BusFault;
using slaves::can::BusFaultKind;
using testing::HasSubstr;

const std::vector<std::string> kLineNames{"x", "y", "z"};

BusFault parsed(std::string_view text) {
  const auto fault = parse_can_fault(text, kLineNames);
  if (!fault) throw std::runtime_error(describe(fault.error()));
  return *fault;
}

std::string error_of(std::string_view text, bool complete = true) {
  const auto fault = parse_can_fault(text, kLineNames, complete);
  return fault ? "" : describe(fault.error());
}

TEST(CanFaultText, EveryParameterArrives) {
  const auto drop = parsed("  drop slave=z\tid=0x181 mask=0x780 count=3 chance=0.25 seed=7 for_ms=1.5 ");
  EXPECT_EQ(drop.kind, BusFaultKind::kDrop);
  EXPECT_EQ(drop.slave, 2);
  EXPECT_EQ(drop.identifier, 0x181U);
  EXPECT_EQ(drop.mask, 0x780U);
  EXPECT_EQ(drop.count, 3U);
  EXPECT_EQ(drop.chance, 0.25);
  EXPECT_EQ(drop.seed, 7U);
  EXPECT_EQ(drop.duration, 1500us);
  EXPECT_EQ(parsed("drop").slave, BusFault::kEverySlave);
  EXPECT_EQ(parsed("drop").mask, 0U);
  EXPECT_EQ(parsed("bit-error id=5 bit=30").bit, 30);
  EXPECT_EQ(parsed("bit-error id=5").mask, 0x1FFF'FFFFU);
  EXPECT_EQ(parsed("no-terminator end=last").end, BusEnd::kLast);
  const auto babble = parsed("babble slave=0 id=0x10 data=aB01");
  EXPECT_EQ(babble.frame.length, 2);
  EXPECT_EQ(babble.frame.data[0], std::byte{0xAB});
  EXPECT_EQ(parsed("bit-rate slave=y rate=500000").bit_rate, 500'000U);
}

TEST(CanFaultText, IsReadBackAsTheSameFault) {
  for (const std::string_view text :
       {"drop", "drop slave=y id=0x181 count=3", "drop id=0x180 mask=0x780 chance=0.5 seed=7 for_ms=2.5",
        "bit-error id=0x5 bit=30", "cable-break slave=x", "no-terminator", "no-terminator end=first",
        "babble slave=x id=0x10 data=AB01", "dominant slave=z for_ms=1", "power-off slave=x",
        "bit-rate slave=y rate=500000", "bus-off slave=x", "reset slave=z"}) {
    EXPECT_EQ(can_fault_text(parsed(text), kLineNames), text);
  }
}

TEST(CanFaultText, WhatIsWrongIsSaid) {
  EXPECT_THAT(error_of(""),
              HasSubstr("is not a kind of fault of a CAN line; the kinds are drop, bit-error, cable-break"));
  EXPECT_THAT(error_of("corrupt"), HasSubstr("\"corrupt\" is not a kind of fault of a CAN line"));
  EXPECT_EQ(error_of("drop fast"), "\"fast\": KEY=VALUE is expected");
  EXPECT_EQ(error_of("drop speed=1"), "\"speed\" is no key of a fault; help lists the keys");
  EXPECT_EQ(error_of("drop bit=3"),
            "bit is not a key of \"drop\"; its keys are [slave], [id], [mask], [count], [chance], [seed]");
  EXPECT_EQ(error_of("dominant"), "\"dominant\" needs slave: name or position of a slave");
  EXPECT_EQ(error_of("dominant slave=q"), "slave there is no slave \"q\" among the 3");
  EXPECT_EQ(error_of("bit-rate slave=x"), "\"bit-rate\" needs rate: 10000 to 1000000");
  EXPECT_EQ(error_of("bit-rate slave=x", false), "") << "kind and place are enough to heal it";
  EXPECT_EQ(error_of("bit-rate slave=x rate=300000"),
            "rate is 300000, a rate whose bits are whole nanoseconds is expected");
  EXPECT_EQ(error_of("bit-rate slave=x rate=5"), "rate is \"5\", 10000 to 1000000 is expected");
  EXPECT_EQ(error_of("drop mask=1"), "\"drop\" has a mask and no id");
  EXPECT_EQ(error_of("drop id=0x20000000"), "id is \"0x20000000\", 0 to 536870911 is expected");
  EXPECT_EQ(error_of("drop count=0"), "count is \"0\", 1 to 4294967294 is expected");
  EXPECT_EQ(error_of("drop chance=nan"), "chance is \"nan\", 0 to 1 is expected");
  EXPECT_EQ(error_of("bit-error bit=111"), "bit is \"111\", 1 to 110 is expected");
  EXPECT_EQ(error_of("no-terminator end=left"), "end is \"left\", both, first or last is expected");
  EXPECT_THAT(error_of("babble slave=x data=ABC"), HasSubstr("data is \"ABC\", up to 16 hexadecimal digits"));
  EXPECT_THAT(error_of("babble slave=x data=0102030405060708FF"), HasSubstr("up to 16 hexadecimal digits"));
  EXPECT_EQ(error_of("reset slave=x for_ms=5"), "for_ms is not a key of \"reset\", which does not last");
  EXPECT_EQ(error_of("drop for_ms=0"), "for_ms is \"0\", 0.001 to 86400000 is expected");
  for (const auto& row : slaves::can::kBusFaultKinds) EXPECT_THAT(can_fault_help(), HasSubstr(row.name));
}

constexpr std::string_view kFaultyLine = R"([bus]
type = "can"
seed = 3
[[slave]]
name = "x"
node = 3
[[slave]]
name = "y"
node = 4
[[slave]]
name = "z"
node = 5
model = "servoone"
[[fault]]
at_ms = 30
kind = "bit-error"
chance = 0.3
for_ms = 50
[[fault]]
at_ms = 40
kind = "cable-break"
slave = "y"
for_ms = 15.5
[[fault]]
at_ms = 60
kind = "no-terminator"
[[fault]]
at_ms = 70
kind = "drop"
slave = "x"
id = 0x80
count = 4
[[fault]]
at_ms = 75.25
kind = "reset"
slave = 1
)";

TEST(CanLineFault, IsReadFromTheDescription) {
  const auto config = parse_can_line_config(kFaultyLine, "cell.toml");
  ASSERT_TRUE(config) << describe(config.error());
  ASSERT_EQ(config->faults.size(), 5U);
  EXPECT_EQ(config->faults[0].at, 30ms);
  EXPECT_EQ(config->faults[0].fault.chance, 0.3);
  EXPECT_EQ(config->faults[1].fault.slave, 1);
  EXPECT_EQ(config->faults[1].fault.duration, 15'500us);
  EXPECT_EQ(config->faults[3].fault.identifier, 0x80U);
  EXPECT_EQ(config->faults[4].fault.kind, BusFaultKind::kReset);
  const auto failure = [](const std::string& fault) {
    const auto wrong = parse_can_line_config(
        "[bus]\ntype = \"can\"\n[[slave]]\nname = \"x\"\nnode = 3\n[[fault]]\n" + fault, "cell.toml");
    return wrong ? "" : describe(wrong.error());
  };
  EXPECT_EQ(failure("kind = \"dominant\"\nslave = \"q\"\n"),
            "cell.toml:8: [fault 1] slave: there is no slave \"q\" among the 1");
  EXPECT_THAT(failure("kind = \"delay\"\n"),
              HasSubstr("cell.toml:7: [fault 1] kind: \"delay\" is not a kind of fault"));
  EXPECT_EQ(failure("kind = \"dominant\"\n"),
            "cell.toml:6: [fault 1]: \"dominant\" needs slave: name or position of a slave");
  EXPECT_THAT(failure("kind = \"reset\"\nslave = \"x\"\nfor_ms = 3\n"),
              HasSubstr("[fault 1] for_ms: is not a key of \"reset\""));
  EXPECT_THAT(failure("at_ms = -1\nkind = \"drop\"\n"), HasSubstr("[fault 1] at_ms"));
  EXPECT_THAT(failure("kind = \"drop\"\nspeed = 1\n"), HasSubstr("[fault 1] speed"));
}

struct Recording {
  std::vector<slaves::can::ScriptedNode::Seen> seen;
  std::vector<std::string> events;
  std::uint64_t error_frames = 0;
  bool operator==(const Recording&) const = default;
};

/// All that a client sees of the line in 200 ms in which it starts the drives and sends SYNCs, in steps of this size.
Recording record(std::string_view text, std::chrono::nanoseconds step) {
  const auto config = parse_can_line_config(text, "cell.toml");
  if (!config) throw std::runtime_error(describe(config.error()));
  CanLine line(*config);
  slaves::can::ScriptedNode client;
  line.bus().attach(client, {.error_frames = true, .automatic_recovery = true});
  using slaves::can::Frame;
  client.send_at(5ms, Frame::of(0, bytes_test::hex("01 00")));
  for (int i = 0; i < 190; ++i) client.send_at(10ms + i * 1ms, Frame::of(0x80, {}));
  for (std::chrono::nanoseconds now{0}; now < 200ms; now += step) line.advance(now);
  line.advance(200ms);
  Recording recording{client.received, {}, line.bus().statistics().error_frames};
  while (const auto event = line.faults().take_event()) {
    recording.events.push_back(std::to_string(event->time.count()) + (event->begins ? " begins " : " ends ") +
                               can_fault_text(event->fault, line.names()));
  }
  return recording;
}

TEST(CanLineFault, TheSameSeedGivesTheSameFramesAtTheSameNanosecond) {
  const auto first = record(kFaultyLine, 1ms);
  EXPECT_EQ(first, record(kFaultyLine, 1ms));
  // Only the end of a fault whose frames are used up is noticed, and told, at the end of a step.
  const auto in_other_steps = record(kFaultyLine, 37us);
  EXPECT_EQ(first.seen, in_other_steps.seen);
  EXPECT_EQ(first.error_frames, in_other_steps.error_frames);
  EXPECT_GT(first.error_frames, 10U);
  EXPECT_GT(first.seen.size(), 4U);
  std::string other(kFaultyLine);
  other.replace(other.find("seed = 3"), 8, "seed = 4");
  EXPECT_NE(first.seen, record(other, 1ms).seen) << "what happens now and then happens at other times";
  EXPECT_THAT(first.events, testing::Contains("40000000 begins cable-break slave=y for_ms=15.5"));
  EXPECT_THAT(first.events, testing::Contains("55500000 ends cable-break slave=y for_ms=15.5"));
  EXPECT_THAT(first.events, testing::Contains("75250000 begins reset slave=y"));
}

TEST(CanLineFault, ASlaveIsRestartedAndTold) {
  const auto config = parse_can_line_config(
      "[bus]\ntype = \"can\"\n[[slave]]\nname = \"x\"\nnode = 3\n[[fault]]\nat_ms = 50\nkind = \"power-off\"\nslave = "
      "\"x\"\n"
      "for_ms = 20\n",
      "cell.toml");
  ASSERT_TRUE(config) << describe(config.error());
  CanLine line(*config);
  slaves::can::ScriptedNode client;
  line.bus().attach(client);
  line.advance(40ms);
  EXPECT_EQ(line.device(0).state(), "Pre-operational");
  EXPECT_EQ(line.next_event(), std::min(line.bus().next_event(), std::chrono::nanoseconds{50ms}));
  ASSERT_NE(line.device(0).signals(), nullptr);
  line.advance(60ms);
  EXPECT_FALSE(line.bus().controller(0).powered());
  EXPECT_EQ(line.faults().active().size(), 1U);
  line.advance(100ms);
  EXPECT_TRUE(line.faults().active().empty());
  EXPECT_EQ(client.identifiers(), (std::vector<std::uint32_t>{0x703, 0x703})) << "boot-up messages";
  EXPECT_GT(client.received.back().time, 70ms);
}

}  // namespace
}  // namespace driveline::runtime
