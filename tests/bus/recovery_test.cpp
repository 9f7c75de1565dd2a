// Slaves that lose power, are unplugged or fall out of OP come back while the others keep cycling.
#include <gmock/gmock.h>

#include "drive_line.hpp"
#include "driveline/ecat_master/line_supervisor.hpp"
#include "driveline/port/redundant_port.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::LineEvent;
using ecat_master::LineSupervisor;
using ecat_master::MotionPhase;
using wire::AlState;
using Kind = LineEvent::Kind;

class Recovery : public testing::Test {
 protected:
  void start(std::size_t count, RunOptions options = {}, const slaves::SlaveOptions& slave = {}) {
    options.task = &watch;
    drives = std::make_unique<DriveLine>(count, slave);
    operation = std::make_unique<LineOperation>(*drives, options);
    ASSERT_EQ(sentence(operation->to_op()), "");
    operation->run(milliseconds{2});
    LineSupervisor::Settings settings;
    settings.state_timeout = std::chrono::seconds{1};
    supervisor = std::make_unique<LineSupervisor>(operation->master(), nullptr, settings);
  }
  /// Cycles and polls every millisecond until everybody is back, at most for `limit`.
  bool wait_for_all(nanoseconds limit) {
    const auto end = drives->clock.now() + limit;
    do {
      operation->run(milliseconds{1});
      supervisor->poll();
    } while (!supervisor->all_operational() && drives->clock.now() < end);
    operation->run(milliseconds{1});
    return supervisor->all_operational();
  }
  ecat_master::CyclicCore& core() { return *operation->master().core(); }
  [[nodiscard]] std::string told() const {
    std::string all;
    for (const auto& event : supervisor->history()) {
      const auto text = describe(event);
      all += text.substr(text.find(" s ") + 3) + "\n";
    }
    return all;
  }
  /// Slaves 0..reached-1 must have valid data in every cycle of `meanwhile`.
  void expect_undisturbed(std::size_t reached, const std::function<void()>& meanwhile) {
    watch.reset();
    meanwhile();
    EXPECT_GT(watch.cycles, 0U);
    for (std::size_t i = 0; i < reached; ++i) EXPECT_EQ(watch.invalid[i], 0U) << "cycles of slave " << i;
  }

  /// Counts the cycles in which the data of a slave were not valid.
  struct Watch final : ecat_master::CyclicTask {
    void update(std::int64_t, std::span<const std::byte>, std::span<const bool> valid,
                std::span<std::byte>) noexcept override {
      ++cycles;
      for (std::size_t i = 0; i < valid.size(); ++i) invalid[i] += valid[i] ? 0 : 1;
    }
    void reset() { *this = {}; }
    std::array<std::uint64_t, 16> invalid{};
    std::uint64_t cycles = 0;
  };

  Watch watch;
  std::unique_ptr<DriveLine> drives;
  std::unique_ptr<LineOperation> operation;
  std::unique_ptr<LineSupervisor> supervisor;
};

TEST_F(Recovery, ASlaveThatFellToSafeOpIsBackInOp) {
  start(3);
  const auto value = wire::AlControl{AlState::kSafeOp, false, false}.raw();
  const auto ref = operation->master().slaves()[1].info.ref;
  expect_undisturbed(1, [&] {
    ASSERT_EQ(sentence(operation->master().bus().write(ref, wire::reg::kAlControl, value)), "");
    operation->run(milliseconds{1});
    EXPECT_FALSE(core().slave_report(1).operational);
    ASSERT_TRUE(wait_for_all(std::chrono::seconds{2}));
  });
  EXPECT_EQ(told(),
            "slave 1: left OP, is in SAFEOP, AL status code 0x0000 (no error)\n"
            "slave 1: back in OP\n");
  EXPECT_TRUE(drives->all_in(AlState::kOp));
  EXPECT_TRUE(core().slave_report(1).operational);
}

