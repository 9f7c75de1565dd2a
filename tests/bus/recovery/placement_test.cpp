// Several slaves of the same type are missing at once and return one by one: each must get its own identity,
// configuration and setpoints again, whatever the wiring and the order.
#include <gmock/gmock.h>

#include <cmath>

#include "drive_line.hpp"
#include "driveline/ecat_master/recovery/line_supervisor.hpp"
#include "driveline/esi/sii.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::LineSupervisor;
using motion::AxisPresence;
using motion::LossPolicy;
using motion::MotionFailure;
using motion::MotionPhase;
using wire::AlState;

constexpr std::size_t kSerialByte = 28;  // words 14 and 15 of the EEPROM

/// A hub and one slave at each of its ports.
slaves::Wiring star() {
  slaves::Wiring wiring(4);
  wiring.connect_master(slaves::MasterPort::kPrimary, {0, 0});
  wiring.connect({0, 3}, {1, 0});
  wiring.connect({0, 1}, {2, 0});
  wiring.connect({0, 2}, {3, 0});
  return wiring;
}

/// Slave 2 is on a branch of slave 1, slave 3 behind it; slaves 4 and 5 follow on the trunk.
slaves::Wiring branch() {
  slaves::Wiring wiring(6);
  wiring.connect_master(slaves::MasterPort::kPrimary, {0, 0});
  wiring.connect({0, 1}, {1, 0});
  wiring.connect({1, 3}, {2, 0});
  wiring.connect({2, 1}, {3, 0});
  wiring.connect({1, 1}, {4, 0});
  wiring.connect({4, 1}, {5, 0});
  return wiring;
}

void set_serial(slaves::Slave& slave, std::uint32_t serial) {
  auto& sii = slave.esc().sii();
  for (std::size_t i = 0; i < 4; ++i) sii.corrupt(kSerialByte + i, static_cast<std::byte>(serial >> 8 * i & 0xFF));
  sii.corrupt(14, static_cast<std::byte>(esi::sii_checksum(sii.image().first<esi::SiiConfigArea::kSize>())));
}

