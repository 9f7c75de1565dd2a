#include "driveline/slaves/line/simulated_line.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace driveline::slaves {

namespace {

/// Byte of the Ethernet header whose second bit slave controllers set: the source address becomes locally administered,
/// which shows the sender that its frame has passed the line (ESC data sheet II, 0x0100 bit 0).
constexpr std::size_t kSourceAddress = 6;
constexpr std::byte kLocallyAdministered{0x02};

}  // namespace

SimulatedLine::SimulatedLine(rt::Clock& clock, std::vector<std::unique_ptr<Slave>> slaves, const LineOptions& options,
                             std::optional<Wiring> wiring)
    : clock_(clock),
      slaves_(std::move(slaves)),
      wiring_(wiring ? std::move(*wiring) : Wiring::line(slaves_.size(), options.cable_delay)),
      options_(options),
      ports_(slaves_.size()),
      auto_closed_(slaves_.size()),
      lost_frame_(port::kMaxFrameBytes),
      faults_(*this, slaves_.size()) {
  if (wiring_.slave_count() != slaves_.size())
    throw std::invalid_argument("the wiring is for another number of slaves");
  ends_[0] = std::make_unique<LineEnd>(*this, clock_, MasterPort::kPrimary);
  ends_[1] = std::make_unique<LineEnd>(*this, clock_, MasterPort::kSecondary);
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    ports_[i].delays = i < options_.slave_delays.size() ? options_.slave_delays[i] : options_.delays;
  }
}

void SimulatedLine::advance(Nanoseconds now) {
  // Faults start and end at their exact times, even if this is called late.
  for (auto due = faults_.due(); due <= now; due = faults_.due()) {
    advance_slaves(slaves_, due);
    faults_.run(due);
  }
  advance_slaves(slaves_, now);
}

void SimulatedLine::advance_some(std::size_t first, std::size_t count, Nanoseconds now) {
  if (faults_.due() <= now) return advance(now);
  const auto from = std::min(first, slaves_.size());
  advance_slaves(std::span(slaves_).subspan(from, std::min(count, slaves_.size() - from)), now);
}

void SimulatedLine::advance_slaves(std::span<const std::unique_ptr<Slave>> slaves, Nanoseconds now) {
  for (const auto& slave : slaves) {
    slave->advance(now);
    topology_changed_ |= slave->esc().loop_control_changed();
  }
}

port::SendStatus SimulatedLine::transmit(LineEnd& from, std::span<const std::byte> frame) noexcept {
  if (frame.size() > port::kMaxFrameBytes) return port::SendStatus::kTooLong;
  const auto now = clock_.now();
  advance(now);
  const auto& path = current_path(from.which_);
  const auto plugged = wiring_.master(from.which_);
  if (!plugged || !link_up(*plugged)) return port::SendStatus::kLinkDown;
  // The frame is processed in the buffer that it will be received from.
  LineEnd* to = path.exit() ? ends_[static_cast<std::size_t>(*path.exit())].get() : nullptr;
  LineEnd::Slot* slot = to != nullptr ? to->next_slot() : nullptr;
  if (to != nullptr && slot == nullptr) return port::SendStatus::kBusy;
  const std::span<std::byte> room = slot != nullptr ? std::span<std::byte>(slot->bytes) : lost_frame_;
  const auto passing = room.first(frame.size());
  std::copy(frame.begin(), frame.end(), passing.begin());
  from.last_send_ = now;
  if (const auto passage = pass_along(passing, path, now); passage && to != nullptr) {
    const auto begin = from.occupy(now, options_.byte_time, frame.size());
    const auto arrival =
        begin + passage->delay + passage->fault_delay + options_.byte_time * static_cast<std::int64_t>(frame.size());
    to->commit(frame.size(), arrival);
    if (auto* copy = passage->duplicated ? to->next_slot() : nullptr; copy != nullptr) {
      copy->bytes = slot->bytes;
      to->commit(frame.size(), arrival);
    }
  }
  return port::SendStatus::kSent;
}

std::optional<SimulatedLine::Passage> SimulatedLine::process(std::span<std::byte> frame, Nanoseconds now,
                                                             MasterPort from) {
  advance(now);
  return pass(frame, now, from);
}

std::optional<SimulatedLine::Passage> SimulatedLine::pass(std::span<std::byte> frame, Nanoseconds now,
                                                          MasterPort from) {
  return pass_along(frame, current_path(from), now);
}

std::optional<SimulatedLine::Passage> SimulatedLine::pass_along(std::span<std::byte> frame, const FramePath& path,
                                                                Nanoseconds now) noexcept {
  ++counters_.frames;
  const auto fate = faults_.concern_frames() ? faults_.next_frame(frame, now) : FrameFate{};
  bool survives = !fate.lost_out && pass_frame(frame, path, fate, now);
  if (faults_.concern_frames()) faults_.corrupt_reply(frame, now);
  survives = survives && !fate.lost_back && time_of_damage(path, fate) == LineFaults::kNever;
  if (!survives || !path.exit()) {
    ++counters_.lost;
    return std::nullopt;
  }
  return Passage{*path.exit(), path.delay(), fate.delay, fate.duplicated};
}

bool SimulatedLine::pass_frame(std::span<std::byte> frame, const FramePath& path, const FrameFate& fate,
                               Nanoseconds now) noexcept {
  bool survives = true;
  switch (datagrams_.load(frame)) {
    case FrameKind::kForeign:
      ++counters_.foreign;
      survives = survives_as_foreign(path);
      break;
    case FrameKind::kNoCommands:
      break;
    case FrameKind::kCommands:
      survives = pass_slaves(path, fate, now);
      if (!path.steps().empty()) frame[kSourceAddress] |= kLocallyAdministered;
      break;
  }
  if (datagrams_.malformed()) ++counters_.malformed;
  if (fate.damaged_at) count_damage(path, *fate.damaged_at);
  return survives;
}

