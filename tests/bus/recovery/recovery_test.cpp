// Slaves that lose power, are unplugged or leave OP recover while the others keep cycling.
#include <gmock/gmock.h>

#include "drive_line.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/esi/sii.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::LineEvent;
using ecat_master::LineSupervisor;
using motion::MotionPhase;
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
  /// Cycles and polls every millisecond until all slaves are back, at most for `limit`.
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
  struct Watch final : motion::CycleTask {
    void update(const motion::TaskCycle& now) noexcept override {
      const auto valid = now.valid;
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
  // The last slave of the line.
  expect_undisturbed(3, [&] {
    drives->line().set_power(3, false);
    for (int i = 0; i < 20; ++i) {
      operation->run(milliseconds{5});
      supervisor->poll();
    }
    EXPECT_FALSE(supervisor->operational(3));
    EXPECT_EQ(operation->motion().axes()[3].inputs().state, snapshot::AxisState::kUnavailable);
    EXPECT_EQ(told(), "slave 3: no longer answers\n");
    drives->line().set_power(3, true);
    ASSERT_TRUE(wait_for_all(std::chrono::seconds{5})) << told();
  });
  EXPECT_EQ(told(),
            "slave 3: no longer answers\n"
            "slave 3: back in OP\n");
  EXPECT_TRUE(drives->all_in(AlState::kOp));
  EXPECT_EQ(core().groups()[0].bad_cycles.load(), 0U);
  // It is enabled again like the others.
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
    // The drives behind the break have been stopped by their watchdogs and have kept their configuration.
    EXPECT_EQ(drives->state(2), AlState::kSafeOp);
    ASSERT_TRUE(drives->line().break_cable({1, 1}, false));
    ASSERT_TRUE(wait_for_all(std::chrono::seconds{2})) << told();
  });
  EXPECT_EQ(told(),
            "slave 2: no longer answers\n"
            "slave 3: no longer answers\n"
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
  EXPECT_EQ(
      told(),
      "slave 1: left OP, is in SAFEOP, AL status code 0x0000 (no error)\n"
      "slave 1: not brought back to OP: slave 1: requested OP, is in SAFEOP + error, AL status code 0x002C (fatal "
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

/// Changes bytes of an EEPROM and updates the checksum of its configuration area.
void rewrite(slaves::Slave& slave, const std::vector<std::pair<std::size_t, unsigned>>& bytes) {
  auto& sii = slave.esc().sii();
  for (const auto& [offset, value] : bytes) sii.corrupt(offset, static_cast<std::byte>(value));
  sii.corrupt(14, static_cast<std::byte>(esi::sii_checksum(sii.image().first<esi::SiiConfigArea::kSize>())));
}

TEST_F(Recovery, AnotherDeviceInItsPlaceIsNamedAndLeftAlone) {
  start(3);
  drives->line().set_power(2, false);
  operation->run(milliseconds{5});
  // Revision number, words 12 and 13 of the EEPROM.
  rewrite(drives->slave(2), {{24, 0xEF}, {25, 0xBE}, {26, 0xAD}, {27, 0xDE}});
  drives->line().set_power(2, true);
  expect_undisturbed(2, [&] { EXPECT_FALSE(wait_for_all(milliseconds{500})); });
  EXPECT_THAT(told(), testing::StartsWith("slave 2: no longer answers\n"
                                          "slave 2: not brought back to OP: slave 2: revision is 0xDEADBEEF but 0x"));
  EXPECT_EQ(supervisor->history().size(), 2U) << "said once";
  EXPECT_EQ(drives->state(2), AlState::kInit);
}

/// Slave 2 is on a branch of slave 1; slave 3 follows on the trunk.
class HotConnect : public Recovery {
 protected:
  void SetUp() override {
    slaves::Wiring wiring(4);
    wiring.connect_master(slaves::MasterPort::kPrimary, {0, 0});
    wiring.connect({0, 1}, {1, 0});
    wiring.connect({1, 3}, {2, 0});
    wiring.connect({1, 1}, {3, 0});
    drives = std::make_unique<DriveLine>(4, slaves::SlaveOptions{}, slaves::LineOptions{}, std::move(wiring));
    set_alias(2, 0x0207);
    set_alias(3, 0x0308);
  }
  /// Takes effect when the slave is switched on.
  void set_alias(std::size_t slave, unsigned alias) {
    drives->line().set_power(slave, false);
    rewrite(drives->slave(slave), {{8, alias & 0xFF}, {9, alias >> 8}});
    drives->line().set_power(slave, true);
  }
  void run(std::vector<std::size_t> hot) {
    RunOptions options;
    options.task = &watch;
    options.hot_connect = std::move(hot);
    operation = std::make_unique<LineOperation>(*drives, options);
    ASSERT_EQ(sentence(operation->to_op()), "");
    supervisor = std::make_unique<LineSupervisor>(operation->master());
  }
};

TEST_F(HotConnect, ASlaveBehindTheMissingOneIsNotTakenForIt) {
  run({2});
  expect_undisturbed(2, [&] {
    drives->line().set_power(2, false);
    operation->run(milliseconds{20});
    supervisor->poll();
    // Slave 3 is now the third of the line, at the former position of slave 2.
    drives->line().set_power(3, false);
    operation->run(milliseconds{20});
    supervisor->poll();
    drives->line().set_power(3, true);
    for (int i = 0; i < 200; ++i) {
      operation->run(milliseconds{2});
      supervisor->poll();
    }
    EXPECT_TRUE(supervisor->operational(3)) << told();
    EXPECT_FALSE(supervisor->operational(2));
    drives->line().set_power(2, true);
    ASSERT_TRUE(wait_for_all(std::chrono::seconds{3})) << told();
  });
  EXPECT_TRUE(drives->all_in(AlState::kOp));
}

TEST_F(HotConnect, SlavesThatChangedPlacesAreKnownByTheirAliases) {
  run({2, 3});
  expect_undisturbed(2, [&] {
    // As if each had been plugged in at the other's position.
    set_alias(2, 0x0308);
    set_alias(3, 0x0207);
    ASSERT_TRUE(wait_for_all(std::chrono::seconds{3})) << told();
  });
  const auto station = [this](std::size_t at) {
    return drives->slave(at).esc().memory().get(wire::reg::kStationAddress);
  };
  EXPECT_EQ(station(2), operation->master().slaves()[3].info.ref.station);
  EXPECT_EQ(station(3), operation->master().slaves()[2].info.ref.station);
  EXPECT_TRUE(drives->all_in(AlState::kOp));
}

}  // namespace
}  // namespace driveline::bus_test