class Placement : public testing::Test {
 protected:
  void wire(slaves::Wiring wiring) {
    const auto count = wiring.slave_count();
    supervisor.reset();
    operation.reset();
    drives = std::make_unique<DriveLine>(count, slaves::SlaveOptions{}, slaves::LineOptions{}, std::move(wiring));
  }
  /// No drive has a serial number: only the position distinguishes them.
  void forget_serials() {
    for (std::size_t i = 0; i < drives->size(); ++i) set_serial(drives->slave(i), 0);
  }
  void run(LossPolicy policy = LossPolicy::kContinue) { run(drives->line(), policy); }
  void run(port::Port& port, LossPolicy policy = LossPolicy::kContinue) {
    RunOptions options;
    options.on_loss = policy;
    options.repeat = true;
    options.amplitude_rad = 0.3;
    options.plan_serials = plan_serials;
    options.accept_swapped_ports = accept_swapped;
    operation = std::make_unique<LineOperation>(*drives, port, options);
    ASSERT_EQ(sentence(operation->to_motion()), "");
    ASSERT_TRUE(operation->run_until(MotionPhase::kFollowing, std::chrono::seconds{2}));
    LineSupervisor::Settings settings;
    settings.state_timeout = std::chrono::seconds{1};
    supervisor = std::make_unique<LineSupervisor>(operation->master(), nullptr, settings);
    operation->run(milliseconds{50});
  }
  void live(nanoseconds duration) {
    const auto end = drives->clock.now() + duration;
    while (drives->clock.now() < end) {
      operation->run(milliseconds{5});
      supervisor->poll();
      operation->axis_samples.clear();
      operation->line_samples.clear();
      for (std::size_t i = 0; i < drives->size(); ++i) check(i);
    }
  }
  /// Checks that no slave ever has the station address of another, and that each enabled axis follows its own path.
  void check(std::size_t i) {
    const auto station = drives->slave(i).esc().memory().get(wire::reg::kStationAddress);
    for (const auto& slave : operation->master().slaves()) {
      if (slave.info.ref.position != i) {
        ASSERT_NE(station, slave.info.ref.station) << "slave " << i;
      }
    }
    if (!operation->motion().axes()[i].enabled()) return;
    ASSERT_NEAR(operation->motion().setpoints()[i].position, drives->drive(i).position_rad(), 0.15) << "drive " << i;
  }
  bool live_until(const std::function<bool()>& done, nanoseconds limit) {
    const auto end = drives->clock.now() + limit;
    while (!done() && drives->clock.now() < end && !HasFatalFailure()) live(milliseconds{5});
    return done();
  }
  bool wait_for(std::size_t slave) {
    return live_until(
        [&] { return supervisor->operational(slave) && operation->motion().presence(slave) == AxisPresence::kPresent; },
        std::chrono::seconds{8});
  }
  void power(std::initializer_list<std::size_t> which, bool on) {
    for (const auto slave : which) drives->line().set_power(slave, on);
  }
  [[nodiscard]] std::string told() const {
    std::string all;
    for (const auto& event : supervisor->history()) all += what_happened(event) + "\n";
    return all;
  }
  [[nodiscard]] std::string gone(std::initializer_list<int> which) const {
    std::string all;
    for (const int slave : which) all += "slave " + std::to_string(slave) + ": no longer answers\n";
    return all;
  }
  /// Slaves `first` and `second` are off; the second returns at once, the first much later.
  void later_one_comes_back_first(std::size_t first, std::size_t second, LossPolicy policy) {
    run(policy);
    power({first, second}, false);
    live(milliseconds{200});
    power({second}, true);
    if (policy == LossPolicy::kContinue) {
      ASSERT_TRUE(wait_for(second)) << told();
    } else {
      ASSERT_TRUE(live_until([&] { return supervisor->operational(second); }, std::chrono::seconds{5})) << told();
      EXPECT_EQ(operation->motion().phase(), MotionPhase::kWaiting);
    }
    live(milliseconds{300});
    EXPECT_FALSE(supervisor->operational(first)) << told();
    EXPECT_EQ(operation->motion().presence(first), AxisPresence::kMissing);
    power({first}, true);
    ASSERT_TRUE(wait_for(first)) << told();
    ASSERT_TRUE(wait_for(second)) << told();
    live(milliseconds{100});
    EXPECT_TRUE(drives->all_in(AlState::kOp));
    EXPECT_EQ(supervisor->recoveries(), 2U);
    EXPECT_EQ(told(), gone({static_cast<int>(first), static_cast<int>(second)}) + "slave " + std::to_string(second) +
                          ": back in OP\nslave " + std::to_string(first) + ": back in OP\n");
    EXPECT_EQ(operation->motion().failure().cause, MotionFailure::Cause::kNone);
    operation->motion().request_stop();
    ASSERT_TRUE(operation->run_until(MotionPhase::kIdle, std::chrono::seconds{3}));
    ASSERT_EQ(sentence(operation->master().shut_down()), "");
  }

  bool plan_serials = false;
  bool accept_swapped = false;
  std::unique_ptr<DriveLine> drives;
  std::unique_ptr<LineOperation> operation;
  std::unique_ptr<LineSupervisor> supervisor;
};

TEST_F(Placement, OnAStarTheLaterOneComesBackFirst) {
  for (const auto policy : {LossPolicy::kContinue, LossPolicy::kHold}) {
    for (const auto& [first, second] : {std::pair<std::size_t, std::size_t>{1, 2}, {2, 3}, {1, 3}}) {
      SCOPED_TRACE(first * 10 + second);
      wire(star());
      later_one_comes_back_first(first, second, policy);
    }
  }
}

TEST_F(Placement, OnAStarWithPlannedSerialNumbers) {
  plan_serials = true;
  wire(star());
  later_one_comes_back_first(1, 2, LossPolicy::kContinue);
}

TEST_F(Placement, OnAStarWithoutSerialNumbersThePlaceAloneDecides) {
  wire(star());
  forget_serials();
  later_one_comes_back_first(1, 2, LossPolicy::kContinue);
}

TEST_F(Placement, OnABranchTheTrunkComesBackBeforeTheBranch) {
  wire(branch());
  forget_serials();
  run();
  power({2, 3, 4, 5}, false);
  live(milliseconds{100});
  power({4, 5}, true);
  ASSERT_TRUE(wait_for(4) && wait_for(5)) << told();
  EXPECT_FALSE(supervisor->operational(2));
  EXPECT_FALSE(supervisor->operational(3));
  power({2, 3}, true);
  ASSERT_TRUE(wait_for(2) && wait_for(3)) << told();
  EXPECT_TRUE(drives->all_in(AlState::kOp));
  EXPECT_EQ(supervisor->recoveries(), 4U);
}

