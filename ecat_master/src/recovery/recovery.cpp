// Bringing single slaves back while the others keep cycling.
#include <algorithm>

#include "driveline/ecat_master/configuration/configuration_check.hpp"
#include "driveline/ecat_master/configuration/description_plan.hpp"
#include "driveline/ecat_master/configuration/process_data_setup.hpp"
#include "driveline/ecat_master/discovery/device_identification.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/ecat_master/sii/sii_reader.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/wire/sync_manager.hpp"

namespace driveline::ecat_master {
namespace {

using wire::AlState;

/// Least state in which the configuration of the process data is still in place.
constexpr AlState kConfigured = AlState::kSafeOp;

Error error_of(ErrorKind kind, SlaveRef slave, std::uint16_t address, std::uint32_t expected, std::uint32_t received) {
  Error error;
  error.kind = kind;
  error.slave = slave.position;
  error.address = address;
  error.expected = expected;
  error.received = received;
  return error;
}

/// One number of an identity as planned and found.
struct IdentityField {
  IdentityRule planned;
  std::uint32_t found = 0;
  bool by_start = false;  ///< the plan says nothing
};

/// What the plan says about who the slave is; where it leaves a number open, that of the slave that was found at start.
/// A hot-connected one is whoever has its alias or device ID, and no serial number is 0.
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

/// The device at `slave` is the one that was found there at start, or one of its kind that the plan accepts.
Result<void> check_identity(Bus& bus, const ConfiguredSlave& slave) {
  const auto& ref = slave.info.ref;
  const auto mismatch = [&ref](IdentityNumber number, std::uint32_t expected, std::uint32_t received) {
    const auto which = static_cast<std::uint16_t>(number);
    return tl::unexpected(error_of(ErrorKind::kIdentityMismatch, ref, which, expected, received));
  };
  auto images = read_sii(bus, {&ref, 1});
  if (!images) return tl::unexpected(images.error());
  if (!images->front()) return tl::unexpected(images->front().error());
  const auto decoded = esi::decode_sii(*images->front());
  if (!decoded) {
    const auto word = static_cast<std::uint16_t>(decoded.error().word_offset);
    return tl::unexpected(error_of(ErrorKind::kSiiContent, ref, word, 0, 0));
  }
  const auto fields = identity_fields(slave, esi::description_from_sii(*decoded));
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (fields[i].planned.accepts(fields[i].found)) continue;
    auto refused = mismatch(static_cast<IdentityNumber>(i), fields[i].planned.value, fields[i].found);
    refused.value().code = fields[i].by_start ? 1 : 0;
    return refused;
  }
  if (slave.plan.alias && decoded->config.station_alias != *slave.plan.alias)
    return mismatch(IdentityNumber::kAlias, *slave.plan.alias, decoded->config.station_alias);
  if (!slave.plan.device_id) return {};
  const auto ids = read_device_ids(bus, {&ref, 1});
  if (!ids) return tl::unexpected(ids.error());
  if (ids->front() != slave.plan.device_id)
    return mismatch(IdentityNumber::kDeviceId, *slave.plan.device_id, ids->front().value_or(0));
  return {};
}

/// One slave of the line by position: its station address and the alias it loaded when it was switched on.
struct Seen {
  std::uint16_t station = 0;
  std::uint16_t alias = 0;
  bool answers = false;
  std::optional<std::uint16_t> device_id{};  ///< when somebody is missing who is known by it
};

Result<std::vector<Seen>> look_around(Bus& bus) {
  std::array<std::byte, 1> type{};
  const auto count = bus.broadcast_read(wire::reg::kType.address, type);
  if (!count) return tl::unexpected(count.error());
  // Station address 0x0010 and alias 0x0012 in one read.
  std::vector<std::array<std::byte, 4>> data(*count);
  std::vector<Request> requests;
  for (std::uint16_t i = 0; i < *count; ++i) {
    requests.push_back(
        {wire::Command::kAprd, wire::DatagramAddress::position(i, wire::reg::kStationAddress.address), data[i]});
  }
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < data.size(); ++i) {
    seen.push_back({wire::load_le<std::uint16_t>(data[i]), wire::load_le<std::uint16_t>(std::span(data[i]).subspan(2)),
                    requests[i].working_counter == 1});
  }
  return seen;
}

}  // namespace

