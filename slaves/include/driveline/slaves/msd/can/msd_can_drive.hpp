#pragma once

#include "driveline/slaves/canopen/device.hpp"
#include "driveline/slaves/msd/can/dip_switch.hpp"
#include "driveline/slaves/msd/can/rpdo_uses.hpp"
#include "driveline/slaves/msd/can/telegram_watch.hpp"
#include "driveline/slaves/msd/core/drive_core.hpp"

namespace driveline::slaves::msd {

/// What the CAN connection of a drive has beyond MsdParameters.
struct CanConnection {
  DipSwitch dip_switch;                                                 ///< S4
  std::optional<Series> series;                                         ///< housing; empty: of the variant
  std::chrono::nanoseconds sdo_delay = std::chrono::microseconds{500};  ///< until the answer (MSD manual 8.2.4)
};

/// CANopen front end of the MSD servo drive and its variants: a DriveCore, which is the drive itself, behind a CiA 301
/// device. Belongs to the thread that advances the bus:
///
///     can::Bus bus;
///     MsdCanDrive drive({}, {.dip_switch = {3}});
///     bus.attach(drive.device());
class MsdCanDrive final : private cia301::Application, private DriveBus {
 public:
  /// Starts when its device is attached to a bus, with mains, 24 V at X32, ENPO and ISDSH connected and the other
  /// terminals low.
  explicit MsdCanDrive(const MsdParameters& parameters = {}, const CanConnection& connection = {});
  MsdCanDrive(const MsdCanDrive&) = delete;  // the parts refer to one another
  MsdCanDrive& operator=(const MsdCanDrive&) = delete;
  ~MsdCanDrive() override = default;

  /// Returns the node of the bus.
  [[nodiscard]] cia301::Device& device() noexcept { return device_; }
  /// Returns the node of the bus, read only. \rtsafe
  [[nodiscard]] const cia301::Device& device() const noexcept { return device_; }
  /// Returns the drive itself. \rtsafe
  [[nodiscard]] DriveCore& core() noexcept { return core_; }
  /// Returns the drive itself, read only. \rtsafe
  [[nodiscard]] const DriveCore& core() const noexcept { return core_; }
  /// Switches the drive off and on again, with the next advance of the bus.
  void restart() { device_.power_on(); }

  /// Sets S4. The address counts from reset node or a restart on (MSD manual 4.4.2), the resistor at once. \rtsafe
  void set_dip_switch(DipSwitch dip_switch) noexcept { dip_switch_ = dip_switch; }
  /// Whether the drive terminates the bus. \rtsafe
  [[nodiscard]] bool terminates_bus() const noexcept { return dip_switch_.terminates(series_); }
  /// Connects or disconnects 24 V at X32, without which the drive is not on the bus (MSD manual 4.5). When it comes,
  /// the communication starts again (ours).
  void set_bus_supply(bool on) noexcept;
  /// Whether the yellow LED H14 is lit at this time: the NMT state. \rtsafe
  [[nodiscard]] bool led_h14(std::chrono::nanoseconds time) const noexcept;
  /// Whether the green LED H15 is lit: 24 V at X32 (MSD manual Table 4.3). \rtsafe
  [[nodiscard]] bool led_h15() const noexcept { return bus_supply_; }

 private:
  // cia301::Application
  [[nodiscard]] SdoResult<void> accept(const EntryRow& row, std::uint64_t raw) override;
  void written(const EntryRow& row) override;
  [[nodiscard]] bool power_stage_on() const noexcept override { return core_.power_stage_on(); }
  [[nodiscard]] std::uint8_t node_id(cia301::Reset reset) override;
  [[nodiscard]] std::uint32_t bit_rate(cia301::Reset reset) override;
  void restart(cia301::Reset reset, std::chrono::nanoseconds now) override;
  void restore_communication() override;
  [[nodiscard]] std::chrono::nanoseconds start_up_time() const noexcept override { return core_.start_up_left(); }
  void advance(std::chrono::nanoseconds now) override;
  [[nodiscard]] std::chrono::nanoseconds next_wake() const noexcept override;
  void state_changed(canopen::NmtState state, std::chrono::nanoseconds now) override;
  void sync(std::uint8_t counter, std::chrono::nanoseconds now) override;
  void rpdo_received(std::size_t number, std::chrono::nanoseconds now) override;
  void rpdo_applied(std::size_t number, std::chrono::nanoseconds now) override;
  void communication(cia301::CommunicationEvent event, std::chrono::nanoseconds now) override;
  [[nodiscard]] std::uint64_t event_mask(std::size_t tpdo) const noexcept override;

  // DriveBus
  void report(const FaultMessage& message) noexcept override;
  [[nodiscard]] bool cause_persists(Fault fault) const noexcept override;
  void parameters_replaced() override { settings_changed(); }

  [[nodiscard]] ObjectDictionary& dictionary() noexcept { return core_.process_values(); }
  [[nodiscard]] const ObjectDictionary& dictionary() const noexcept { return core_.process_values(); }
  void settings_changed() noexcept;
  void keep_mode() noexcept;
  void step_millisecond(std::chrono::nanoseconds now);
  [[nodiscard]] bool timing_agrees() const noexcept;
  void power_transceiver() noexcept;

  DriveCore core_;
  cia301::DeviceOptions options_;
  DipSwitch dip_switch_;
  Series series_;
  cia301::Device device_;
  RpdoUses rpdos_;
  TelegramWatch telegrams_;
  std::uint16_t active_bit_rate_ = 0;  ///< P 2059
  std::uint8_t active_address_ = 0;    ///< P 2058
  std::int8_t mode_ = 0;               ///< last 6060h that exists on this bus
  std::uint16_t told_error_ = 0;       ///< code of the EMCY whose fault is not acknowledged
  bool operational_ = false;
  bool bus_supply_ = true;                   ///< 24 V at X32
  std::chrono::nanoseconds millisecond_{0};  ///< the next one
};

}  // namespace driveline::slaves::msd
