#include "driveline/ecat_master/soe/soe_log.hpp"

#include <fmt/format.h>

#include <optional>
#include <string_view>

namespace driveline::ecat_master {
namespace {

using wire::SoeHeader;
using wire::SoeOpCode;

std::string message_text(const SoeNotification& notification) {
  const auto idn = notification.idn.text();
  return fmt::format("data state of {} is 0x{:04X} ({})", std::string_view(idn.data(), idn.size()),
                     static_cast<std::uint16_t>(notification.state), wire::to_text(notification.state));
}

std::string message_text(const wire::Emergency& emergency) {
  auto text =
      fmt::format("emergency 0x{:04X}, error register 0x{:02X},", emergency.error_code, emergency.error_register);
  for (const auto byte : emergency.data) text += fmt::format(" {:02X}", std::to_integer<unsigned>(byte));
  return text;
}

std::optional<std::variant<SoeNotification, wire::Emergency>> message_of(const SoeHeader& header,
                                                                         std::span<const std::byte> data) {
  if (header.op_code == SoeOpCode::kNotification && data.size() >= sizeof(std::uint16_t)) {
    return SoeNotification{header.idn(), static_cast<wire::SoeCommandState>(bytes::load_le<std::uint16_t>(data))};
  }
  if (header.op_code != SoeOpCode::kEmergency) return std::nullopt;
  const auto emergency = wire::Emergency::decode(data);
  if (!emergency) return std::nullopt;
  return *emergency;
}

}  // namespace

std::string describe_message(const SoeRecord& record) {
  return fmt::format("drive {}: {}", record.drive,
                     std::visit([](const auto& message) { return message_text(message); }, record.message));
}

std::string describe(const SoeRecord& record) {
  return fmt::format("{:.3f} s slave {} {}", std::chrono::duration<double>(record.time).count(), record.slave,
                     describe_message(record));
}

void SoeLog::receive(SlaveRef slave, std::span<const std::byte> service, std::chrono::nanoseconds now) {
  const auto header = SoeHeader::decode(service);
  if (!header) return;
  auto message = message_of(*header, service.subspan(SoeHeader::kSize));
  if (!message) return;
  const std::scoped_lock lock(mutex_);
  if (records_.size() == kMaxRecords) {
    records_.pop_front();
    ++dropped_;
  }
  records_.push_back({slave.position, header->drive, now, *message});
}

bool SoeLog::is_request(std::span<const std::byte> service) const noexcept {
  const auto header = SoeHeader::decode(service);
  return header && (header->op_code == SoeOpCode::kReadRequest || header->op_code == SoeOpCode::kWriteRequest);
}

std::vector<SoeRecord> SoeLog::take() {
  const std::scoped_lock lock(mutex_);
  std::vector<SoeRecord> records(records_.begin(), records_.end());
  records_.clear();
  return records;
}

std::uint64_t SoeLog::dropped() const {
  const std::scoped_lock lock(mutex_);
  return dropped_;
}

}  // namespace driveline::ecat_master
