#include "eoe/ethernet_tunnel.hpp"

#include <poll.h>
#include <sys/prctl.h>

#include <algorithm>
#include <utility>

#include "driveline/ecat_master/eoe/eoe_ports.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;

/// Port of the switch for the TAP interface.
constexpr std::size_t kTapPort = 0;
/// Most frames taken from the TAP interface before the frames of the slaves are served.
constexpr int kFramesPerTurn = 32;
/// Pauses between two polls of the mailboxes: during traffic, and after kTrafficEnds without traffic.
constexpr nanoseconds kBusyTunnelPause = std::chrono::microseconds{100};
constexpr nanoseconds kIdleTunnelPause = std::chrono::milliseconds{1};
constexpr nanoseconds kTrafficEnds = std::chrono::milliseconds{200};

}  // namespace

EthernetTunnel::EthernetTunnel(ecat_master::Master& master, std::unique_ptr<TapDevice> tap, const IpNetwork& network,
                               std::vector<EoeHost> hosts)
    : master_(master), tap_(std::move(tap)), network_(network) {
  switch_.set_link(switch_.connect(tap_->name(), *tap_), true);
  for (auto& host : hosts) {
    auto slave = std::make_unique<Slave>();
    slave->host = std::move(host);
    slave->number = switch_.connect(slave->host.name, *slave);
    slaves_.push_back(std::move(slave));
  }
}

Result<std::unique_ptr<EthernetTunnel>> EthernetTunnel::start(ecat_master::Master& master,
                                                              std::unique_ptr<TapDevice> tap, const IpNetwork& network,
                                                              std::vector<EoeHost> hosts) {
  std::unique_ptr<EthernetTunnel> tunnel(new EthernetTunnel(master, std::move(tap), network, std::move(hosts)));
  // Frames may arrive as soon as a port is open; all ports of the switch exist by then.
  for (auto& slave : tunnel->slaves_) {
    auto port = master.open_eoe(slave->host.position, *tunnel);
    if (!port) return fail_line(port.error());
    slave->port = std::move(*port);
  }
  tunnel->thread_ = std::jthread([self = tunnel.get()](const std::stop_token& stop) { self->run(stop); });
  return tunnel;
}

EthernetTunnel::~EthernetTunnel() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  for (const auto& slave : slaves_) {
    if (slave->port) master_.eoe().close(slave->host.position);
  }
}

void EthernetTunnel::receive(std::uint16_t position, std::span<const std::byte> frame) {
  const auto from = std::find_if(slaves_.begin(), slaves_.end(),
                                 [position](const auto& slave) { return slave->host.position == position; });
  if (from == slaves_.end()) return;
  last_frame_.store(now().count(), std::memory_order_relaxed);
  switch_.receive((*from)->number, frame, now());
}

void EthernetTunnel::run(const std::stop_token& stop) {
  // By default, Linux extends short sleeps of ordinary threads by 50 us.
  ::prctl(PR_SET_TIMERSLACK, 1000UL);
  while (!stop.stop_requested()) {
    for (auto& slave : slaves_) supervise(*slave);
    const bool from_tap = take_from_tap();
    const bool from_slaves = master_.mailboxes().step();
    if (!from_tap && !from_slaves) rest();
  }
}

/// Sets the IP parameters of a slave when they are due, and then sets its link up.
void EthernetTunnel::supervise(Slave& slave) {
  const bool up = slave.port->up();
  if (!slave.being_given && up && slave.schedule.due(slave.port->openings(), now())) {
    switch_.set_link(slave.number, false);
    slave.being_given = ecat_master::EoeService::set_ip(slave.host.parameters);
    master_.mailboxes().submit(slave.host.position, slave.being_given);
  }
  if (!up) switch_.set_link(slave.number, false);
  if (!slave.being_given || !slave.being_given->done()) return;
  const auto service = std::exchange(slave.being_given, nullptr);
  if (up) take_result(slave, service->result());
}

/// Only the first of several equal failures is reported.
void EthernetTunnel::take_result(Slave& slave, const ecat_master::Result<void>& result) {
  if (result) {
    switch_.set_link(slave.number, true);
    return;
  }
  const bool refused = result.error().is<ecat_master::facts::EoeRefused>();
  if (!refused && !slave.schedule.no_answer(now())) return;
  const std::scoped_lock lock(mutex_);
  refusals_.push_back({slave.host, result.error()});
}

bool EthernetTunnel::take_from_tap() {
  for (int i = 0; i < kFramesPerTurn; ++i) {
    const auto frame = tap_->receive();
    if (!frame) return i > 0;
    last_frame_.store(now().count(), std::memory_order_relaxed);
    switch_.receive(kTapPort, *frame, now());
  }
  return true;
}

void EthernetTunnel::rest() {
  const bool idle = now().count() - last_frame_.load(std::memory_order_relaxed) > kTrafficEnds.count();
  const timespec pause{0, static_cast<long>((idle ? kIdleTunnelPause : kBusyTunnelPause).count())};
  pollfd tap{tap_->descriptor(), POLLIN, 0};
  if (::ppoll(&tap, 1, &pause, nullptr) <= 0 || (tap.revents & POLLERR) == 0) return;
  // The interface has been deleted: from now on its descriptor would end every wait at once.
  switch_.set_link(kTapPort, false);
  ::ppoll(nullptr, 0, &pause, nullptr);
}

std::vector<EthernetTunnel::Refusal> EthernetTunnel::take_refusals() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(refusals_, {});
}

EoeReport EthernetTunnel::report() const {
  EoeReport report{network_, {}};
  auto figures = switch_.figures();
  report.ports.push_back({std::move(figures[kTapPort]), std::nullopt, network_.address, std::nullopt});
  for (const auto& slave : slaves_) {
    report.ports.push_back({std::move(figures[slave->number]), slave->host.position, *slave->host.parameters.ip,
                            slave->port->statistics()});
  }
  return report;
}

}  // namespace driveline::runtime
