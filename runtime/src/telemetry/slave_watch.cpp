#include "telemetry/slave_watch.hpp"

#include <algorithm>

#include "driveline/wire/al.hpp"
#include "telemetry/feed_owners.hpp"

namespace driveline::runtime {

using ecat_master::kSlavePorts;
using snapshot::FeedSlave;

static_assert(kSlavePorts == snapshot::kFeedSlavePorts);

namespace {

std::int64_t wall_time_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// Values of FeedSlave::clock.
constexpr std::uint8_t kFollowsReference = 1;
constexpr std::uint8_t kIsReference = 2;

}  // namespace

void set_identity(FeedSlave& record, const ecat_master::ConfiguredSlave& slave) {
  const auto& description = slave.info.description;
  record.name.set(slave.plan.name);
  record.device.set(description.name.empty() ? description.type : description.name);
  record.vendor_id = description.vendor_id;
  record.product_code = description.product_code;
  record.revision = description.revision;
  record.serial_number = description.serial_number;
  record.station = slave.info.ref.station;
  record.alias = slave.info.alias;
  record.hot_connect = slave.plan.hot_connect ? 1 : 0;
}

void set_registers(FeedSlave& record, const ecat_master::SlaveDiagnosis& slave, std::int64_t wall_time_ns) {
  record.answers = slave.answers ? 1 : 0;
  if (!slave.answers) return;
  record.read_at_ns = wall_time_ns;
  record.al_state = static_cast<std::uint8_t>(slave.al.status.state);
  record.al_error = slave.al.status.error ? 1 : 0;
  record.al_status_code = static_cast<std::uint16_t>(slave.al.code);
  const bool told = slave.al.code != wire::AlStatusCode::kNoError;
  record.al_text.set(told ? wire::to_text(slave.al.code) : std::string_view{});
  record.processing_unit_errors = slave.processing_unit_errors;
  record.pdi_errors = slave.pdi_errors;
  for (std::size_t i = 0; i < kSlavePorts; ++i) {
    const auto& port = slave.ports[i];
    const bool open = !port.status.loop_closed && port.status.communication;
    record.port[i] = {static_cast<std::uint8_t>(port.status.link ? 1 : 0),
                      static_cast<std::uint8_t>(open ? 1 : 0),
                      port.invalid_frames,
                      port.receive_errors,
                      port.forwarded,
                      port.lost_links,
                      {}};
  }
}

void set_place(FeedSlave& record, const ecat_master::Topology& topology, std::size_t slave) {
  record.parent = snapshot::kFeedParentUnknown;
  if (slave >= topology.slaves.size()) return;
  const auto& node = topology.slaves[slave];
  record.parent = node.parent ? node.parent->slave : snapshot::kFeedParentMaster;
  record.parent_port = node.parent ? node.parent->port : std::uint8_t{0};
  record.entry_port = node.entry_port;
  record.depth = node.depth;
}

snapshot::FeedConditionHead wiring_of(const ecat_master::Topology& topology) {
  snapshot::FeedConditionHead head;
  if (topology.ring_end) {
    head.ring_slave = topology.ring_end->slave;
    head.ring_port = topology.ring_end->port;
  }
  for (const auto& silent : topology.silent_ports) {
    if (head.silent_ports == snapshot::kMaxFeedSilentPorts) break;
    head.silent[head.silent_ports++] = silent.slave * kSlavePorts + silent.port;
  }
  return head;
}

/// Returns the states that the frames of the cycle have brought, at no further cost.
std::vector<std::uint32_t> SlaveWatch::states_in_cycle() const {
  auto* core = master_.core();
  if (core == nullptr || !master_.cycling()) return {};
  std::vector<std::uint32_t> states;
  for (std::size_t i = 0; i < master_.slaves().size(); ++i) {
    const auto report = core->slave_report(i);
    const std::uint32_t there = master_.slaves()[i].present ? 0x100U : 0U;
    states.push_back(there | (report.absent ? 0x200U : 0U) | report.al_status);
  }
  // An extra entry for a line that is cut off at the master, which the states of the slaves do not show.
  states.push_back(core->al_status().slaves == 0 ? 1 : 0);
  return states;
}

bool SlaveWatch::poll() {
  auto states = states_in_cycle();
  if (states == seen_ && clock_.now() < due_) return false;
  seen_ = std::move(states);
  read();
  return true;
}

void SlaveWatch::read() {
  due_ = clock_.now() + kPeriod;
  const auto slaves = master_.slaves();
  condition_.slaves.resize(slaves.size());
  const auto now = wall_time_now_ns();
  // Without returning frames every request would wait for its time-out.
  const bool silent = master_.cycling() && master_.core() != nullptr && master_.core()->al_status().slaves == 0;
  const auto found = silent ? std::vector<ecat_master::SlaveDiagnosis>(slaves.size())
                            : ecat_master::read_slave_diagnosis(master_.bus(), slaves)
                                  .value_or(std::vector<ecat_master::SlaveDiagnosis>(slaves.size()));
  const auto& topology = master_.topology();
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    set_identity(condition_.slaves[i], slaves[i]);
    set_registers(condition_.slaves[i], found[i], now);
    set_place(condition_.slaves[i], topology, i);
  }
  condition_.head = wiring_of(topology);
  set_clocks();
}

bool SlaveWatch::set_owners(const std::vector<std::string>& owners) {
  return set_feed_owners(owners, condition_);
}

void SlaveWatch::set_clocks() {
  const auto* watch = master_.clock_watch();
  const auto* clocks = watch != nullptr ? &watch->clocks() : master_.clocks();
  for (std::size_t i = 0; i < condition_.slaves.size(); ++i) {
    auto& record = condition_.slaves[i];
    record.clock = 0;
    if (clocks == nullptr || i >= clocks->slaves.size() || !clocks->slaves[i].present) continue;
    const auto& clock = clocks->slaves[i];
    record.clock = i == clocks->reference ? kIsReference : kFollowsReference;
    record.clock_delay_ns = clock.delay;
    record.sync0_cycle_ns = clock.signals.sync0() ? clock.signals.sync0_cycle.count() : 0;
    if (watch != nullptr) record.clock_difference_ns = watch->differences(i).max().count();
  }
}

}  // namespace driveline::runtime
