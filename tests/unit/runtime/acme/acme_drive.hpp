#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "driveline/slaves/cia402/power_state_machine.hpp"
#include "driveline/slaves/generic/generic_device.hpp"

namespace driveline::acme {

constexpr std::uint32_t kVendorId = 0xE000ACE0;
constexpr std::uint32_t kProductCode = 0x00000A1D;
/// Vendor object: time between two setpoints, in us. The drive does not switch on before it has been written.
constexpr std::uint16_t kSetpointTime = 0x4001;

/// The common part of all drives of this vendor: six PDOs, the objects of CiA 402 in them, 60C2h and 4001h.
[[nodiscard]] std::shared_ptr<const slaves::generic::DeviceModel> drive_model();

/// A simulated drive without inertia that knows only CSP: it moves to a setpoint when the next one arrives.
class AcmeDrive final : public slaves::Device {
 public:
  AcmeDrive(std::int32_t start_increments, std::uint32_t serial_number);

  /// The present value of an object of its dictionary.
  [[nodiscard]] std::uint64_t object(std::uint16_t index, std::uint8_t subindex) const;

  // Device
  [[nodiscard]] const slaves::DeviceProfile& profile() const noexcept override { return bus_.profile(); }
  [[nodiscard]] std::size_t process_data_size(std::size_t sync_manager) const noexcept override {
    return bus_.process_data_size(sync_manager);
  }
  [[nodiscard]] wire::AlStatusCode transition(wire::AlState from, wire::AlState to) noexcept override {
    return bus_.transition(from, to);
  }
  void fall_back(wire::AlState from, wire::AlState to, wire::AlStatusCode reason) noexcept override {
    bus_.fall_back(from, to, reason);
  }
  void write_outputs(std::size_t sync_manager, std::span<const std::byte> data) noexcept override;
  void read_inputs(std::size_t sync_manager, std::span<std::byte> data) noexcept override {
    bus_.read_inputs(sync_manager, data);
  }
  void mailbox_request(std::span<const std::byte> mailbox) override { bus_.mailbox_request(mailbox); }
  [[nodiscard]] std::size_t mailbox_reply(std::span<std::byte> out) override { return bus_.mailbox_reply(out); }
  void advance(std::chrono::nanoseconds now) noexcept override;
  [[nodiscard]] std::chrono::nanoseconds process_data_period() const noexcept override {
    return bus_.process_data_period();
  }

 private:
  [[nodiscard]] double output(std::size_t number) const noexcept {
    return bus_.signal({slaves::SignalId::Direction::kOutput, number});
  }

  slaves::generic::GenericDevice bus_;
  slaves::PowerStateMachine power_;
  std::chrono::nanoseconds last_{0};
  std::int32_t position_;
  std::int32_t target_;  ///< previous setpoint
};

}  // namespace driveline::acme
