#include "driveline/ecat_master/configuration/description_plan.hpp"

#include <algorithm>

#include "configuration/process_data_setup.hpp"
#include "driveline/ecat_master/configuration/pdo_discovery.hpp"
#include "driveline/esi/hex.hpp"

namespace driveline::ecat_master {
namespace {

using Use = esi::SyncManager::Use;
using Steps = std::vector<SdoScript::Step>;

template <typename Limit>
void complete(Limit& limit, const std::optional<std::uint32_t>& milliseconds) {
  if (!limit && milliseconds) limit = std::chrono::milliseconds{*milliseconds};
}

void complete_timeouts(SlavePlan& plan, const esi::DeviceTimeouts& file) {
  complete(plan.timeouts.to_pre_op, file.to_pre_op);
  complete(plan.timeouts.to_safe_op, file.to_safe_op_and_op);
  complete(plan.timeouts.to_op, file.to_safe_op_and_op);
  complete(plan.timeouts.back_to_init, file.back_to_init);
  complete(plan.timeouts.back_to_safe_op, file.back_to_safe_op);
  complete(plan.mailbox_timeouts.request, file.mailbox_request);
  complete(plan.mailbox_timeouts.response, file.mailbox_response);
}

/// The times are in increments of the divider, so all come from the plan or all from the file.
void complete_watchdogs(SlavePlan& plan, const esi::DeviceWatchdogs& file) {
  if (plan.watchdog != WatchdogPlan{}) return;
  plan.watchdog = {file.divider, file.process_data, file.pdi};
}

const std::vector<esi::Pdo>& pdos_of(const esi::DeviceDescription& device, bool outputs) {
  return outputs ? device.rx_pdos : device.tx_pdos;
}

const esi::Pdo* find_pdo(const std::vector<esi::Pdo>& pdos, std::uint16_t index) {
  const auto found = std::find_if(pdos.begin(), pdos.end(), [=](const esi::Pdo& pdo) { return pdo.index == index; });
  return found == pdos.end() ? nullptr : &*found;
}

std::vector<motion::MappedObject> objects_of(const esi::Pdo& pdo) {
  std::vector<motion::MappedObject> objects;
  for (const auto& entry : pdo.entries) objects.push_back({entry.index, entry.subindex, entry.bit_length});
  return objects;
}

tl::unexpected<PdoMisfit> misfit(std::uint16_t pdo, MisfitFacts facts) {
  return tl::unexpected(PdoMisfit{pdo, facts});
}

tl::expected<void, PdoMisfit> check_pdo(const esi::DeviceDescription& device, const motion::PdoMapping& planned,
                                        const std::vector<esi::Pdo>& known) {
  const auto* pdo = find_pdo(known, planned.index);
  if (pdo == nullptr) {
    if (device.mailbox.coe_pdo_config) return {};
    return misfit(planned.index, misfits::UnknownPdo{});
  }
  if (motion::same_content(planned.objects, objects_of(*pdo))) return {};
  if (pdo->fixed) return misfit(pdo->index, misfits::FixedEntries{});
  if (device.mailbox.coe_pdo_config) return {};
  return misfit(pdo->index, misfits::NoPdoConfiguration{});
}

/// Checks that the sync manager of a PDO carries that direction, and is the device's sync manager for a PDO that cannot
/// be moved.
tl::expected<void, PdoMisfit> check_place(const esi::DeviceDescription& device, const motion::PdoMapping& planned,
                                          const esi::Pdo* known, bool outputs) {
  if (!planned.sync_manager) return {};
  const auto number = *planned.sync_manager;
  const auto use = outputs ? Use::kOutputs : Use::kInputs;
  if (!device.sync_managers.empty() &&
      (number >= device.sync_managers.size() || device.sync_managers[number].use != use)) {
    return misfit(planned.index, misfits::WrongSyncManager{.planned = number, .output = outputs});
  }
  const bool stays = known != nullptr && known->fixed && known->sync_manager;
  if (!stays || *known->sync_manager == number) return {};
  return misfit(planned.index, misfits::FixedSyncManager{.fixed = *known->sync_manager, .planned = number});
}

tl::expected<void, PdoMisfit> check_direction(const esi::DeviceDescription& device,
                                              const std::vector<motion::PdoMapping>& planned,
                                              const std::vector<esi::Pdo>& known, bool outputs) {
  const auto is_planned = [&](std::uint16_t index) {
    return std::any_of(planned.begin(), planned.end(),
                       [=](const motion::PdoMapping& pdo) { return pdo.index == index; });
  };
  for (const auto& one : planned) {
    if (auto done = check_pdo(device, one, known); !done) return done;
    const auto* pdo = find_pdo(known, one.index);
    if (auto done = check_place(device, one, pdo, outputs); !done) return done;
    if (pdo == nullptr) continue;
    for (const auto other : pdo->excluded) {
      if (!is_planned(other)) continue;
      return misfit(one.index, misfits::ExcludedPdo{other});
    }
  }
  for (const auto& pdo : known) {
    if (pdo.mandatory && !is_planned(pdo.index)) return misfit(pdo.index, misfits::MandatoryPdo{});
    if (!device.mailbox.coe_pdo_assign && pdo.sync_manager.has_value() != is_planned(pdo.index)) {
      return misfit(pdo.index, misfits::FixedAssignment{.assigned = pdo.sync_manager.has_value()});
    }
  }
  return {};
}

/// A list object: count 0, elements, count (ETG.1000.6 5.6.7.4).
template <typename T>
void append_list(Steps& steps, std::uint16_t index, const std::vector<T>& elements) {
  steps.push_back(SdoScript::Step::of<std::uint8_t>(index, 0, 0));
  std::uint8_t subindex = 0;
  for (const auto element : elements) steps.push_back(SdoScript::Step::of<T>(index, ++subindex, element));
  if (!elements.empty()) steps.push_back(SdoScript::Step::of<std::uint8_t>(index, 0, subindex));
}

void append_mapping(Steps& steps, const motion::PdoMapping& pdo) {
  std::vector<std::uint32_t> objects;
  for (const auto& object : pdo.objects) objects.push_back(object.raw());
  append_list(steps, pdo.index, objects);
}

std::optional<std::uint8_t> first_of(const esi::DeviceDescription& device, Use use) {
  for (std::size_t n = 0; n < device.sync_managers.size(); ++n) {
    if (device.sync_managers[n].use == use) return static_cast<std::uint8_t>(n);
  }
  return std::nullopt;
}

}  // namespace

esi::DeviceDescription merge_description(const esi::DeviceDescription& eeprom, const esi::DeviceDescription& file) {
  auto merged = file;
  merged.vendor_id = eeprom.vendor_id;
  merged.product_code = eeprom.product_code;
  merged.revision = eeprom.revision;
  merged.serial_number = eeprom.serial_number;
  merged.eeprom_bytes = eeprom.eeprom_bytes;
  merged.eeprom_config_data_hex = eeprom.eeprom_config_data_hex;
  // Files may omit values that only the EEPROM needs.
  if (merged.bootstrap_rx_size == 0) {
    merged.bootstrap_rx_offset = eeprom.bootstrap_rx_offset;
    merged.bootstrap_rx_size = eeprom.bootstrap_rx_size;
    merged.bootstrap_tx_offset = eeprom.bootstrap_tx_offset;
    merged.bootstrap_tx_size = eeprom.bootstrap_tx_size;
  }
  if (merged.sync_managers.empty()) merged.sync_managers = eeprom.sync_managers;
  if (merged.fmmus.empty()) merged.fmmus = eeprom.fmmus;
  if (merged.dc_modes.empty()) merged.dc_modes = eeprom.dc_modes;
  return merged;
}

void apply_description(ConfiguredSlave& slave) {
  if (slave.eeprom) {
    slave.info.description = std::move(*slave.eeprom);
    slave.eeprom.reset();
  }
  // An earlier plan may have changed it; it is not in the EEPROM.
  slave.info.description.eeprom_to_application = slave.plan.eeprom_to_application.value_or(false);
  if (!slave.plan.esi) return;
  const auto& file = *slave.plan.esi;
  slave.eeprom = std::move(slave.info.description);
  slave.info.description = merge_description(*slave.eeprom, file);
  if (slave.plan.eeprom_to_application) {
    slave.info.description.eeprom_to_application = *slave.plan.eeprom_to_application;
  }
  complete_timeouts(slave.plan, file.timeouts);
  complete_watchdogs(slave.plan, file.watchdogs);
  auto commands = startup_commands(file);
  auto& planned = slave.plan.startup_sdos;
  planned.insert(planned.begin(), commands.begin(), commands.end());
  auto& pdos = slave.plan.pdos;
  complete_pdos(file, pdos);
  // The PDOs of modules are not in the file: use those of the slave.
  const bool knows_pdos = !file.rx_pdos.empty() || !file.tx_pdos.empty();
  if (!knows_pdos || !pdos.outputs.empty() || !pdos.inputs.empty()) return;
  pdos = pdo_configuration_from_sii(file);
  slave.plan.own_pdos = false;
}

std::vector<motion::StartupSdo> startup_commands(const esi::DeviceDescription& device) {
  std::vector<motion::StartupSdo> sdos;
  // Commands for INIT to PREOP need the mailbox as well: they are sent first in PREOP.
  const std::array<std::pair<std::string_view, motion::StartupState>, 3> kinds{
      {{"IP", motion::StartupState::kPreOperational},
       {"PS", motion::StartupState::kPreOperational},
       {"SO", motion::StartupState::kSafeOperational}}};
  for (const auto& [transition, in] : kinds) {
    for (const auto& command : device.init_commands) {
      const auto& when = command.transitions;
      if (std::find(when.begin(), when.end(), transition) == when.end()) continue;
      auto data = esi::parse_hex(command.data_hex).value_or(std::vector<std::byte>{});
      if (data.empty()) continue;
      sdos.push_back({command.index, command.subindex, std::move(data), command.complete_access, in});
    }
  }
  return sdos;
}

void complete_pdos(const esi::DeviceDescription& device, motion::PdoConfiguration& pdos) {
  for (const bool outputs : {true, false}) {
    for (auto& planned : outputs ? pdos.outputs : pdos.inputs) {
      const auto* pdo = find_pdo(pdos_of(device, outputs), planned.index);
      if (pdo == nullptr) continue;
      if (planned.objects.empty()) planned.objects = objects_of(*pdo);
      if (!planned.sync_manager) planned.sync_manager = pdo->sync_manager;
    }
  }
}

tl::expected<void, PdoMisfit> check_pdos(const esi::DeviceDescription& device, const motion::PdoConfiguration& pdos) {
  if (auto done = check_direction(device, pdos.outputs, device.rx_pdos, true); !done) return done;
  return check_direction(device, pdos.inputs, device.tx_pdos, false);
}

std::vector<AssignmentPlan> plan_assignments(const motion::PdoConfiguration& pdos,
                                             const esi::DeviceDescription& device) {
  std::vector<AssignmentPlan> plans;
  if (!device.mailbox.coe || (!device.mailbox.coe_pdo_assign && !device.mailbox.coe_pdo_config)) return plans;
  for (std::size_t n = 0; n < device.sync_managers.size(); ++n) {
    const auto use = device.sync_managers[n].use;
    if (use != Use::kOutputs && use != Use::kInputs) continue;
    const bool outputs = use == Use::kOutputs;
    const auto first = first_of(device, use);
    AssignmentPlan plan{static_cast<std::uint8_t>(n), outputs, {}, {}};
    std::vector<std::uint16_t> assigned;
    Steps mappings;
    for (const auto& pdo : outputs ? pdos.outputs : pdos.inputs) {
      if (pdo.sync_manager.value_or(first.value_or(0)) != n) continue;
      assigned.push_back(pdo.index);
      const auto* known = find_pdo(pdos_of(device, outputs), pdo.index);
      const bool fixed = known != nullptr && known->fixed;
      const bool as_found = pdo.own_mapping || pdo.objects.empty();
      const bool written = device.mailbox.coe_pdo_config && !fixed && !as_found;
      if (written) append_mapping(mappings, pdo);
      plan.pdos.push_back({pdo.index, written ? pdo.objects : std::vector<motion::MappedObject>{}});
    }
    const auto assignment = static_cast<std::uint16_t>(kPdoAssignment + n);
    // A PDO can be changed only while it is not assigned.
    if (device.mailbox.coe_pdo_assign && !mappings.empty())
      plan.steps.push_back(SdoScript::Step::of<std::uint8_t>(assignment, 0, 0));
    for (auto& mapping : mappings) plan.steps.push_back(std::move(mapping));
    if (device.mailbox.coe_pdo_assign) append_list(plan.steps, assignment, assigned);
    plans.push_back(std::move(plan));
  }
  return plans;
}

}  // namespace driveline::ecat_master
