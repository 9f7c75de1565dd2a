#include "driveline/runtime/eoe/ethernet_switch.hpp"

#include <algorithm>

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;
using wire::MacAddress;

constexpr std::size_t kVlanTag = 4;
constexpr std::uint16_t kVlanType = 0x8100;
/// Interval of the search for old addresses.
constexpr nanoseconds kAgeingStep = std::chrono::seconds{1};

MacAddress mac_at(std::span<const std::byte> frame, std::size_t place) {
  MacAddress mac{};
  std::copy_n(frame.begin() + static_cast<std::ptrdiff_t>(place), mac.size(), mac.begin());
  return mac;
}

bool is_group(const MacAddress& mac) {
  return (mac[0] & std::byte{1}) != std::byte{0};
}

/// Whether the address is 01-80-C2-00-00-00 to -0F: for the next bridge only (IEEE 802.1D Table 7-10).
bool is_link_local(const MacAddress& mac) {
  constexpr MacAddress kFirst = {std::byte{0x01}, std::byte{0x80}, std::byte{0xC2}};
  return std::equal(mac.begin(), mac.end() - 1, kFirst.begin()) && (mac[5] & std::byte{0xF0}) == std::byte{0};
}

}  // namespace

std::size_t EthernetSwitch::connect(std::string name, SwitchedDevice& device) {
  const std::scoped_lock lock(mutex_);
  Port port;
  port.device = &device;
  port.figures.name = std::move(name);
  port.flood_credit = settings_.flood_burst;
  ports_.push_back(std::move(port));
  return ports_.size() - 1;
}

void EthernetSwitch::set_link(std::size_t port, bool up) {
  const std::scoped_lock lock(mutex_);
  ports_[port].figures.link = up;
  if (!up) std::erase_if(stations_, [port](const auto& station) { return station.second.port == port; });
}

bool EthernetSwitch::acceptable(std::span<const std::byte> frame) const noexcept {
  if (frame.size() < wire::EthernetHeader::kSize) return false;
  const bool tagged = bytes::load_be16(frame.subspan(2 * sizeof(MacAddress), 2)) == kVlanType;
  if (frame.size() > wire::EthernetHeader::kSize + settings_.mtu + (tagged ? kVlanTag : 0)) return false;
  return !is_group(mac_at(frame, 6)) && !is_link_local(mac_at(frame, 0));
}

void EthernetSwitch::receive(std::size_t from, std::span<const std::byte> frame, nanoseconds now) {
  const std::scoped_lock lock(mutex_);
  auto& port = ports_[from];
  if (!port.figures.link) return;
  if (!acceptable(frame)) {
    ++port.figures.refused;
    return;
  }
  ++port.figures.received;
  port.figures.bytes_in += frame.size();
  forget_old(now);
  learn(mac_at(frame, 6), from, now);
  const auto destination = mac_at(frame, 0);
  const auto station = is_group(destination) ? stations_.end() : stations_.find(destination);
  if (station == stations_.end()) {
    flood(from, frame, now);
  } else if (station->second.port != from) {
    forward(ports_[station->second.port], frame);
  }
}

void EthernetSwitch::learn(const MacAddress& source, std::size_t port, nanoseconds now) {
  const auto known = stations_.find(source);
  if (known != stations_.end()) {
    known->second = {port, now};
  } else if (stations_.size() < settings_.addresses) {
    stations_.emplace(source, Station{port, now});
  }
}

void EthernetSwitch::forget_old(nanoseconds now) {
  if (now < next_ageing_) return;
  next_ageing_ = now + kAgeingStep;
  std::erase_if(stations_, [&](const auto& station) { return now - station.second.seen >= settings_.ageing; });
}

/// Sends a frame to all ports. A token bucket for each port limits a broadcast storm of a device to flood_rate.
void EthernetSwitch::flood(std::size_t from, std::span<const std::byte> frame, nanoseconds now) {
  auto& source = ports_[from];
  const auto elapsed = std::chrono::duration<double>(now - source.credit_at).count();
  source.flood_credit = std::min(settings_.flood_burst, source.flood_credit + elapsed * settings_.flood_rate);
  source.credit_at = now;
  if (source.flood_credit < 1.0) {
    ++source.figures.flood_limit;
    return;
  }
  source.flood_credit -= 1.0;
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    if (i != from && ports_[i].figures.link) forward(ports_[i], frame);
  }
}

void EthernetSwitch::forward(Port& port, std::span<const std::byte> frame) {
  if (!port.device->send(frame)) {
    ++port.figures.full;
    return;
  }
  ++port.figures.sent;
  port.figures.bytes_out += frame.size();
}

std::vector<SwitchPortFigures> EthernetSwitch::figures() const {
  const std::scoped_lock lock(mutex_);
  std::vector<SwitchPortFigures> all;
  for (const auto& port : ports_) all.push_back(port.figures);
  for (const auto& [mac, station] : stations_) all[station.port].addresses.push_back(mac);
  return all;
}

}  // namespace driveline::runtime
