#include "driveline/ecat_master/diagnosis/diagnosis.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace driveline::ecat_master {
namespace {

/// Error counters 0x0300 .. 0x0313 in one read.
constexpr std::size_t kCounterBytes = 20;
/// AL status 0x0130 .. AL status code 0x0135.
constexpr std::size_t kAlBytes = 6;

struct Answers {
  std::array<std::byte, kCounterBytes> counters{};
  std::array<std::byte, 2> dl_status{};
  std::array<std::byte, kAlBytes> al{};
};

void decode(const Answers& answers, SlaveDiagnosis& slave) {
  const std::span<const std::byte> al = answers.al;
  slave.al.status = wire::AlStatus::from_raw(bytes::load_le<std::uint16_t>(al));
  slave.al.code = static_cast<wire::AlStatusCode>(bytes::load_le<std::uint16_t>(al.subspan(4)));
  const auto links = wire::DlStatus::from_raw(bytes::load_le<std::uint16_t>(answers.dl_status));
  const auto counter = [&answers](std::size_t address) {
    return std::to_integer<std::uint8_t>(answers.counters[address - wire::reg::kRxErrorCounter.address]);
  };
  for (unsigned port = 0; port < kSlavePorts; ++port) {
    slave.ports[port] = {links.ports[port], counter(wire::reg::kRxErrorCounter.at(port)),
                         counter(wire::reg::kRxErrorCounter.at(port) + 1U),
                         counter(wire::reg::kForwardedErrorCounter.at(port)),
                         counter(wire::reg::kLostLinkCounter.at(port))};
  }
  slave.processing_unit_errors = counter(wire::reg::kProcessingUnitErrorCounter.address);
  slave.pdi_errors = counter(wire::reg::kPdiErrorCounter.address);
}

/// The other end of the cable at a port.
struct FarEnd {
  bool cable = false;
  bool master = false;
  std::uint16_t slave = 0;
  std::uint8_t port = 0;
};

FarEnd far_end(const Topology& topology, std::uint16_t slave, unsigned port) {
  FarEnd end;
  if (slave >= topology.slaves.size()) return end;
  const auto& node = topology.slaves[slave];
  const bool ring = topology.ring_end && topology.ring_end->slave == slave && topology.ring_end->port == port;
  if (ring) return {true, true, 0, 0};
  if (port == node.entry_port) {
    if (!node.parent) return {true, true, 0, 0};
    return {true, false, node.parent->slave, node.parent->port};
  }
  if (const auto child = node.children[port]; child && *child < topology.slaves.size()) {
    return {true, false, *child, topology.slaves[*child].entry_port};
  }
  return end;
}

/// Collects the faults of the slaves; a fault on a cable is reported by the end that has more information.
class Locator {
 public:
  Locator(std::span<const SlaveDiagnosis> slaves, const Topology& topology) : slaves_(slaves), topology_(topology) {}

  std::vector<FaultPlace> run() {
    const auto count = static_cast<std::uint16_t>(slaves_.size());
    for (std::uint16_t i = 0; i < count; ++i) {
      if (!slaves_[i].answers) {
        if (!slaves_[i].optional) unreachable(i);
        continue;
      }
      for (std::uint8_t port = 0; port < kSlavePorts; ++port) inspect_port(i, port);
      if (slaves_[i].processing_unit_errors > 0) {
        add(FaultPlace::Kind::kBadFrames, i, 0, {}, slaves_[i].processing_unit_errors);
      }
      if (slaves_[i].pdi_errors > 0) add(FaultPlace::Kind::kPdi, i, 0, {}, slaves_[i].pdi_errors);
    }
    return std::move(places_);
  }

 private:
  void add(FaultPlace::Kind kind, std::uint16_t slave, std::uint8_t port, const FarEnd& end, std::uint32_t count) {
    places_.push_back({kind, slave, port, end.cable && !end.master ? std::optional(end.slave) : std::nullopt, count});
  }

  void inspect_port(std::uint16_t slave, std::uint8_t port) {
    const auto& facts = slaves_[slave].ports[port];
    const auto end = far_end(topology_, slave, port);
    const auto damaged = std::max(facts.invalid_frames, facts.receive_errors);
    if (damaged > 0) add(FaultPlace::Kind::kDamagedFrames, slave, port, end, damaged);
    // Both ends count a lost link; the end nearer to the master reports it, unless only the other end counted it.
    const bool other_tells = end.cable && !end.master && end.slave < slave && slaves_[end.slave].answers &&
                             slaves_[end.slave].ports[end.port].lost_links > 0;
    if (facts.lost_links > 0 && !other_tells) add(FaultPlace::Kind::kLostLink, slave, port, end, facts.lost_links);
    const bool reported_behind = end.cable && !end.master && (!slaves_[end.slave].answers || end.slave < slave);
    if (end.cable && !facts.status.link && !reported_behind) add(FaultPlace::Kind::kNoLink, slave, port, end, 0);
  }

