// Registers of the distributed clocks that another master, or a damaged frame, has written.
#include <gmock/gmock.h>

#include "clock_run.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::LineSupervisor;

class ClockRegisters : public testing::Test {
 protected:
  void start(port::Port* port = nullptr) {
    ClockRun::Options options;
    options.port = port;
    run_ = std::make_unique<ClockRun>(line_, options);
    ASSERT_EQ(run_->start(line_.plan()), "");
    supervisor_ = std::make_unique<LineSupervisor>(run_->master());
    live(milliseconds{500});
    ASSERT_EQ(told(), "");
    ASSERT_GE(supervisor_->guard().rounds, 10U);
  }
  void live(nanoseconds duration) {
    const auto end = line_.clock.now() + duration;
    while (line_.clock.now() < end) {
      run_->run(milliseconds{5});
      supervisor_->poll();
    }
  }
  template <typename T>
  void overwrite(std::size_t slave, const wire::Register<T>& reg, std::type_identity_t<T> value) {
    ASSERT_TRUE(run_->master().bus().write(line_.refs()[slave], reg, value));
  }
  template <typename T>
  [[nodiscard]] T value(std::size_t slave, const wire::Register<T>& reg) {
    return line_.slave(slave).esc().memory().get(reg);
  }
  [[nodiscard]] std::string told() const {
    std::string all;
    for (const auto& event : supervisor_->history()) all += what_happened(event) + "\n";
    return all;
  }
  void expect_whole() {
    for (std::size_t i = 0; i < line_.size(); ++i) {
      EXPECT_EQ(line_.slave(i).state(), wire::AlState::kOp) << i;
      EXPECT_EQ(value(i, wire::reg::kDcActivation), 0x03) << i;
      EXPECT_EQ(value(i, wire::reg::kSync0CycleTime), 125'000U) << i;
      EXPECT_EQ(value(i, wire::reg::kSystemTimeOffset), run_->clocks().slaves[i].offset) << i;
      EXPECT_EQ(value(i, wire::reg::kSystemTimeDelay), run_->clocks().slaves[i].delay) << i;
      // The next pulse is in the grid of the common start.
      EXPECT_EQ((value(i, wire::reg::kStartTimeCyclic) - run_->clocks().start) % 125'000U, 0U) << i;
    }
    EXPECT_LE(run_->worst_sync0(), nanoseconds{200});
    EXPECT_TRUE(run_->status().locked);
    EXPECT_TRUE(supervisor_->all_operational());
  }

  ClockLine line_{random_clocks(3, 50.0)};
  std::unique_ptr<ClockRun> run_;
  std::unique_ptr<LineSupervisor> supervisor_;
};

TEST_F(ClockRegisters, AnOffsetOfAClockThatFollows) {
  start();
  overwrite(2, wire::reg::kSystemTimeOffset, value(2, wire::reg::kSystemTimeOffset) + 50'000);
  live(std::chrono::seconds{2});
  EXPECT_THAT(told(),
              testing::MatchesRegex(
                  "slave 2: left OP, [^\n]*\nslave 2: system time offset .0x0920. is 0x[0-9A-F]*, 0x[0-9A-F]* was "
                  "configured; it must be configured again\nslave 2: back in "
                  "OP\n"));
  expect_whole();
}

TEST_F(ClockRegisters, TheOffsetOfTheReferenceClockIsPutBackAtOnce) {
  start();
  overwrite(0, wire::reg::kSystemTimeOffset, value(0, wire::reg::kSystemTimeOffset) + 20'000);
  live(std::chrono::seconds{3});
  EXPECT_THAT(told(), testing::MatchesRegex("slave 0: left OP, [^\n]*\nslave 0: back in OP\n"));
  expect_whole();
}

TEST_F(ClockRegisters, DelayAndFiltersAreWrittenAgain) {
  start();
  overwrite(1, wire::reg::kSystemTimeDelay, 77'777);
  live(milliseconds{30});
  overwrite(1, wire::reg::kSpeedCounterStart, 0x0100);
  live(milliseconds{30});
  overwrite(1, wire::reg::kSpeedFilterDepth, 1);
  live(milliseconds{30});
  EXPECT_THAT(told(),
              testing::MatchesRegex(
                  "slave 1: system time delay .0x0928. is 0x00012FD1, 0x[0-9A-F]* was configured; written again\n"
                  "slave 1: speed counter start .0x0930. is 0x0100, 0x1000 was configured; written again\n"
                  "slave 1: speed counter filter depth .0x0935. is 0x01, 0x[0-9A-F]* was configured; written "
                  "again\n"));
  live(std::chrono::seconds{2});
  expect_whole();
}

TEST_F(ClockRegisters, SignalsThatWereSwitchedOff) {
  start();
  for (const std::size_t slave : {1U, 0U}) {
    overwrite(slave, wire::reg::kDcActivation, 0);
    live(std::chrono::seconds{2});
    const auto who = "slave " + std::to_string(slave);
    EXPECT_THAT(told(),
                testing::HasSubstr(
                    who + ": DC activation (0x0981) is 0x00, 0x03 was configured; it must be configured again\n" + who +
                    ": back in OP\n"));
    expect_whole();
  }
}

TEST_F(ClockRegisters, ACycleTimeOfSync0) {
  start();
  overwrite(2, wire::reg::kSync0CycleTime, 250'000);
  live(std::chrono::seconds{2});
  EXPECT_THAT(told(),
              testing::HasSubstr("slave 2: SYNC0 cycle time (0x09A0) is 0x0003D090, 0x0001E848 was configured"));
  expect_whole();
}

/// Switches a slave off just before its signals are set up.
class FatalStart final : public PassingPort {
 public:
  explicit FatalStart(slaves::SimulatedLine& line) : PassingPort(line), line_(line) {}
  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    const auto first = first_datagram(frame);
    const bool unit = first.command == wire::Command::kFpwr && first.ado == wire::reg::kCyclicUnitControl.address &&
                      first.data.size() == 1;
    if (unit && victim) {
      line_.set_power(*victim, false);
      victim.reset();
    }
    return inner_.send(frame);
  }
  std::optional<std::size_t> victim;

 private:
  slaves::SimulatedLine& line_;
};

TEST_F(ClockRegisters, ASlaveThatIsLostOnItsWayBackLeavesTheSignalsOfTheOthersAlone) {
  FatalStart port(line_.line());
  start(&port);
  line_.line().set_power(2, false);
  live(milliseconds{50});
  port.victim = 2;
  line_.line().set_power(2, true);
  live(std::chrono::seconds{2});
  ASSERT_FALSE(port.victim) << "it was switched off once more: " << told();
  for (const std::size_t i : {0U, 1U}) {
    EXPECT_EQ(value(i, wire::reg::kDcActivation), 0x03) << i;
    EXPECT_EQ(line_.slave(i).state(), wire::AlState::kOp) << i;
  }
  line_.line().set_power(2, true);
  live(std::chrono::seconds{2});
  expect_whole();
}

}  // namespace
}  // namespace driveline::bus_test
