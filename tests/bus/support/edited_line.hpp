#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "drive_line.hpp"
#include "driveline/esi/sii.hpp"

namespace driveline::bus_test {

/// A device with an edited profile (EEPROM, sync managers, identification) and the behaviour of the inner device.
class EditedDevice final : public slaves::Device {
 public:
  EditedDevice(std::unique_ptr<slaves::Device> inner, slaves::DeviceProfile profile)
      : inner_(std::move(inner)), profile_(std::move(profile)) {}

  [[nodiscard]] const slaves::DeviceProfile& profile() const noexcept override { return profile_; }
  [[nodiscard]] std::size_t process_data_size(std::size_t sync_manager) const noexcept override {
    return inner_->process_data_size(sync_manager);
  }
  [[nodiscard]] wire::AlStatusCode transition(wire::AlState from, wire::AlState to) noexcept override {
    if (judges) {
      if (const auto refusal = judges(from, to); refusal != wire::AlStatusCode::kNoError) return refusal;
    }
    return inner_->transition(from, to);
  }
  void fall_back(wire::AlState from, wire::AlState to, wire::AlStatusCode reason) noexcept override {
    inner_->fall_back(from, to, reason);
  }
  void write_outputs(std::size_t sync_manager, std::span<const std::byte> data) noexcept override {
    inner_->write_outputs(sync_manager, data);
  }
  void read_inputs(std::size_t sync_manager, std::span<std::byte> data) noexcept override {
    inner_->read_inputs(sync_manager, data);
  }
  [[nodiscard]] bool takes_mailbox(std::span<const std::byte> mailbox) const noexcept override {
    return inner_->takes_mailbox(mailbox);
  }
  bool connect_network(slaves::EthernetLink* network) override { return inner_->connect_network(network); }
  void show(slaves::DeviceStatus& out) const noexcept override { inner_->show(out); }
  void mailbox_request(std::span<const std::byte> mailbox) override;
  [[nodiscard]] std::size_t mailbox_reply(std::span<std::byte> out) override;
  void advance(nanoseconds now) noexcept override { inner_->advance(now); }
  [[nodiscard]] nanoseconds process_data_period() const noexcept override { return inner_->process_data_period(); }

  /// Mailbox messages that the slave sends ahead of its own answers.
  std::vector<std::vector<std::byte>> says_first;
  /// Changes a mailbox message of the master before the device receives it.
  std::function<void(std::span<std::byte> mailbox)> changes_request;
  /// Called with every mailbox message that the master writes.
  std::function<void(std::span<const std::byte> mailbox)> hears;
  /// Called at each change of state; returns why the device refuses it.
  std::function<wire::AlStatusCode(wire::AlState from, wire::AlState to)> judges;
  /// Whether a mailbox message of the master is lost in the slave.
  std::function<bool(std::span<const std::byte> mailbox)> swallows;
  /// Changes an answer before it is sent; returns its new length.
  std::function<std::size_t(std::span<std::byte> out, std::size_t length)> changes_answer;

 private:
  std::unique_ptr<slaves::Device> inner_;
  slaves::DeviceProfile profile_;
};

/// A line of MSD drives whose profiles are edited.
class EditedLine {
 public:
  using Edit = std::function<void(std::size_t drive, slaves::DeviceProfile& profile)>;
  using Options = std::function<slaves::SlaveOptions(std::size_t drive)>;
  explicit EditedLine(std::size_t drives, const Edit& edit = {}, const Options& options = {},
                      std::optional<slaves::Wiring> wiring = std::nullopt);

  rt::VirtualClock clock;
  [[nodiscard]] slaves::SimulatedLine& line() noexcept { return *line_; }
  [[nodiscard]] EditedDevice& device(std::size_t drive) noexcept { return *devices_[drive]; }
  [[nodiscard]] slaves::Slave& slave(std::size_t drive) noexcept { return line_->slave(drive); }

 private:
  std::vector<EditedDevice*> devices_;
  std::unique_ptr<slaves::SimulatedLine> line_;
};

/// Gives the EEPROM in `profile` another station alias, with a valid checksum.
void set_alias(slaves::DeviceProfile& profile, std::uint16_t alias);

}  // namespace driveline::bus_test
