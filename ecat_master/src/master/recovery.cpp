// Recovers single slaves while the others continue to cycle.
#include <algorithm>

#include "bus/write_protection.hpp"
#include "configuration/pdo_writing.hpp"
#include "configuration/process_data_setup.hpp"
#include "driveline/ecat_master/configuration/configuration_check.hpp"
#include "driveline/ecat_master/configuration/description_plan.hpp"
#include "driveline/ecat_master/discovery/device_identification.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/wire/sync_manager.hpp"
#include "master/newcomers.hpp"
#include "sii/sii_reader.hpp"

namespace driveline::ecat_master {
namespace {

using wire::AlState;

/// Lowest state in which the configuration of the process data is retained.
constexpr AlState kConfigured = AlState::kSafeOp;

/// A number of an identity as planned and found.
struct IdentityField {
  IdentityRule planned;
  std::uint32_t found = 0;
  bool by_start = false;  ///< the plan leaves it open
};

/// The identity in the plan; open numbers are those of the slave found at start. The serial number found at start is
/// not compared if it is 0 or the slave is hot-connect: another device may have its alias or device ID.
std::array<IdentityField, 4> identity_fields(const ConfiguredSlave& slave, const esi::DeviceDescription& found) {
  const auto& known = slave.info.description;
  const auto equal_or_any = [](std::uint32_t value) {
    return value == 0 ? IdentityRule{} : IdentityRule::equal(value);
  };
  const auto field = [&slave](IdentityRule planned, IdentityRule at_start, std::uint32_t value) -> IdentityField {
    const bool by_start = planned == IdentityRule{} && slave.present;
    return {by_start ? at_start : planned, value, by_start};
  };
  const auto serial = slave.plan.hot_connect ? IdentityRule{} : equal_or_any(known.serial_number);
  return {field(equal_or_any(slave.plan.vendor_id), IdentityRule::equal(known.vendor_id), found.vendor_id),
          field(equal_or_any(slave.plan.product_code), IdentityRule::equal(known.product_code), found.product_code),
          field(slave.plan.revision, IdentityRule::equal(known.revision), found.revision),
          field(slave.plan.serial, serial, found.serial_number)};
}

/// Checks that the device at `slave` is the one found there at start, or one of its type that the plan accepts.
Result<void> check_identity(Bus& bus, const ConfiguredSlave& slave) {
  const auto& ref = slave.info.ref;
  const auto refuse = [&ref](ErrorFacts facts) { return tl::unexpected(Error{facts, ref.position}); };
  auto images = read_sii(bus, {&ref, 1});
  if (!images) return tl::unexpected(images.error());
  if (!images->front()) return tl::unexpected(images->front().error());
  const auto decoded = esi::decode_sii(*images->front());
  if (!decoded) return refuse(facts::SiiContent{static_cast<std::uint16_t>(decoded.error().word_offset)});
  const auto fields = identity_fields(slave, esi::description_from_sii(*decoded));
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (fields[i].planned.accepts(fields[i].found)) continue;
    return refuse(facts::IdentityMismatch{.number = static_cast<IdentityNumber>(i),
                                          .at_start = fields[i].by_start,
                                          .expected = fields[i].planned.value,
                                          .found = fields[i].found});
  }
  const auto alias = decoded->config.station_alias;
  if (slave.plan.alias && alias != *slave.plan.alias) {
    return refuse(
        facts::IdentityMismatch{.number = IdentityNumber::kAlias, .expected = *slave.plan.alias, .found = alias});
  }
  if (!slave.plan.device_id) return {};
  const auto ids = read_device_ids(bus, {&ref, 1});
  if (!ids) return tl::unexpected(ids.error());
  if (ids->front() == slave.plan.device_id) return {};
  return refuse(facts::IdentityMismatch{.number = IdentityNumber::kDeviceId,
                                        .expected = *slave.plan.device_id,
                                        .found = ids->front().value_or(std::uint16_t{0})});
}

}  // namespace

Result<AlReport> Master::al_status_of(std::size_t slave) {
  auto reports = read_al_status(bus_, {&refs_[slave], 1});
  if (!reports) return tl::unexpected(reports.error());
  return reports->front();
}

