// Supervision of the process that publishes a line, replaced by a stub that the test controls.
#include "telemetry/bridge_supervisor.hpp"

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "driveline/runtime/event.hpp"
#include "driveline/runtime/helper/helper_program.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using Clock = BridgeSupervisor::Clock;

TEST(RestartPause, DoublesUpToItsLimitAndBeginsAnew) {
  RestartPause pause(100ms, 1000ms);
  EXPECT_EQ(pause.next(), 100ms);
  EXPECT_EQ(pause.next(), 200ms);
  EXPECT_EQ(pause.next(), 400ms);
  EXPECT_EQ(pause.next(), 800ms);
  EXPECT_EQ(pause.next(), 1000ms);
  EXPECT_EQ(pause.next(), 1000ms);
  pause.reset();
  EXPECT_EQ(pause.next(), 100ms);
}

snapshot::FeedWriter feed_of(std::uint32_t axes) {
  snapshot::FeedDescription description;
  description.axes = axes;
  auto feed = snapshot::FeedWriter::create(description, 8);
  if (!feed) throw std::runtime_error(rt::describe(feed.error()));
  return *std::move(feed);
}

class BridgeSupervisorTest : public test::TemporaryDirectory {
 protected:
  /// While the folder with the stub's log still exists.
  void TearDown() override {
    supervisor_.reset();
    test::TemporaryDirectory::TearDown();
  }

  /// `words`: behaviour of the stub, one word per start.
  void make(const std::string& words, BridgeSupervisor::Settings settings = {}) {
    ::setenv("BRIDGE_STUB", ((directory / "log").string() + ":" + words).c_str(), 1);
    settings.program = BRIDGE_STUB;
    auto made = must(BridgeSupervisor::create(feed_, std::move(settings)));
    supervisor_ = std::move(*made);
  }

  /// Serves until the condition holds, or for ten seconds.
  template <typename Condition>
  bool serve_until(const Condition& holds) {
    const auto limit = Clock::now() + 40s;
    while (!holds() && Clock::now() < limit) {
      supervisor_->serve(Clock::now());
      for (auto& facts : supervisor_->take_events()) said_.push_back(describe(Event{std::move(facts)}));
      std::this_thread::sleep_for(1ms);
    }
    return holds();
  }

  std::vector<std::string> starts() const {
    std::ifstream log(directory / "log");
    std::vector<std::string> lines;
    for (std::string line; std::getline(log, line);) lines.push_back(line);
    return lines;
  }

  snapshot::FeedWriter feed_ = feed_of(2);
  std::unique_ptr<BridgeSupervisor> supervisor_;
  std::vector<std::string> said_;
};

TEST_F(BridgeSupervisorTest, StartsTheBridgeWithItsDescriptorsAndEndsIt) {
  make("ready");
  ASSERT_TRUE(supervisor_->start());
  EXPECT_TRUE(supervisor_->running());
  const auto process = supervisor_->process();
  EXPECT_THAT(starts(), ElementsAre(HasSubstr("--supervisor-fd 3 --feed-fd 4 --return-fd 8 --condition-fd 9")));
  supervisor_->end();
  EXPECT_NE(::kill(process, 0), 0);
  EXPECT_TRUE(supervisor_->take_events().empty()) << "an end in order is no event";
}

TEST_F(BridgeSupervisorTest, WhatTheBridgeSaysOfItsStartIsTheErrorOfTheStart) {
  make("fail");
  EXPECT_EQ(failure_text(supervisor_->start()), "telemetry: no  [31mway ") << "without control characters";
}

TEST_F(BridgeSupervisorTest, WhatTheBridgeRemarksIsToldWithoutControlCharacters) {
  make("remark", {.user = "1000:1001"});
  ASSERT_TRUE(supervisor_->start());
  EXPECT_TRUE(supervisor_->running());
  const auto events = supervisor_->take_events();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(describe(Event{events[0]}), "telemetry: as  [31mnever ");
  EXPECT_THAT(starts(), ElementsAre(HasSubstr("--user 1000:1001")));
}

TEST_F(BridgeSupervisorTest, AProgramThatIsNotThereIsAnError) {
  BridgeSupervisor::Settings settings;
  settings.program = "/nowhere/driveline-bridge";
  auto none = must(BridgeSupervisor::create(feed_, settings));
  const auto started = (*none)->start();
  ASSERT_FALSE(started);
  EXPECT_THAT(describe(started.error()), HasSubstr("/nowhere/driveline-bridge: cannot be started: No such file"));
}

