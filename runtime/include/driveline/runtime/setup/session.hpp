#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>
#include "driveline/runtime/error.hpp"

#include "driveline/port/capture_port.hpp"
#include "driveline/port/interface_lock.hpp"
#include "driveline/port/interface_port.hpp"
#include "driveline/port/redundant_port.hpp"
#include "driveline/runtime/setup/composition.hpp"
#include "driveline/runtime/setup/line_orders.hpp"
#include "driveline/runtime/setup/line_session.hpp"

namespace driveline::runtime {

/// The bus to open.
struct BusOptions {
  std::string config;      ///< line description; may be empty when `interface` is given
  std::string interface;   ///< replaces the simulated line of the file
  std::string interface2;  ///< interface at the far end of a ring
  bool virtual_time = false;
  bool cycle = false;        ///< a cycle will run: use [bus] port of the file; otherwise a packet socket suffices
  DeviceRegistry devices{};  ///< families that the line description may name
};

/// Takes the locks of `interfaces`. Error: another process holds one of them (kInterfaceBusy); `would` is what this
/// process was about to do, for the sentence. With `force`, locks of other processes are skipped.
[[nodiscard]] Result<std::vector<port::InterfaceLock>> take_locks(std::span<const std::string> interfaces, bool force,
                                                                  std::string_view would);

/// An open bus of EtherCAT: clock, port, and the simulated line or interface of the port.
class Session final : public LineSession {
 public:
  /// Reads the configuration, opens the interface or builds the simulated line, and the capture if it is configured.
  [[nodiscard]] static Result<std::unique_ptr<Session>> open(const BusOptions& options, const Adjust& adjust = {});
  /// Same for a configuration in memory; BusOptions::config is ignored.
  [[nodiscard]] static Result<std::unique_ptr<Session>> open(LineConfig config, const BusOptions& options,
                                                             const Adjust& adjust = {});

  /// Finishes the capture unless close_capture() has done so.
  ~Session() override;
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  [[nodiscard]] Result<void> claim(bool force, std::string_view would) override;
  /// Whether another process of this program has claimed the line.
  [[nodiscard]] bool claimed_by_another() const;

  /// Returns why no frame can pass now, with the remedy; empty: one of the interfaces has a link, or the line is
  /// simulated in this process.
  [[nodiscard]] std::string no_link() const;

  [[nodiscard]] const LineConfig& config() const noexcept override { return config_; }
  /// Whether there is a line description.
  [[nodiscard]] bool has_config() const noexcept { return has_config_; }
  /// For a line without a description: sets the slaves that were found instead of those of a file.
  void use_found_slaves(std::vector<SlaveConfig> slaves) { config_.slaves = std::move(slaves); }
  [[nodiscard]] rt::Clock& clock() noexcept override { return *clock_; }
  /// Returns the port of the bus; frames pass the capture if there is one.
  [[nodiscard]] port::Port& port() noexcept { return capture_ ? static_cast<port::Port&>(*capture_) : *wire_; }
  /// Returns the two ends of a ring; null: the line has one end.
  [[nodiscard]] port::RedundantPort* ring() const noexcept { return ring_.get(); }
  /// Returns the line in this process; null: the bus is a network interface.
  [[nodiscard]] slaves::SimulatedLine* simulated_line() const noexcept { return line_.get(); }
  /// Returns the commands to the line in this process, which are executed when a frame is sent; for one thread at a
  /// time. Null: the bus is a network interface.
  [[nodiscard]] LineOrders* line_orders() const noexcept { return orders_.get(); }
  /// An interface of the bus, and how it was opened.
  struct Wire {
    std::string interface;                ///< name of the interface
    std::string access_method;            ///< port::InterfacePort::access_method()
    std::vector<std::string> steps_down;  ///< port::OpenInterface::steps_down
  };
  /// Returns one entry for each end; empty: the line is simulated in this process.
  [[nodiscard]] const std::vector<Wire>& wires() const noexcept { return wires_; }
  /// Returns the time by which the port takes frames before they leave (Port::hold_until()); 0: it sends at once.
  [[nodiscard]] std::chrono::nanoseconds launch_ahead() const noexcept { return launch_ahead_; }
  [[nodiscard]] bool virtual_time() const noexcept override { return virtual_time_; }
  [[nodiscard]] Result<Capture> close_capture() override;

 private:
  Session() = default;
  [[nodiscard]] Result<void> take_options(const BusOptions& options, const Adjust& adjust);
  [[nodiscard]] Result<void> open_bus();
  [[nodiscard]] Result<void> open_interfaces();
  [[nodiscard]] Result<std::unique_ptr<port::InterfacePort>> open_interface(const std::string& interface);
  /// Returns an error if none of the interfaces has a link.
  [[nodiscard]] Result<void> must_have_link() const;
  void join_ends(port::Port& primary, port::Port& secondary);

  LineConfig config_;
  bool has_config_ = false;
  bool virtual_time_ = false;
  bool cycle_ = false;
  std::unique_ptr<rt::Clock> clock_;
  std::unique_ptr<slaves::SimulatedLine> line_;
  std::unique_ptr<LineOrders> orders_;
  std::unique_ptr<port::Port> ordered_;     ///< the primary interface of line_, which executes the commands
  std::vector<port::InterfaceLock> locks_;  ///< none: not claimed
  std::unique_ptr<port::InterfacePort> end_;
  std::unique_ptr<port::InterfacePort> end2_;
  std::vector<Wire> wires_;
  std::chrono::nanoseconds launch_ahead_{};
  std::unique_ptr<port::RedundantPort> ring_;
  port::Port* wire_ = nullptr;
  std::unique_ptr<port::CapturePort> capture_;
  bool capture_closed_ = false;
};

}  // namespace driveline::runtime
