#include "driveline/slaves/line/wiring.hpp"

namespace driveline::slaves {

Wiring Wiring::line(std::size_t slave_count, std::chrono::nanoseconds cable_delay) {
  Wiring wiring(slave_count);
  if (slave_count > 0) wiring.connect_master(MasterPort::kPrimary, {0, 0}, cable_delay);
  for (std::size_t i = 1; i < slave_count; ++i) wiring.connect({i - 1, 1}, {i, 0}, cable_delay);
  return wiring;
}

Wiring Wiring::ring(std::size_t slave_count, std::chrono::nanoseconds cable_delay) {
  Wiring wiring = line(slave_count, cable_delay);
  if (slave_count > 0) wiring.connect_master(MasterPort::kSecondary, {slave_count - 1, 1}, cable_delay);
  return wiring;
}

bool Wiring::free(PortId port) const noexcept {
  return port.slave < ends_.size() && port.port < kPortCount && at(port).kind == End::Kind::kNothing;
}

bool Wiring::connect(PortId a, PortId b, std::chrono::nanoseconds delay) {
  if (!free(a) || !free(b) || a == b) return false;
  ends_[a.slave][a.port] = {End::Kind::kSlave, b, {}, delay};
  ends_[b.slave][b.port] = {End::Kind::kSlave, a, {}, delay};
  return true;
}

bool Wiring::connect_master(MasterPort master, PortId slave, std::chrono::nanoseconds delay) {
  auto& place = masters_[static_cast<std::size_t>(master)];
  if (place || !free(slave)) return false;
  place = slave;
  ends_[slave.slave][slave.port] = {End::Kind::kMaster, {}, master, delay};
  return true;
}

bool Wiring::set_delay(PortId port, std::chrono::nanoseconds delay) noexcept {
  if (port.slave >= ends_.size() || port.port >= kPortCount) return false;
  auto& end = ends_[port.slave][port.port];
  if (end.kind == End::Kind::kNothing) return false;
  end.delay = delay;
  if (end.kind == End::Kind::kSlave) ends_[end.slave.slave][end.slave.port].delay = delay;
  return true;
}

bool Wiring::break_cable(PortId port, bool broken) noexcept {
  if (port.slave >= ends_.size() || port.port >= kPortCount) return false;
  auto& end = ends_[port.slave][port.port];
  if (end.kind == End::Kind::kNothing) return false;
  end.broken = broken;
  if (end.kind == End::Kind::kSlave) ends_[end.slave.slave][end.slave.port].broken = broken;
  return true;
}

}  // namespace driveline::slaves
