#include "driveline/ecat_master/configuration/configurator.hpp"

#include <algorithm>

#include "configuration/pdo_writing.hpp"
#include "configuration/process_data_setup.hpp"
#include "driveline/ecat_master/configuration/description_plan.hpp"
#include "driveline/ecat_master/configuration/pdo_discovery.hpp"
#include "driveline/ecat_master/state_machine.hpp"
#include "driveline/wire/sync_manager.hpp"
#include "sii/sii_ownership.hpp"

namespace driveline::ecat_master {
namespace {

using Use = esi::SyncManager::Use;

bool same_device(const SlaveInfo& a, const SlaveInfo& b) {
  return a.description.vendor_id == b.description.vendor_id && a.description.product_code == b.description.product_code;
}

/// Notes a slave that exchanges nothing although it has PDOs.
void note_nothing_assigned(const ConfiguredSlave& slave, StartupNotes& notes) {
  const auto& device = slave.info.description;
  const auto pdos = device.rx_pdos.size() + device.tx_pdos.size();
  const bool exchanges = slave.plan.pdos.output_bytes() + slave.plan.pdos.input_bytes() > 0;
  if (exchanges || pdos == 0) return;
  notes.push_back({slave.info.ref.position, notes::NothingAssigned{static_cast<std::uint16_t>(pdos)}});
}

/// Completes the plans that use the PDOs assigned by the slave.
Result<void> read_own_pdos(MailboxEngine& engine, std::span<ConfiguredSlave> slaves, StartupNotes& notes) {
  std::vector<SlaveInfo> asked;
  std::vector<ConfiguredSlave*> owners;
  for (auto& slave : slaves) {
    if (!slave.plan.own_pdos || !slave.present) continue;
    asked.push_back(slave.info);
    owners.push_back(&slave);
  }
  auto found = read_pdo_configurations(engine, asked, notes);
  for (std::size_t i = 0; i < owners.size(); ++i) {
    if (!found[i]) return tl::unexpected(found[i].error());
    owners[i]->plan.pdos = std::move(*found[i]);
    note_nothing_assigned(*owners[i], notes);
  }
  // A slave that is not on the line yet gets the PDOs of an identical slave.
  for (auto& slave : slaves) {
    if (slave.present || !slave.plan.own_pdos) continue;
    const auto alike = std::find_if(slaves.begin(), slaves.end(), [&](const ConfiguredSlave& other) {
      return other.present && same_device(other.info, slave.info);
    });
    if (alike != slaves.end()) slave.plan.pdos = alike->plan.pdos;
  }
  return {};
}

/// The PDOs of a plan without objects, outputs first.
std::vector<motion::PdoMapping*> unnamed_mappings(SlavePlan& plan) {
  std::vector<motion::PdoMapping*> pdos;
  for (auto* direction : {&plan.pdos.outputs, &plan.pdos.inputs}) {
    for (auto& pdo : *direction) {
      if (pdo.objects.empty() || pdo.own_mapping) pdos.push_back(&pdo);
    }
  }
  return pdos;
}

/// Gives slaves that are not on the line yet the mapping of an identical slave.
void take_mappings_of_kind(std::span<ConfiguredSlave> slaves) {
  for (auto& slave : slaves) {
    if (slave.present || slave.plan.own_pdos) continue;
    const auto alike = std::find_if(slaves.begin(), slaves.end(), [&](const ConfiguredSlave& other) {
      return other.present && same_device(other.info, slave.info);
    });
    if (alike == slaves.end()) continue;
    for (auto* pdo : unnamed_mappings(slave.plan)) {
      for (const auto* theirs : unnamed_mappings(alike->plan)) {
        if (theirs->index != pdo->index) continue;
        pdo->objects = theirs->objects;
        pdo->own_mapping = true;
      }
    }
  }
}

/// Completes the PDOs without objects with the mapping in the slaves.
Result<void> read_own_mappings(MailboxEngine& engine, std::span<ConfiguredSlave> slaves, StartupNotes& notes) {
  std::vector<SlaveInfo> asked;
  std::vector<PdoPlace> places;
  std::vector<motion::PdoMapping*> pdos;
  for (auto& slave : slaves) {
    if (!slave.present || slave.plan.own_pdos) continue;
    const auto unnamed = unnamed_mappings(slave.plan);
    if (unnamed.empty()) continue;
    for (auto* pdo : unnamed) places.push_back({asked.size(), pdo->index});
    pdos.insert(pdos.end(), unnamed.begin(), unnamed.end());
    asked.push_back(slave.info);
  }
  auto mappings = read_mappings(engine, asked, places, notes);
  for (std::size_t i = 0; i < pdos.size(); ++i) {
    if (!mappings[i]) return tl::unexpected(mappings[i].error());
    pdos[i]->objects = std::move(*mappings[i]);
    pdos[i]->own_mapping = true;
  }
  take_mappings_of_kind(slaves);
  return {};
}

}  // namespace

std::chrono::nanoseconds rise_timeout(const ConfiguredSlave& slave, wire::AlState target) noexcept {
  const auto& limits = slave.plan.timeouts;
  const auto planned = target == wire::AlState::kOp ? limits.to_op : limits.to_safe_op;
  return planned.value_or(slave.info.description.mailbox.soe ? kSoeOpTimeout : kOpTimeout);
}

Result<SdoScript> coe_script(const ConfiguredSlave& slave, motion::StartupState in) {
  SdoScript script;
  script.position = slave.info.ref.position;
  for (const auto& sdo : slave.plan.startup_sdos) {
    if (sdo.in != in || sdo.need == motion::WriteNeed::kOmitted) continue;
    script.steps.push_back(
        {{sdo.index, sdo.subindex, sdo.complete}, sdo.data, sdo.need, sdo.need == motion::WriteNeed::kOptional});
  }
  if (script.steps.empty() || (slave.mailbox && slave.info.description.mailbox.coe)) return script;
  return tl::unexpected(Error{facts::NoMailbox{wire::MailboxType::kCoe}, slave.info.ref.position});
}

std::vector<AssignmentPlan> planned_assignments(const ConfiguredSlave& slave) {
  const auto& plan = slave.plan;
  const bool fixed_pdos = plan.own_pdos || !slave.info.description.mailbox.any();
  const bool no_pdos = plan.pdos.outputs.empty() && plan.pdos.inputs.empty();
  if (fixed_pdos || no_pdos) return {};
  auto assignments = plan.esi ? plan_assignments(plan.pdos, slave.info.description) : plan_assignments(plan.pdos);
  std::erase_if(assignments, [&plan](const AssignmentPlan& assignment) {
    return assignment.outputs ? plan.kept.outputs : plan.kept.inputs;
  });
  return assignments;
}

std::vector<ExpectedSlave> expected_slaves(std::span<const SlavePlan> plans) {
  auto equal_or_any = [](std::uint32_t value) { return value == 0 ? IdentityRule{} : IdentityRule::equal(value); };
  std::vector<ExpectedSlave> expected;
  for (const auto& plan : plans) {
    expected.push_back({plan.name, equal_or_any(plan.vendor_id), equal_or_any(plan.product_code), plan.revision,
                        plan.serial, plan.alias, plan.device_id, plan.hot_connect && (plan.alias || plan.device_id),
                        plan.behind});
  }
  return expected;
}

Result<std::optional<MailboxWindow>> write_mailbox_channels(Bus& bus, const SlaveInfo& slave,
                                                            const MailboxTimeouts& timeouts) {
  const auto out = find_sync_manager(slave, Use::kMailboxOut);
  const auto in = find_sync_manager(slave, Use::kMailboxIn);
  if (!slave.description.mailbox.any() || !out || !in) return std::nullopt;
  const auto& out_layout = slave.description.sync_managers[*out];
  const auto& in_layout = slave.description.sync_managers[*in];
  std::array writes{sync_manager_write(slave.ref, *out, out_layout, out_layout.default_size),
                    sync_manager_write(slave.ref, *in, in_layout, in_layout.default_size)};
  if (auto done = bus.write_all(writes); !done) return tl::unexpected(done.error());
  return MailboxWindow{out_layout.start_address, out_layout.default_size, in_layout.start_address,
                       in_layout.default_size, timeouts};
}

Result<std::vector<std::unique_ptr<MailboxClient>>> enter_pre_op(MailboxEngine& engine,
                                                                 std::span<const SlaveInfo> slaves,
                                                                 std::span<const StateTimeouts> timeouts,
                                                                 std::span<const MailboxTimeouts> mailbox_timeouts) {
  auto& bus = engine.bus();
  std::vector<SlaveRef> refs;
  std::vector<StateTarget> up;
  std::vector<StateTarget> down;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    const auto& slave = slaves[i];
    if (!slave.usable()) return tl::unexpected(*slave.problem);
    const auto limits = i < timeouts.size() ? timeouts[i] : StateTimeouts{};
    refs.push_back(slave.ref);
    down.push_back({slave.ref, limits.limit(wire::AlState::kInit, true)});
    up.push_back({slave.ref, limits.limit(wire::AlState::kPreOp, false)});
  }
  // An earlier attempt may have raised slaves; sync managers and mailbox counters are only reset in INIT.
  if (auto done = first_failure(change_states(bus, down, wire::AlState::kInit)); !done)
    return tl::unexpected(done.error());
  if (auto done = clear_channels(bus, refs); !done) return tl::unexpected(done.error());
  std::vector<std::unique_ptr<MailboxClient>> mailboxes;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    const auto& slave = slaves[i];
    mailboxes.push_back(nullptr);
    engine.close(slave.ref.position);
    const auto window =
        write_mailbox_channels(bus, slave, i < mailbox_timeouts.size() ? mailbox_timeouts[i] : MailboxTimeouts{});
    if (!window) return tl::unexpected(window.error());
    if (*window) mailboxes.back() = std::make_unique<MailboxClient>(engine, slave.ref, **window);
  }
  if (auto done = hand_over_eeproms(bus, slaves); !done) return tl::unexpected(done.error());
  if (auto done = first_failure(change_states(bus, up, wire::AlState::kPreOp)); !done)
    return tl::unexpected(done.error());
  return mailboxes;
}