/// Checks identity and process data size of a hot-connect slave that joins for the first time.
Result<void> Master::check_joining_slave(std::size_t slave) {
  auto& one = slaves_[slave];
  if (auto done = check_identity(bus_, one); !done) return done;
  auto images = read_sii(bus_, {&refs_[slave], 1});
  if (!images) return tl::unexpected(images.error());
  ConfiguredSlave arrived;
  arrived.info = make_slave_info(refs_[slave], std::move(images->front()));
  if (!arrived.info.usable()) return tl::unexpected(*arrived.info.problem);
  arrived.plan = one.plan;
  if (one.plan.esi) {
    arrived.eeprom = std::move(arrived.info.description);
    arrived.info.description = merge_description(*arrived.eeprom, *one.plan.esi);
  }
  arrived.info.description.eeprom_to_application =
      one.plan.eeprom_to_application.value_or(arrived.info.description.eeprom_to_application);
  const auto reserved = make_demand(one);
  const auto wanted = make_demand(arrived);
  if (!wanted) return tl::unexpected(wanted.error());
  const auto fits = [&] {
    return reserved && std::equal(reserved->channels.begin(), reserved->channels.end(), wanted->channels.begin(),
                                  wanted->channels.end(), [](const auto& a, const auto& b) { return a.same_place(b); });
  };
  if (!fits()) {
    std::size_t bytes = 0;
    for (const auto& channel : wanted->channels) bytes += channel.bytes;
    return tl::unexpected(
        Error{facts::ProcessDataSize{.bytes = static_cast<std::uint32_t>(bytes)}, refs_[slave].position});
  }
  image_.relocate(slave, reserved->channels, wanted->channels);
  one.info = std::move(arrived.info);
  one.eeprom = std::move(arrived.eeprom);
  one.present = true;
  return {};
}

/// Another device is at the position of this slave and loses its address, so that the right one can join.
Result<void> Master::refuse(std::size_t slave, const Error& error) {
  if (error.is<facts::IdentityMismatch>()) {
    // If the write fails, the device is gone again, together with its address.
    static_cast<void>(bus_.write(refs_[slave], wire::reg::kStationAddress, 0).has_value());
  }
  return tl::unexpected(error);
}

Result<std::vector<Master::Readdressed>> Master::readdress_newcomers() {
  return newcomers_->readdress();
}

Result<void> Master::recover(std::size_t slave, std::chrono::nanoseconds state_timeout) {
  const auto report = al_status_of(slave);
  if (!report) {
    const bool silent = report.error().is<facts::WorkingCounter>();
    return tl::unexpected(silent ? newcomers_->unplaced(slave).value_or(report.error()) : report.error());
  }
  const bool joins = !slaves_[slave].present;
  if (joins) {
    if (auto done = check_joining_slave(slave); !done) return refuse(slave, done.error());
  }
  // A write-protected slave could not be recovered.
  if (auto done = lift_write_protection(bus_, refs_[slave]); !done) return done;
  const std::span<const SlaveRef> ref(&refs_[slave], 1);
  // A slave that has kept its station address and is in SAFEOP or above is still configured, unless an invalid
  // configuration caused the error.
  bool configured = !joins && !newcomers_->unproven(slave) &&
                    (report->status.state == kConfigured || report->status.state == AlState::kOp);
  if (configured) {
    const auto changes = changed_registers(slave);
    if (!changes) return tl::unexpected(changes.error());
    if (auto done = rewrite(bus_, refs_[slave], *changes); !done) return done;
    configured = !needs_configuration(*changes);
  }
  const auto to_op = recovery_timeout(slave, AlState::kOp, state_timeout);
  if (configured && change_state(bus_, ref, AlState::kOp, to_op)) return {};
  if (auto done = reconfigure(slave, state_timeout); !done) {
    if (done.error().is<facts::IdentityMismatch>()) return refuse(slave, done.error());
    return tl::unexpected(explain(done.error()));
  }
  StartupNotes notes;
  const auto written =
      write_startup_values(engine_, {&slaves_[slave], 1}, motion::StartupState::kSafeOperational, notes);
  add_new(startup_notes_, notes);
  if (!written) return written;
  if (auto done = change_state(bus_, ref, AlState::kOp, to_op); !done) return tl::unexpected(explain(done.error()));
  return {};
}

