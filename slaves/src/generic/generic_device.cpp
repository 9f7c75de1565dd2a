#include "driveline/slaves/generic/generic_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>

#include "driveline/esi/sii.hpp"
#include "driveline/slaves/bit_copy.hpp"

namespace driveline::slaves::generic {
namespace {

using esi::DataType;
using wire::AlState;
using wire::AlStatusCode;
using Use = esi::SyncManager::Use;

/// Same value as the drives of a mixed line, so that the device can follow their shortest cycle.
constexpr std::chrono::nanoseconds kProcessDataPeriod{125'000};
constexpr std::uint8_t kSyncType = 1;  ///< sub-indices of 1C30h + n (ETG.1020)
constexpr std::uint8_t kSyncCycle = 2;
/// Mailbox buffer size of a device without mailbox.
constexpr std::size_t kMinMailbox = 64;

SyncManagerLayout::Use layout_use(const esi::SyncManager& manager) noexcept {
  switch (manager.use) {
    case Use::kMailboxOut:
      return SyncManagerLayout::Use::kMailboxOut;
    case Use::kMailboxIn:
      return SyncManagerLayout::Use::kMailboxIn;
    case Use::kOutputs:
      return SyncManagerLayout::Use::kOutputs;
    case Use::kInputs:
    case Use::kUnused:  // an input sync manager without process data: it must not be enabled with a length
      break;
  }
  return SyncManagerLayout::Use::kInputs;
}

/// Without PDOs of its direction, the EEPROM's length of a sync manager is the only information available.
std::uint16_t unmapped_length(const esi::DeviceDescription& device, const esi::SyncManager& manager) noexcept {
  const bool unknown = (manager.use == Use::kOutputs && device.rx_pdos.empty()) ||
                       (manager.use == Use::kInputs && device.tx_pdos.empty());
  return unknown ? manager.default_size : std::uint16_t{0};
}

std::vector<std::byte> make_image(const esi::DeviceDescription& description, const GenericOptions& options) {
  if (!options.sii_image.empty()) return options.sii_image;
  if (options.serial_number == 0) return esi::encode_sii(esi::make_sii(description));
  auto device = description;
  device.serial_number = options.serial_number;
  return esi::encode_sii(esi::make_sii(device));
}

DeviceProfile make_profile(const DeviceModel& model, const GenericOptions& options) {
  const auto& device = model.description();
  DeviceProfile profile;
  profile.sii_image = make_image(device, options);
  for (const auto& manager : device.sync_managers) {
    profile.sync_managers.push_back({layout_use(manager), manager.start_address, manager.min_size, manager.max_size,
                                     manager.default_size, unmapped_length(device, manager)});
  }
  if (device.bootstrap_rx_size != 0 && device.bootstrap_tx_size != 0) {
    profile.bootstrap_mailboxes = {
        {SyncManagerLayout::Use::kMailboxOut, device.bootstrap_rx_offset, 0, 0, device.bootstrap_rx_size},
        {SyncManagerLayout::Use::kMailboxIn, device.bootstrap_tx_offset, 0, 0, device.bootstrap_tx_size}};
  }
  profile.fmmu_count = static_cast<std::uint8_t>(std::clamp<std::size_t>(device.fmmus.size(), 8, 16));
  profile.sync_manager_count = static_cast<std::uint8_t>(std::clamp<std::size_t>(device.sync_managers.size(), 8, 16));
  profile.ram_kib = model.ram_kib();
  profile.distributed_clock = options.distributed_clock;
  profile.identification = device.identification;
  return profile;
}

std::size_t longest_mailbox(const DeviceProfile& profile) noexcept {
  std::size_t longest = kMinMailbox;
  for (const auto* list : {&profile.sync_managers, &profile.bootstrap_mailboxes}) {
    for (const auto& manager : *list) {
      if (manager.use != SyncManagerLayout::Use::kMailboxOut) continue;
      longest = std::max<std::size_t>({longest, manager.default_length, manager.max_length});
    }
  }
  return longest;
}

CoeServer::Options coe_options(const esi::DeviceDescription& device) noexcept {
  return {.complete_access = device.mailbox.coe_complete_access, .sdo_information = device.mailbox.coe_sdo_info};
}

std::unique_ptr<EoeServer> make_eoe(const esi::DeviceDescription& device, std::uint32_t serial_number) {
  if (!device.mailbox.eoe) return nullptr;
  return std::make_unique<EoeServer>(factory_address(serial_number));
}

/// Whether the drives choose their process data: the device has no object dictionary, and its description has no PDOs.
bool chooses_by_idn(const esi::DeviceDescription& device) noexcept {
  return device.mailbox.soe && !device.mailbox.coe && device.rx_pdos.empty() && device.tx_pdos.empty();
}

std::unique_ptr<SoeDrives> make_soe(const esi::DeviceDescription& device, const GenericOptions& options) {
  if (!device.mailbox.soe) return nullptr;
  const auto drives = std::clamp<std::size_t>(device.mailbox.soe_channels, 1, SoeDrives::kMaxDrives);
  return std::make_unique<SoeDrives>(
      drives, chooses_by_idn(device) ? SoeDrives::ProcessData::kByLists : SoeDrives::ProcessData::kNone,
      options.soe_rules);
}

std::vector<MailboxProtocol*> protocols(const esi::DeviceDescription& device, CoeServer& coe, EoeServer* eoe,
                                        SoeServer* soe) {
  std::vector<MailboxProtocol*> protocols;
  if (device.mailbox.coe) protocols.push_back(&coe);
  if (eoe != nullptr) protocols.push_back(eoe);
  if (soe != nullptr) protocols.push_back(soe);
  return protocols;
}

bool exchanges(const esi::SyncManager& manager) noexcept {
  return manager.use == Use::kOutputs || manager.use == Use::kInputs;
}

/// Whether the value is none of the synchronisation types, which are 0 to 3 and from 22h on (ETG.1020 Table 60).
bool is_no_sync_type(const EntryRow& row, std::uint64_t raw) noexcept {
  const bool type = row.index >= sync_parameter_object(0) && row.index < sync_parameter_object(32) &&
                    row.subindex == kSyncType && row.type == DataType::kUnsigned16;
  return type && raw > static_cast<std::uint64_t>(SyncType::kSync1) &&
         raw < static_cast<std::uint64_t>(SyncType::kSm2Event);
}

bool is_real(DataType type) noexcept {
  return type == DataType::kReal32 || type == DataType::kReal64;
}

}  // namespace

tl::expected<void, SignalValueError> check_signal(const EntryRow& input, const Signal& signal) {
  if (is_string(input.type)) return tl::unexpected(SignalIsNoNumber{});
  if (is_real(input.type)) return {};
  const auto bits = static_cast<int>(std::min<std::size_t>(bit_size(input), 63));
  const double lowest = is_signed(input.type) ? -std::ldexp(1.0, bits - 1) : 0.0;
  const double highest = std::ldexp(1.0, is_signed(input.type) ? bits - 1 : bits) - 1.0;
  for (const double value : {signal.smallest(), signal.largest()}) {
    if (value < lowest || value > highest) {
      return tl::unexpected(SignalBeyondEntry{value, bit_size(input), lowest, highest});
    }
  }
  return {};
}

GenericDevice::GenericDevice(std::shared_ptr<const DeviceModel> model, const GenericOptions& options)
    : model_(std::move(model)),
      profile_(make_profile(*model_, options)),
      dictionary_(model_->table()),
      coe_(dictionary_, *this, coe_options(model_->description())),
      serial_number_(options.serial_number != 0 ? options.serial_number : model_->description().serial_number),
      eoe_(make_eoe(model_->description(), serial_number_)),
      soe_drives_(make_soe(model_->description(), options)),
      soe_(soe_drives_ ? std::make_unique<SoeServer>(*soe_drives_) : nullptr),
      drives_(model_->table()),
      mapped_by_idn_(chooses_by_idn(model_->description())),
      mailbox_(protocols(model_->description(), coe_, eoe_.get(), soe_.get()), longest_mailbox(profile_)),
      looped_(options.loop_back),
      scripts_(options.inputs),
      inputs_(model_->inputs()),
      outputs_(model_->outputs()) {
  set_slots_.reserve(inputs_.size());
  const auto* serial = model_->table().find(0x1018, 4);
  if (serial != nullptr && options.serial_number != 0) dictionary_.set_raw(serial->slot, options.serial_number);
  for (const auto& manager : model_->description().sync_managers) {
    maps_.emplace_back(exchanges(manager) ? model_->max_fields() : 0);
  }
  build_process_data();
}

std::chrono::nanoseconds GenericDevice::process_data_period() const noexcept {
  return kProcessDataPeriod;
}

void GenericDevice::build_process_data() {
  const auto& managers = model_->description().sync_managers;
  for (std::size_t n = 0; n < maps_.size(); ++n) {
    if (exchanges(managers[n])) maps_[n].build(dictionary_, n, model_->limits());
  }
  build_loops();
}

/// Whether a drive, a script or set_signal() determines the input.
bool GenericDevice::driven(const PdoMap::Field& field) const noexcept {
  if (!field.is_number()) return false;
  return drives_.owns(field.slot) ||
         std::any_of(scripts_.begin(), scripts_.end(),
                     [&field](const ScriptedInput& script) { return script.input->slot == field.slot; }) ||
         std::find(set_slots_.begin(), set_slots_.end(), field.slot) != set_slots_.end();
}

void GenericDevice::build_loops() {
  loops_.clear();
  if (!looped_) return;
  using Kind = std::pair<bool, std::uint8_t>;  // text or number, length
  std::map<Kind, std::deque<PdoMap::Field>> outputs;
  const auto& managers = model_->description().sync_managers;
  for (std::size_t n = 0; n < maps_.size(); ++n) {
    if (managers[n].use != Use::kOutputs) continue;
    for (const auto& field : maps_[n].fields()) {
      const bool of_drive = field.is_number() && drives_.owns(field.slot);
      if (!of_drive) outputs[{field.is_text(), field.bits}].push_back(field);
    }
  }
  for (std::size_t n = 0; n < maps_.size(); ++n) {
    if (managers[n].use != Use::kInputs) continue;
    for (const auto& field : maps_[n].fields()) {
      auto& next = outputs[{field.is_text(), field.bits}];
      if (field.storage == PdoMap::Storage::kConstant || next.empty() || driven(field)) continue;
      loops_.push_back({next.front(), field});
      next.pop_front();
    }
  }
}

std::size_t GenericDevice::process_data_size(std::size_t sync_manager) const noexcept {
  if (sync_manager >= maps_.size()) return 0;
  if (!mapped_by_idn_) return maps_[sync_manager].size();
  switch (model_->description().sync_managers[sync_manager].use) {
    case Use::kOutputs:
      return soe_drives_->outputs_size();
    case Use::kInputs:
      return soe_drives_->inputs_size();
    default:
      return 0;
  }
}

std::optional<MappedEntry> GenericDevice::mapped_input(std::uint16_t index, std::uint8_t subindex) const noexcept {
  for (std::size_t n = 0; n < maps_.size(); ++n) {
    if (model_->description().sync_managers[n].use != Use::kInputs) continue;
    if (const auto* field = maps_[n].find(index, subindex); field != nullptr) {
      return MappedEntry{n, field->bit_offset, field->bits};
    }
  }
  return std::nullopt;
}

void GenericDevice::enter_al_state(AlState state) noexcept {
  if (al_state_ == AlState::kOp && state != AlState::kOp) clear_outputs();
  al_state_ = state;
  if (state == AlState::kInit) mailbox_.reset();
  if (eoe_) eoe_->enter(state);
}

void GenericDevice::mailbox_request(std::span<const std::byte> mailbox) {
  if (eoe_) eoe_->set_time(now_);
  mailbox_.request(mailbox);
}

bool GenericDevice::connect_network(EthernetLink* network) {
  if (eoe_) eoe_->connect(network);
  return eoe_ != nullptr;
}

void GenericDevice::show(DeviceStatus& out) const noexcept {
  out = {};
  const auto& device = model_->description();
  out.maker = device.vendor_name;
  out.type = device.type;
  out.name = device.name;
  out.vendor_id = device.vendor_id;
  out.product_code = device.product_code;
  out.revision = device.revision;
  out.serial_number = serial_number_;
  out.al_state = al_state_;
  for (const auto* entries : {&inputs_, &outputs_}) {
    for (const auto& entry : *entries) {
      if (is_string(entry.row->type)) continue;
      out.add(DeviceStatus::Kind::kActual, entry.name,
              number_from_raw(entry.row->type, dictionary_.raw(entry.row->slot)));
    }
  }
}

/// Everything except EoE restarts on entering INIT.
void GenericDevice::restart() {
  enter_al_state(AlState::kInit);
  drives_.restart();
  if (eoe_) eoe_->restart();
}

void GenericDevice::clear_outputs() noexcept {
  if (mapped_by_idn_) soe_drives_->clear_outputs();
  const auto& managers = model_->description().sync_managers;
  for (std::size_t n = 0; n < maps_.size(); ++n) {
    if (managers[n].use != Use::kOutputs) continue;
    for (const auto& field : maps_[n].fields()) {
      if (field.is_text()) {
        dictionary_.text(field.slot).clear();
      } else if (field.is_number()) {
        dictionary_.set_raw(field.slot, 0);
      }
    }
  }
  loop_back();
}

void GenericDevice::loop_back() noexcept {
  for (const auto& loop : loops_) {
    if (loop.input.is_text()) {
      dictionary_.text(loop.input.slot) = dictionary_.text(loop.output.slot);  // within the reserved capacity
      continue;
    }
    const auto value = dictionary_.raw(loop.output.slot);
    const auto mask = loop.input.bits < 64 ? (std::uint64_t{1} << loop.input.bits) - 1 : ~std::uint64_t{0};
    const bool is_signed = loop.input.storage == PdoMap::Storage::kSigned;
    dictionary_.set_raw(loop.input.slot, is_signed ? sign_extended(value, loop.input.bits) : value & mask);
  }
}

/// PDOs that exclude each other must not be assigned together (ETG.2000, Exclude).
AlStatusCode GenericDevice::check_assignments() const noexcept {
  const auto& device = model_->description();
  const auto assigned = [this](std::uint16_t index) {
    for (std::size_t n = 0; n < maps_.size(); ++n) {
      const auto rows = model_->table().object(assignment_object(n));
      if (rows.empty()) continue;
      const auto count = dictionary_.raw(rows.front());
      for (std::size_t i = 1; i < rows.size() && i <= count; ++i) {
        if (dictionary_.raw(rows[i]) == index) return true;
      }
    }
    return false;
  };
  const auto conflict = [&assigned](const std::vector<esi::Pdo>& pdos) {
    return std::any_of(pdos.begin(), pdos.end(), [&](const esi::Pdo& pdo) {
      return assigned(pdo.index) && std::any_of(pdo.excluded.begin(), pdo.excluded.end(), assigned);
    });
  };
  if (conflict(device.rx_pdos)) return AlStatusCode::kInvalidOutputMapping;
  return conflict(device.tx_pdos) ? AlStatusCode::kInvalidInputMapping : AlStatusCode::kNoError;
}

AlStatusCode GenericDevice::transition(AlState from, AlState to) noexcept {
  if (from == AlState::kPreOp && to == AlState::kSafeOp) {
    if (const auto code = check_assignments(); code != AlStatusCode::kNoError) return code;
  }
  const bool rises = to > from && (to == AlState::kSafeOp || to == AlState::kOp);
  if (rises && soe_drives_ && !soe_drives_->check_transition(to)) return kSoeCheckFailed;
  enter_al_state(to);
  return AlStatusCode::kNoError;
}

void GenericDevice::fall_back(AlState /*from*/, AlState to, AlStatusCode reason) noexcept {
  enter_al_state(to);
  if (reason != AlStatusCode::kSyncManagerWatchdog) return;
  drives_.communication_failed(dictionary_);
  if (soe_drives_) soe_drives_->communication_failed();
}

void GenericDevice::sync_started(std::chrono::nanoseconds sync0_cycle) noexcept {
  if (sync0_cycle.count() == 0) return;
  for (std::size_t n = 0; n < maps_.size(); ++n) {
    const auto* row = model_->table().find(sync_parameter_object(n), kSyncCycle);
    if (row == nullptr || row->type != DataType::kUnsigned32 || row->slot == slot::kConstant) continue;
    dictionary_.set_raw(row->slot, static_cast<std::uint64_t>(sync0_cycle.count()));
  }
}

void GenericDevice::write_outputs(std::size_t sync_manager, std::span<const std::byte> data) noexcept {
  if (sync_manager >= maps_.size()) return;
  if (mapped_by_idn_) soe_drives_->write_outputs(data);
  maps_[sync_manager].decode(data, dictionary_);
  drives_.exchange(dictionary_);
  loop_back();
}

void GenericDevice::read_inputs(std::size_t sync_manager, std::span<std::byte> data) noexcept {
  std::fill(data.begin(), data.end(), std::byte{0});
  if (sync_manager < maps_.size()) maps_[sync_manager].encode(dictionary_, data);
  if (mapped_by_idn_) soe_drives_->read_inputs(data);
}

void GenericDevice::advance(std::chrono::nanoseconds now) noexcept {
  if (!start_) start_ = now;
  now_ = now;
  if (soe_drives_) soe_drives_->advance(now);
  drives_.advance(dictionary_, now);
  for (const auto& script : scripts_) {
    const double value = script.signal.at(now - *start_);
    const auto type = script.input->type;
    dictionary_.set_raw(script.input->slot, raw_from_number(type, is_real(type) ? value : std::nearbyint(value)));
  }
}

std::string GenericDevice::signal_name(SignalId id) const {
  return rows(id.direction)[id.number].name;
}

tl::expected<SignalId, SignalNameError> GenericDevice::find_signal(Direction direction, std::string_view name) const {
  const auto row = direction == Direction::kInput ? model_->find_input(name) : model_->find_output(name);
  if (!row) return tl::unexpected(row.error());
  const auto& list = rows(direction);
  const auto found = std::find_if(list.begin(), list.end(), [&](const auto& entry) { return entry.row == *row; });
  return SignalId{direction, static_cast<std::size_t>(found - list.begin())};
}

tl::expected<void, SignalValueError> GenericDevice::check_signal_value(std::size_t input, double value) const {
  return check_signal(*inputs_[input].row, {.low = value});
}

void GenericDevice::set_signal(std::size_t input, double value) noexcept {
  const EntryRow& row = *inputs_[input].row;
  if (is_string(row.type)) return;
  std::erase_if(scripts_, [&row](const ScriptedInput& script) { return script.input->slot == row.slot; });
  std::erase_if(loops_, [&row](const Loop& loop) { return !loop.input.is_text() && loop.input.slot == row.slot; });
  if (std::find(set_slots_.begin(), set_slots_.end(), row.slot) == set_slots_.end()) set_slots_.push_back(row.slot);
  dictionary_.set_raw(row.slot, raw_from_number(row.type, is_real(row.type) ? value : std::nearbyint(value)));
}

double GenericDevice::signal(SignalId id) const noexcept {
  const EntryRow& row = *rows(id.direction)[id.number].row;
  return is_string(row.type) ? 0.0 : number_from_raw(row.type, dictionary_.raw(row.slot));
}

SdoResult<void> GenericDevice::accept(const EntryRow& row, std::uint64_t raw) {
  if (is_no_sync_type(row, raw)) return tl::unexpected(wire::SdoAbort::kValueRange);
  return check_pdo_write(dictionary_, model_->limits(), row, raw);
}

void GenericDevice::written(const EntryRow& row) {
  // The number of entries is written last; until then the entries have no effect.
  if (row.index >= 0x1600 && row.index < 0x1C30 && row.subindex == 0) build_process_data();
}

}  // namespace driveline::slaves::generic