TEST_F(BridgeSupervisorTest, ABridgeThatDiesIsStartedAgainAfterGrowingPauses) {
  make("abort,exit,exit,ready", {.first_pause = 20ms, .longest_pause = 50ms});
  ASSERT_TRUE(supervisor_->start());
  ASSERT_TRUE(serve_until([&] { return supervisor_->restarts() == 3 && supervisor_->running(); }));
  EXPECT_THAT(said_, ElementsAre("telemetry: bridge stopped (signal 6), restart in 0.02 s",
                                 "telemetry: bridge stopped (status 3), restart in 0.04 s",
                                 "telemetry: bridge stopped (status 3), restart in 0.05 s",
                                 HasSubstr("telemetry: bridge runs again (process ")));
  EXPECT_EQ(starts().size(), 4U);
}

TEST_F(BridgeSupervisorTest, ItIsNotStartedBeforeItsPauseIsOver) {
  make("exit", {.first_pause = 1h, .longest_pause = 2h});
  ASSERT_TRUE(supervisor_->start()) << "a bridge that dies is no reason not to run";
  const auto now = Clock::now();
  supervisor_->serve(now + 59min);
  EXPECT_EQ(supervisor_->restarts(), 0U);
  supervisor_->serve(now + 61min);
  EXPECT_EQ(supervisor_->restarts(), 1U);
}

TEST_F(BridgeSupervisorTest, ABridgeWithoutASignOfLifeIsEnded) {
  make("ready,ready", {.first_pause = 10ms, .hang_limit = 50ms});
  ASSERT_TRUE(supervisor_->start());
  ASSERT_TRUE(serve_until([&] { return supervisor_->restarts() == 1; }));
  EXPECT_EQ(said_.front(), "telemetry: bridge stopped (signal 9), restart in 0.01 s");
}

TEST_F(BridgeSupervisorTest, ABridgeThatStandsStillIsToldAndSoIsThatItGoesOn) {
  make("beat", {.still_limit = 50ms, .hang_limit = 1h});
  ASSERT_TRUE(supervisor_->start());
  ASSERT_TRUE(serve_until([&] { return supervisor_->counts().beats() > 0; }));
  const auto last_says = [&](const char* text) {
    return serve_until([&] { return !said_.empty() && said_.back().find(text) != std::string::npos; });
  };
  ASSERT_EQ(::kill(supervisor_->process(), SIGSTOP), 0);
  ASSERT_TRUE(last_says("telemetry: bridge does not respond (process "));
  EXPECT_THAT(said_.back(), HasSubstr("): no sign of life for 0.05 s, its samples are lost"));
  ASSERT_EQ(::kill(supervisor_->process(), SIGCONT), 0);
  EXPECT_TRUE(last_says("telemetry: bridge runs again (process "));
  EXPECT_EQ(supervisor_->restarts(), 0U);
}

TEST_F(BridgeSupervisorTest, ABridgeThatStandsStillForLongIsReplaced) {
  make("beat", {.first_pause = 10ms, .still_limit = 10ms, .hang_limit = 3s});
  ASSERT_TRUE(supervisor_->start());
  ASSERT_TRUE(serve_until([&] { return supervisor_->counts().beats() > 0; }));
  const auto stopped = supervisor_->process();
  ASSERT_EQ(::kill(stopped, SIGSTOP), 0);
  ASSERT_TRUE(serve_until([&] { return supervisor_->restarts() > 0 && supervisor_->running(); }));
  EXPECT_NE(supervisor_->process(), stopped);
  EXPECT_NE(::kill(stopped, 0), 0) << "it is gone";
  EXPECT_THAT(said_, testing::Contains("telemetry: bridge stopped (signal 9), restart in 0.01 s"));
}

TEST_F(BridgeSupervisorTest, ABridgeThatDoesNotEndIsEndedWithForce) {
  make("silent", {.start_limit = 50ms});
  ASSERT_TRUE(supervisor_->start());
  EXPECT_FALSE(supervisor_->running());
  const auto process = supervisor_->process();
  supervisor_->end();
  EXPECT_NE(::kill(process, 0), 0);
}

TEST_F(BridgeSupervisorTest, CountsAreAddedUpOverAllBridges) {
  for (int i = 0; i < 5; ++i) feed_.push({}, {});
  make("count,count", {.first_pause = 10ms});
  ASSERT_TRUE(supervisor_->start());
  ASSERT_TRUE(serve_until([&] { return supervisor_->counts().published() == 2; }));
  EXPECT_EQ(supervisor_->counts().dropped(), 4U) << "one record is a sample of the line and two of axes; one refused";
  ASSERT_EQ(::kill(supervisor_->process(), SIGKILL), 0);
  for (int i = 0; i < 5; ++i) feed_.push({}, {});
  ASSERT_TRUE(serve_until([&] { return supervisor_->counts().published() == 4; }));
  EXPECT_EQ(supervisor_->counts().published_before(), 2U);
  EXPECT_EQ(supervisor_->counts().dropped_before(), 4U);
  supervisor_->end();
  EXPECT_EQ(supervisor_->counts().dropped(), 8U + 7U * 3U) << "and what was not taken";
}

