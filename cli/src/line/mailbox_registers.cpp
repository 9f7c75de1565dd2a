#include "line/mailbox_registers.hpp"

#include <fmt/format.h>

#include "commands/tool_options.hpp"
#include "driveline/wire/sync_manager.hpp"

namespace driveline::cli {

Outcome<std::optional<ecat_master::MailboxWindow>> read_mailbox_window(ecat_master::Bus& bus,
                                                                       ecat_master::SlaveRef slave) {
  std::array<std::byte, 2 * wire::SyncManagerChannel::kSize> bytes{};
  if (auto done = bus.read(slave, wire::reg::kSyncManager.at(0), bytes); !done) return bus_failure(done.error());
  const auto out = wire::SyncManagerChannel::decode(std::span(bytes).first(wire::SyncManagerChannel::kSize));
  const auto in = wire::SyncManagerChannel::decode(std::span(bytes).subspan(wire::SyncManagerChannel::kSize));
  const auto usable = [](const wire::SyncManagerChannel& channel, wire::SyncManagerDirection direction) {
    const auto control = wire::SyncManagerControl::from_raw(channel.control);
    return (channel.activate & wire::SyncManagerActivate::kEnable) != 0 &&
           channel.length > wire::MailboxHeader::kSize && control.mode == wire::SyncManagerMode::kMailbox &&
           control.direction == direction;
  };
  if (!usable(*out, wire::SyncManagerDirection::kWrite) || !usable(*in, wire::SyncManagerDirection::kRead)) {
    return std::optional<ecat_master::MailboxWindow>{};
  }
  ecat_master::MailboxWindow window{out->start_address, out->length, in->start_address, in->length, {}};
  // The other master may have fetched an answer that is missing, and the slave knows its counters.
  window.timeouts.repeat = std::chrono::nanoseconds{0};
  return std::optional(window);
}

bool has_mailbox(wire::AlState state) noexcept {
  using wire::AlState;
  return state == AlState::kPreOp || state == AlState::kSafeOp || state == AlState::kOp;
}

Outcome<void> refuse_if_driven(std::span<const ecat_master::AlReport> states, bool force, std::string_view would) {
  for (std::size_t i = 0; i < states.size() && !force; ++i) {
    if (states[i].status.state != wire::AlState::kOp) continue;
    return failed(fmt::format("slave {} is in OP: a master drives the line, and this would {}; --force does it anyway",
                              i, would));
  }
  return {};
}

Outcome<void> must_not_be_driven(runtime::Session& session, ecat_master::Master& master, bool force) {
  constexpr std::string_view kWould = "take it out of operation";
  if (!force) {
    const auto states = master.peek_states();
    if (!states) return bus_failure(states.error());
    if (auto free = refuse_if_driven(*states, force, kWould); !free) return free;
  }
  return outcome(session.claim(force, kWould));
}

}  // namespace driveline::cli