Result<void> hand_over_eeproms(Bus& bus, std::span<const SlaveInfo> slaves) {
  std::vector<SlaveRef> refs;
  for (const auto& slave : slaves) {
    if (slave.description.eeprom_to_application) refs.push_back(slave.ref);
  }
  return give_to_applications(bus, refs);
}

Result<std::unique_ptr<MailboxClient>> enter_bootstrap(MailboxEngine& engine, const SlaveInfo& slave) {
  auto& bus = engine.bus();
  if (!slave.usable()) return tl::unexpected(*slave.problem);
  const auto& device = slave.description;
  if (device.bootstrap_rx_size == 0 || device.bootstrap_tx_size == 0) {
    return tl::unexpected(Error{facts::NoBootMailbox{}, slave.ref.position});
  }
  const std::array refs{slave.ref};
  if (auto done = change_state(bus, refs, wire::AlState::kInit, kPreOpTimeout); !done)
    return tl::unexpected(done.error());
  if (auto done = clear_channels(bus, refs); !done) return tl::unexpected(done.error());
  using wire::SyncManagerControl;
  using Mode = wire::SyncManagerMode;
  using Direction = wire::SyncManagerDirection;
  esi::SyncManager out;
  out.start_address = device.bootstrap_rx_offset;
  out.control = SyncManagerControl{Mode::kMailbox, Direction::kWrite, false, true, false}.raw();
  esi::SyncManager in;
  in.start_address = device.bootstrap_tx_offset;
  in.control = SyncManagerControl{Mode::kMailbox, Direction::kRead, false, true, false}.raw();
  std::array writes{sync_manager_write(slave.ref, 0, out, device.bootstrap_rx_size),
                    sync_manager_write(slave.ref, 1, in, device.bootstrap_tx_size)};
  if (auto done = bus.write_all(writes); !done) return tl::unexpected(done.error());
  if (auto done = hand_over_eeproms(bus, {&slave, 1}); !done) return tl::unexpected(done.error());
  if (auto done = change_state(bus, refs, wire::AlState::kBootstrap, kPreOpTimeout); !done)
    return tl::unexpected(done.error());
  return std::make_unique<MailboxClient>(engine, slave.ref,
                                         MailboxWindow{device.bootstrap_rx_offset, device.bootstrap_rx_size,
                                                       device.bootstrap_tx_offset, device.bootstrap_tx_size});
}

