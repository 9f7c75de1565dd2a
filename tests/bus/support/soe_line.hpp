#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "driveline/ecat_master/error/facts.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/ecat_master/soe/soe_client.hpp"
#include "driveline/esi/device_description.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "driveline/slaves/line/simulated_line.hpp"

namespace driveline::bus_test {

// Operation data of the simulated drives (slaves::generic::SoeDrives).
inline constexpr ecat_master::facts::SoeDatum kGain{0, {100}};
inline constexpr ecat_master::facts::SoeDatum kReset{0, {99}};  ///< procedure command
/// A text of up to 512 bytes.
inline constexpr ecat_master::facts::SoeDatum kApplication{0, {142}};

/// A device with two drives that knows SoE and CoE, with mailboxes of `mailbox` bytes at 1000h and 1400h.
[[nodiscard]] esi::DeviceDescription soe_device(std::uint16_t mailbox);

/// soe_device(128) without object dictionary and PDOs: the drives themselves select their process data.
[[nodiscard]] esi::DeviceDescription drive_by_idn();

/// A list in the form of a mailbox message: length and capacity, then the content.
[[nodiscard]] std::vector<std::byte> as_list(std::span<const std::byte> content);

/// Two devices with drives behind SoE, and their master, on virtual time.
struct SoeLine {
  explicit SoeLine(std::uint16_t mailbox = 128) : SoeLine(soe_device(mailbox)) {}
  /// `rules`: checks of the drives of the second device.
  explicit SoeLine(const esi::DeviceDescription& device, const std::vector<slaves::generic::SoeRule>& rules = {})
      : line(make(device, rules)), master(*line, clock) {}

  /// Takes the line to PREOP; returns the sentence of the error, empty on success.
  [[nodiscard]] std::string to_pre_op();
  [[nodiscard]] ecat_master::SoeClient soe(std::uint16_t position = 0) { return {master.mailboxes(), position}; }
  /// Goes from the scan to SAFEOP; returns the sentence of the error, empty on success.
  [[nodiscard]] std::string to_safe_op(std::vector<ecat_master::SlavePlan> plans = {});
  /// Starts the cycle and goes to OP; returns the sentence of the error, empty on success.
  [[nodiscard]] std::string to_op();
  /// Simulates that the controller of a device reports an expired watchdog to it.
  void lose_process_data(std::size_t device) {
    devices.at(device)->fall_back(wire::AlState::kOp, wire::AlState::kPreOp, wire::AlStatusCode::kSyncManagerWatchdog);
  }

  rt::VirtualClock clock{std::chrono::milliseconds{1}};
  std::array<slaves::generic::GenericDevice*, 2> devices{};  ///< devices of the line
  std::array<slaves::Slave*, 2> stations{};                  ///< slaves of the line
  std::unique_ptr<slaves::SimulatedLine> line;
  ecat_master::Master master;

 private:
  [[nodiscard]] std::unique_ptr<slaves::SimulatedLine> make(const esi::DeviceDescription& device,
                                                            const std::vector<slaves::generic::SoeRule>& rules);
};

}  // namespace driveline::bus_test