SimulatedLine::Nanoseconds SimulatedLine::time_of_damage(const FramePath& path, const FrameFate& fate) noexcept {
  if (!fate.damaged_at) return LineFaults::kNever;
  const auto time = path.received(fate.damaged_at->slave)[fate.damaged_at->port];
  return time == FramePath::kNotReceived ? LineFaults::kNever : time;
}

void SimulatedLine::count_damage(const FramePath& path, PortId damaged_at) noexcept {
  const auto damage = path.received(damaged_at.slave)[damaged_at.port];
  if (damage == FramePath::kNotReceived) return;
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    for (unsigned port = 0; port < kPortCount; ++port) {
      const auto time = path.received(i)[port];
      if (time == FramePath::kNotReceived || time < damage) continue;
      slaves_[i]->esc().count_damaged_frame(port, PortId{i, port} != damaged_at);
    }
  }
}

bool SimulatedLine::pass_slaves(const FramePath& path, const FrameFate& fate, Nanoseconds now) noexcept {
  ++serial_;
  bool circulating = datagrams_.circulating();
  bool latch = false;
  const auto damage = time_of_damage(path, fate);
  for (const auto& step : path.steps()) {
    // A controller accepts data of a frame only if the frame check sequence is right (ETG.1000.4 5.2).
    if (step.time >= damage) break;
    if (step.circulates && circulating) return false;
    circulating |= step.circulates;
    auto& esc = slaves_[step.slave]->esc();
    esc.begin_frame(serial_);
    if (fate.short_working_counter && !faults_.takes_part(step.slave)) {
      process_without_logical(esc, now + step.time);
    } else {
      for (auto& datagram : datagrams_.datagrams()) esc.process(datagram, now + step.time);
    }
    if (datagrams_.malformed()) esc.count_malformed_frame();
    latch |= esc.clock().latch_requested();
  }
  if (latch) latch_receive_times(path, now);
  datagrams_.store(circulating);
  return true;
}

void SimulatedLine::process_without_logical(Esc& esc, Nanoseconds time) noexcept {
  for (auto& datagram : datagrams_.datagrams()) {
    if (!wire::is_logical(datagram.command)) esc.process(datagram, time);
  }
}

void SimulatedLine::latch_receive_times(const FramePath& path, Nanoseconds now) noexcept {
  for (const auto& step : path.steps()) {
    auto& clock = slaves_[step.slave]->esc().clock();
    if (!clock.latch_requested()) continue;
    auto received = path.received(step.slave);
    for (auto& time : received) {
      if (time != FramePath::kNotReceived) time += now;
    }
    clock.latch(received, now + step.time);
  }
}

bool SimulatedLine::survives_as_foreign(const FramePath& path) const noexcept {
  return std::all_of(path.steps().begin(), path.steps().end(),
                     [this](const auto& step) { return slaves_[step.slave]->esc().forwards_foreign_frames(); });
}

bool SimulatedLine::link_up(PortId port) const noexcept {
  const auto& end = wiring_.at(port);
  if (!slaves_[port.slave]->powered() || end.broken || end.kind == Wiring::End::Kind::kNothing) return false;
  return end.kind == Wiring::End::Kind::kMaster || slaves_[end.slave.slave]->powered();
}

const FramePath& SimulatedLine::current_path(MasterPort from) noexcept {
  refresh_topology();
  const auto& path = paths_[static_cast<std::size_t>(from)];
  // An auto-closed port opens when it receives a frame.
  while (path.blocked() && link_up(*path.blocked()) && auto_closed_[path.blocked()->slave][path.blocked()->port]) {
    auto_closed_[path.blocked()->slave][path.blocked()->port] = false;
    topology_changed_ = true;
    refresh_topology();
  }
  return path;
}

void SimulatedLine::refresh_topology() noexcept {
  if (!topology_changed_) return;
  topology_changed_ = false;
  for (std::size_t i = 0; i < slaves_.size(); ++i) refresh_ports(i, slaves_[i]->esc().take_loop_control_change());
  paths_[0].trace(wiring_, ports_, MasterPort::kPrimary);
  paths_[1].trace(wiring_, ports_, MasterPort::kSecondary);
}

void SimulatedLine::refresh_ports(std::size_t position, bool loop_control_written) noexcept {
  auto& esc = slaves_[position]->esc();
  for (unsigned port = 0; port < kPortCount; ++port) {
    const bool link = link_up({position, port});
    const auto control = esc.loop_control(port);
    auto& auto_closed = auto_closed_[position][port];
    if (control != wire::LoopControl::kAutoClose || (link && loop_control_written)) auto_closed = false;
    if (control == wire::LoopControl::kAutoClose && !link) auto_closed = true;
    bool closed = control == wire::LoopControl::kClosed || auto_closed;
    if (control == wire::LoopControl::kAuto) closed = !link;
    ports_[position].closed[port] = closed || !slaves_[position]->powered();
    esc.set_port(port, {link, closed, link && !closed});
  }
}

void SimulatedLine::set_power(std::size_t position, bool on, Nanoseconds now) noexcept {
  slaves_[position]->set_power(on, now);
  topology_changed_ = true;
}

bool SimulatedLine::break_cable(PortId port, bool broken) noexcept {
  topology_changed_ = true;
  return wiring_.break_cable(port, broken);
}

}  // namespace driveline::slaves
