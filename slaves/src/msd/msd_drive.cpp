#include "driveline/slaves/msd/msd_drive.hpp"

#include <algorithm>
#include <array>

#include "driveline/bytes/endian.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/slaves/msd/core/drive_settings.hpp"
#include "driveline/slaves/msd/device_layout.hpp"
#include "driveline/slaves/msd/ethercat_values.hpp"
#include "driveline/slaves/pdo/pdo_settings.hpp"

namespace driveline::slaves::msd {
namespace {

using std::chrono::nanoseconds;
using wire::AlState;
using wire::AlStatusCode;

constexpr NetworkState network_state(AlState state) noexcept {
  switch (state) {
    case AlState::kInit:
      return NetworkState::kInitialising;
    case AlState::kPreOp:
      return NetworkState::kPreOperational;
    case AlState::kSafeOp:
      return NetworkState::kSafeOperational;
    case AlState::kOp:
      return NetworkState::kOperational;
    default:
      return NetworkState::kBootUp;
  }
}

/// Whether the master has ended OP, by a request for an illegal or unknown state.
constexpr bool is_request_error(AlStatusCode code) noexcept {
  return code == AlStatusCode::kInvalidRequestedStateChange || code == AlStatusCode::kUnknownRequestedState;
}

/// Whether 1C33h:01 has the value: the types of 1C32h:01, and 22h, the event of the outputs, as of devices that have
/// outputs (Beckhoff, EL922x manual, index 1C33).
constexpr bool is_input_type(std::uint64_t raw) noexcept {
  return raw <= static_cast<std::uint64_t>(SyncType::kSync0) || raw == static_cast<std::uint64_t>(SyncType::kSm2Event);
}

std::uint16_t count16(std::uint64_t count) noexcept {
  return static_cast<std::uint16_t>(std::min<std::uint64_t>(count, 0xFFFF));
}

DeviceProfile make_profile(const MsdParameters& parameters) {
  using Use = SyncManagerLayout::Use;
  auto description = eeprom_description(parameters.variant);
  description.serial_number = parameters.serial_number;
  DeviceProfile profile;
  profile.sii_image = esi::encode_sii(esi::make_sii(description));
  profile.bootstrap_mailboxes = {
      {Use::kMailboxOut, kMailboxOutStart, kMailboxMinSize, kMailboxSize, kMailboxSize},
      {Use::kMailboxIn, kMailboxInStart, kMailboxMinSize, kMailboxSize, kMailboxSize},
  };
  profile.sync_managers = {
      {Use::kMailboxOut, kMailboxOutStart, kMailboxMinSize, kMailboxSize, kMailboxSize},
      {Use::kMailboxIn, kMailboxInStart, kMailboxMinSize, kMailboxSize, kMailboxSize},
      {Use::kOutputs, kOutputsStart, 0, kMaxProcessData, 0},
      {Use::kInputs, kInputsStart, 0, kMaxProcessData, 0},
  };
  return profile;
}

}  // namespace

MsdDrive::MsdDrive(const MsdParameters& parameters)
    : core_(parameters, dictionary_table(parameters.variant), *this),
      profile_(make_profile(parameters)),
      coe_(core_.process_values(), *this, {.fill_sign = true}),  // MSD manual Table 8.3
      files_(core_, parameters.file_password, parameters.flash_time),
      foe_(files_),
      eoe_(std::make_unique<EoeServer>(factory_address(parameters.serial_number))),
      mailbox_(std::array<MailboxProtocol*, 3>{&coe_, &foe_, eoe_.get()}, kMailboxSize) {
  restart();
}

void MsdDrive::restart() {
  enter_al_state(AlState::kInit);
  eoe_->restart();
  core_.restart();
  pdo_limits_.even_bytes = core_.firmware() < facts(core_.variant()).odd_pdos_since;
  build_process_data();
  if (!eeprom_good_) core_.raise(Fault::kEepromData);
}

void MsdDrive::enter_al_state(AlState state) noexcept {
  al_state_ = state;
  if (state != AlState::kSafeOp && state != AlState::kOp) sync_started(nanoseconds{0});
  core_.enter_network_state(network_state(state));
  if (state == AlState::kInit) mailbox_.reset();
  eoe_->enter(state);
}

void MsdDrive::mailbox_request(std::span<const std::byte> mailbox) {
  eoe_->set_time(core_.running_time());
  mailbox_.request(mailbox);
}

/// A waiting request may read any object.
std::size_t MsdDrive::mailbox_reply(std::span<std::byte> out) {
  if (mailbox_.waiting()) core_.complete_publication();
  return mailbox_.reply(out, al_state_);
}

bool MsdDrive::connect_network(EthernetLink* network) {
  eoe_->connect(network);
  return true;
}

/// BOOT to INIT restarts the device (MSD manual 9.2, transition BI).
AlStatusCode MsdDrive::transition(AlState from, AlState to) noexcept {
  if (from == AlState::kBootstrap) restart();
  if (to == AlState::kOp && !timing_valid(core_.process_values())) {
    core_.raise(Fault::kInvalidConfiguration);
    return AlStatusCode::kInconsistentSettings;
  }
  if (to == AlState::kOp && !sync0_matches()) {
    core_.raise(Fault::kInvalidConfiguration);
    return AlStatusCode::kDcInvalidSyncCycleTime;
  }
  enter_al_state(to);
  if (to == AlState::kOp) core_.process_values().set(kBusValue.sync_error, false);
  if (from == AlState::kOp) outputs_ended();
  return AlStatusCode::kNoError;
}

/// The master has ended OP: outputs are missing for a motor that is on (Er 14 05).
void MsdDrive::outputs_ended() noexcept {
  if (core_.power_on()) core_.raise(Fault::kMissingOutputs);
}

void MsdDrive::fall_back(AlState from, AlState to, AlStatusCode reason) noexcept {
  enter_al_state(to);
  if (from != AlState::kOp) return;
  core_.process_values().set(kBusValue.sync_error, is_sync_error(reason));
  if (is_request_error(reason)) return outputs_ended();
  core_.raise(reason == AlStatusCode::kSyncManagerWatchdog ? Fault::kBusWatchdog : Fault::kLocalError);
}

/// Er 14 02 is "wrong EEPROM data" and "unsupported communication controller" (MSD manual 5.3.3): the content cannot be
/// loaded, or belongs to another device.
void MsdDrive::eeprom_loaded(std::span<const std::byte> image, bool valid) noexcept {
  constexpr std::size_t kVendor = 0x10;  // byte offset in the EEPROM (ETG.1000.6 Table 16)
  constexpr std::size_t kProduct = 0x14;
  const bool own = valid && image.size() >= kProduct + sizeof(std::uint32_t) &&
                   bytes::load_le<std::uint32_t>(image.subspan(kVendor)) == kVendorId &&
                   bytes::load_le<std::uint32_t>(image.subspan(kProduct)) == facts(core_.variant()).product_code;
  eeprom_good_ = own;
  if (!own) core_.raise(Fault::kEepromData);
}

/// The SYNC0 cycle must be a multiple of 125 us (MSD manual 9.1). 1C32h:01 = 2 requires SYNC0, 1 requires process data
/// in each setpoint cycle; 0, its default, accepts either. With SYNC0 outputs are due in each setpoint cycle, too.
SyncDemand MsdDrive::sync_demand() const noexcept {
  SyncDemand demand;
  const auto type = static_cast<SyncType>(core_.process_values().get(kBusValue.sync_type_outputs));
  if (type != SyncType::kFreeRun) demand.type = type;
  if (type == SyncType::kSmEvent) demand.cycle = reference_cycle(core_.process_values());
  const auto input_type = static_cast<SyncType>(core_.process_values().get(kBusValue.sync_type_inputs));
  if (input_type != SyncType::kFreeRun) demand.input_type = input_type;
  demand.outputs = rx_map_.size() > 0;
  demand.outputs_cycle = reference_cycle(core_.process_values());
  demand.calc_and_copy = kCalcAndCopyTime;
  demand.time_base = demand.min_cycle = kProcessDataPeriod;
  demand.error_limit = core_.process_values().get(kBusValue.sync_error_limit);
  return demand;
}

/// 1C32h:02 and 1C33h:02 show the cycle of SYNC0, or that of the drive's own process data (ETG.1020; Slave Stack Code
/// 5.13, StartInputHandler).
void MsdDrive::sync_started(nanoseconds sync0_cycle) noexcept {
  const auto cycle = sync0_cycle.count() > 0 ? sync0_cycle : kProcessDataPeriod;
  core_.process_values().set(kBusValue.sync_cycle, static_cast<std::uint32_t>(cycle.count()));
}

/// The control cycles end half a cycle after SYNC0, so that their order is always the same.
void MsdDrive::sync_event(SyncSignal signal, nanoseconds time) noexcept {
  if (signal != SyncSignal::kSync0) return;
  sync0_.pulse(time);
  core_.align_cycle(time + kControlStep / 2);
}

void MsdDrive::sync_margin(const SyncMargin& margin) noexcept {
  ObjectDictionary& dictionary = core_.process_values();
  dictionary.set(kBusValue.sync_events_missed, count16(margin.missed));
  dictionary.set(kBusValue.sync_cycles_exceeded, count16(margin.exceeded));
  dictionary.set(kBusValue.sync_shifts_too_short, count16(margin.too_short));
  if (margin.pulses == 0) return;
  dictionary.set(kBusValue.sync_distance_min, static_cast<std::uint32_t>(margin.shortest.count()));
  dictionary.set(kBusValue.sync_distance_max, static_cast<std::uint32_t>(margin.longest.count()));
}

bool MsdDrive::sync0_matches() const noexcept {
  return sync0_.fits(reference_cycle(core_.process_values()), core_.cycle_end());
}

bool MsdDrive::cause_persists(Fault fault) const noexcept {
  if (fault == Fault::kInvalidConfiguration) return !sync0_matches();
  return fault == Fault::kEepromData && !eeprom_good_;
}

/// Manufacturer-specific bytes: number, location, complete operating hours, little endian (MSD manual 13.1).
void MsdDrive::report(const FaultMessage& message) noexcept {
  wire::Emergency emergency;
  emergency.error_code = message.error_code;
  emergency.error_register = message.error_register;
  emergency.data = {static_cast<std::byte>(message.number), static_cast<std::byte>(message.location),
                    static_cast<std::byte>(message.operating_hours),
                    static_cast<std::byte>(message.operating_hours >> 8U),
                    static_cast<std::byte>(message.operating_hours >> 16U)};
  coe_.raise(emergency);
}

SdoResult<void> MsdDrive::accept(const EntryRow& row, std::uint64_t raw) {
  const bool input_type = !is_string(row.type) && row.slot == kBusValue.sync_type_inputs.number;
  if (input_type && !is_input_type(raw)) return tl::unexpected(wire::SdoAbort::kValueRange);
  return core_.accept(row, raw).and_then(
      [&] { return check_pdo_write(core_.process_values(), pdo_limits_, row, raw); });
}

void MsdDrive::written(const EntryRow& row) {
  const bool mapping = row.index >= pdo_limits_.rx_first && row.index < 0x2000;  // or assignment
  if (mapping && !is_string(row.type)) build_process_data();
  core_.written(row);
}

void MsdDrive::build_process_data() noexcept {
  rx_map_.build(core_.process_values(), kOutputsSyncManager, pdo_limits_);
  tx_map_.build(core_.process_values(), kInputsSyncManager, pdo_limits_);
  settings_mapped_ = has_settings(rx_map_);
  ValueGroups sent;
  for (const PdoMap::Field& field : tx_map_.fields()) {
    if (field.is_number()) sent = sent.with(value_group(field.slot));
  }
  core_.send(sent);
}

std::size_t MsdDrive::process_data_size(std::size_t sync_manager) const noexcept {
  if (sync_manager == kOutputsSyncManager) return rx_map_.size();
  return sync_manager == kInputsSyncManager ? tx_map_.size() : 0;
}

std::optional<MappedEntry> MsdDrive::mapped_input(std::uint16_t index, std::uint8_t subindex) const noexcept {
  const auto* field = tx_map_.find(index, subindex);
  if (field == nullptr) return std::nullopt;
  return MappedEntry{kInputsSyncManager, field->bit_offset, field->bits};
}

void MsdDrive::write_outputs(std::size_t sync_manager, std::span<const std::byte> data) noexcept {
  if (sync_manager != kOutputsSyncManager) return;
  if (settings_mapped_) {
    decode_settings(rx_map_, data, core_.process_values(), *this);
  } else {
    rx_map_.decode(data, core_.process_values());
  }
  core_.outputs_written();
}

void MsdDrive::read_inputs(std::size_t sync_manager, std::span<std::byte> data) noexcept {
  if (sync_manager == kInputsSyncManager) tx_map_.encode(core_.process_values(), data);
}

}  // namespace driveline::slaves::msd