  /// Reports only the first unreachable slave: the others are behind it.
  void unreachable(std::uint16_t slave) {
    if (slave >= topology_.slaves.size()) return add(FaultPlace::Kind::kNoAnswer, slave, 0, {}, 0);
    const auto& node = topology_.slaves[slave];
    if (!node.parent) return add(FaultPlace::Kind::kNoAnswer, slave, node.entry_port, {}, 0);
    const auto& parent = slaves_[node.parent->slave];
    if (!parent.answers) return;
    const bool link = parent.ports[node.parent->port].status.link;
    const FarEnd end{true, false, slave, node.entry_port};
    if (!link) return add(FaultPlace::Kind::kNoLink, node.parent->slave, node.parent->port, end, 0);
    add(FaultPlace::Kind::kNoAnswer, slave, node.entry_port, {true, false, node.parent->slave, node.parent->port}, 0);
  }

  std::span<const SlaveDiagnosis> slaves_;
  const Topology& topology_;
  std::vector<FaultPlace> places_;
};

/// What deviates from the standard at the mailbox of a slave, as sentences.
void add_mailbox_habits(std::uint16_t slave, const MailboxStatistics& statistics, std::vector<std::string>& problems) {
  const auto add = [&](std::uint64_t count, std::string_view what) {
    if (count != 0) problems.push_back(fmt::format("slave {}: {} ({})", slave, what, count));
  };
  add(statistics.resent, "mailbox requests were sent again because no answer came");
  add(statistics.same_counter, "mailbox answers have the counter of the previous message");
}

}  // namespace

Result<std::vector<SlaveDiagnosis>> read_slave_diagnosis(Bus& bus, std::span<const ConfiguredSlave> slaves) {
  std::vector<Answers> answers(slaves.size());
  std::vector<Request> requests;
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    const auto ask = [&](std::uint16_t address, std::span<std::byte> data) {
      const auto station = slaves[i].info.ref.station;
      requests.push_back({wire::Command::kFprd, wire::DatagramAddress::physical(station, address), data});
    };
    ask(wire::reg::kRxErrorCounter.address, answers[i].counters);
    ask(wire::reg::kDlStatus.address, answers[i].dl_status);
    ask(wire::reg::kAlStatus.address, answers[i].al);
  }
  if (auto done = bus.exchange().exchange(requests); !done) return tl::unexpected(done.error());
  std::vector<SlaveDiagnosis> found(slaves.size());
  for (std::size_t i = 0; i < slaves.size(); ++i) {
    found[i].name = slaves[i].plan.name;
    found[i].ref = slaves[i].info.ref;
    found[i].optional = slaves[i].plan.hot_connect;
    const auto own = std::span(requests).subspan(3 * i, 3);
    found[i].answers = std::all_of(own.begin(), own.end(), [](const Request& r) { return r.working_counter == 1; });
    if (found[i].answers) decode(answers[i], found[i]);
  }
  return found;
}

Result<void> clear_error_counters(Bus& bus) {
  const std::array<std::byte, kCounterBytes> zeros{};
  return bus.broadcast_write(wire::reg::kRxErrorCounter.address, zeros).map([](auto) {});
}

std::vector<FaultPlace> locate_faults(std::span<const SlaveDiagnosis> slaves, const Topology& topology) {
  return Locator(slaves, topology).run();
}

Result<LineDiagnosis> diagnose(Master& master, const LineSupervisor* supervisor, const port::RedundantPort* ring) {
  LineDiagnosis diagnosis;
  auto slaves = read_slave_diagnosis(master.bus(), master.slaves());
  if (!slaves) return tl::unexpected(slaves.error());
  diagnosis.slaves = std::move(*slaves);
  diagnosis.places = locate_faults(diagnosis.slaves, master.topology());
  std::vector<SlaveInfo> infos;
  for (const auto& slave : master.slaves()) {
    if (slave.present) infos.push_back(slave.info);
  }
  diagnosis.problems = describe_problems(infos);
  for (const auto& info : infos) {
    const auto position = info.ref.position;
    add_mailbox_habits(position, master.mailboxes().statistics(position), diagnosis.problems);
  }
  diagnosis.time = master.bus().exchange().now();
  if (auto* core = master.core()) {
    std::vector<std::uint32_t> expected(core->groups().size());
    for (const auto& datagram : master.image().datagrams()) {
      expected[datagram.group] += datagram.expected_working_counter;
    }
    for (std::size_t i = 0; i < core->groups().size(); ++i) {
      const auto& group = core->groups()[i];
      diagnosis.groups.push_back({group.exchanges.value(), group.lost_frames.value(), group.wkc_errors.value(),
                                  group.bad_cycles.load(), group.longest_bad.load(), group.working_counter.load(),
                                  expected[i], group.outputs_zeroed.load()});
    }
    diagnosis.cycles = core->cycles();
    diagnosis.stale_frames = core->stale_frames();
    diagnosis.foreign_frames = core->foreign_frames();
    if (!master.cycling()) diagnosis.statistics = core->statistics();
  }
  if (ring != nullptr) diagnosis.ring = ring->status();
  if (supervisor != nullptr) {
    if (supervisor->guard().looks > 0) diagnosis.guard = supervisor->guard();
    diagnosis.events.assign(supervisor->history().begin(), supervisor->history().end());
    diagnosis.exchange_history.assign(supervisor->exchange_history().begin(), supervisor->exchange_history().end());
    diagnosis.state_history.assign(supervisor->state_history().begin(), supervisor->state_history().end());
  }
  diagnosis.emergencies = master.emergencies().all();
  return diagnosis;
}

}  // namespace driveline::ecat_master