/// The drives of a slave with SoE check their parameters whenever it rises, so it gets no less time than at the start.
std::chrono::nanoseconds Master::recovery_timeout(std::size_t slave, AlState target,
                                                  std::chrono::nanoseconds timeout) const noexcept {
  const auto& one = slaves_[slave];
  return one.info.description.mailbox.soe ? std::max(timeout, rise_timeout(one, target)) : timeout;
}

Result<void> Master::reconfigure(std::size_t slave, std::chrono::nanoseconds state_timeout) {
  auto& one = slaves_[slave];
  const std::span<const SlaveRef> ref(&refs_[slave], 1);
  if (auto done = check_identity(bus_, one); !done) return done;
  newcomers_->prove(slave);
  if (auto done = change_state(bus_, ref, AlState::kInit, state_timeout); !done) return done;
  if (auto done = clear_channels(bus_, ref); !done) return done;
  const auto window = write_mailbox_channels(bus_, one.info, one.plan.mailbox_timeouts);
  if (!window) return tl::unexpected(window.error());
  if (*window && !one.mailbox) {
    one.mailbox = std::make_unique<MailboxClient>(engine_, one.info.ref, **window);
  } else if (*window) {
    engine_.open(one.info.ref, **window);
  }
  if (auto done = hand_over_eeproms(bus_, {&one.info, 1}); !done) return done;
  if (auto done = change_state(bus_, ref, AlState::kPreOp, state_timeout); !done) return done;
  StartupNotes notes;
  auto configured = write_startup_values(engine_, {&one, 1}, motion::StartupState::kPreOperational, notes);
  if (configured) configured = restore_pdos(slave, notes);
  add_new(startup_notes_, notes);
  if (!configured) return configured;
  if (auto done = write_watchdogs(bus_, {&one, 1}); !done) return done;
  if (auto done = write_process_data_setup(bus_, {&one, 1}, image_); !done) return done;
  if (auto done = restore_clock(slave); !done) return done;
  if (auto done = restore_registers(slave); !done) return done;
  const StateTarget target{refs_[slave], recovery_timeout(slave, AlState::kSafeOp, state_timeout),
                           one.plan.safe_op_retries};
  StartupNotes refusals;
  auto raised = change_states(bus_, {&target, 1}, AlState::kSafeOp, &refusals).front();
  add_new(startup_notes_, refusals);
  return raised;
}

/// Writes the planned PDOs. The process image is laid out: a slave that now keeps other PDOs does not fit into it.
Result<void> Master::restore_pdos(std::size_t slave, StartupNotes& notes) {
  auto& one = slaves_[slave];
  const auto planned = one.plan.pdos;
  const auto kept = one.plan.kept;
  if (auto done = write_planned_pdos(engine_, {&one, 1}, notes); !done) return done;
  const bool same = motion::same_pdos(planned.outputs, one.plan.pdos.outputs) &&
                    motion::same_pdos(planned.inputs, one.plan.pdos.inputs);
  if (same) return {};
  const auto bytes = [](const motion::PdoConfiguration& pdos) {
    return static_cast<std::uint32_t>(pdos.output_bytes() + pdos.input_bytes());
  };
  const facts::ProcessDataSize other{.bytes = bytes(one.plan.pdos), .limit = bytes(planned)};
  one.plan.pdos = planned;
  one.plan.kept = kept;
  return tl::unexpected(Error{other, refs_[slave].position});
}

/// Restores the registers that are not part of the plan to the values read when the slave was first configured. For a
/// slave that was missing then, reads the values now.
Result<void> Master::restore_registers(std::size_t slave) {
  if (facts_[slave] == ControllerFacts{}) {
    auto facts = read_controller_facts(bus_, {&refs_[slave], 1});
    if (!facts) return tl::unexpected(facts.error());
    facts_[slave] = facts->front();
    return {};
  }
  const auto changes = changed_registers(slave);
  if (!changes) return tl::unexpected(changes.error());
  return rewrite(bus_, refs_[slave], *changes);
}

}  // namespace driveline::ecat_master