TEST_F(BridgeSupervisorTest, NonsenseInItsCountsIsLeftOutAndToldOnce) {
  make("garbage");
  ASSERT_TRUE(supervisor_->start());
  ASSERT_TRUE(serve_until([&] { return supervisor_->invalid_counts() > 5; }));
  EXPECT_THAT(said_, ElementsAre("telemetry: invalid counters from the bridge are ignored"));
  EXPECT_EQ(supervisor_->counts().published(), 0U);
  EXPECT_EQ(supervisor_->counts().dropped(), 0U);
  EXPECT_EQ(supervisor_->counts().next(), 0U);
}

class BridgeCountsTest : public testing::Test {
 protected:
  void tell(const snapshot::FeedReturn& told) {
    rt::shared_detail::store_record<std::memory_order_relaxed>(region_.words().data() + rt::shared_detail::kRecordsWord,
                                                               told);
  }

  rt::SharedRegion region_ = *rt::SharedRegion::create("driveline-test", snapshot::feed_return_layout(1));
  BridgeCounts counts_{region_, 2};
};

TEST_F(BridgeCountsTest, WhatCannotBeIsNotBelieved) {
  constexpr std::uint64_t kWritten = 10;
  constexpr auto kHuge = ~std::uint64_t{0};
  counts_.begin(0);
  tell({.beats = 5, .next = 4, .published = 8, .lost = 1, .refused = 2});
  ASSERT_TRUE(counts_.update(kWritten));
  for (const auto& told : {snapshot::FeedReturn{.beats = 4, .next = 4, .published = 8, .lost = 1, .refused = 2},
                           snapshot::FeedReturn{.beats = 5, .next = 3, .published = 8, .lost = 1, .refused = 2},
                           snapshot::FeedReturn{.beats = 5, .next = 11, .published = 8, .lost = 1, .refused = 2},
                           snapshot::FeedReturn{.beats = 5, .next = 4, .published = 7, .lost = 1, .refused = 2},
                           snapshot::FeedReturn{.beats = 5, .next = 4, .published = 21, .lost = 1, .refused = 2},
                           snapshot::FeedReturn{.beats = 5, .next = 4, .published = 8, .lost = 0, .refused = 2},
                           snapshot::FeedReturn{.beats = 5, .next = 4, .published = 8, .lost = 11, .refused = 2},
                           snapshot::FeedReturn{.beats = 5, .next = 4, .published = 8, .lost = 1, .refused = 1},
                           snapshot::FeedReturn{.beats = 5, .next = 4, .published = 8, .lost = 1, .refused = kHuge}}) {
    tell(told);
    EXPECT_FALSE(counts_.update(kWritten));
    EXPECT_EQ(counts_.published(), 8U);
    EXPECT_EQ(counts_.dropped(), 5U);
  }
  tell({.beats = 6, .next = 10, .published = 20, .lost = 1, .refused = 2});
  EXPECT_TRUE(counts_.update(kWritten));
}

TEST_F(BridgeCountsTest, ANewBridgeGoesOnWhereTheOneBeforeHasEnded) {
  counts_.begin(0);
  tell({.beats = 5, .next = 4, .published = 8});
  ASSERT_TRUE(counts_.update(10));
  counts_.begin(10);
  EXPECT_EQ(region_.words()[rt::shared_detail::kRecordsWord + 1], 4U);
  EXPECT_EQ(region_.words()[rt::shared_detail::kRecordsWord + 2], 0U);
  EXPECT_EQ(counts_.next(), 4U);
}

TEST(HelperProgram, OfTheEnvironmentMustBeThere) {
  ::setenv("DRIVELINE_TEST_HELPER", "/nowhere/helper", 1);
  EXPECT_EQ(failure_text(find_helper_program("no-such-helper", "DRIVELINE_TEST_HELPER")),
            "/nowhere/helper: is set by DRIVELINE_TEST_HELPER, but the file does not exist");
  ::unsetenv("DRIVELINE_TEST_HELPER");
  EXPECT_THAT(failure_text(find_helper_program("no-such-helper", "DRIVELINE_TEST_HELPER")),
              AllOf(HasSubstr("no-such-helper: the program is neither in "), HasSubstr("libexec/driveline")));
}

}  // namespace
}  // namespace driveline::runtime
