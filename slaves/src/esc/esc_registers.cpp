// Effects of EtherCAT accesses to the register space (ETG.1000.4 chapter 6, ESC data sheet section II).
#include <algorithm>
#include <array>
#include <cstring>

#include "driveline/slaves/esc/esc.hpp"

namespace driveline::slaves {

namespace reg = wire::reg;

/// Register blocks with side effects, ascending. A write is split at their boundaries.
enum class RegisterBlock : std::uint8_t {
  kPlain,
  kStationAddress,
  kWriteProtection,
  kReset,
  kDlControl,
  kAlControl,
  kEventMask,
  kErrorCounters,
  kWatchdogSettings,
  kWatchdogCounters,
  kSii,
  kMii,
  kFmmu,
  kSyncManager,
  kClock,
  kUserRam,
};

namespace {

using Block = RegisterBlock;

struct BlockRange {
  std::uint32_t begin;
  std::uint32_t end;
  Block block;
};

/// Returns the range from the first byte of register `first` to the last byte of register `last`.
template <typename First, typename Last>
constexpr BlockRange range(Block block, const First& first, const Last& last) noexcept {
  return {first.address, wire::register_row(last).end(), block};
}

constexpr std::array kBlocks = {
    range(Block::kStationAddress, reg::kStationAddress, reg::kStationAddress),
    range(Block::kWriteProtection, reg::kRegisterWriteEnable, reg::kEscWriteProtection),
    range(Block::kReset, reg::kResetEcat, reg::kResetEcat),
    range(Block::kDlControl, reg::kDlControl, reg::kDlControl),
    range(Block::kAlControl, reg::kAlControl, reg::kAlControl),
    range(Block::kEventMask, reg::kEcatEventMask, reg::kEcatEventMask),
    range(Block::kErrorCounters, reg::kRxErrorCounter, reg::kLostLinkCounter),
    range(Block::kWatchdogSettings, reg::kWatchdogDivider, reg::kWatchdogTimeProcessData),
    range(Block::kWatchdogCounters, reg::kWatchdogCounterProcessData, reg::kWatchdogCounterPdi),
    range(Block::kSii, reg::kSiiConfiguration, reg::kSiiData),
    range(Block::kMii, reg::kMiiControl, reg::kPhyPortStatus),
    range(Block::kFmmu, reg::kFmmu, reg::kFmmu),
    range(Block::kSyncManager, reg::kSyncManager, reg::kSyncManager),
    range(Block::kClock, reg::kReceiveTimePort, reg::kPdiBufferChangeTime),
    range(Block::kUserRam, reg::kUserRam, reg::kUserRam),
};

constexpr std::size_t kClockEnd = wire::register_row(reg::kPdiBufferChangeTime).end();

/// Block of the first byte, and how many of the remaining bytes belong to it.
struct Part {
  Block block;
  std::size_t length;
};

Part first_part(std::size_t address, std::size_t length) noexcept {
  for (const auto& range : kBlocks) {
    if (address >= range.end) continue;
    if (address >= range.begin) return {range.block, std::min<std::size_t>(length, range.end - address)};
    return {Block::kPlain, std::min<std::size_t>(length, range.begin - address)};
  }
  return {Block::kPlain, length};
}

bool reaches_into(std::size_t address, std::size_t length, std::size_t begin, std::size_t end) noexcept {
  return address < end && begin < address + length;
}

}  // namespace

bool Esc::ecat_read(std::size_t address, std::span<std::byte> out, Nanoseconds now) noexcept {
  if (address >= wire::kProcessRamStart) return read_ram(address, out, now);
  const std::size_t in_registers = std::min<std::size_t>(out.size(), wire::kProcessRamStart - address);
  const bool any = read_registers(address, out.first(in_registers), now);
  const auto rest = out.subspan(in_registers);
  return (!rest.empty() && read_ram(wire::kProcessRamStart, rest, now)) || any;
}

bool Esc::read_ram(std::size_t address, std::span<std::byte> out, Nanoseconds now) noexcept {
  const bool any = sync_managers_.read(address, out);
  if (sync_managers_.take_ecat_buffer_event()) clock_.stamp_ecat_buffer(now);
  return any;
}

bool Esc::write_ram(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept {
  const bool any = write_allowed(address) && sync_managers_.write(address, data, now);
  if (sync_managers_.take_ecat_buffer_event()) clock_.stamp_ecat_buffer(now);
  return any;
}

bool Esc::ecat_write(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept {
  if (address >= wire::kProcessRamStart) return write_ram(address, data, now);
  const std::size_t in_registers = std::min<std::size_t>(data.size(), wire::kProcessRamStart - address);
  const bool any = write_registers(address, data.first(in_registers), now);
  const auto rest = data.subspan(in_registers);
  return (!rest.empty() && write_ram(wire::kProcessRamStart, rest, now)) || any;
}

bool Esc::read_registers(std::size_t address, std::span<std::byte> out, Nanoseconds now) noexcept {
  if (out.empty()) return false;
  const bool reads_clock = reaches_into(address, out.size(), reg::kReceiveTimePort.address, kClockEnd);
  if (reads_clock) clock_.refresh(Side::kEcat, address, out.size(), now);
  if (reaches_into(address, out.size(), reg::kSiiConfiguration.address, reg::kMiiControl.address)) sii_.refresh(now);
  const bool reads_dl_status = reaches_into(address, out.size(), reg::kDlStatus.address, reg::kDlStatus.address + 2);
  if (reads_dl_status) publish_dl_status();
  std::memcpy(out.data(), memory_.at(address, out.size()).data(), out.size());
  if (reads_clock) clock_.was_read(Side::kEcat, address, out.size());
  if (reads_dl_status) events_.set_ecat(ecat_event::kDlStatus, false);
  if (reaches_into(address, out.size(), reg::kAlStatus.address, reg::kAlStatus.address + 2)) {
    events_.set_ecat(ecat_event::kAlStatus, false);
  }
  return true;
}

bool Esc::write_allowed(std::size_t address) const noexcept {
  // A write to the enable registers lifts the protection for the rest of the frame. Register protection does not
  // include the user RAM (ESC data sheet I, write protection).
  if ((memory_.get(reg::kEscWriteProtection) & 1U) != 0 && esc_write_enabled_in_ != frame_serial_) return false;
  return address >= reg::kUserRam.address || (memory_.get(reg::kRegisterWriteProtection) & 1U) == 0 ||
         register_write_enabled_in_ == frame_serial_;
}

bool Esc::write_registers(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept {
  bool any = false;
  while (!data.empty()) {
    const auto [block, length] = first_part(address, data.size());
    const auto part = data.first(length);
    if (block == Block::kWriteProtection) {
      any |= write_protection(address, part);
    } else if (write_allowed(address)) {
      any |= write_block(block, address, part, now);
    }
    address += length;
    data = data.subspan(length);
  }
  return any;
}

/// Writes a part that lies within one block; returns whether a register took data.
bool Esc::write_block(RegisterBlock block, std::size_t address, std::span<const std::byte> part,
                      Nanoseconds now) noexcept {
  switch (block) {
    case Block::kReset:
      return write_reset(part[0], reset_ecat_, reg::kResetEcat);
    case Block::kDlControl:
      return write_dl_control(address, part, now);
    case Block::kAlControl:
      return write_al_control(address, part, now);
    case Block::kErrorCounters:
      return write_error_counters(address, part.size());
    case Block::kWatchdogCounters:
      watchdog_.clear_counters();
      return true;
    case Block::kSii:
      return sii_.write_registers(Side::kEcat, address, part, now);
    case Block::kFmmu:
      return fmmus_.write_registers(address, part);
    case Block::kSyncManager:
      return sync_managers_.write_registers(address, part);
    case Block::kClock:
      return clock_.write_registers(Side::kEcat, address, part, now);
    case Block::kWriteProtection:  // write_registers()
    case Block::kMii:              // owned by the PDI
      return false;
    case Block::kStationAddress:
    case Block::kEventMask:
    case Block::kWatchdogSettings:
    case Block::kPlain:
    case Block::kUserRam:
      break;
  }
  const bool any = write_plain(address, part, kEcatAccess);
  plain_written(block, address, part.size(), now);
  return any;
}

/// Lets the units of the controller use registers that have been written without side effects.
void Esc::plain_written(RegisterBlock block, std::size_t address, std::size_t length, Nanoseconds now) noexcept {
  switch (block) {
    case Block::kStationAddress:
      return refresh_addressing();
    case Block::kEventMask:
      return events_.refresh();
    case Block::kWatchdogSettings:
      return watchdog_.configure();
    case Block::kPlain:
    case Block::kUserRam:
      return sync_managers_.register_written(address, length, now);
    default:
      return;
  }
}

bool Esc::write_plain(std::size_t address, std::span<const std::byte> data, const RegisterAccessMap& access) noexcept {
  bool any = false;
  const auto target = memory_.at(address, data.size());
  for (std::size_t i = 0; i < data.size(); ++i) {
    if (!access.writable(address + i)) continue;
    target[i] = access.accepted(address + i, data[i]);
    any = true;
  }
  return any;
}

bool Esc::write_dl_control(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept {
  constexpr std::size_t kLoops = reg::kDlControl.address + 1;
  constexpr std::uint32_t kTemporary = 0x00000002;
  constexpr Nanoseconds kTemporaryTime = std::chrono::seconds{1};
  const auto before = std::to_integer<std::uint8_t>(memory_.at(kLoops, 1)[0]);
  if (!write_plain(address, data, kEcatAccess)) return false;
  if (reaches_into(address, data.size(), kLoops, kLoops + 1)) {
    const bool temporary = (memory_.get(reg::kDlControl) & kTemporary) != 0;
    // After temporary settings, restore the last permanent one.
    if (temporary && loops_revert_at_ == WatchdogUnit::kNever) loops_before_ = before;
    loops_revert_at_ = temporary ? now + kTemporaryTime : WatchdogUnit::kNever;
  }
  refresh_addressing();
  loop_control_changed_ = true;
  events_.call_firmware();
  return true;
}

bool Esc::write_protection(std::size_t address, std::span<const std::byte> data) noexcept {
  bool any = false;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const std::size_t target = address + i;
    if (target == reg::kRegisterWriteEnable.address) {
      register_write_enabled_in_ = frame_serial_;
      any = true;
    } else if (target == reg::kEscWriteEnable.address) {
      esc_write_enabled_in_ = frame_serial_;
      any = true;
    } else if ((target == reg::kRegisterWriteProtection.address || target == reg::kEscWriteProtection.address) &&
               write_allowed(target)) {
      memory_.at(target, 1)[0] = data[i] & std::byte{1};
      any = true;
    }
  }
  return any;
}

bool Esc::write_al_control(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept {
  // Behaves like a mailbox: locked until the application has read it (ESC data sheet II, 0x0120).
  if (!device_emulation() && events_.al_pending(al_event::kAlControl)) return false;
  write_plain(address, data, kEcatAccess);
  al_control_time_ = now;
  events_.set_al(al_event::kAlControl, true);
  events_.call_firmware();
  return true;
}

bool Esc::write_error_counters(std::size_t address, std::size_t length) noexcept {
  bool any = false;
  // A write to any counter of a group clears the whole group; the PDI error code 0x030E is read only.
  struct Group {
    std::size_t trigger_begin, trigger_end, begin, end;
  };
  constexpr std::size_t kUnit = reg::kProcessingUnitErrorCounter.address;
  constexpr std::size_t kPdi = reg::kPdiErrorCounter.address;
  constexpr std::size_t kLostLink = reg::kLostLinkCounter.address;
  constexpr std::array kGroups = {
      Group{reg::kRxErrorCounter.address, kUnit, reg::kRxErrorCounter.address, kUnit},
      Group{kUnit, kUnit + 1, kUnit, kUnit + 1},
      Group{kPdi, kPdi + 1, kPdi, kPdi + 3},
      Group{kLostLink, kLostLink + 4, kLostLink, kLostLink + 4},
  };
  for (const auto& group : kGroups) {
    if (!reaches_into(address, length, group.trigger_begin, group.trigger_end)) continue;
    const auto target = memory_.at(group.begin, std::size_t{group.end} - group.begin);
    std::fill(target.begin(), target.end(), std::byte{0});
    any = true;
  }
  return any;
}

bool Esc::write_reset(std::byte value, ResetSequence& sequence, const wire::reg::U8& target) noexcept {
  if (sequence.write(value)) {
    reset_requested_ = true;
    events_.call_firmware();
  }
  memory_.set(target, sequence.step);
  return true;
}

bool Esc::ResetSequence::write(std::byte value) noexcept {
  constexpr std::array kSequence = {std::byte{'R'}, std::byte{'E'}, std::byte{'S'}};
  if (value != kSequence[step]) {
    step = value == kSequence[0] ? 1 : 0;
    return false;
  }
  if (++step < kSequence.size()) return false;
  step = 0;
  return true;
}

}  // namespace driveline::slaves
