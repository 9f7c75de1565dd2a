// The shared memory between the bridge and the thread of the commands, written by bridges of every kind.
#include "commands/command_service.hpp"

#include <gmock/gmock.h>

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

class CommandServiceTest : public testing::Test, protected AxesForCommands {
 protected:
  CommandServiceTest() {
    axis_requests.open(*single);
    auto started = CommandService::start(axis_requests, std::chrono::seconds{60});
    service = std::move(started).value();
    const auto descriptors = service->descriptors();
    commands.emplace(std::move(rt::SharedRegion::open(descriptors[0], snapshot::command_layout())).value());
    answers.emplace(std::move(rt::SharedRegion::open(descriptors[1], snapshot::command_answer_layout())).value());
    reader.emplace(*answers);
  }
  /// The next answer; none: time-out.
  std::optional<CommandAnswer> answer() {
    std::vector<std::uint64_t> record(reader->record_words());
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds{20};
    while (!reader->take(record)) {
      if (std::chrono::steady_clock::now() > limit) return std::nullopt;
      std::this_thread::sleep_for(milliseconds{1});
    }
    CommandAnswer answer;
    std::memcpy(static_cast<void*>(&answer), record.data(), sizeof(answer));
    return answer;
  }
  std::vector<std::string> told() {
    std::vector<std::string> sentences;
    for (auto& facts : axis_requests.take_events()) sentences.push_back(describe(Event{std::move(facts)}));
    return sentences;
  }
  /// Waits until the axis is free, with a time-out.
  void wait_until_free() {
    for (int i = 0; i < 20'000 && !axis_requests.authority().owner_of(0).empty(); ++i) {
      std::this_thread::sleep_for(milliseconds{1});
    }
    EXPECT_EQ(axis_requests.authority().owner_of(0), "");
  }

  rt::MonotonicClock clock;
  AxisRequests axis_requests{configs, clock, [] {}};
  std::unique_ptr<CommandService> service;
  std::optional<rt::SharedRegion> commands;
  std::optional<rt::SharedRegion> answers;
  std::optional<rt::SharedBlockReader> reader;
};

TEST_F(CommandServiceTest, AnswersWhatABridgeWrites) {
  rt::SharedRingWriter<CommandRecord> bridge(*commands);
  const auto record = command("panel", "x", CommandKind::kAcquire);
  ASSERT_TRUE(bridge.try_push(record));
  const auto got = answer();
  ASSERT_TRUE(got);
  EXPECT_EQ(got->number, record.number);
  EXPECT_EQ(got->participant, record.participant);
  EXPECT_EQ(static_cast<CommandResult>(got->result), CommandResult::kDone);
  EXPECT_NE(got->lease, 0U);
}

TEST_F(CommandServiceTest, ABridgeThatHasEndedTakesItsLeasesAlong) {
  rt::SharedRingWriter<CommandRecord> bridge(*commands);
  ASSERT_TRUE(bridge.try_push(command("panel", "x", CommandKind::kAcquire)));
  ASSERT_TRUE(answer());
  EXPECT_NE(axis_requests.authority().owner_of(0), "");
  service->bridge_lost();
  wait_until_free();
  rt::SharedRingWriter<CommandRecord> next(*commands);
  ASSERT_TRUE(next.try_push(command("panel", "x", CommandKind::kAcquire)));
  EXPECT_TRUE(answer()) << "the next one is heard";
}

TEST_F(CommandServiceTest, OutlivesGarbageInAllOfTheMemory) {
  std::mt19937_64 chance(1);
  const auto end = std::chrono::steady_clock::now() + milliseconds{1500};
  while (std::chrono::steady_clock::now() < end) {
    for (auto& word : commands->words()) std::atomic_ref(word).store(chance(), std::memory_order_relaxed);
  }
  EXPECT_EQ(axis_requests.authority().owner_of(0), "");
  EXPECT_EQ(axis_requests.authority().owner_of(1), "");
  const auto sentences = told();
  EXPECT_LT(sentences.size(), 300U) << "nobody is flooded with sentences";
  EXPECT_THAT(sentences, Contains("commands: invalid data from the bridge is ignored"));
}

TEST_F(CommandServiceTest, AFullRingRefusesAndIsReadOn) {
  rt::SharedRingWriter<CommandRecord> bridge(*commands);
  const auto end = std::chrono::steady_clock::now() + milliseconds{500};
  while (std::chrono::steady_clock::now() < end) bridge.try_push(command("flood", "x", CommandKind::kJog, 1));
  EXPECT_GT(bridge.dropped(), 0U);
  std::this_thread::sleep_for(milliseconds{1200});
  ASSERT_TRUE(bridge.try_push(command("panel", "y", CommandKind::kAcquire, 0, 2)));
  while (const auto got = answer()) {
    if (got->participant[0] == 2) break;
  }
  EXPECT_NE(axis_requests.authority().owner_of(1), "");
}

}  // namespace
}  // namespace driveline::runtime
