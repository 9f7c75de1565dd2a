#include "driveline/ecat_master/eoe/eoe_ports.hpp"

#include <utility>

namespace driveline::ecat_master {

// Never call the engine with mutex_ held: it calls receive() while holding its own mutex.

std::shared_ptr<EoePort> EoePorts::open(std::uint16_t position, EoeReceiver& receiver) {
  engine_.handle(wire::MailboxType::kEoe, *this);
  auto port = std::make_shared<EoePort>(position, receiver);
  {
    const std::scoped_lock lock(mutex_);
    ports_[position] = port;
  }
  engine_.open_stream(position, port);
  return port;
}

void EoePorts::close(std::uint16_t position) {
  engine_.close_stream(position);
  const std::scoped_lock lock(mutex_);
  ports_.erase(position);
}

std::shared_ptr<EoePort> EoePorts::port(std::uint16_t position) const {
  const std::scoped_lock lock(mutex_);
  const auto found = ports_.find(position);
  return found == ports_.end() ? nullptr : found->second;
}

void EoePorts::receive(SlaveRef slave, std::span<const std::byte> service, std::chrono::nanoseconds /*now*/) {
  if (const auto target = port(slave.position)) target->receive(service);
}

}  // namespace driveline::ecat_master