TEST_F(Placement, OnAStarWithASlaveWhoseCablesAreSwapped) {
  slaves::Wiring wiring(4);
  wiring.connect_master(slaves::MasterPort::kPrimary, {0, 0});
  wiring.connect({0, 3}, {1, 1});
  wiring.connect({0, 1}, {2, 0});
  wiring.connect({0, 2}, {3, 0});
  wire(std::move(wiring));
  forget_serials();
  accept_swapped = true;
  later_one_comes_back_first(1, 2, LossPolicy::kContinue);
}

TEST_F(Placement, ADriveInThePlaceOfAnotherIsRefusedAndThePlaceStaysOpen) {
  wire(star());
  run();
  power({1, 2}, false);
  live(milliseconds{50});
  // As if drive 2 had been plugged in at the position of drive 1.
  set_serial(drives->slave(1), 1002);
  power({1}, true);
  live(milliseconds{500});
  EXPECT_EQ(told(),
            gone({1, 2}) +
                "slave 1: not brought back to OP: slave 1: serial number is 0x000003EA but 0x000003E9 was there "
                "at start\n");
  EXPECT_EQ(drives->state(1), AlState::kInit) << "not changed";
  EXPECT_EQ(drives->slave(1).esc().memory().get(wire::reg::kStationAddress), 0U);
  // The correct slave returns.
  power({1}, false);
  set_serial(drives->slave(1), 1001);
  power({1, 2}, true);
  ASSERT_TRUE(wait_for(1) && wait_for(2)) << told();
  EXPECT_TRUE(drives->all_in(AlState::kOp));
}

TEST_F(Placement, ADriveThatWasPlannedByItsSerialNumberIsNotReplacedByAnother) {
  plan_serials = true;
  wire(star());
  run();
  power({1}, false);
  live(milliseconds{50});
  set_serial(drives->slave(1), 77);
  power({1}, true);
  live(milliseconds{300});
  EXPECT_EQ(
      told(),
      gone({1}) + "slave 1: not brought back to OP: slave 1: serial number is 0x0000004D but 0x000003E9 is planned\n");
  EXPECT_EQ(drives->slave(1).esc().memory().get(wire::reg::kStationAddress), 0U);
}

/// A port with unreliable DL status: the wiring of the line is unknown.
class WithoutWiring : public Placement {
 protected:
  void start() {
    port = std::make_unique<ChangingPort>(drives->line(), ChangingPort::Change{}, [](std::span<std::byte> frame) {
      auto cursor = wire::MutableDatagramCursor::open(frame);
      while (cursor && !cursor->done()) {
        auto datagram = cursor->next();
        if (!datagram) return;
        const auto& header = datagram->header;
        const bool dl_status = wire::is_logical(header.command) == false &&
                               header.address.ado() == wire::reg::kDlStatus.address && datagram->data.size() == 2;
        // All four ports open, which is impossible for a line of several slaves.
        if (dl_status) bytes::store_le<std::uint16_t>(datagram->data, 0xAAF1);
      }
    });
    run(*port);
    ASSERT_TRUE(operation->master().topology().slaves.empty());
  }
  std::unique_ptr<ChangingPort> port;
};

TEST_F(WithoutWiring, TheSerialNumberTellsWhoIsBack) {
  wire(star());
  start();
  power({1, 2}, false);
  live(milliseconds{50});
  power({2}, true);
  ASSERT_TRUE(wait_for(2)) << told();
  EXPECT_FALSE(supervisor->operational(1));
  power({1}, true);
  ASSERT_TRUE(wait_for(1)) << told();
  EXPECT_EQ(told(), gone({1, 2}) + "slave 2: back in OP\nslave 1: back in OP\n");
}

TEST_F(WithoutWiring, NobodyIsMovedWhenNothingTells) {
  wire(star());
  forget_serials();
  start();
  power({1, 2}, false);
  live(milliseconds{50});
  power({2}, true);
  live(milliseconds{600});
  const std::string doubt = ": of 2 missing slaves 1 came back, and neither wiring nor serial number identifies them\n";
  EXPECT_EQ(told(), gone({1, 2}) + "slave 1: not brought back to OP: slave 1" + doubt +
                        "slave 2: not brought back to OP: slave 2" + doubt);
  EXPECT_EQ(drives->state(2), AlState::kInit) << "not changed";
  // Both are present, so their order identifies them.
  power({1}, true);
  ASSERT_TRUE(wait_for(1) && wait_for(2)) << told();
  EXPECT_TRUE(drives->all_in(AlState::kOp));
}

}  // namespace
}  // namespace driveline::bus_test
