#include "driveline/ecat_master/coe/emergency_log.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "driveline/motion/cia402/error_code.hpp"

namespace driveline::ecat_master {

std::string describe(const EmergencyRecord& record) {
  auto text = fmt::format("{:.3f} s slave {}: emergency {}, error register 0x{:02X},",
                          std::chrono::duration<double>(record.time).count(), record.slave,
                          motion::cia402::error_text(record.message.error_code), record.message.error_register);
  for (const auto byte : record.message.data) text += fmt::format(" {:02X}", std::to_integer<unsigned>(byte));
  return text;
}

void EmergencyLog::receive(SlaveRef slave, std::span<const std::byte> service, std::chrono::nanoseconds now) {
  const auto coe = wire::CoeHeader::decode(service);
  if (!coe || coe->service != wire::CoeService::kEmergency) return;
  const auto emergency = wire::Emergency::decode(service.subspan(wire::CoeHeader::kSize));
  if (emergency) add({slave.position, now, *emergency});
}

void EmergencyLog::add(const EmergencyRecord& record) {
  const std::scoped_lock lock(mutex_);
  auto& slave = slaves_[record.slave];
  if (slave.records.size() == kMaxPerSlave) {
    slave.records.pop_front();
    ++slave.dropped;
  }
  slave.records.push_back(record);
}

std::vector<EmergencyRecord> EmergencyLog::take(std::uint16_t slave) {
  const std::scoped_lock lock(mutex_);
  const auto found = slaves_.find(slave);
  if (found == slaves_.end()) return {};
  std::vector<EmergencyRecord> records(found->second.records.begin(), found->second.records.end());
  found->second.records.clear();
  return records;
}

std::vector<EmergencyRecord> EmergencyLog::all() const {
  const std::scoped_lock lock(mutex_);
  std::vector<EmergencyRecord> records;
  for (const auto& [position, slave] : slaves_) {
    records.insert(records.end(), slave.records.begin(), slave.records.end());
  }
  std::stable_sort(records.begin(), records.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return records;
}

std::uint64_t EmergencyLog::dropped(std::uint16_t slave) const {
  const std::scoped_lock lock(mutex_);
  const auto found = slaves_.find(slave);
  return found == slaves_.end() ? 0 : found->second.dropped;
}

}  // namespace driveline::ecat_master
