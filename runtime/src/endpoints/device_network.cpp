#include "endpoints/device_network.hpp"

#include <algorithm>

namespace driveline::runtime {

bool DeviceNetwork::send(std::span<const std::byte> frame) noexcept {
  if (frame.size() > sent_.bytes.size()) return false;
  sent_.length = frame.size();
  std::copy(frame.begin(), frame.end(), sent_.bytes.begin());
  return to_network_.try_push(sent_);
}

std::size_t DeviceNetwork::receive(std::span<std::byte> out) noexcept {
  if (status_wanted_.load(std::memory_order_relaxed)) tell_status();
  if (!to_master_.try_pop(received_) || received_.length > out.size()) return 0;
  std::copy_n(received_.bytes.begin(), received_.length, out.begin());
  return received_.length;
}

void DeviceNetwork::set_address(const wire::EoeIpParameters& address) noexcept {
  slaves::EndpointAddress told;
  told.mac = address.mac.value_or(wire::MacAddress{});
  told.ip = address.ip.value_or(wire::IpV4Address{});
  told.subnet_mask = address.subnet_mask.value_or(wire::IpV4Address{});
  told.gateway = address.gateway.value_or(wire::IpV4Address{});
  addresses_.write(told);
}

/// Discards the frames to the master when the link goes down. Must run on their consumer's thread, which calls
/// receive().
void DeviceNetwork::set_link(bool up) noexcept {
  while (!up && to_master_.try_pop(received_)) continue;
  up_.store(up, std::memory_order_relaxed);
}

void DeviceNetwork::tell_status() noexcept {
  device_->show(status_);
  if (statuses_.try_push(status_)) status_wanted_.store(false, std::memory_order_relaxed);
}

}  // namespace driveline::runtime
