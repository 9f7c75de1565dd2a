#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "driveline/slaves/device.hpp"
#include "driveline/slaves/esc/esc.hpp"
#include "driveline/slaves/persona/persona.hpp"
#include "persona/mailbox_habits.hpp"

namespace driveline::slaves {

/// A device with quirks: passes everything on to another device, except what its personas change. Belongs to the thread
/// that drives the line.
class PersonaDevice final : public Device {
 public:
  /// `device` must not be null.
  PersonaDevice(std::unique_ptr<Device> device, std::span<const Persona> personas);
  PersonaDevice(const PersonaDevice&) = delete;
  PersonaDevice& operator=(const PersonaDevice&) = delete;
  ~PersonaDevice() override = default;

  /// Connects the registers of the slave controller, which must outlive the device.
  void connect(Esc& esc) noexcept { esc_ = &esc; }

  [[nodiscard]] const DeviceProfile& profile() const noexcept override { return profile_; }
  [[nodiscard]] std::size_t process_data_size(std::size_t sync_manager) const noexcept override {
    return device_->process_data_size(sync_manager);
  }
  [[nodiscard]] std::optional<MappedEntry> mapped_input(std::uint16_t index,
                                                        std::uint8_t subindex) const noexcept override {
    return device_->mapped_input(index, subindex);
  }
  [[nodiscard]] wire::AlStatusCode transition(wire::AlState from, wire::AlState to) noexcept override;
  void fall_back(wire::AlState from, wire::AlState to, wire::AlStatusCode reason) noexcept override {
    device_->fall_back(from, to, reason);
  }
  void restart() override;
  void eeprom_loaded(std::span<const std::byte> image, bool valid) noexcept override {
    device_->eeprom_loaded(image, valid);
  }
  [[nodiscard]] bool firmware_valid() const noexcept override { return device_->firmware_valid(); }
  [[nodiscard]] wire::AlStatusCode check_mapping() const noexcept override { return device_->check_mapping(); }
  [[nodiscard]] bool inputs_valid() const noexcept override { return device_->inputs_valid(); }
  [[nodiscard]] SyncDemand sync_demand() const noexcept override;
  void sync_event(SyncSignal signal, std::chrono::nanoseconds time) noexcept override {
    device_->sync_event(signal, time);
  }
  void sync_margin(const SyncMargin& margin) noexcept override { device_->sync_margin(margin); }
  void write_outputs(std::size_t sync_manager, std::span<const std::byte> data) noexcept override {
    device_->write_outputs(sync_manager, data);
  }
  void read_inputs(std::size_t sync_manager, std::span<std::byte> data) noexcept override;
  [[nodiscard]] bool takes_mailbox(std::span<const std::byte> mailbox) const noexcept override {
    return device_->takes_mailbox(mailbox);
  }
  void mailbox_request(std::span<const std::byte> mailbox) override;
  [[nodiscard]] std::size_t mailbox_reply(std::span<std::byte> out) override;
  bool connect_network(EthernetLink* network) override { return device_->connect_network(network); }
  void show(DeviceStatus& out) const noexcept override { device_->show(out); }
  void advance(std::chrono::nanoseconds now) noexcept override;
  [[nodiscard]] DeviceSignals* signals() noexcept override { return device_->signals(); }
  [[nodiscard]] std::chrono::nanoseconds process_data_period() const noexcept override {
    return device_->process_data_period();
  }

 private:
  [[nodiscard]] bool owns_eeprom() noexcept;
  void set_statusword(std::size_t sync_manager, std::span<std::byte> data) const noexcept;
  void delay_mode(std::size_t sync_manager, std::span<std::byte> data) noexcept;

  std::unique_ptr<Device> device_;
  std::vector<Persona> personas_;
  DeviceProfile profile_;
  MailboxHabits mailbox_;
  Esc* esc_ = nullptr;
  std::chrono::nanoseconds now_{0};
  bool safeop_refused_ = false;  ///< the transition that fails once has failed
  std::uint64_t mode_ = 0;       ///< mode of the inputs of the device
  std::uint64_t mode_shown_ = 0;
  std::chrono::nanoseconds mode_since_{0};  ///< time of the last change of mode_
};

}  // namespace driveline::slaves
