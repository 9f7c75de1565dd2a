#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/canopen_port/can_capture.hpp"
#include "driveline/canopen_port/can_port.hpp"
#include "driveline/port/interface_lock.hpp"
#include "driveline/runtime/can_line/simulated_can_port.hpp"
#include "driveline/runtime/setup/line_session.hpp"

namespace driveline::runtime {

/// An open CAN bus: clock, port with its capture, and the line in this process if there is one.
class CanSession final : public LineSession {
 public:
  /// Selects the bus; overrides the description.
  struct Options {
    std::string interface;      ///< text of canopen::open_can_port(); empty: that of the description
    bool virtual_time = false;  ///< the line in this process runs on virtual time
  };

  /// Opens the port that `config` or `options` name, or simulates the line in this process, and the capture if one is
  /// configured: a log of candump, or pcapng when the name of the file ends so. Precondition: `config` describes a CAN
  /// line. Errors: contradictory settings (kSetting), the port or the capture cannot be opened (kMachine).
  [[nodiscard]] static Result<std::unique_ptr<CanSession>> open(LineConfig config, const Options& options,
                                                                const Adjust& adjust = {});
  /// Finishes the capture unless close_capture() has done so.
  ~CanSession() override;

  [[nodiscard]] const LineConfig& config() const noexcept override { return config_; }
  [[nodiscard]] rt::Clock& clock() noexcept override { return *clock_; }
  [[nodiscard]] bool virtual_time() const noexcept override { return virtual_time_; }
  /// Two texts that name the same bus, as a host by name and by address, are two claims.
  [[nodiscard]] Result<void> claim(bool force, std::string_view would) override;
  [[nodiscard]] Result<Capture> close_capture() override;

  /// Returns the port of the bus; frames pass the capture if there is one.
  [[nodiscard]] canopen::CanPort& port() noexcept;
  /// Returns the line in this process, to inject faults or to look at its devices, on the thread that uses the port;
  /// null: the bus is elsewhere.
  [[nodiscard]] CanLine* simulated_line() noexcept { return simulated_ != nullptr ? &simulated_->line() : nullptr; }
  /// Returns the way to the line in this process for other threads; null: the bus is elsewhere.
  [[nodiscard]] CanLineCalls* line_calls() noexcept { return simulated_ != nullptr ? &simulated_->calls() : nullptr; }
  /// Returns the bus for messages: its interface, or "the simulated bus".
  [[nodiscard]] std::string bus_name() const;

 private:
  CanSession() = default;
  [[nodiscard]] Result<void> take_options(const Options& options, const Adjust& adjust);
  [[nodiscard]] Result<void> open_port();
  [[nodiscard]] Result<void> open_capture();

  LineConfig config_;
  bool virtual_time_ = false;
  std::unique_ptr<rt::Clock> clock_;
  std::vector<port::InterfaceLock> locks_;  ///< none: not claimed
  std::unique_ptr<canopen::CanPort> port_;
  SimulatedCanPort* simulated_ = nullptr;  ///< port_, if it leads to a line in this process
  std::unique_ptr<canopen::CanCapture> capture_;
  bool capture_closed_ = false;
};

}  // namespace driveline::runtime