TEST_F(Recovery, ADriveThatWasSwitchedOffAndOnIsConfiguredAnew) {
  start(4);
  // The last one: nobody behind it.
  expect_undisturbed(3, [&] {
    drives->line().set_power(3, false);
    for (int i = 0; i < 20; ++i) {
      operation->run(milliseconds{5});
      supervisor->poll();
    }
    EXPECT_FALSE(supervisor->operational(3));
    EXPECT_EQ(operation->motion().axes()[3].inputs().state, snapshot::AxisState::kUnavailable);
    EXPECT_EQ(told(), "slave 3: does not answer any more\n");
    drives->line().set_power(3, true);
    ASSERT_TRUE(wait_for_all(std::chrono::seconds{5})) << told();
  });
  EXPECT_EQ(told(),
            "slave 3: does not answer any more\n"
            "slave 3: back in OP\n");
  EXPECT_TRUE(drives->all_in(AlState::kOp));
  EXPECT_EQ(core().groups()[0].bad_cycles.load(), 0U);
  // It is driven again like the others.
  operation->motion().request_start();
  EXPECT_TRUE(operation->run_until(MotionPhase::kFollowing, std::chrono::seconds{3}));
}

TEST_F(Recovery, ADriveInTheMiddleTakesThoseBehindItAlong) {
  start(5);
  expect_undisturbed(2, [&] {
    drives->line().set_power(2, false);
    operation->run(milliseconds{200});
    supervisor->poll();
    for (const std::size_t gone : {2U, 3U, 4U}) EXPECT_FALSE(supervisor->operational(gone)) << gone;
    drives->line().set_power(2, true);
    ASSERT_TRUE(wait_for_all(std::chrono::seconds{5})) << told();
  });
  EXPECT_TRUE(drives->all_in(AlState::kOp));
  EXPECT_EQ(supervisor->recoveries(), 3U);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_TRUE(core().slave_report(i).operational) << i;
}

TEST_F(Recovery, ACableThatIsPulledAndPluggedInAgain) {
  start(4);
  expect_undisturbed(2, [&] {
    ASSERT_TRUE(drives->line().break_cable({1, 1}));
    operation->run(milliseconds{300});
    supervisor->poll();
    // The drives behind the break have stopped by their watchdogs and kept their configuration.
    EXPECT_EQ(drives->state(2), AlState::kSafeOp);
    ASSERT_TRUE(drives->line().break_cable({1, 1}, false));
    ASSERT_TRUE(wait_for_all(std::chrono::seconds{2})) << told();
  });
  EXPECT_EQ(told(),
            "slave 2: does not answer any more\n"
            "slave 3: does not answer any more\n"
            "slave 2: back in OP\n"
            "slave 3: back in OP\n");
}

TEST_F(Recovery, TheWholeLineComesBack) {
  start(3);
  for (std::size_t i = 0; i < 3; ++i) drives->line().set_power(i, false);
  operation->run(milliseconds{100});
  supervisor->poll();
  for (std::size_t i = 0; i < 3; ++i) drives->line().set_power(i, true);
  ASSERT_TRUE(wait_for_all(std::chrono::seconds{5})) << told();
  EXPECT_TRUE(drives->all_in(AlState::kOp));
}

TEST_F(Recovery, ASlaveThatRefusesIsNamedWithItsReasonAndTriedAgain) {
  start(3);
  drives->slave(1).al().refuse(AlState::kOp, wire::AlStatusCode::kFatalSyncError);
  const auto value = wire::AlControl{AlState::kSafeOp, false, false}.raw();
  ASSERT_EQ(
      sentence(operation->master().bus().write(operation->master().slaves()[1].info.ref, wire::reg::kAlControl, value)),
      "");
  expect_undisturbed(1, [&] { EXPECT_FALSE(wait_for_all(milliseconds{500})); });
  EXPECT_EQ(told(),
            "slave 1: left OP, is in SAFEOP, AL status code 0x0000 (no error)\n"
            "slave 1: not brought back to OP: slave 1: asked for OP, is in SAFEOP, AL status code 0x002C (fatal "
            "synchronization error)\n");
}

TEST_F(Recovery, WithoutItSlavesStayWhereTheyAreButAreNamed) {
  start(2);
  LineSupervisor::Settings settings;
  settings.recover = false;
  supervisor = std::make_unique<LineSupervisor>(operation->master(), nullptr, settings);
  const auto value = wire::AlControl{AlState::kSafeOp, false, false}.raw();
  ASSERT_EQ(
      sentence(operation->master().bus().write(operation->master().slaves()[1].info.ref, wire::reg::kAlControl, value)),
      "");
  EXPECT_FALSE(wait_for_all(milliseconds{100}));
  EXPECT_EQ(drives->state(1), AlState::kSafeOp);
  EXPECT_EQ(told(), "slave 1: left OP, is in SAFEOP, AL status code 0x0000 (no error)\n");
}

}  // namespace
}  // namespace driveline::bus_test
