#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "driveline/canopen_master/node_line.hpp"
#include "driveline/canopen_wire/candump.hpp"
#include "driveline/rt/clock.hpp"

namespace driveline::canopen {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

/// A frame as candump writes it: "601#4000100000000000".
[[nodiscard]] inline std::string text_of(const Frame& frame) {
  const auto line = candump::line_of(frame, "", 0);
  return std::string(line.view().substr(line.view().rfind(' ') + 1));
}

/// A node of a few lines that puts its frames together byte by byte, without our codec, and lies where a test says so.
class FakeNode {
 public:
  using Key = std::pair<unsigned, unsigned>;  ///< index, sub-index

  /// With four PDOs in each direction that are not valid, heartbeats and guarding off, node-ID `id`.
  explicit FakeNode(unsigned node_id) : id(node_id) {
    set(0x1000, 0, 0x0002'0192, 4);
    for (unsigned sub = 1; sub <= 4; ++sub) set(0x1018, sub, 0x100 * sub + 7, 4);
    set(0x1005, 0, 0x80, 4);
    set(0x1006, 0, 0, 4);
    set(0x100C, 0, 0, 2);
    set(0x100D, 0, 0, 1);
    set(0x1016, 0, 2, 1);
    for (unsigned sub = 1; sub <= 2; ++sub) set(0x1016, sub, 0, 4);
    set(0x1017, 0, 0, 2);
    for (unsigned pdo = 0; pdo < 4; ++pdo) {
      set(0x1400 + pdo, 1, 0x8000'0200 + 0x100 * pdo + id, 4);
      set(0x1400 + pdo, 2, 255, 1);
      set(0x1600 + pdo, 0, 0, 1);
      set(0x1800 + pdo, 1, 0xC000'0180 + 0x100 * pdo + id, 4);
      set(0x1800 + pdo, 2, 255, 1);
      set(0x1800 + pdo, 3, 0, 2);
      set(0x1800 + pdo, 5, 0, 2);
      set(0x1A00 + pdo, 0, 0, 1);
      for (unsigned sub = 1; sub <= 8; ++sub) {
        set(0x1600 + pdo, sub, 0, 4);
        set(0x1A00 + pdo, sub, 0, 4);
      }
    }
  }

  void set(unsigned index, unsigned subindex, std::uint32_t value, std::size_t bytes) {
    auto& entry = entries[{index, subindex}];
    entry.clear();
    for (std::size_t i = 0; i < bytes; ++i) entry.push_back(static_cast<std::uint8_t>(value >> 8 * i));
  }
  [[nodiscard]] std::uint32_t value(unsigned index, unsigned subindex) const {
    std::uint32_t number = 0;
    const auto& entry = entries.at({index, subindex});
    for (std::size_t i = 0; i < entry.size(); ++i) number |= std::uint32_t{entry[i]} << 8 * i;
    return number;
  }

  unsigned id;
  std::map<Key, std::vector<std::uint8_t>> entries;
  std::map<Key, std::uint32_t> refuses;  ///< abort codes of downloads
  std::set<Key> forgets;                 ///< downloads that are accepted and not kept
  bool there = true;                     ///< has power
  bool boots = true;                     ///< sends a boot-up message after a reset
  bool mute = false;                     ///< does not answer SDOs
  bool guards = true;                    ///< answers remote frames
  bool deaf = false;                     ///< does not obey NMT commands but resets
  bool keeps_toggle = false;             ///< the toggle bit of guarding stands still
  unsigned state = 127;                  ///< NMT state
  unsigned answers = 1;                  ///< so many answers to each request
  nanoseconds delay = 300us;             ///< until an answer
  std::vector<std::string> writes;       ///< downloads: "1400:01=8000020A"

 private:
  friend class FakeBus;

  bool toggle_ = false;
  nanoseconds next_heartbeat_{0};
  nanoseconds ready_{0};  ///< the end of its start
};

/// A port to fake nodes, in virtual time.
class FakeBus final : public CanPort {
 public:
  explicit FakeBus(rt::VirtualClock& clock) : clock_(&clock) {}

  FakeNode& add(unsigned id) { return nodes.emplace_back(id); }
  /// A frame arrives at a time, whatever is sent.
  void arrives(nanoseconds time, const std::string& frame) { put(*candump::parse_frame(frame), time); }
  /// Power of a node; when it comes, its boot-up message does, and what was not stored is lost.
  void power(FakeNode& node, bool on) {
    node.there = on;
    if (on) boot(node, clock_->now());
  }

  [[nodiscard]] SendStatus send(const Frame& frame) noexcept override {
    if (status != SendStatus::kSent) return status;
    if (frame.kind == FrameKind::kRemote && !carries_remote) return SendStatus::kNotValid;
    sent.push_back(text_of(frame));
    if (lose_next > 0) {
      --lose_next;
      return SendStatus::kSent;
    }
    for (auto& node : nodes) take(node, frame);
    return SendStatus::kSent;
  }
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override {
    beat();
    const auto next = first();
    if (next == arriving_.end() || next->time > clock_->now()) return std::nullopt;
    const auto frame = *next;
    arriving_.erase(next);
    return frame;
  }
  bool wait_readable(nanoseconds deadline) noexcept override {
    const auto next = first();
    const bool readable = next != arriving_.end() && next->time <= deadline;
    clock_->sleep_until(readable ? next->time : deadline);
    return readable;
  }
  [[nodiscard]] PortStatistics statistics() const noexcept override {
    PortStatistics statistics;
    statistics.down = status == SendStatus::kDown;
    statistics.state = bus_state;
    return statistics;
  }

  std::deque<FakeNode> nodes;
  std::vector<std::string> sent;
  SendStatus status = SendStatus::kSent;
  BusState bus_state = BusState::kErrorActive;
  bool carries_remote = true;
  unsigned lose_next = 0;  ///< frames of the master that reach nobody

 private:
  void put(const Frame& frame, nanoseconds time) { arriving_.push_back({frame, time}); }
  void put(unsigned identifier, const std::vector<unsigned>& data, nanoseconds time) {
    std::vector<std::byte> bytes;
    for (const auto one : data) bytes.push_back(static_cast<std::byte>(one));
    put(Frame::of(identifier, bytes), time);
  }
  void boot(FakeNode& node, nanoseconds time) {
    node.state = 127;
    node.toggle_ = false;
    node.set(0x1017, 0, 0, 2);
    node.ready_ = time + 2ms;
    if (node.boots) put(0x700 + node.id, {0}, node.ready_);
  }
  /// Heartbeats that are due.
  void beat() {
    for (auto& node : nodes) {
      const auto period = std::chrono::milliseconds{node.value(0x1017, 0)};
      if (period.count() == 0 || !node.there) node.next_heartbeat_ = clock_->now() + period;
      if (period.count() == 0 || !node.there) continue;
      if (node.next_heartbeat_ + period < clock_->now()) node.next_heartbeat_ = clock_->now();
      for (; node.next_heartbeat_ <= clock_->now(); node.next_heartbeat_ += period) {
        put(0x700 + node.id, {node.state}, node.next_heartbeat_);
      }
    }
  }
  void take(FakeNode& node, const Frame& frame) {
    if (!node.there || clock_->now() < node.ready_) return;
    const auto identifier = frame.identifier.value;
    if (frame.kind == FrameKind::kRemote) {
      if (identifier != 0x700 + node.id || !node.guards) return;
      put(0x700 + node.id, {node.state | (node.toggle_ ? 0x80U : 0U)}, clock_->now() + node.delay);
      if (!node.keeps_toggle) node.toggle_ = !node.toggle_;
      return;
    }
    const auto byte = [&](std::size_t i) { return std::to_integer<unsigned>(frame.data[i]); };
    if (identifier == 0 && frame.length == 2 && (byte(1) == node.id || byte(1) == 0)) command(node, byte(0));
    const bool serves = (node.state == 127 || node.state == 5) && !node.mute;
    if (identifier == 0x600 + node.id && frame.length == 8 && serves) {
      for (unsigned i = 0; i < node.answers; ++i) serve(node, frame, clock_->now() + (i + 1) * node.delay);
    }
  }
  void command(FakeNode& node, unsigned command) {
    if (command == 0x81 || command == 0x82) return boot(node, clock_->now());
    if (node.deaf) return;
    if (command == 1) node.state = 5;
    if (command == 2) node.state = 4;
    if (command == 0x80) node.state = 127;
  }
  void serve(FakeNode& node, const Frame& frame, nanoseconds time) {
    const auto byte = [&](std::size_t i) { return std::to_integer<unsigned>(frame.data[i]); };
    const FakeNode::Key key{byte(1) | byte(2) << 8, byte(3)};
    const auto reply = [&](unsigned command, std::uint32_t number) {
      put(0x580 + node.id,
          {command, byte(1), byte(2), byte(3), number & 0xFF, number >> 8 & 0xFF, number >> 16 & 0xFF, number >> 24},
          time);
    };
    const auto entry = node.entries.find(key);
    if (byte(0) == 0x80 || (byte(0) & 0xE0) == 0x60) return;  // aborts and segments are not answered
    if (entry == node.entries.end()) return reply(0x80, 0x0602'0000);
    const auto size = static_cast<unsigned>(entry->second.size());
    if (byte(0) == 0x40) {
      if (size <= 4) return reply(0x43 | (4 - size) << 2, node.value(key.first, key.second));
      return reply(0x41, size);  // and never a segment
    }
    if ((byte(0) & 0xE3) != 0x23) return reply(0x80, 0x0504'0001);
    if (node.refuses.count(key) != 0) return reply(0x80, node.refuses.at(key));
    const unsigned length = 4 - (byte(0) >> 2 & 3);
    if (length != size) return reply(0x80, 0x0607'0010);
    std::uint32_t value = 0;
    for (unsigned i = 0; i < length; ++i) value |= byte(4 + i) << 8 * i;
    if (!node.forgets.count(key)) node.set(key.first, key.second, value, length);
    char line[32];
    std::snprintf(line, sizeof(line), "%04X:%02X=%X", key.first, key.second, value);
    node.writes.emplace_back(line);
    reply(0x60, 0);
  }
  [[nodiscard]] std::vector<ReceivedFrame>::iterator first() {
    return std::min_element(arriving_.begin(), arriving_.end(),
                            [](const ReceivedFrame& a, const ReceivedFrame& b) { return a.time < b.time; });
  }

  rt::VirtualClock* clock_;
  std::vector<ReceivedFrame> arriving_;
};

/// A line of fake nodes and what its master does with them, without a cycle.
class FakeLine : public ::testing::Test {
 protected:
  /// The plan of a drive with a setpoint and an actual value, and heartbeats both ways.
  static NodePlan drive(std::uint8_t id) {
    NodePlan node;
    node.name = "drive " + std::to_string(id);
    node.id = id;
    node.rpdos.push_back({.number = 2, .objects = {{0x60C1, 1, 32}}});
    node.tpdos.push_back({.objects = {{0x6041, 0, 16}, {0x6064, 0, 32}}});
    node.error_control.heartbeat = 100ms;
    node.error_control.tolerance = 250ms;
    node.error_control.master_tolerance = 70ms;
    node.timeouts = {50ms, 300ms, 200ms};
    return node;
  }

  /// Nodes of the plan without fakes are added as good ones.
  void begin() {
    for (const auto& node : plan.nodes) {
      if (!std::any_of(bus.nodes.begin(), bus.nodes.end(), [&](auto& one) { return one.id == node.id; }))
        bus.add(node.id);
    }
    line.emplace(plan, SupervisorSettings{true, 400ms});
  }
  void pass(nanoseconds duration) {
    const auto end = clock.now() + duration;
    while (clock.now() < end) {
      line->pump(bus, clock.now());
      for (auto& event : line->take_events()) events.push_back(event);
      static_cast<void>(bus.wait_readable(std::min(end, clock.now() + 1ms)));
    }
    line->pump(bus, clock.now());
    for (auto& event : line->take_events()) events.push_back(event);
  }
  /// Boots all nodes; the errors of those that failed.
  NodeErrors boot() {
    begin();
    line->boot(clock.now());
    NodeErrors errors;
    for (int i = 0; i < 10'000 && !line->all([](auto& node) { return node.settled(); }); ++i) pass(1ms);
    for (std::size_t i = 0; i < line->size(); ++i) {
      if (const auto& error = line->node(i).view().error) errors.push_back(*error);
    }
    return errors;
  }
  /// Boots and starts all nodes.
  void operate() {
    ASSERT_THAT(boot(), ::testing::IsEmpty());
    line->watch(clock.now());
    line->start(clock.now());
    pass(250ms);
    ASSERT_TRUE(line->all([](auto& node) { return node.operational(); }));
    events.clear();
    bus.sent.clear();
  }
  [[nodiscard]] const NodeView& view(std::size_t node) const { return line->node(node).view(); }
  [[nodiscard]] std::vector<MasterEvent::Kind> kinds() const {
    std::vector<MasterEvent::Kind> out;
    for (const auto& event : events) out.push_back(event.kind);
    return out;
  }

  rt::VirtualClock clock{1s};
  FakeBus bus{clock};
  MasterPlan plan{.period = 2ms, .master_id = 126, .master_heartbeat = 20ms, .nodes = {drive(10)}};
  std::optional<NodeLine> line;
  std::vector<MasterEvent> events;
};

}  // namespace driveline::canopen
