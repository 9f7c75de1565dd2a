#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "driveline/canopen_master/can_master.hpp"
#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/msd/can/msd_can_drive.hpp"
#include "support/scripted_node.hpp"

namespace driveline::canopen {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

/// A port to a simulated bus, in virtual time.
class SimulatedPort final : public CanPort, private slaves::can::Node {
 public:
  SimulatedPort(slaves::can::Bus& bus, rt::VirtualClock& clock) : bus_(&bus), clock_(&clock) { bus.attach(*this); }

  [[nodiscard]] SendStatus send(const Frame& frame) noexcept override {
    bus_->advance(clock_->now());
    if (unplugged) return SendStatus::kDown;
    return controller_->send(frame) ? SendStatus::kSent : SendStatus::kBusy;
  }
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override {
    bus_->advance(clock_->now());
    if (received_.empty() || unplugged) return std::nullopt;
    const auto frame = received_.front();
    received_.pop_front();
    return frame;
  }
  bool wait_readable(nanoseconds deadline) noexcept override {
    while (received_.empty() && bus_->now() < deadline) bus_->advance(std::min(deadline, bus_->next_event()));
    clock_->sleep_until(received_.empty() ? deadline : bus_->now());
    return !received_.empty();
  }
  [[nodiscard]] PortStatistics statistics() const noexcept override {
    PortStatistics statistics;
    statistics.down = unplugged;
    const bool off = controller_->errors().state() == slaves::can::ErrorState::kBusOff;
    statistics.state = off ? BusState::kBusOff : BusState::kErrorActive;
    return statistics;
  }
  [[nodiscard]] slaves::can::Controller& controller() noexcept { return *controller_; }

  bool unplugged = false;

 private:
  void connected(slaves::can::Controller& controller) override { controller_ = &controller; }
  void receive(const Frame& frame, nanoseconds now) override { received_.push_back({frame, now}); }
  void advance(nanoseconds /*now*/) override {}
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return slaves::can::kNever; }

  slaves::can::Bus* bus_;
  rt::VirtualClock* clock_;
  slaves::can::Controller* controller_ = nullptr;
  std::deque<ReceivedFrame> received_;
};

/// Two MSDs (3 and 4) and a ServoOne (5), which watches no heartbeat.
class SimulatedLine : public ::testing::Test {
 protected:
  SimulatedLine() {
    add_drive(3, slaves::msd::Variant::kMsd);
    add_drive(4, slaves::msd::Variant::kMsd);
    add_drive(5, slaves::msd::Variant::kServoOne);
    bus.attach(tool);
  }

  static NodePlan drive(std::uint8_t id, bool watches) {
    NodePlan node;
    node.name = "drive " + std::to_string(id);
    node.id = id;
    node.startup_sdos.push_back({0x60C2, 1, {std::byte{2}}});
    node.rpdos = {{.number = 1,
                   .transmission = 255,
                   .exchange = PdoExchange::kOnChange,
                   .objects = {{0x6040, 0, 16}, {0x6060, 0, 8}}},
                  {.number = 2, .objects = {{0x60C1, 1, 32}}}};
    node.tpdos = {{.number = 1, .objects = {{0x6041, 0, 16}, {0x6064, 0, 32}}},
                  {.number = 2,
                   .transmission = 255,
                   .exchange = PdoExchange::kOnChange,
                   .objects = {{0x6061, 0, 8}, {0x603F, 0, 16}}}};
    node.error_control.heartbeat = 50ms;
    node.error_control.master_tolerance = watches ? 100ms : 0ms;
    return node;
  }
  void add_drive(std::uint8_t id, slaves::msd::Variant variant) {
    slaves::msd::MsdParameters parameters;
    parameters.variant = variant;
    parameters.serial_number = 100U + id;
    slaves::msd::CanConnection connection;
    connection.dip_switch = {id};
    drives.push_back(std::make_unique<slaves::msd::MsdCanDrive>(parameters, connection));
    bus.attach(drives.back()->device());
    plan.nodes.push_back(drive(id, variant == slaves::msd::Variant::kMsd));
  }
  void make() { master = std::make_unique<CanMaster>(port, clock, plan, settings); }
  /// Boots, starts the cycle and the nodes.
  void operate() {
    make();
    ASSERT_EQ(failure(master->boot()), "");
    ASSERT_TRUE(start_cycle());
    ASSERT_EQ(failure(master->go_operational()), "");
    take_events();
  }
  [[nodiscard]] bool start_cycle() {
    return master
        ->start_cycle(nullptr, {}, {},
                      [this](CanCycle& cycle) { return std::make_unique<motion::InlineRunner>(cycle, clock); })
        .has_value();
  }
  /// The sentences of the errors; empty: there are none.
  [[nodiscard]] std::string failure(const MasterResult<void>& result) const {
    std::string text;
    if (result) return text;
    for (const auto& error : result.error()) text += describe(error, master->plan().nodes[error.node].name) + "\n";
    return text;
  }
  std::vector<MasterEvent::Kind> take_events() {
    std::vector<MasterEvent::Kind> kinds;
    events.clear();
    while (const auto event = master->take_event()) {
      events.push_back(*event);
      kinds.push_back(event->kind);
    }
    return kinds;
  }
  [[nodiscard]] NmtState state(std::size_t drive_number) const { return drives[drive_number]->device().state(); }
  [[nodiscard]] std::uint64_t value(std::size_t drive_number, std::uint16_t index, std::uint8_t subindex = 0) const {
    const auto& dictionary = drives[drive_number]->core().complete_values();
    return dictionary.raw(*dictionary.table().find(index, subindex));
  }
  /// EMCY messages that a tool on the bus has heard of a node.
  [[nodiscard]] long emergencies(std::uint8_t id) const {
    const auto& all = tool.received;
    return std::count_if(all.begin(), all.end(),
                         [&](const auto& one) { return one.frame.identifier.value == 0x80U + id; });
  }

  rt::VirtualClock clock{1s};
  slaves::can::Bus bus;
  std::vector<std::unique_ptr<slaves::msd::MsdCanDrive>> drives;
  slaves::can::ScriptedNode tool;
  SimulatedPort port{bus, clock};
  MasterPlan plan{.period = 2ms, .master_id = 126, .master_heartbeat = 30ms};
  CanMaster::Settings settings;
  std::unique_ptr<CanMaster> master;
  std::vector<MasterEvent> events;
};

}  // namespace driveline::canopen