Result<AlReport> Master::al_status_of(std::size_t slave) {
  auto reports = read_al_status(bus_, {&refs_[slave], 1});
  if (!reports) return tl::unexpected(reports.error());
  return reports->front();
}

/// A slave that was switched off has lost its station address. Members of the line are recognised by it; whoever has
/// another or none is the missing slave whose place it is, or the hot-connected one with that alias.
Result<std::size_t> Master::readdress_newcomers() {
  auto seen = look_around(bus_);
  if (!seen) return tl::unexpected(seen.error());
  const auto index_of = [this](std::uint16_t station) -> std::optional<std::size_t> {
    const auto found = std::find_if(refs_.begin(), refs_.end(), [=](SlaveRef ref) { return ref.station == station; });
    if (found == refs_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - refs_.begin());
  };
  std::vector<bool> present(refs_.size());
  for (const auto& one : *seen) {
    if (const auto index = index_of(one.station); index && one.answers) present[*index] = true;
  }
  bool by_id = false;
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    by_id = by_id || (!present[i] && slaves_[i].plan.hot_connect && slaves_[i].plan.device_id);
  }
  if (by_id) {
    std::vector<std::uint16_t> strangers;
    for (std::size_t position = 0; position < seen->size(); ++position) {
      const auto& one = (*seen)[position];
      if (one.answers && !index_of(one.station)) strangers.push_back(static_cast<std::uint16_t>(position));
    }
    const auto ids = identify_newcomers(strangers);
    if (!ids) return tl::unexpected(ids.error());
    for (std::size_t i = 0; i < strangers.size(); ++i) (*seen)[strangers[i]].device_id = (*ids)[i];
  }
  std::size_t addressed = 0;
  std::vector<std::optional<std::size_t>> known(seen->size());
  const auto give_address = [&](std::size_t position, std::size_t slave) {
    known[position] = slave;
    present[slave] = true;
    unproven_[slave] = true;
    ++addressed;
    const auto address = wire::to_le_bytes(refs_[slave].station);
    return bus_.write_at_position(static_cast<std::uint16_t>(position), wire::reg::kStationAddress.address, address);
  };
  std::size_t reached = 0;
  for (std::size_t position = 0; position < seen->size(); ++position) {
    const auto& one = (*seen)[position];
    if (!one.answers) continue;
    reached = position + 1;
    if ((known[position] = index_of(one.station))) continue;
    for (std::size_t i = 0; i < slaves_.size(); ++i) {
      if (present[i] || !slaves_[i].plan.hot_connect || slaves_[i].plan.behind) continue;
      const auto alias = slaves_[i].plan.alias.value_or(slaves_[i].info.alias);
      const bool match =
          (one.alias != 0 && alias == one.alias) || (one.device_id && slaves_[i].plan.device_id == one.device_id);
      if (!match) continue;
      if (auto done = give_address(position, i); !done) return tl::unexpected(done.error());
      break;
    }
  }
  // Who belongs to one with a name.
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    const auto& behind = slaves_[i].plan.behind;
    if (present[i] || !behind) continue;
    const auto head = std::find(known.begin(), known.end(), position_of(behind->head));
    if (head == known.end() || !*head) continue;
    const auto position = static_cast<std::size_t>(head - known.begin()) + behind->distance;
    if (position >= reached || !(*seen)[position].answers || known[position]) continue;
    if (auto done = give_address(position, i); !done) return tl::unexpected(done.error());
  }
  // Behind the break of a ring nobody is reached by position.
  const auto placed = place_by_wiring(std::span(known).first(reached));
  if (!placed) return tl::unexpected(placed.error());
  for (const auto& [position, slave] : *placed) {
    if (auto done = give_address(position, slave); !done) return tl::unexpected(done.error());
  }
  return addressed;
}

