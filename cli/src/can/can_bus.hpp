#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/canopen_client/bus_link.hpp"
#include "driveline/canopen_client/node_states.hpp"
#include "driveline/canopen_client/sdo_client.hpp"
#include "driveline/canopen_port/can_capture.hpp"
#include "driveline/canopen_port/open_can_port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/runtime/can_line/can_line_config.hpp"
#include "failure.hpp"

namespace driveline::cli {

/// Whether a text that selects an interface selects a CAN bus: it begins with the name of a protocol (`slcan:`,
/// `socketcan:`, `socketcand:`, `cannelloni:`), or is a CAN interface of the kernel.
[[nodiscard]] bool names_can_interface(std::string_view interface);
/// Whether --config and --iface select a CAN bus; the interface decides where both are given.
[[nodiscard]] bool selects_can(const std::string& config, const std::string& interface);

/// A node of the line description.
struct DescribedNode {
  std::uint8_t node = 0;  ///< node-ID
  std::string name;       ///< in the description
};

/// How a CAN bus is opened.
struct CanBusOptions {
  std::string config;                     ///< line description; may be empty when `interface` is given
  std::string interface;                  ///< replaces the simulated line of the file
  std::optional<std::uint32_t> bit_rate;  ///< in bit/s; empty: that of the description, else 1 Mbit/s
  bool real_time = false;                 ///< a simulated line runs in the time of the machine, and as it starts
  bool listen_only = false;               ///< neither sends nor acknowledges, where the adapter can
  bool error_frames = false;              ///< reports error frames, where the adapter can
  std::string log{};                      ///< file for a log of candump; empty: none
  std::string pcap{};                     ///< file for a capture in pcapng; empty: none
};

/// An open CAN bus: the port, its clock, and what is known of the nodes.
class CanBus {
 public:
  /// Reads the description, opens the port, or simulates the line in this process. A simulated line has started when
  /// this returns, unless it runs in real time: its nodes have sent their boot-up messages.
  [[nodiscard]] static Outcome<std::unique_ptr<CanBus>> open(const CanBusOptions& options);
  CanBus(const CanBus&) = delete;
  CanBus& operator=(const CanBus&) = delete;

  /// The port as commands use it; ends waiting when a signal stops the program.
  [[nodiscard]] canopen::BusLink& link() noexcept { return link_; }
  /// The clock of the port.
  [[nodiscard]] rt::Clock& clock() noexcept { return *parts_.clock; }
  /// States and emergencies of the nodes since the bus was opened.
  [[nodiscard]] const canopen::NodeStates& states() const noexcept { return states_; }
  /// Nodes of the description, in its order; none without one.
  [[nodiscard]] const std::vector<DescribedNode>& described() const noexcept { return described_; }
  /// Name of a node in the description; empty: none.
  [[nodiscard]] std::string_view name_of(std::uint8_t node) const noexcept;
  /// Bit rate in bit/s.
  [[nodiscard]] std::uint32_t bit_rate() const noexcept { return bit_rate_; }
  /// Name of the bus, for messages and logs.
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  /// Waits until frames that were sent have left: an adapter drops those that wait when its user goes. `count`: how
  /// many were sent.
  void let_frames_leave(std::size_t count);
  /// Writes out what the captures have; nothing is captured any more. Failure: a file is not complete.
  [[nodiscard]] Outcome<void> finish_captures();
  /// For commands that have changed something: prints on stderr that the changes to a line simulated in this process
  /// are lost when it ends.
  void tell_what_ends() const;

 private:
  /// What frames pass: the clock, the port, and the captures, the outermost last.
  struct Parts {
    std::unique_ptr<rt::Clock> clock;
    std::unique_ptr<canopen::CanPort> port;
    std::vector<std::unique_ptr<canopen::CanCapture>> captures;

    [[nodiscard]] canopen::CanPort& outermost() const { return captures.empty() ? *port : *captures.back(); }
    [[nodiscard]] Outcome<void> capture(const std::string& file, const std::string& interface);
  };

  explicit CanBus(Parts parts);
  void wait_for_boot_up();

  Parts parts_;
  canopen::NodeStates states_;
  canopen::BusLink link_;
  std::vector<DescribedNode> described_;
  std::string name_;
  std::uint32_t bit_rate_ = 1'000'000;
  bool simulated_ = false;
};

/// Turns an error on the bus into a failure of the program.
[[nodiscard]] inline tl::unexpected<Failure> can_failure(const canopen::ClientError& error) {
  return failed(canopen::describe(error));
}

}  // namespace driveline::cli
