// Commands over DDS: checks, answers, events, and the effect of a flood or garbage.
#include "commands/command_desk.hpp"

#include <gmock/gmock.h>

#include <cstring>
#include <limits>
#include <random>

#include "command_line_of_axes.hpp"

namespace driveline::runtime {
namespace {

using snapshot::CommandAnswer;
using snapshot::CommandKind;
using snapshot::CommandRecord;
using snapshot::CommandResult;
using std::chrono::milliseconds;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

class CommandDeskTest : public testing::Test, protected AxesForCommands {
 protected:
  CommandDeskTest() { axis_requests.open(*single); }

  std::vector<std::string> told() {
    std::vector<std::string> sentences;
    for (auto& facts : axis_requests.take_events()) sentences.push_back(describe(Event{std::move(facts)}));
    return sentences;
  }
  /// The first answer to a command.
  CommandAnswer ask(const CommandRecord& record) {
    desk.take(record);
    const auto answers = desk.take_answers();
    EXPECT_EQ(answers.size(), 1U);
    return answers.empty() ? CommandAnswer{} : answers.front();
  }
  std::string refusal(const CommandRecord& record) {
    const auto answer = ask(record);
    EXPECT_EQ(static_cast<CommandResult>(answer.result), CommandResult::kRefused);
    EXPECT_EQ(answer.number, record.number);
    return std::string(answer.text.view());
  }
  std::uint64_t acquire(const char* client, const char* axis, std::uint8_t participant = 1) {
    const auto answer = ask(command(client, axis, CommandKind::kAcquire, 0, participant));
    EXPECT_EQ(static_cast<CommandResult>(answer.result), CommandResult::kDone);
    EXPECT_NE(answer.lease, 0U);
    return answer.lease;
  }

