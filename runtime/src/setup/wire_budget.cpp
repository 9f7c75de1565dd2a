#include "driveline/runtime/setup/wire_budget.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "driveline/ecat_master/cyclic/acyclic_budget.hpp"
#include "driveline/wire/frame.hpp"
#include "driveline/wire/wire_time.hpp"

namespace driveline::runtime {
namespace {

using std::chrono::nanoseconds;

/// Forwarding delay of a slave in both directions, if the ports do not measure it.
constexpr nanoseconds kAssumedDelay{1000};

double us(nanoseconds time) {
  return static_cast<double>(time.count()) / 1000.0;
}

/// Returns the longest mailbox; it is written and read as a whole, in one datagram.
std::size_t longest_mailbox(const ecat_master::Master& master) {
  using Use = esi::SyncManager::Use;
  std::size_t bytes = 0;
  for (const auto& slave : master.slaves()) {
    if (!slave.info.description.mailbox.any()) continue;
    for (const auto& manager : slave.info.description.sync_managers) {
      if (manager.use != Use::kMailboxOut && manager.use != Use::kMailboxIn) continue;
      bytes = std::max<std::size_t>(bytes, manager.default_size);
    }
  }
  return bytes == 0 ? 0 : bytes + wire::kDatagramsOffset + wire::DatagramHeader::kOverhead;
}

nanoseconds wire_time(std::size_t frame_bytes) {
  return nanoseconds{static_cast<std::int64_t>(frame_bytes + wire::kPreambleFcsGap) * wire::kNsPerByte};
}

}  // namespace

WireBudget wire_budget(const ecat_master::Master& master, const LineConfig& config) {
  WireBudget budget;
  budget.period = config.period;
  budget.frames = nanoseconds{ecat_master::wire_time_ns(master.image(), config.clocks.has_value())};
  budget.line = master.slaves().size() * kAssumedDelay;
  const auto& topology = master.topology();
  if (const auto first = topology.first(); first && topology.slaves[*first].span_ns > 0) {
    // Time from the first slave to the end of the line and back, plus the delay of the first slave itself.
    budget.line = nanoseconds{topology.slaves[*first].span_ns} + kAssumedDelay;
    budget.line_measured = true;
  }
  budget.acyclic_bytes = config.acyclic_bytes.value_or(
      ecat_master::acyclic_bytes(master.image(), config.clocks.has_value(), config.period));
  budget.longest_mailbox = longest_mailbox(master);
  return budget;
}

Result<void> check_budget(const WireBudget& budget, bool on_interface) {
  const auto window = receive_window(budget.period);
  const auto needed = on_interface ? budget.total() : budget.line;
  if (needed <= window) return {};
  const auto frames = on_interface ? fmt::format("{:.1f} us of frames at 100 Mbit/s and ", us(budget.frames)) : "";
  return fail(ErrorKind::kLine,
              fmt::format("the last answer arrives after {:.1f} us ({}{:.1f} us through the line), but a cycle of "
                          "{:.1f} us waits {:.1f} us: choose a longer cycle_us, fewer slaves, or groups with dividers",
                          us(needed), frames, us(budget.line), us(budget.period), us(window)));
}

std::string describe(const WireBudget& budget, bool on_interface) {
  auto text = fmt::format("{:.1f} us of {:.1f} us on the wire, {} bytes a cycle for everything else",
                          us(budget.total()), us(budget.period), budget.acyclic_bytes);
  if (!on_interface && budget.total() > receive_window(budget.period)) {
    text += fmt::format("\n  a simulated line has no wire: at 100 Mbit/s the answers would not return within {:.1f} us",
                        us(receive_window(budget.period)));
  }
  if (budget.frames + wire_time(budget.longest_mailbox) > budget.period && budget.longest_mailbox > 0) {
    text += fmt::format("\n  a mailbox message takes a frame of {} bytes, {:.1f} us: each delays the next cycle",
                        budget.longest_mailbox, us(wire_time(budget.longest_mailbox)));
  }
  return text;
}

}  // namespace driveline::runtime
