#include "driveline/slaves/msd/can/msd_can_drive.hpp"

#include <algorithm>

#include "driveline/slaves/cia402/words.hpp"
#include "driveline/slaves/msd/can/can_indicators.hpp"
#include "driveline/slaves/msd/can/can_values.hpp"
#include "driveline/slaves/msd/core/drive_settings.hpp"

namespace driveline::slaves::msd {
namespace {

using canopen::NmtState;
using cia301::CommunicationEvent;
using cia301::Reset;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr nanoseconds kMillisecond = milliseconds{1};
constexpr std::uint16_t kFirstCommunication = 0x1000;
constexpr std::uint16_t kLastCommunication = 0x1FFF;

/// The numbers of P 2060; Stopped has that of SAFEOP (MSD manual Table 6.5).
constexpr NetworkState network_state(NmtState state) noexcept {
  switch (state) {
    case NmtState::kStopped:
      return NetworkState::kSafeOperational;
    case NmtState::kOperational:
      return NetworkState::kOperational;
    case NmtState::kPreOperational:
      return NetworkState::kPreOperational;
    case NmtState::kInitialising:
      break;
  }
  return NetworkState::kInitialising;
}

/// Modes 8, 9 and 10 exist on EtherCAT only (MSD manual 12.1).
constexpr bool exists_on_can(std::int8_t mode) noexcept {
  switch (static_cast<OperationMode>(mode)) {
    case OperationMode::kCyclicSynchronousPosition:
    case OperationMode::kCyclicSynchronousVelocity:
    case OperationMode::kCyclicSynchronousTorque:
      return false;
    default:
      return true;
  }
}

/// Whether the row has this value, regardless of others. Inhibit times are whole milliseconds (MSD manual 8.3.1).
bool possible_on_can(const EntryRow& row, std::uint64_t raw) noexcept {
  constexpr std::uint64_t kHundredMicrosecondsPerMs = 10;
  if (row.slot == kValue.mode.number) return exists_on_can(static_cast<std::int8_t>(raw));
  if (row.slot == kCanValue.bit_rate.number) {
    return std::find(kCanBitRates.begin(), kCanBitRates.end(), raw) != kCanBitRates.end();
  }
  const bool tx_parameter = row.index >= 0x1800 && row.index < 0x1800 + kCanPdos;
  return !tx_parameter || row.subindex != 3 || raw % kHundredMicrosecondsPerMs == 0;
}

/// Whether a write to the row stores the parameters.
bool stores(const EntryRow& row) noexcept {
  return row.slot == kValue.store_command.number || row.slot == kValue.restore_command.number ||
         row.slot == kValue.save_parameters.number;
}

cia301::DeviceOptions device_options(const MsdParameters& parameters, const CanConnection& connection) {
  cia301::DeviceOptions options;
  options.sdo_delay = connection.sdo_delay;
  options.fill_sign = true;  // MSD manual Table 8.3
  options.rpdos = options.tpdos = kCanPdos;
  options.mapping = {};  // the filler of a PDO is P 2055, there are no dummy objects (MSD manual 8.3.3)
  options.mapping.even_bytes = parameters.firmware_version() < facts(parameters.variant).odd_pdos_since;
  options.pdo_cycle = options.nmt_cycle = kMillisecond;  // MSD manual 8.1.1
  options.stores = false;
  options.failure_emergencies = false;  // each failure is a fault of the drive
  return options;
}

}  // namespace

MsdCanDrive::MsdCanDrive(const MsdParameters& parameters, const CanConnection& connection)
    : core_(parameters, can_dictionary_table(parameters.variant), *this),
      options_(device_options(parameters, connection)),
      dip_switch_(connection.dip_switch),
      series_(connection.series.value_or(facts(parameters.variant).series)),
      device_(core_.process_values(), *this, options_),
      rpdos_(core_.process_values()) {
  core_.restart();
}

void MsdCanDrive::set_bus_supply(bool on) noexcept {
  if (std::exchange(bus_supply_, on) == on) return;
  power_transceiver();
  if (on) device_.restart_communication();
}

void MsdCanDrive::power_transceiver() noexcept {
  if (device_.controller() != nullptr) device_.controller()->set_power(bus_supply_);
}

bool MsdCanDrive::led_h14(nanoseconds time) const noexcept {
  return network_led_h14(device_.state(), time);
}

/// Stored COB-IDs that count from the node-ID do not contain it, so that drives with other addresses can have the same
/// parameters (MSD manual 4.4).
SdoResult<void> MsdCanDrive::accept(const EntryRow& row, std::uint64_t raw) {
  if (!possible_on_can(row, raw)) return tl::unexpected(sdo::SdoAbort::kValueRange);
  if (!stores(row)) return core_.accept(row, raw);
  cia301::remove_node_id(dictionary(), options_.node_relative, device_.node_id());
  auto result = core_.accept(row, raw);
  cia301::add_node_id(dictionary(), options_.node_relative, device_.node_id());
  return result;
}

void MsdCanDrive::written(const EntryRow& row) {
  if (!is_string(row.type)) {
    if (row.slot == kValue.mode.number) mode_ = dictionary().get(kValue.mode);
    const bool mapping = row.index >= 0x1600 && row.index < 0x1600 + kCanPdos;
    const bool telegram = row.slot == kCanValue.telegram.number || row.slot == kCanValue.telegram_time_out.number;
    if (mapping || telegram) settings_changed();
  }
  core_.written(row);
}

void MsdCanDrive::settings_changed() noexcept {
  rpdos_.update();
  telegrams_.configure(static_cast<TelegramWatch::Signal>(dictionary().get(kCanValue.telegram)),
                       milliseconds{dictionary().get(kCanValue.telegram_time_out)});
}

/// The address is the sum of S4 and P 2005; a sum that is no node-ID keeps the drive off the bus (ours).
std::uint8_t MsdCanDrive::node_id(Reset reset) {
  if (reset != Reset::kCommunication) {
    active_address_ = static_cast<std::uint8_t>(dip_switch_.address(series_) + dictionary().get(kCanValue.address));
  }
  dictionary().set(kCanValue.active_address, active_address_);
  return active_address_;
}

/// P 2006 counts after a restart of the drive only (MSD manual 6.5.1).
std::uint32_t MsdCanDrive::bit_rate(Reset reset) {
  constexpr std::uint32_t kKilobit = 1000;
  if (reset == Reset::kPowerOn) active_bit_rate_ = dictionary().get(kCanValue.bit_rate);
  dictionary().set(kCanValue.active_bit_rate, active_bit_rate_);
  return active_bit_rate_ * kKilobit;
}

void MsdCanDrive::restart(Reset /*reset*/, nanoseconds now) {
  core_.advance(now);
  told_error_ = 0;
  core_.restart();
  mode_ = dictionary().get(kValue.mode);
  settings_changed();
  power_transceiver();
}

void MsdCanDrive::restore_communication() {
  core_.restore_parameters(kFirstCommunication, kLastCommunication);
  settings_changed();
}

void MsdCanDrive::advance(nanoseconds now) {
  core_.advance(now);
  if (telegrams_.fails(now)) core_.raise(Fault::kTelegramFailure);
  if (millisecond_ <= now) step_millisecond(now);
}

/// Everything about PDOs happens in cycles of 1 ms (MSD manual 8.1.1).
void MsdCanDrive::step_millisecond(nanoseconds now) {
  millisecond_ = (now / kMillisecond + 1) * kMillisecond;
  if (core_.motion().follows_cyclic_setpoints() && !timing_agrees()) core_.raise(Fault::kInvalidConfiguration);
  device_.watch(now);
}

nanoseconds MsdCanDrive::next_wake() const noexcept {
  return std::min(millisecond_, telegrams_.deadline());
}

/// Leaving Operational leaves a motor under control without setpoints.
void MsdCanDrive::state_changed(NmtState state, nanoseconds now) {
  core_.advance(now);
  const bool operational = state == NmtState::kOperational;
  if (std::exchange(operational_, operational) && !operational && core_.power_on()) {
    core_.raise(Fault::kCommunicationEnded);
  }
  telegrams_.restart(operational);
  core_.enter_network_state(network_state(state));
}

/// The control cycles end half a cycle after SYNC, so that their order is always the same.
void MsdCanDrive::sync(std::uint8_t /*counter*/, nanoseconds now) {
  telegrams_.came(TelegramWatch::Signal::kSync, now);
  core_.align_cycle(now + kControlStep / 2);
}

void MsdCanDrive::rpdo_received(std::size_t /*number*/, nanoseconds now) {
  telegrams_.came(TelegramWatch::Signal::kRxPdo, now);
}

void MsdCanDrive::rpdo_applied(std::size_t number, nanoseconds now) {
  keep_mode();
  if (rpdos_.carries_setpoint(number)) {
    core_.outputs_written();
  } else {
    core_.commands_written();
  }
  if (rpdos_.is_answered(number)) device_.trigger(number, now);
}

/// A mode that does not exist here changes nothing, as with SDO.
void MsdCanDrive::keep_mode() noexcept {
  const std::int8_t wanted = dictionary().get(kValue.mode);
  if (exists_on_can(wanted)) {
    mode_ = wanted;
  } else {
    dictionary().set(kValue.mode, mode_);
  }
}

void MsdCanDrive::communication(CommunicationEvent event, nanoseconds now) {
  core_.advance(now);
  switch (event) {
    case CommunicationEvent::kHeartbeatLost:
      return core_.raise(Fault::kHeartbeat);
    case CommunicationEvent::kLifeGuardingLost:
      return core_.raise(Fault::kLifeGuarding);
    case CommunicationEvent::kBusOff:
      return core_.raise(Fault::kBusOff);
    default:
      return;
  }
}

std::uint64_t MsdCanDrive::event_mask(std::size_t tpdo) const noexcept {
  const std::uint64_t low = dictionary().get(kCanValue.event_masks[2 * tpdo]);
  return low | std::uint64_t{dictionary().get(kCanValue.event_masks[2 * tpdo + 1])} << 32U;
}

/// Manufacturer-specific bytes: number, location, complete operating hours, little endian (MSD manual 13.1).
void MsdCanDrive::report(const FaultMessage& message) noexcept {
  const nanoseconds now = device_.now();
  if (message.error_code == 0) return device_.clear(std::exchange(told_error_, 0), now);
  told_error_ = message.error_code;
  device_.raise(
      {message.error_code,
       message.error_register,
       {static_cast<std::byte>(message.number), static_cast<std::byte>(message.location),
        static_cast<std::byte>(message.operating_hours), static_cast<std::byte>(message.operating_hours >> 8U),
        static_cast<std::byte>(message.operating_hours >> 16U)}},
      now);
}

/// P 306, 1006h and 60C2h must name the same cycle (MSD manual 6.4.2); the drive compares the other two by itself.
bool MsdCanDrive::timing_agrees() const noexcept {
  return reference_cycle(dictionary()) == std::chrono::microseconds{dictionary().get(kCanValue.communication_cycle)};
}

bool MsdCanDrive::cause_persists(Fault fault) const noexcept {
  switch (fault) {
    case Fault::kInvalidConfiguration:
      return !timing_agrees();
    case Fault::kHeartbeat:
      return device_.persists(CommunicationEvent::kHeartbeatLost);
    case Fault::kLifeGuarding:
      return device_.persists(CommunicationEvent::kLifeGuardingLost);
    case Fault::kBusOff:
      return device_.persists(CommunicationEvent::kBusOff);
    case Fault::kTelegramFailure:
      return telegrams_.lost();
    default:
      return false;
  }
}

}  // namespace driveline::slaves::msd
