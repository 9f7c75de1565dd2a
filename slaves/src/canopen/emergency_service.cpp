#include "driveline/slaves/canopen/emergency_service.hpp"

#include <algorithm>

namespace driveline::slaves::cia301 {

EmergencyService::EmergencyService(ObjectDictionary& dictionary, Outbox& outbox)
    : outbox_(&outbox),
      register_(dictionary, 0x1001, 0),
      history_count_(dictionary, 0x1003, 0),
      cob_id_(dictionary, 0x1014, 0),
      inhibit_time_(dictionary, 0x1015, 0) {
  for (const EntryRow& row : dictionary.table().object(0x1003)) {
    if (row.subindex != 0) history_.emplace_back(dictionary, row.index, row.subindex);
  }
  errors_.reserve(kErrors);
  waiting_.reserve(kWaiting);
}

void EmergencyService::forget(std::uint8_t first, std::uint8_t last) noexcept {
  waiting_.clear();
  free_at_ = nanoseconds{0};
  std::erase_if(errors_, [&](const Error& error) { return error.source >= first && error.source <= last; });
  update_register();
}

void EmergencyService::update_register() noexcept {
  unsigned bits = errors_.empty() ? 0U : canopen::error_register::kGeneric;
  for (const Error& error : errors_) bits |= error.register_bits;
  register_.set(bits);
}

/// Newest at sub-index 1, the others move down (CiA 301 7.5.2.4). The upper half has the first two manufacturer bytes.
void EmergencyService::log(const Emergency& emergency) noexcept {
  for (std::size_t i = history_.size(); i-- > 1;) history_[i].set(history_[i - 1].value());
  if (history_.empty()) return;
  history_.front().set(emergency.code | std::to_integer<std::uint32_t>(emergency.manufacturer[0]) << 16 |
                       std::to_integer<std::uint32_t>(emergency.manufacturer[1]) << 24);
  history_count_.set(std::min<std::uint32_t>(history_count_.value() + 1, static_cast<std::uint32_t>(history_.size())));
}

void EmergencyService::raise(const Emergency& emergency, std::uint8_t source, bool allowed, nanoseconds now) noexcept {
  const bool is_there = std::any_of(errors_.begin(), errors_.end(), [&](const Error& error) {
    return error.code == emergency.code && error.source == source;
  });
  if (is_there || emergency.code == canopen::emergency_code::kNoError) return;
  if (errors_.size() == kErrors) errors_.erase(errors_.begin());  // the oldest one is in the history
  errors_.push_back({emergency.code, source, emergency.error_register});
  update_register();
  log(emergency);
  Emergency message = emergency;
  message.error_register = static_cast<std::uint8_t>(register_.exists() ? register_.value() : emergency.error_register);
  send(message, allowed, now);
}

void EmergencyService::remove(std::uint16_t code, std::uint8_t source, bool allowed, nanoseconds now) noexcept {
  const auto removed =
      std::erase_if(errors_, [&](const Error& error) { return error.code == code && error.source == source; });
  if (removed == 0) return;
  update_register();
  if (errors_.empty()) send({canopen::emergency_code::kNoError, 0, {}}, allowed, now);
}

SdoResult<void> EmergencyService::check(const EntryRow& row, std::uint32_t raw) const noexcept {
  if (history_count_.is(row) && raw != 0) return tl::unexpected(sdo::SdoAbort::kValueRange);
  return cob_id_.is(row) ? check_cob_id(cob_id_.cob_id(), {raw}) : SdoResult<void>{};
}

void EmergencyService::written(const EntryRow& row) noexcept {
  if (!history_count_.is(row)) return;
  for (Entry& entry : history_) entry.set(0);
}

void EmergencyService::send(const Emergency& emergency, bool allowed, nanoseconds now) noexcept {
  if (!cob_id_.exists() || cob_id_.cob_id().invalid()) return;
  if (waiting_.size() == kWaiting) waiting_.erase(waiting_.begin());
  waiting_.push_back(emergency);
  advance(allowed, now);
}

void EmergencyService::advance(bool allowed, nanoseconds now) noexcept {
  while (next_wake(allowed) <= now) {
    outbox_->send(waiting_.front().frame(cob_id_.cob_id().identifier()));
    waiting_.erase(waiting_.begin());
    free_at_ = now + inhibit();
  }
}

nanoseconds EmergencyService::next_wake(bool allowed) const noexcept {
  return allowed && !waiting_.empty() ? free_at_ : kNever;
}

}  // namespace driveline::slaves::cia301