Result<void> write_startup_values(MailboxEngine& engine, std::span<const ConfiguredSlave> slaves,
                                  motion::StartupState in, StartupNotes& notes) {
  std::vector<SdoScript> scripts;
  for (const auto& slave : slaves) {
    if (!slave.present) continue;
    auto script = coe_script(slave, in);
    if (!script) return tl::unexpected(script.error());
    if (!script->steps.empty()) scripts.push_back(std::move(*script));
  }
  if (auto done = first_failure(run_scripts(engine, scripts, &notes)); !done) return done;
  return write_startup_idns(engine, slaves, in);
}

Result<void> write_watchdogs(Bus& bus, std::span<const ConfiguredSlave> slaves) {
  std::vector<RegisterWrite> writes;
  for (const auto& slave : slaves) {
    if (!slave.present) continue;
    const auto& plan = slave.plan.watchdog;
    auto write = [&](const wire::Register<std::uint16_t>& reg, std::optional<std::uint16_t> value) {
      if (!value) return;
      const auto bytes = bytes::to_le_bytes(*value);
      writes.push_back({slave.info.ref, reg.address, {bytes.begin(), bytes.end()}});
    };
    write(wire::reg::kWatchdogDivider, plan.divider);
    write(wire::reg::kWatchdogTimePdi, plan.pdi);
    write(wire::reg::kWatchdogTimeProcessData, plan.process_data);
  }
  return bus.write_all(writes);
}

Result<ProcessImage> configure_process_data(MailboxEngine& engine, std::span<ConfiguredSlave> slaves,
                                            const LayoutSettings& layout, StartupNotes& notes) {
  auto& bus = engine.bus();
  if (auto done = write_startup_values(engine, slaves, motion::StartupState::kPreOperational, notes); !done)
    return tl::unexpected(done.error());
  if (auto done = write_planned_pdos(engine, slaves, notes); !done) return tl::unexpected(done.error());
  if (auto done = read_own_pdos(engine, slaves, notes); !done) return tl::unexpected(done.error());
  if (auto done = read_own_mappings(engine, slaves, notes); !done) return tl::unexpected(done.error());
  if (auto done = write_watchdogs(bus, slaves); !done) return tl::unexpected(done.error());
  const auto demands = make_demands(bus, slaves);
  if (!demands) return tl::unexpected(demands.error());
  auto image = ProcessImage::lay_out(*demands, layout);
  if (!image) return image;
  if (auto done = write_process_data_setup(bus, slaves, *image); !done) return tl::unexpected(done.error());
  return image;
}

}  // namespace driveline::ecat_master
