#include "driveline/slaves/esc/sync_manager_unit.hpp"

#include <algorithm>
#include <cstring>

namespace driveline::slaves {

using wire::SyncManagerChannel;
using wire::SyncManagerStatus;

namespace {

constexpr std::size_t kSyncManagerBase = wire::reg::kSyncManager.address;
constexpr std::size_t kControlOffset = 4;
constexpr std::size_t kStatusOffset = 5;
constexpr std::size_t kActivateOffset = 6;
constexpr std::size_t kPdiControlOffset = 7;
/// Bit 7 of the control byte is reserved.
constexpr std::byte kControlMask{0x7F};
/// Enable, repeat request and latch event bits; the others are reserved.
constexpr std::byte kActivateMask{0xC3};

void copy(std::span<const std::byte> from, std::span<std::byte> to) noexcept {
  if (!from.empty()) std::memcpy(to.data(), from.data(), from.size());
}

}  // namespace

SyncManagerUnit::SyncManagerUnit(EscMemory& memory, EventUnit& events, WatchdogUnit& watchdog, unsigned count) noexcept
    : memory_(memory), events_(events), watchdog_(watchdog), count_(std::min(count, kMaxCount)) {}

void SyncManagerUnit::reset() noexcept {
  for (unsigned n = 0; n < count_; ++n) {
    channels_[n] = {};
    configure(n);
  }
  rebuild_active();
}

SyncManagerUnit::Run SyncManagerUnit::locate(std::size_t address, std::size_t length) const noexcept {
  std::size_t end = address + length;
  for (unsigned i = 0; i < active_count_; ++i) {
    const auto& c = channels_[active_[i]];
    if (address >= c.begin && address < c.end()) return {active_[i], std::min(end, c.end()) - address};
    if (c.begin > address) end = std::min<std::size_t>(end, c.begin);
  }
  return {-1, end - address};
}

bool SyncManagerUnit::read(std::size_t address, std::span<std::byte> out) noexcept {
  bool any = false;
  out = out.first(address < memory_.size() ? std::min(out.size(), memory_.size() - address) : 0);
  while (!out.empty()) {
    const Run run = locate(address, out.size());
    const auto part = out.first(run.length);
    if (run.channel >= 0) {
      any |= read_channel(static_cast<unsigned>(run.channel), address, part);
    } else {
      copy(memory_.at(address, part.size()), part);
      any = true;
    }
    address += run.length;
    out = out.subspan(run.length);
  }
  return any;
}

bool SyncManagerUnit::write(std::size_t address, std::span<const std::byte> data, Nanoseconds now) noexcept {
  bool any = false;
  data = data.first(address < memory_.size() ? std::min(data.size(), memory_.size() - address) : 0);
  while (!data.empty()) {
    const Run run = locate(address, data.size());
    const auto part = data.first(run.length);
    if (run.channel >= 0) {
      any |= write_channel(static_cast<unsigned>(run.channel), address, part, now);
    } else {
      copy(part, memory_.at(address, part.size()));
      any = true;
    }
    address += run.length;
    data = data.subspan(run.length);
  }
  return any;
}

void SyncManagerUnit::peek(std::size_t address, std::span<std::byte> out) const noexcept {
  out = out.first(address < memory_.size() ? std::min(out.size(), memory_.size() - address) : 0);
  while (!out.empty()) {
    const Run run = locate(address, out.size());
    std::size_t source = address;
    if (run.channel >= 0 && channels_[static_cast<unsigned>(run.channel)].usable) {
      const auto& c = channels_[static_cast<unsigned>(run.channel)];
      const std::uint8_t last = c.newest == kNoBuffer ? std::uint8_t{0} : c.newest;
      source = buffer_address(c, c.write_open ? c.writing : last) + (address - c.begin);
    }
    copy(memory_.at(source, run.length), out.first(run.length));
    address += run.length;
    out = out.subspan(run.length);
  }
}

std::size_t SyncManagerUnit::buffer_address(const Channel& c, std::uint8_t buffer) const noexcept {
  return c.mailbox() || c.in_registers ? c.begin : c.begin + std::size_t{buffer} * c.length;
}

bool SyncManagerUnit::open_for_read(Channel& c) noexcept {
  if (c.mailbox() && !c.full) return false;
  c.reading = c.newest == kNoBuffer ? std::uint8_t{0} : c.newest;
  c.read_open = true;
  c.interrupt_write = false;
  return true;
}

void SyncManagerUnit::close_read(Channel& c) noexcept {
  c.read_open = false;
  c.full = false;
  c.fresh = false;
  c.interrupt_read = true;
}

bool SyncManagerUnit::open_for_write(Channel& c) noexcept {
  if (c.mailbox() && c.full) return false;
  c.write_open = true;
  c.interrupt_read = false;
  return true;
}

void SyncManagerUnit::close_write(Channel& c) noexcept {
  c.write_open = false;
  c.full = c.mailbox();
  c.fresh = true;
  c.interrupt_write = true;
  ++c.writes;
  if (c.mailbox()) return;
  // The next buffer to write is neither the newest nor the one being read.
  c.newest = c.writing;
  c.writing = 0;
  while (c.writing == c.newest || (c.read_open && c.writing == c.reading)) ++c.writing;
}

bool SyncManagerUnit::read_channel(unsigned n, std::size_t address, std::span<std::byte> out) noexcept {
  auto& c = channels_[n];
  if (!c.usable || c.ecat_writes()) return false;
  const std::size_t offset = address - c.begin;
  if (offset == 0 ? !open_for_read(c) : !c.read_open) return false;
  copy(memory_.at(buffer_address(c, c.reading) + offset, out.size()), out);
  if (offset + out.size() == c.length) {
    close_read(c);
    ecat_buffer_event_ |= c.latch_ecat;
    if (c.mailbox()) events_.call_firmware();
  }
  publish_status(n);
  return true;
}

bool SyncManagerUnit::write_channel(unsigned n, std::size_t address, std::span<const std::byte> data,
                                    Nanoseconds now) noexcept {
  auto& c = channels_[n];
  if (!c.usable || !c.ecat_writes()) return false;
  const std::size_t offset = address - c.begin;
  if (offset == 0 ? !open_for_write(c) : !c.write_open) return false;
  copy(data, memory_.at(buffer_address(c, c.writing) + offset, data.size()));
  if (offset + data.size() == c.length) {
    close_write(c);
    ecat_buffer_event_ |= c.latch_ecat;
    triggered_by_master(n, now);
  }
  publish_status(n);
  return true;
}

void SyncManagerUnit::triggered_by_master(unsigned n, Nanoseconds now) noexcept {
  channels_[n].last_write = now;
  if (channels_[n].control.watchdog_trigger) watchdog_.trigger(now);
  if (channels_[n].mailbox()) events_.call_firmware();
}

void SyncManagerUnit::register_written(std::size_t address, std::size_t length, Nanoseconds now) noexcept {
  for (unsigned n = 0; n < count_; ++n) {
    auto& c = channels_[n];
    const std::size_t last = c.end() - 1;
    if (!c.in_registers || !c.usable || !c.ecat_writes() || last < address || last >= address + length) continue;
    c.fresh = true;
    c.interrupt_write = true;
    ++c.writes;
    triggered_by_master(n, now);
    publish_status(n);
  }
}

bool SyncManagerUnit::write_registers(std::size_t address, std::span<const std::byte> data) noexcept {
  bool any = false;
  bool activation_changed = false;
  std::size_t i = 0;
  while (i < data.size()) {
    const std::size_t n = (address + i - kSyncManagerBase) / SyncManagerChannel::kSize;
    const std::size_t next = kSyncManagerBase + (n + 1) * SyncManagerChannel::kSize - address;
    if (n >= count_) break;
    const bool locked = channels_[n].enabled;
    for (; i < std::min(next, data.size()); ++i) {
      const std::size_t field = (address + i - kSyncManagerBase) % SyncManagerChannel::kSize;
      auto& target = memory_.at(address + i, 1)[0];
      if (field <= kControlOffset) {
        // Start address, length and control are locked while the channel is enabled (ESC data sheet II, 0x0800).
        if (!locked) target = field == kControlOffset ? data[i] & kControlMask : data[i];
        any |= !locked;
      } else if (field == kActivateOffset) {
        activation_changed |= target != (data[i] & kActivateMask);
        target = data[i] & kActivateMask;
        any = true;
      }
    }
    configure(static_cast<unsigned>(n));
  }
  rebuild_active();
  if (activation_changed) {
    events_.set_al(al_event::kSyncManagerChanged, true);
    events_.call_firmware();
  }
  return any;
}

SyncManagerChannel SyncManagerUnit::channel(unsigned n) const noexcept {
  return *SyncManagerChannel::decode(
      memory_.at(kSyncManagerBase + n * SyncManagerChannel::kSize, SyncManagerChannel::kSize));
}

void SyncManagerUnit::configure(unsigned n) noexcept {
  auto& c = channels_[n];
  const auto settings = channel(n);
  const bool enable = (settings.activate & wire::SyncManagerActivate::kEnable) != 0;
  const bool deactivated = (settings.pdi_control & wire::SyncManagerPdiControl::kDeactivate) != 0;
  const bool was_usable = c.usable;
  c.begin = settings.start_address;
  c.length = settings.length;
  c.control = wire::SyncManagerControl::from_raw(settings.control);
  c.enabled = enable;
  c.latch_ecat = (settings.activate & wire::SyncManagerActivate::kLatchEcat) != 0;
  c.latch_pdi = (settings.activate & wire::SyncManagerActivate::kLatchPdi) != 0;
  c.in_registers = settings.start_address < wire::kProcessRamStart;
  const std::size_t buffers = c.mailbox() || c.in_registers ? 1 : 3;
  const std::size_t limit = c.in_registers ? wire::kProcessRamStart : memory_.size();
  c.usable = enable && !deactivated && c.length > 0 && c.begin + buffers * c.length <= limit;
  if (c.usable != was_usable || !c.usable) clear_buffers(c);
  publish_status(n);
}

void SyncManagerUnit::clear_buffers(Channel& c) noexcept {
  c.full = c.fresh = c.write_open = c.read_open = c.interrupt_write = c.interrupt_read = false;
  c.newest = kNoBuffer;
  c.writing = c.reading = 0;
  c.writes = 0;
}

void SyncManagerUnit::rebuild_active() noexcept {
  active_count_ = 0;
  for (unsigned n = 0; n < count_; ++n) {
    const auto& c = channels_[n];
    if (c.enabled && c.length > 0 && !c.in_registers) active_[active_count_++] = static_cast<std::uint8_t>(n);
  }
}

void SyncManagerUnit::publish_status(unsigned n) noexcept {
  const auto& c = channels_[n];
  unsigned status = (c.interrupt_write ? SyncManagerStatus::kInterruptWrite : 0U) |
                    (c.interrupt_read ? SyncManagerStatus::kInterruptRead : 0U) |
                    (c.read_open ? SyncManagerStatus::kReadInUse : 0U) |
                    (c.write_open ? SyncManagerStatus::kWriteInUse : 0U);
  status |= c.mailbox() ? (c.full ? SyncManagerStatus::kMailboxFull : 0U) : unsigned{c.newest} << 4;
  memory_.at(kSyncManagerBase + n * SyncManagerChannel::kSize + kStatusOffset, 1)[0] = static_cast<std::byte>(status);

  const bool for_ecat = c.ecat_writes() ? c.interrupt_read : c.interrupt_write;
  const bool for_pdi = c.ecat_writes() ? c.interrupt_write : c.interrupt_read;
  if (n < ecat_event::kSyncManagers) {
    events_.set_ecat(static_cast<std::uint16_t>(ecat_event::kSyncManager0 << n), for_ecat && c.control.interrupt_ecat);
  }
  events_.set_al(al_event::kSyncManager0 << n, for_pdi && c.control.interrupt_pdi);
}

std::span<const std::byte> SyncManagerUnit::waiting_mail(unsigned n) const noexcept {
  const auto& c = channels_[n];
  if (!c.usable || !c.ecat_writes() || !c.full) return {};
  return memory_.at(c.begin, c.length);
}

std::span<const std::byte> SyncManagerUnit::take(unsigned n) noexcept {
  auto& c = channels_[n];
  if (!c.usable || !c.ecat_writes() || !c.fresh || (!c.in_registers && !open_for_read(c))) return {};
  const auto data = memory_.at(buffer_address(c, c.reading), c.length);
  c.interrupt_write = false;
  close_read(c);
  pdi_buffer_event_ |= c.latch_pdi;
  publish_status(n);
  return data;
}

std::span<std::byte> SyncManagerUnit::begin_publish(unsigned n) noexcept {
  auto& c = channels_[n];
  if (!c.usable || c.ecat_writes() || !open_for_write(c)) return {};
  return memory_.at(buffer_address(c, c.writing), c.length);
}

void SyncManagerUnit::end_publish(unsigned n) noexcept {
  auto& c = channels_[n];
  if (!c.usable || c.ecat_writes() || !c.write_open) return;
  close_write(c);
  pdi_buffer_event_ |= c.latch_pdi;
  publish_status(n);
}

void SyncManagerUnit::set_deactivated(unsigned n, bool deactivated) noexcept {
  auto& control = memory_.at(kSyncManagerBase + n * SyncManagerChannel::kSize + kPdiControlOffset, 1)[0];
  constexpr std::byte kBit{wire::SyncManagerPdiControl::kDeactivate};
  control = deactivated ? control | kBit : control & ~kBit;
  configure(n);
}

bool SyncManagerUnit::repeat_requested(unsigned n) const noexcept {
  const auto settings = channel(n);
  const bool request = (settings.activate & wire::SyncManagerActivate::kRepeatRequest) != 0;
  const bool acknowledge = (settings.pdi_control & wire::SyncManagerPdiControl::kRepeatAck) != 0;
  return channels_[n].usable && request != acknowledge;
}

void SyncManagerUnit::acknowledge_repeat(unsigned n) noexcept {
  const bool request = (channel(n).activate & wire::SyncManagerActivate::kRepeatRequest) != 0;
  auto& control = memory_.at(kSyncManagerBase + n * SyncManagerChannel::kSize + kPdiControlOffset, 1)[0];
  constexpr std::byte kBit{wire::SyncManagerPdiControl::kRepeatAck};
  control = request ? control | kBit : control & ~kBit;
}

}  // namespace driveline::slaves
