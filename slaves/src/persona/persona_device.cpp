#include "persona/persona_device.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "driveline/slaves/bit_copy.hpp"
#include "driveline/wire/registers.hpp"
#include "persona/eeprom_edit.hpp"

namespace driveline::slaves {
namespace {

using std::chrono::nanoseconds;
using wire::AlState;
using wire::AlStatusCode;
using Kind = PersonaKind;

constexpr std::uint16_t kStatusword = 0x6041;
constexpr std::uint16_t kModeDisplay = 0x6061;
constexpr std::uint64_t kWarning = 1U << 7U;
constexpr std::uint64_t kFollows = 1U << 12U;

DeviceProfile changed_profile(const Device& device, std::span<const Persona> personas) {
  auto profile = device.profile();
  edit_eeprom(personas, profile.sii_image);
  if (has_persona(personas, Kind::kClock32Bit)) profile.distributed_clock_64bit = false;
  if (has_persona(personas, Kind::kNoClock)) profile.distributed_clock = false;
  if (has_persona(personas, Kind::kNoLrw)) profile.logical_read_write = false;
  profile.fmmu_count = static_cast<std::uint8_t>(persona_value(personas, Kind::kFewFmmus, profile.fmmu_count));
  return profile;
}

}  // namespace

PersonaDevice::PersonaDevice(std::unique_ptr<Device> device, std::span<const Persona> personas)
    : device_(std::move(device)),
      personas_(personas.begin(), personas.end()),
      profile_(changed_profile(*device_, personas)),
      mailbox_(personas) {}

void PersonaDevice::restart() {
  safeop_refused_ = false;
  device_->restart();
}

/// Bit 0 of 0500h: the EEPROM belongs to the process data interface (ETG.1000.4 Table 48).
bool PersonaDevice::owns_eeprom() noexcept {
  std::array<std::byte, 1> owner{};
  return esc_ != nullptr && esc_->pdi_read(wire::reg::kSiiConfiguration.address, owner, now_) &&
         (owner[0] & std::byte{1}) != std::byte{0};
}

AlStatusCode PersonaDevice::transition(AlState from, AlState to) noexcept {
  const bool mailbox_starts = from == AlState::kInit && to == AlState::kPreOp;
  if (mailbox_starts && has_persona(personas_, Kind::kEepromForApplication) && !owns_eeprom()) {
    return AlStatusCode::kEepromNoAccess;
  }
  const auto* refusal = find_persona(personas_, Kind::kSafeOpRefusedOnce);
  if (from == AlState::kPreOp && to == AlState::kSafeOp && refusal != nullptr && !safeop_refused_) {
    safeop_refused_ = true;
    return static_cast<AlStatusCode>(refusal->value);
  }
  const auto code = device_->transition(from, to);
  if (mailbox_starts && code == AlStatusCode::kNoError) mailbox_.start(now_);
  return code;
}

SyncDemand PersonaDevice::sync_demand() const noexcept {
  auto demand = device_->sync_demand();
  if (has_persona(personas_, Kind::kNeedsSync0)) demand.type = SyncType::kSync0;
  return demand;
}

void PersonaDevice::set_statusword(std::size_t sync_manager, std::span<std::byte> data) const noexcept {
  const auto bits = (has_persona(personas_, Kind::kWarningBit) ? kWarning : 0U) |
                    (has_persona(personas_, Kind::kFollowBitAlways) ? kFollows : 0U);
  if (bits == 0) return;
  const auto place = device_->mapped_input(kStatusword, 0);
  if (!place || place->sync_manager != sync_manager || place->bit_offset + place->bits > 8 * data.size()) return;
  store_bits(data, place->bit_offset, place->bits, load_bits(data, place->bit_offset, place->bits) | bits);
}

void PersonaDevice::delay_mode(std::size_t sync_manager, std::span<std::byte> data) noexcept {
  const auto* late = find_persona(personas_, Kind::kLateModeDisplay);
  if (late == nullptr) return;
  const auto place = device_->mapped_input(kModeDisplay, 0);
  if (!place || place->sync_manager != sync_manager || place->bit_offset + place->bits > 8 * data.size()) return;
  const auto mode = load_bits(data, place->bit_offset, place->bits);
  if (mode != mode_) mode_since_ = now_;
  mode_ = mode;
  if (now_ - mode_since_ >= std::chrono::milliseconds{late->value}) mode_shown_ = mode;
  store_bits(data, place->bit_offset, place->bits, mode_shown_);
}

void PersonaDevice::read_inputs(std::size_t sync_manager, std::span<std::byte> data) noexcept {
  device_->read_inputs(sync_manager, data);
  set_statusword(sync_manager, data);
  delay_mode(sync_manager, data);
}

void PersonaDevice::mailbox_request(std::span<const std::byte> mailbox) {
  const auto passed_on = mailbox_.request(mailbox, now_);
  if (!passed_on.empty()) device_->mailbox_request(passed_on);
}

std::size_t PersonaDevice::mailbox_reply(std::span<std::byte> out) {
  if (!mailbox_.may_send(now_)) return 0;
  auto length = mailbox_.own_message(out);
  if (length == 0) length = device_->mailbox_reply(out);
  if (length != 0) mailbox_.rewrite(out.first(std::min(length, out.size())));
  return length;
}

void PersonaDevice::advance(nanoseconds now) noexcept {
  now_ = now;
  device_->advance(now);
}

}  // namespace driveline::slaves