  rt::VirtualClock clock;
  AxisRequests axis_requests{configs, clock, [this] { ++stops; }};
  int stops = 0;
  CommandDesk desk{axis_requests, clock, milliseconds{300}};
};

constexpr const char* kPanel = "dds panel (participant 010000000000000000000000)";

TEST_F(CommandDeskTest, AsksForNothingWithoutALease) {
  const auto* const sentence = "axis x: the caller does not hold the lease of the axis; acquire the axis first";
  EXPECT_EQ(refusal(command("panel", "x", CommandKind::kEnable)), sentence);
  EXPECT_EQ(refusal(command("panel", "x", CommandKind::kJog, 7)), sentence);
  EXPECT_EQ(refusal(command("panel", "x", CommandKind::kRenew)), sentence);
  EXPECT_EQ(refusal(command("panel", "x", CommandKind::kRelease, 1)), sentence);
  EXPECT_EQ(axis_requests.authority().owner_of(0), "");
  const auto lease = acquire("panel", "x");
  EXPECT_EQ(refusal(command("panel", "x", CommandKind::kEnable, lease + 1)), sentence);
  EXPECT_EQ(refusal(command("panel", "y", CommandKind::kEnable, lease)),
            "axis y: the caller does not hold the lease of the axis; acquire the axis first");
  EXPECT_EQ(static_cast<CommandResult>(ask(command("panel", "x", CommandKind::kEnable, lease)).result),
            CommandResult::kAccepted);
}

TEST_F(CommandDeskTest, GivesAnAxisToOneClient) {
  const auto lease = acquire("panel", "x");
  EXPECT_EQ(refusal(command("other", "x", CommandKind::kAcquire)), std::string("axis x: is commanded by ") + kPanel);
  EXPECT_EQ(refusal(command("panel", "x", CommandKind::kAcquire, 0, 2)),
            std::string("axis x: is commanded by ") + kPanel)
      << "another participant that calls itself the same";
  EXPECT_THAT(refusal(command("panel", "x", CommandKind::kJog, lease, 2)), HasSubstr("acquire the axis first"))
      << "who has heard the number of the lease does not have it";
  EXPECT_EQ(ask(command("panel", "x", CommandKind::kAcquire)).lease, lease) << "he has it already";
}

TEST_F(CommandDeskTest, AStopNeedsNoLease) {
  acquire("panel", "x");
  for (const auto kind : {CommandKind::kHalt, CommandKind::kQuickStop}) {
    EXPECT_EQ(static_cast<CommandResult>(ask(command("other", "x", kind)).result), CommandResult::kAccepted);
  }
  EXPECT_THAT(refusal(command("other", "x", CommandKind::kReleaseStop)), HasSubstr("acquire the axis first"));
}

TEST_F(CommandDeskTest, ALeaseThatIsNotRenewedEnds) {
  const auto lease = acquire("panel", "x");
  for (int i = 0; i < 5; ++i) {
    clock.advance(milliseconds{200});
    desk.poll();
    EXPECT_EQ(ask(command("panel", "x", CommandKind::kRenew, lease)).lease, lease);
  }
  told();
  clock.advance(milliseconds{301});
  desk.poll();
  EXPECT_EQ(axis_requests.authority().owner_of(0), "");
  EXPECT_THAT(told(), ElementsAre(std::string("axis x: ") + kPanel + " no longer renews its lease: the axis stops"));
  EXPECT_THAT(refusal(command("panel", "x", CommandKind::kRenew, lease)), HasSubstr("acquire the axis first"));
  EXPECT_NE(acquire("panel", "x"), lease);
}

TEST_F(CommandDeskTest, AnAxisThatIsReleasedIsFree) {
  const auto lease = acquire("panel", "x");
  EXPECT_EQ(ask(command("panel", "x", CommandKind::kRelease, lease)).lease, 0U);
  EXPECT_EQ(axis_requests.authority().owner_of(0), "");
  acquire("other", "x");
}

TEST_F(CommandDeskTest, RefusesWhatCannotBe) {
  const auto lease = acquire("panel", "x");
  auto record = command("panel", "x", CommandKind::kJog, lease);
  record.target = 20.0;
  EXPECT_EQ(refusal(record), "axis x: velocity 1145.92 deg/s is outside -572.958 deg/s to 572.958 deg/s");
  record.number = ++number;
  EXPECT_EQ(ask(record).lease, lease) << "it is his all the same";
  record = command("panel", "x", CommandKind::kMoveAbsolute, lease);
  record.target = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(record), "axis x: target is not a finite number");
  record = command("panel", "x", CommandKind::kMoveAbsolute, lease);
  record.target = 5.0;
  EXPECT_THAT(refusal(record), HasSubstr("position 286.479 deg is outside"));
  record = command("panel", "x", CommandKind::kMoveAbsolute, lease);
  record.acceleration = -1.0;
  EXPECT_THAT(refusal(record), HasSubstr("acceleration -57.2958 deg/s^2 is outside"));
  EXPECT_EQ(refusal(command("panel", "q", CommandKind::kAcquire)), "there is no axis \"q\"");
  EXPECT_EQ(refusal(command("panel", "\x1b[2J", CommandKind::kAcquire)), "there is no axis \"?[2J\"");
  record = command("panel", "x", CommandKind::kAcquire);
  record.kind = 4711;
  EXPECT_EQ(refusal(record), "there is no command with number 4711");
  record = command("panel", "x", CommandKind::kRenew, lease);
  record.number = 1;
  EXPECT_THAT(refusal(record), StartsWith("number 1 must be above "));
  for (const char* name : {"", "a\nb", "\xC3\xA4"}) {
    EXPECT_EQ(refusal(command(name, "x", CommandKind::kAcquire)),
              "the name of a client must have 1 to 63 printable ASCII characters");
  }
}

TEST_F(CommandDeskTest, TellsOfEachCommandButRenewals) {
  const auto lease = acquire("panel", "x");
  ask(command("panel", "x", CommandKind::kRenew, lease));
  ask(command("panel", "x", CommandKind::kEnable, lease));
  ask(command("panel", "x", CommandKind::kJog, lease + 1));
  ask(command("panel", "q", CommandKind::kHalt));
  ask(command("panel", "x", CommandKind::kRelease, lease));
  const std::string who = kPanel;
  EXPECT_THAT(told(), ElementsAre(who + ": axis x: acquire", who + ": axis x: power on",
                                  who + ": axis x: move_velocity 0 deg/s: refused: the caller does not hold the "
                                        "lease of the axis; acquire the axis first",
                                  who + ": axis q: halt: refused: there is no axis \"q\"", who + ": axis x: release"));
}

TEST_F(CommandDeskTest, AnswersAgainWhenACommandIsOver) {
  const auto lease = acquire("panel", "x");
  auto record = command("panel", "x", CommandKind::kMoveRelative, lease);
  record.target = 0.1;
  EXPECT_EQ(static_cast<CommandResult>(ask(record).result), CommandResult::kAccepted);
  desk.poll();
  EXPECT_THAT(desk.take_answers(), IsEmpty()) << "no cycle has seen it";
  cycle();
  desk.poll();
  const auto answers = desk.take_answers();
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(static_cast<CommandResult>(answers[0].result), CommandResult::kAborted);
  EXPECT_EQ(answers[0].number, record.number);
  EXPECT_EQ(answers[0].lease, lease);
  EXPECT_EQ(answers[0].text.view(), "axis x: the axis is not enabled; enable it first");
}

TEST_F(CommandDeskTest, EachStopHasALastAnswerHoweverManyThereAre) {
  std::size_t accepted = 0;
  std::size_t done = 0;
  for (int i = 0; i < 90; ++i) {
    const auto answer = ask(command("panel", "x", CommandKind::kHalt));
    const auto result = static_cast<CommandResult>(answer.result);
    accepted += result == CommandResult::kAccepted ? 1 : 0;
    done += result == CommandResult::kDone && answer.text.view().starts_with("the axis is commanded to stop") ? 1 : 0;
    // Other clients can still stop their axes.
    if (i % 10 == 0) clock.advance(milliseconds{1});
  }
  EXPECT_EQ(accepted, 2 * CommandDesk::kMaxRequests);
  EXPECT_EQ(done, 90 - accepted);
}

TEST_F(CommandDeskTest, WithTheBridgeGoTheLeases) {
  acquire("panel", "x");
  acquire("other", "y", 2);
  told();
  desk.bridge_lost();
  EXPECT_EQ(axis_requests.authority().owner_of(0), "");
  EXPECT_EQ(axis_requests.authority().owner_of(1), "");
  EXPECT_THAT(told(), Contains(std::string(kPanel) +
                               ": the bridge has stopped: the axes of this client stop, and their leases end"));
}

TEST_F(CommandDeskTest, WhatAClientHasSaidToABridgeThatDiedCountsOnce) {
  const auto acquired = command("panel", "x", CommandKind::kAcquire);
  EXPECT_NE(ask(acquired).lease, 0U);
  desk.bridge_lost();
  // As the client's middleware repeats it to the next bridge.
  EXPECT_THAT(refusal(acquired), HasSubstr("must be above"));
  EXPECT_EQ(axis_requests.authority().owner_of(0), "");
  acquire("other", "x", 2);
}

TEST_F(CommandDeskTest, AFloodOfOneClientIsRefusedAndLeavesOthersAlone) {
  const auto lease = acquire("panel", "x");
  told();
  std::size_t refused = 0;
  for (int i = 0; i < 900; ++i) {
    refused +=
        ask(command("flood", "y", CommandKind::kJog, 1, 9)).text.view().starts_with("too many commands: ") ? 1 : 0;
  }
  EXPECT_EQ(refused, 900 - static_cast<std::size_t>(CommandDesk::kClientAtOnce));
  EXPECT_EQ(ask(command("panel", "x", CommandKind::kRenew, lease)).lease, lease);
  EXPECT_EQ(static_cast<CommandResult>(ask(command("flood", "y", CommandKind::kHalt, 0, 9)).result),
            CommandResult::kAccepted)
      << "a stop is always allowed";
  clock.advance(std::chrono::seconds{1});
  EXPECT_THAT(refusal(command("flood", "y", CommandKind::kJog, 1, 9)), HasSubstr("acquire the axis first"))
      << "he is heard again";
}

TEST_F(CommandDeskTest, AFloodOfManyIsCountedAndNotTold) {
  clock.advance(std::chrono::seconds{1});
  for (int i = 0; i < 100'000; ++i) {
    desk.take(command("flood", "y", CommandKind::kJog, 1, static_cast<std::uint8_t>(i % 200)));
  }
  EXPECT_LE(desk.take_answers().size(), static_cast<std::size_t>(CommandDesk::kTotalAtOnce));
  desk.poll();
  const auto sentences = told();
  EXPECT_LE(sentences.size(), static_cast<std::size_t>(CommandDesk::kEventsAtOnce) + 1);
  EXPECT_THAT(sentences, Contains("commands: too many to report one by one: 0 accepted, 900 refused, 99000 "
                                  "dropped unread"));
}

TEST_F(CommandDeskTest, GarbageMovesNothing) {
  std::mt19937_64 chance(1);
  CommandRecord record;
  for (int i = 0; i < 200'000; ++i) {
    std::array<std::uint64_t, sizeof(CommandRecord) / sizeof(std::uint64_t)> words{};
    for (auto& word : words) word = chance();
    std::memcpy(static_cast<void*>(&record), words.data(), sizeof(record));
    // Let some of it pass the first check.
    if (i % 2 == 0) record.client.set("panel");
    if (i % 4 == 0) record.axis.set("x");
    if (i % 3 == 0) record.kind = static_cast<std::uint32_t>(chance() % 14);
    const auto kind = static_cast<CommandKind>(record.kind);
    if (kind == CommandKind::kAcquire) record.kind = static_cast<std::uint32_t>(CommandKind::kJog);
    desk.take(record);
    clock.advance(milliseconds{1});
    if (i % 10 == 0) desk.poll();
    for (const auto& answer : desk.take_answers()) {
      const auto result = static_cast<CommandResult>(answer.result);
      if (result == CommandResult::kAccepted) {
        EXPECT_TRUE(kind == CommandKind::kHalt || kind == CommandKind::kQuickStop) << record.kind;
      }
    }
    if (i % 1000 == 0) {
      cycle();
      told();
    }
  }
  EXPECT_EQ(axis_requests.authority().owner_of(0), "");
  EXPECT_EQ(stops, 0);
}

TEST_F(CommandDeskTest, KeepsABoundedNumberOfClients) {
  for (std::size_t i = 0; i < CommandDesk::kMaxClients; ++i) {
    refusal(command(("c" + std::to_string(i)).c_str(), "q", CommandKind::kHalt, 0, static_cast<std::uint8_t>(i / 8)));
  }
  EXPECT_EQ(refusal(command("one more", "q", CommandKind::kHalt, 0, 99)), "the maximum number of clients is reached");
  clock.advance(std::chrono::seconds{11});
  EXPECT_EQ(refusal(command("one more", "q", CommandKind::kHalt)), "there is no axis \"q\"");
}

TEST_F(CommandDeskTest, OneParticipantKeepsNobodyOutByItsManyNames) {
  for (int i = 0; i < 64; ++i) {
    ask(command(("c" + std::to_string(i)).c_str(), "q", CommandKind::kHalt));
    clock.advance(milliseconds{20});
  }
  EXPECT_EQ(refusal(command("one more", "q", CommandKind::kHalt)), "the maximum number of clients is reached");
  EXPECT_EQ(refusal(command("panel", "q", CommandKind::kHalt, 0, 2)), "there is no axis \"q\"");
}

TEST_F(CommandDeskTest, AStopIsLookedAtInTheFloodOfOthers) {
  clock.advance(std::chrono::seconds{1});
  for (int i = 0; i < 10'000; ++i) {
    desk.take(command("flood", "y", CommandKind::kJog, 1, static_cast<std::uint8_t>(i % 50)));
  }
  EXPECT_FALSE(desk.take_answers().empty());
  EXPECT_EQ(refusal(command("panel", "q", CommandKind::kHalt, 0, 99)), "there is no axis \"q\"");
}

}  // namespace
}  // namespace driveline::runtime
