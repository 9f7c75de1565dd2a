#pragma once

#include <deque>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "driveline/canopen_master/can_master.hpp"
#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/msd/can/msd_can_drive.hpp"
#include "support/canopen_sample.hpp"
#include "support/scripted_node.hpp"

/// A CAN line under the whole CANopen master on virtual time, whose nodes can be harmed.
namespace driveline::bus_test {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// A port to a simulated bus that shows when its adapter is bus off.
class AdapterPort final : public canopen::CanPort, private slaves::can::Node {
 public:
  AdapterPort(slaves::can::Bus& bus, rt::Clock& clock) : bus_(bus), clock_(clock) { bus.attach(*this); }

  [[nodiscard]] canopen::SendStatus send(const canopen::Frame& frame) noexcept override;
  [[nodiscard]] std::optional<canopen::ReceivedFrame> receive() noexcept override;
  bool wait_readable(nanoseconds deadline) noexcept override;
  [[nodiscard]] canopen::PortStatistics statistics() const noexcept override;
  [[nodiscard]] slaves::can::Controller& controller() noexcept { return *controller_; }

 private:
  void connected(slaves::can::Controller& controller) override { controller_ = &controller; }
  void receive(const canopen::Frame& frame, nanoseconds now) override { arrived_.push_back({frame, now}); }
  void advance(nanoseconds /*now*/) override {}
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return slaves::can::kNever; }

  slaves::can::Bus& bus_;
  rt::Clock& clock_;
  slaves::can::Controller* controller_ = nullptr;
  std::deque<canopen::ReceivedFrame> arrived_;
};

/// A node of the line: a drive, or a device that is none.
class HarmedNode {
 public:
  virtual ~HarmedNode() = default;
  [[nodiscard]] virtual slaves::cia301::Device& device() noexcept = 0;
  /// Value of an object without the bus.
  [[nodiscard]] virtual std::uint64_t value(std::uint16_t index, std::uint8_t subindex) const = 0;
  /// Switches the whole node off, or on again, upon which it starts.
  void set_power(bool on);

 protected:
  HarmedNode() = default;
  HarmedNode(const HarmedNode&) = default;
  HarmedNode& operator=(const HarmedNode&) = default;
};

/// Two or three drives with the node-IDs from 3 on, one of them in node guarding; behind them a device that is none;
/// and a drive with the node-ID of the first and another serial number, which is switched off. The times of the plan
/// are short, so that a recovery takes a tenth of a second.
class RecoveryLine {
 public:
  static constexpr nanoseconds kPeriod = milliseconds{4};
  static constexpr milliseconds kPatience{60};         ///< from the last sign of life of a node until it is lost
  static constexpr milliseconds kMasterTolerance{70};  ///< of a node that hears the heartbeat of the master
  static constexpr std::uint8_t kFirstNode = 3;
  static constexpr std::uint8_t kMasterId = 126;

  explicit RecoveryLine(std::mt19937& random);

  /// Takes the line to operation; what failed, empty: nothing.
  [[nodiscard]] std::string start();
  /// Lets the master operate the line, and collects what it tells.
  void live(nanoseconds duration);
  [[nodiscard]] std::string shut_down();

  [[nodiscard]] std::size_t size() const noexcept { return nodes_.size(); }
  [[nodiscard]] HarmedNode& node(std::size_t number) noexcept { return *nodes_[number]; }
  /// The drive of a node; null: it is none.
  [[nodiscard]] slaves::msd::DriveCore* drive(std::size_t number) noexcept;
  /// The drive with the node-ID of node 0 that is another device.
  [[nodiscard]] HarmedNode& other_device() noexcept { return *other_; }
  [[nodiscard]] std::uint8_t id(std::size_t number) const noexcept { return plan_.nodes[number].id; }
  [[nodiscard]] const canopen::NodePlan& plan(std::size_t number) const noexcept { return plan_.nodes[number]; }
  /// Whether the node, and every other one but `except`, exchanges process data.
  [[nodiscard]] bool fine(std::optional<std::size_t> except = {}) noexcept;
  /// The first object of a node that is not as the plan has it; empty: there is none.
  [[nodiscard]] std::string changed_object();

  [[nodiscard]] slaves::can::Bus& bus() noexcept { return bus_; }
  [[nodiscard]] AdapterPort& port() noexcept { return port_; }
  /// Another master on the bus.
  [[nodiscard]] slaves::can::ScriptedNode& stranger() noexcept { return stranger_; }
  [[nodiscard]] canopen::CanMaster& master() noexcept { return *master_; }
  /// Everything that the master has told in operation.
  [[nodiscard]] const std::vector<canopen::MasterEvent>& history() const noexcept { return history_; }
  [[nodiscard]] std::string sentence(const canopen::MasterEvent& event) const;
  [[nodiscard]] nanoseconds now() const noexcept { return clock_.now(); }

 private:
  void add_drive(slaves::msd::Variant variant, bool guarded);
  void add_device();
  [[nodiscard]] std::string sentences(const canopen::MasterResult<void>& result) const;
  void collect();

  rt::VirtualClock clock_{std::chrono::seconds{1}};
  slaves::can::Bus bus_;
  AdapterPort port_{bus_, clock_};  ///< at place 0 of the bus
  slaves::can::ScriptedNode stranger_;
  std::vector<std::unique_ptr<HarmedNode>> nodes_;
  std::vector<slaves::msd::DriveCore*> drives_;
  std::unique_ptr<HarmedNode> other_;
  canopen::MasterPlan plan_;
  std::unique_ptr<canopen::CanMaster> master_;
  std::vector<canopen::MasterEvent> history_;
};

}  // namespace driveline::bus_test
