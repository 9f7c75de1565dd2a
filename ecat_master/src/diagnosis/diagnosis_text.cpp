// Messages of the diagnosis.
#include <fmt/format.h>

#include "driveline/ecat_master/diagnosis/diagnosis.hpp"

namespace driveline::ecat_master {
namespace {

double seconds(std::int64_t time_ns) {
  return static_cast<double>(time_ns) / 1e9;
}

std::string cable(const FaultPlace& place) {
  const auto other = place.other ? fmt::format("slave {}", *place.other) : std::string("the master");
  return fmt::format("the cable between {} and slave {}", other, place.slave);
}

std::string port_text(const PortDiagnosis& port) {
  if (!port.status.link) return "-";
  return port.status.loop_closed ? "link, closed" : "open";
}

bool quiet(const PortDiagnosis& port) {
  return port.invalid_frames == 0 && port.receive_errors == 0 && port.forwarded == 0 && port.lost_links == 0;
}

void add_slaves(std::string& text, const LineDiagnosis& diagnosis) {
  text += "slaves\n";
  for (const auto& slave : diagnosis.slaves) {
    const auto name = slave.name.empty() ? std::string() : fmt::format(" ({})", slave.name);
    if (!slave.answers) {
      text += fmt::format("  {:3}{}: {}\n", slave.ref.position, name,
                          slave.optional ? "is not connected" : "does not answer");
      continue;
    }
    text += fmt::format("  {:3}{}: {}{}", slave.ref.position, name, wire::to_text(slave.al.status.state),
                        slave.al.status.error ? " with an error" : "");
    if (slave.al.code != wire::AlStatusCode::kNoError) {
      text += fmt::format(", AL status code 0x{:04X} ({})", static_cast<unsigned>(slave.al.code),
                          wire::to_text(slave.al.code));
    }
    text += '\n';
    for (unsigned i = 0; i < kSlavePorts; ++i) {
      const auto& port = slave.ports[i];
      if (quiet(port)) continue;
      text += fmt::format("      port {} ({}): {} damaged frames, {} receive errors, {} forwarded, {} lost links\n", i,
                          port_text(port), port.invalid_frames, port.receive_errors, port.forwarded, port.lost_links);
    }
  }
}

void add_exchange(std::string& text, const LineDiagnosis& diagnosis) {
  if (diagnosis.groups.empty()) return;
  text += fmt::format("exchange: {} cycles, {} frames came too late, {} frames were foreign\n", diagnosis.cycles,
                      diagnosis.stale_frames, diagnosis.foreign_frames);
  for (std::size_t i = 0; i < diagnosis.groups.size(); ++i) {
    const auto& group = diagnosis.groups[i];
    text += fmt::format(
        "  group {}: working counter {} of {}; {} exchanges, {} lost frames, {} with a wrong working counter, at worst "
        "{} in a row{}\n",
        i, group.working_counter, group.expected_working_counter, group.exchanges, group.lost_frames, group.wkc_errors,
        group.longest_bad, group.outputs_zeroed ? "; outputs are zero" : "");
  }
}

void add_guard(std::string& text, const LineDiagnosis& diagnosis) {
  if (!diagnosis.guard) return;
  const auto& guard = *diagnosis.guard;
  text +=
      fmt::format("registers: read back {} times, the last read-back of all slaves took {:.1f} ms; {} had changed\n",
                  guard.looks, seconds(guard.last_round.count()) * 1e3, guard.changes);
}

void add_ring(std::string& text, const LineDiagnosis& diagnosis) {
  if (!diagnosis.ring) return;
  using State = port::RingStatus::State;
  const auto& ring = *diagnosis.ring;
  text += ring.state == State::kOpen
              ? fmt::format("ring: open, {} slaves at the primary interface and {} at the secondary interface\n",
                            ring.primary_slaves, ring.secondary_slaves)
              : fmt::format("ring: {}\n", ring.state == State::kClosed ? "closed" : "not known yet");
}

}  // namespace

std::string describe(const FaultPlace& place) {
  switch (place.kind) {
    case FaultPlace::Kind::kDamagedFrames:
      return fmt::format("slave {}, port {}: {} damaged frames received: {}, or the sender at its other end",
                         place.slave, place.port, place.count, cable(place));
    case FaultPlace::Kind::kLostLink:
      return fmt::format("slave {}, port {}: the link was lost {} times: {}, or the supply of one of them", place.slave,
                         place.port, place.count, cable(place));
    case FaultPlace::Kind::kNoLink:
      return fmt::format("slave {}, port {}: no link: {}, or the supply at its other end", place.slave, place.port,
                         cable(place));
    case FaultPlace::Kind::kNoAnswer:
      return fmt::format("slave {}: does not answer to its address: it was restarted or replaced, or cannot be reached",
                         place.slave);
    case FaultPlace::Kind::kBadFrames:
      return fmt::format(
          "slave {}: {} frames were invalid for its processing unit; check for another sender on the wire", place.slave,
          place.count);
    case FaultPlace::Kind::kPdi:
      return fmt::format("slave {}: {} failed accesses by its local processor", place.slave, place.count);
  }
  return "?";
}

std::string describe(const CyclicEvent& event) {
  switch (event.kind) {
    case CyclicEvent::Kind::kSlaveState:
      return fmt::format("{:.6f} s slave {}: AL status 0x{:02X} after 0x{:02X}", seconds(event.time_ns), event.index,
                         event.after, event.before);
    case CyclicEvent::Kind::kWorkingCounter:
      return fmt::format("{:.6f} s group {}: working counter {} of {}", seconds(event.time_ns), event.index,
                         event.after, event.before);
    case CyclicEvent::Kind::kFrameLost:
      return fmt::format("{:.6f} s group {}: {} frame(s) did not come back in their cycle", seconds(event.time_ns),
                         event.index, event.after);
    case CyclicEvent::Kind::kOutputsZeroed:
      return fmt::format("{:.6f} s group {}: outputs set to zero after {} bad exchanges in a row",
                         seconds(event.time_ns), event.index, event.after);
  }
  return "?";
}

std::string to_text(const LineDiagnosis& diagnosis) {
  std::string text;
  if (diagnosis.places.empty() && diagnosis.problems.empty()) {
    text += "no problem is known\n";
  } else {
    text += "wrong\n";
    for (const auto& problem : diagnosis.problems) text += fmt::format("  {}\n", problem);
    for (const auto& place : diagnosis.places) text += fmt::format("  {}\n", describe(place));
  }
  add_ring(text, diagnosis);
  add_slaves(text, diagnosis);
  add_exchange(text, diagnosis);
  add_guard(text, diagnosis);
  if (const auto& cycle = diagnosis.statistics) {
    const auto us = [](std::chrono::nanoseconds time) { return static_cast<double>(time.count()) / 1e3; };
    const auto row = [&](const char* name, const rt::Histogram& times) {
      text += fmt::format("  {} median {:.1f} us, 99.9 % {:.1f} us, longest {:.1f} us\n", name,
                          us(times.percentile(0.5)), us(times.percentile(0.999)), us(times.max()));
    };
    text += fmt::format("cycle: {} cycles, {} missed periods, {} with lost frames, {} with a wrong working counter\n",
                        cycle->cycles, cycle->missed_periods, cycle->lost_frames, cycle->wkc_errors);
    row("wake-up latency", cycle->wake_latency);
    if (cycle->longest_absence.count() > 0) {
      text += fmt::format("  longest absence of the master {:.1f} ms\n", us(cycle->longest_absence) / 1e3);
    }
    row("cost", cycle->cost);
    row(diagnosis.round_trip_modelled ? "round trip (modelled)" : "round trip", cycle->round_trip);
  }
  const auto list = [&text](const char* title, const auto& entries) {
    if (entries.empty()) return;
    text += title;
    for (const auto& entry : entries) text += fmt::format("  {}\n", describe(entry));
  };
  list("what happened\n", diagnosis.events);
  list("states reported in the process data\n", diagnosis.state_history);
  list("exchange history\n", diagnosis.exchange_history);
  list("emergencies\n", diagnosis.emergencies);
  return text;
}

}  // namespace driveline::ecat_master
