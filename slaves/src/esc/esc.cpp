#include "driveline/slaves/esc/esc.hpp"

#include <algorithm>
#include <utility>

#include "driveline/slaves/esc/led.hpp"

namespace driveline::slaves {

namespace reg = wire::reg;

namespace {

/// Bits of the features register 0x0008 that depend on the clock unit.
constexpr std::uint16_t kFeatureClock = 0x0004;
constexpr std::uint16_t kFeatureClock64 = 0x0008;
constexpr std::uint16_t kFeatureEnhancedSync = 0x0100;
/// DL control bit 24: the alias counts as a station address.
constexpr std::uint32_t kAliasEnable = 0x01000000;
constexpr std::uint8_t kDeviceEmulation = 0x01;
/// The MII management interface belongs to the PDI: ECAT cannot use it.
constexpr std::uint8_t kMiiOwnedByPdi = 0x01;

}  // namespace

Esc::Esc(const EscOptions& options, std::vector<std::byte> sii_image)
    : options_(options),
      memory_(options.ram_kib),
      events_(memory_),
      watchdog_(memory_, events_),
      sync_managers_(memory_, events_, watchdog_, options.sync_manager_count),
      fmmus_(memory_, options.fmmu_count),
      sii_(memory_, std::move(sii_image), options.sii),
      clock_(memory_, events_, options.distributed_clock, options.distributed_clock_64bit, options.clock) {
  power_on();
}

void Esc::power_on(Nanoseconds now) noexcept {
  memory_.clear();
  load_reset_values();
  reset_requested_ = false;
  loop_control_changed_ = true;
  register_write_enabled_in_ = esc_write_enabled_in_ = kNoFrame;
  reset_ecat_ = reset_pdi_ = {};
  loops_revert_at_ = WatchdogUnit::kNever;
  watchdog_.reset();
  sync_managers_.reset();
  fmmus_.reset();
  clock_.power_on(now);
  sii_.reset();
  events_.refresh();
  refresh_addressing();
  publish_dl_status();
  if (!sii_.loaded()) memory_.set(reg::kErrLedOverride, led::kFlickering);
}

void Esc::load_reset_values() noexcept {
  for (const auto& row : wire::kRegisters) {
    for (unsigned n = 0; n < row.count; ++n) {
      const auto value = bytes::to_le_bytes(row.reset);
      std::copy_n(value.begin(), row.size, memory_.at(row.address + n * row.stride, row.size).begin());
    }
  }
  memory_.set(reg::kFmmuCount, static_cast<std::uint8_t>(fmmus_.count()));
  memory_.set(reg::kSyncManagerCount, static_cast<std::uint8_t>(sync_managers_.count()));
  memory_.set(reg::kRamSize, static_cast<std::uint8_t>((memory_.size() - wire::kProcessRamStart) / 1024));
  unsigned features = memory_.get(reg::kFeatures);
  if (!options_.distributed_clock) features &= ~unsigned{kFeatureClock | kFeatureClock64 | kFeatureEnhancedSync};
  if (!options_.distributed_clock_64bit) features &= ~unsigned{kFeatureClock64};
  memory_.set(reg::kFeatures, static_cast<std::uint16_t>(features));
  memory_.set(reg::kMiiPdiAccess, kMiiOwnedByPdi);
}

void Esc::refresh_addressing() noexcept {
  station_address_ = memory_.get(reg::kStationAddress);
  station_alias_ = memory_.get(reg::kStationAlias);
  alias_enabled_ = (memory_.get(reg::kDlControl) & kAliasEnable) != 0;
}

void Esc::count_malformed_frame() noexcept {
  const auto count = memory_.get(reg::kProcessingUnitErrorCounter);
  memory_.set(reg::kProcessingUnitErrorCounter, static_cast<std::uint8_t>(std::min(count + 1, 0xFF)));
}

void Esc::count_damaged_frame(unsigned port, bool forwarded) noexcept {
  if (forwarded) {
    const auto count = memory_.get(reg::kForwardedErrorCounter, port);
    memory_.set(reg::kForwardedErrorCounter, static_cast<std::uint8_t>(std::min(count + 1, 0xFF)), port);
    return;
  }
  // The invalid frame counter is the low byte; the RX errors of the physical layer are in the high byte.
  const unsigned count = memory_.get(reg::kRxErrorCounter, port);
  const unsigned invalid = std::min((count & 0xFFU) + 1U, 0xFFU);
  memory_.set(reg::kRxErrorCounter, static_cast<std::uint16_t>((count & 0xFF00U) | invalid), port);
}

bool Esc::forwards_foreign_frames() const noexcept {
  return (memory_.get(reg::kDlControl) & 1U) == 0;
}

wire::LoopControl Esc::loop_control(unsigned port) const noexcept {
  return static_cast<wire::LoopControl>(memory_.get(reg::kDlControl) >> (8 + 2 * port) & 3U);
}

bool Esc::take_loop_control_change() noexcept {
  return std::exchange(loop_control_changed_, false);
}

void Esc::set_port(unsigned number, const wire::DlStatus::Port& state) noexcept {
  auto& port = dl_status_.ports[number];
  if (port == state) return;
  const auto loop = loop_control(number);
  const bool watched = loop == wire::LoopControl::kAuto || loop == wire::LoopControl::kAutoClose;
  if (port.link && !state.link && watched) {
    const auto count = memory_.get(reg::kLostLinkCounter, number);
    memory_.set(reg::kLostLinkCounter, static_cast<std::uint8_t>(std::min(count + 1, 0xFF)), number);
  }
  port = state;
  publish_dl_status();
  events_.set_ecat(ecat_event::kDlStatus, true);
}

void Esc::on_time(Nanoseconds now) noexcept {
  if (watchdog_.expiry() <= now) {
    // Only an expiry in OP sets the ERR LED (ESC data sheet I, ERR LED).
    if (al_status().state == wire::AlState::kOp) memory_.set(reg::kErrLedOverride, led::kDoubleFlash);
    watchdog_.expire();
  }
  if (watchdog_.pdi_expiry() <= now) {
    memory_.set(reg::kErrLedOverride, led::kOn);
    watchdog_.expire_pdi();
  }
  if (loops_revert_at_ <= now) {
    loops_revert_at_ = WatchdogUnit::kNever;
    memory_.at(reg::kDlControl.address + 1U, 1)[0] = std::byte{loops_before_};
    loop_control_changed_ = true;
    events_.call_firmware();
  }
}

void Esc::publish_dl_status() noexcept {
  dl_status_.pdi_operational = pdi_operational();
  dl_status_.pdi_watchdog_ok = pdi_operational() && !watchdog_.pdi_expired();
  memory_.set(reg::kDlStatus, dl_status_.raw());
}

std::optional<Esc::AlRequest> Esc::take_al_request() noexcept {
  if (!events_.al_pending(al_event::kAlControl)) return std::nullopt;
  events_.set_al(al_event::kAlControl, false);
  return AlRequest{wire::AlControl::from_raw(memory_.get(reg::kAlControl)), al_control_time_};
}

void Esc::set_al_status(wire::AlStatus status, std::uint16_t code) noexcept {
  const auto before = al_status();
  const bool new_error = status.error && (!before.error || memory_.get(reg::kAlStatusCode) != code);
  if (before.raw() != status.raw()) events_.set_ecat(ecat_event::kAlStatus, true);
  memory_.set(reg::kAlStatus, status.raw());
  memory_.set(reg::kAlStatusCode, code);
  if (before.state != status.state) memory_.set(reg::kRunLedOverride, led::run_code(status.state));
  show_error(status.error && !device_emulation(), new_error);
}

/// A new error ends an override of the ERR LED (ESC data sheet I, ERR LED).
void Esc::show_error(bool error, bool new_error) noexcept {
  const bool overridden = (memory_.get(reg::kErrLedOverride) & led::kOverride) != 0;
  if (overridden && !new_error) return;
  const bool watchdog =
      memory_.get(reg::kAlStatusCode) == static_cast<std::uint16_t>(wire::AlStatusCode::kSyncManagerWatchdog);
  memory_.set(reg::kErrLedOverride, !error ? led::kOff : watchdog ? led::kDoubleFlash : led::kSingleFlash);
}

wire::AlStatus Esc::al_status() const noexcept {
  return wire::AlStatus::from_raw(memory_.get(reg::kAlStatus));
}

bool Esc::device_emulation() const noexcept {
  return (memory_.get(reg::kEscConfiguration) & kDeviceEmulation) != 0 && pdi_operational();
}

bool Esc::pdi_read(std::size_t address, std::span<std::byte> out, Nanoseconds now) noexcept {
  if (address + out.size() > memory_.size()) return false;
  sii_.refresh(now);
  clock_.refresh(Side::kPdi, address, out.size(), now);
  std::copy_n(memory_.at(address, out.size()).begin(), out.size(), out.begin());
  clock_.was_read(Side::kPdi, address, out.size());
  return true;
}

bool Esc::pdi_write(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept {
  if (data.empty() || address + data.size() > wire::kProcessRamStart) return false;
  if (address >= reg::kSiiConfiguration.address && address < reg::kMiiControl.address) {
    return sii_.write_registers(Side::kPdi, address, data, now);
  }
  if (address >= reg::kReceiveTimePort.address && address < wire::register_row(reg::kPdiBufferChangeTime).end()) {
    return clock_.write_registers(Side::kPdi, address, data, now);
  }
  if (address == reg::kResetPdi.address) return write_reset(data[0], reset_pdi_, reg::kResetPdi);
  const bool any = write_plain(address, data, kPdiAccess);
  refresh_addressing();
  return any;
}

}  // namespace driveline::slaves