/// Device IDs of slaves that have no station address of ours.
Result<std::vector<std::optional<std::uint16_t>>> Master::identify_newcomers(std::span<const std::uint16_t> positions) {
  const auto guests = host(positions);
  if (!guests) return tl::unexpected(guests.error());
  return read_device_ids(bus_, *guests);
}

/// A hot-connected slave that has not been there yet: who it is, and whether its place in the image fits.
Result<void> Master::welcome(std::size_t slave) {
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
    return tl::unexpected(error_of(ErrorKind::kProcessDataSize, refs_[slave], 0, 0, static_cast<std::uint32_t>(bytes)));
  }
  image_.relocate(slave, reserved->channels, wanted->channels);
  one.info = std::move(arrived.info);
  one.eeprom = std::move(arrived.eeprom);
  one.present = true;
  return {};
}

Result<void> Master::recover(std::size_t slave, std::chrono::nanoseconds state_timeout) {
  const auto report = al_status_of(slave);
  if (!report) {
    const bool silent = report.error().kind == ErrorKind::kWorkingCounter;
    return tl::unexpected(silent ? unplaced_[slave].value_or(report.error()) : report.error());
  }
  const bool joins = !slaves_[slave].present;
  if (joins) {
    if (auto done = welcome(slave); !done) return refuse(slave, done.error());
  }
  const std::span<const SlaveRef> ref(&refs_[slave], 1);
  // Who has kept its station address and fell no further than SAFEOP is still configured.
  const bool configured =
      !joins && !unproven_[slave] && (report->status.state == kConfigured || report->status.state == AlState::kOp);
  if (configured && change_state(bus_, ref, AlState::kOp, state_timeout)) return {};
  if (auto done = reconfigure(slave, state_timeout); !done) {
    if (done.error().kind == ErrorKind::kIdentityMismatch) return refuse(slave, done.error());
    return tl::unexpected(explain_state_error(bus_, slaves_, image_, done.error()));
  }
  if (auto done = write_startup_sdos(engine_, {&slaves_[slave], 1}, AlState::kOp); !done) return done;
  return change_state(bus_, ref, AlState::kOp, state_timeout);
}

Result<void> Master::reconfigure(std::size_t slave, std::chrono::nanoseconds state_timeout) {
  auto& one = slaves_[slave];
  const std::span<const SlaveRef> ref(&refs_[slave], 1);
  if (auto done = check_identity(bus_, one); !done) return done;
  unproven_[slave] = false;
  if (auto done = change_state(bus_, ref, AlState::kInit, state_timeout); !done) return done;
  if (auto done = clear_channels(bus_, ref); !done) return done;
  const auto window = write_mailbox_channels(bus_, one.info, one.plan.mailbox_timeouts);
  if (!window) return tl::unexpected(window.error());
  if (*window && !one.mailbox) {
    one.mailbox = std::make_unique<MailboxClient>(engine_, one.info.ref, **window);
  } else if (*window) {
    engine_.open(one.info.ref, **window);
  }
  if (auto done = change_state(bus_, ref, AlState::kPreOp, state_timeout); !done) return done;
  if (auto done = write_startup_sdos(engine_, {&one, 1}, AlState::kSafeOp); !done) return done;
  if (auto done = write_watchdogs(bus_, {&one, 1}); !done) return done;
  if (auto done = write_process_data_setup(bus_, {&one, 1}, image_); !done) return done;
  if (auto done = restore_clock(slave); !done) return done;
  return change_state(bus_, ref, AlState::kSafeOp, state_timeout);
}

}  // namespace driveline::ecat_master
