#include "driveline/slaves/esc/sync_manager_check.hpp"

#include <algorithm>

namespace driveline::slaves {

using wire::AlStatusCode;
using Use = SyncManagerLayout::Use;

namespace {

bool enabled(const wire::SyncManagerChannel& channel) noexcept {
  return (channel.activate & wire::SyncManagerActivate::kEnable) != 0;
}

bool is_mailbox(const SyncManagerLayout& layout) noexcept {
  return layout.use == Use::kMailboxOut || layout.use == Use::kMailboxIn;
}

wire::SyncManagerDirection direction_of(Use use) noexcept {
  return use == Use::kMailboxOut || use == Use::kOutputs ? wire::SyncManagerDirection::kWrite
                                                         : wire::SyncManagerDirection::kRead;
}

bool mailbox_fits(const Esc& esc, const wire::SyncManagerChannel& channel, const SyncManagerLayout& layout) noexcept {
  const auto control = wire::SyncManagerControl::from_raw(channel.control);
  const auto lowest = layout.min_length != 0 ? layout.min_length : layout.default_length;
  const auto highest = layout.max_length != 0 ? layout.max_length : layout.default_length;
  return enabled(channel) && control.mode == wire::SyncManagerMode::kMailbox &&
         control.direction == direction_of(layout.use) && channel.start_address == layout.start_address &&
         channel.length >= lowest && channel.length <= highest &&
         std::size_t{channel.start_address} + channel.length <= esc.memory().size();
}

/// RAM that a channel occupies: all three buffers in three-buffer mode.
struct Area {
  std::size_t begin;
  std::size_t end;
};
Area area(const wire::SyncManagerChannel& channel) noexcept {
  const auto control = wire::SyncManagerControl::from_raw(channel.control);
  const bool one_buffer =
      control.mode == wire::SyncManagerMode::kMailbox || channel.start_address < wire::kProcessRamStart;
  return {channel.start_address, channel.start_address + (one_buffer ? 1U : 3U) * std::size_t{channel.length}};
}

bool areas_overlap(const Esc& esc) noexcept {
  const auto& unit = esc.sync_managers();
  for (unsigned a = 0; a < unit.count(); ++a) {
    const auto first = unit.channel(a);
    if (!enabled(first) || first.length == 0) continue;
    for (unsigned b = a + 1; b < unit.count(); ++b) {
      const auto second = unit.channel(b);
      if (!enabled(second) || second.length == 0) continue;
      if (area(first).begin < area(second).end && area(second).begin < area(first).end) return true;
    }
  }
  return false;
}

AlStatusCode check_process_data_channel(const Esc& esc, const wire::SyncManagerChannel& channel,
                                        const SyncManagerLayout& layout, std::size_t size) noexcept {
  const auto error = layout.use == Use::kOutputs ? AlStatusCode::kInvalidOutputConfiguration
                                                 : AlStatusCode::kInvalidInputConfiguration;
  if (size == 0) {
    if (!enabled(channel) || channel.length == 0) return AlStatusCode::kNoError;
    if (channel.length != layout.unmapped_length) return error;
    size = layout.unmapped_length;
  }
  const auto control = wire::SyncManagerControl::from_raw(channel.control);
  if (!enabled(channel) || channel.length != size || control.direction != direction_of(layout.use) ||
      channel.start_address != layout.start_address || area(channel).end > esc.memory().size()) {
    return error;
  }
  return control.mode == wire::SyncManagerMode::kThreeBuffer ? AlStatusCode::kNoError
                                                             : AlStatusCode::kFreeRunNeedsThreeBufferMode;
}

}  // namespace

AlStatusCode check_mailboxes(const Esc& esc, std::span<const SyncManagerLayout> layout, AlStatusCode error) noexcept {
  for (unsigned n = 0; n < layout.size(); ++n) {
    if (!is_mailbox(layout[n])) continue;
    if (n >= esc.sync_managers().count() || !mailbox_fits(esc, esc.sync_managers().channel(n), layout[n])) return error;
  }
  return AlStatusCode::kNoError;
}

AlStatusCode check_process_data(const Esc& esc, const Device& device) noexcept {
  const auto& unit = esc.sync_managers();
  const auto& layout = device.profile().sync_managers;
  for (unsigned n = 0; n < unit.count(); ++n) {
    if (n >= layout.size()) {
      if (enabled(unit.channel(n))) return AlStatusCode::kInvalidSyncManagerConfiguration;
      continue;
    }
    if (is_mailbox(layout[n])) continue;
    const auto code = check_process_data_channel(esc, unit.channel(n), layout[n], device.process_data_size(n));
    if (code != AlStatusCode::kNoError) return code;
  }
  return areas_overlap(esc) ? AlStatusCode::kInvalidSyncManagerConfiguration : AlStatusCode::kNoError;
}

AlStatusCode check_watchdog(const Esc& esc, const Device& device) noexcept {
  const auto& layout = device.profile().sync_managers;
  const auto count = std::min<std::size_t>(layout.size(), esc.sync_managers().count());
  for (unsigned n = 0; n < count; ++n) {
    const auto channel = esc.sync_managers().channel(n);
    const bool triggers = wire::SyncManagerControl::from_raw(channel.control).watchdog_trigger;
    if (layout[n].use != Use::kOutputs || !enabled(channel) || !triggers) continue;
    if (esc.watchdog().timeout() < device.process_data_period() || !esc.watchdog().enabled()) {
      return AlStatusCode::kInvalidWatchdogConfiguration;
    }
  }
  return AlStatusCode::kNoError;
}

}  // namespace driveline::slaves
