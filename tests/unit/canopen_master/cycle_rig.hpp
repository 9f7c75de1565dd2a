#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "driveline/canopen_master/can_cycle.hpp"
#include "driveline/canopen_wire/candump.hpp"
#include "support/bytes.hpp"
#include "support/must.hpp"

namespace driveline::canopen::cycle_test {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

/// Frames in candump's notation.
inline std::string text_of(const Frame& frame) {
  const auto line = candump::line_of(frame, "", 0);
  return std::string(line.view().substr(line.view().rfind(' ') + 1));
}

/// A port of memory: keeps what is sent, and delivers frames at their time.
class MemoryPort final : public CanPort {
 public:
  explicit MemoryPort(rt::Clock& clock) : clock_(&clock) {}

  /// A frame is there from `time` on.
  void arrives(nanoseconds time, const std::string& frame) {
    arriving_.push_back({*candump::parse_frame(frame), time});
  }
  /// What was sent since the last call.
  std::vector<std::string> take_sent() { return std::exchange(sent, {}); }

  [[nodiscard]] SendStatus send(const Frame& frame) noexcept override {
    const auto found = refusals.find(frame.identifier.value);
    if (found != refusals.end()) return found->second;
    sent.push_back(text_of(frame));
    ++counters.sent;
    return SendStatus::kSent;
  }
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override {
    if (arriving_.empty() || arriving_.front().time > clock_->now()) return std::nullopt;
    const auto frame = arriving_.front();
    arriving_.pop_front();
    return frame;
  }
  bool wait_readable(nanoseconds /*deadline*/) noexcept override { return !arriving_.empty(); }
  [[nodiscard]] PortStatistics statistics() const noexcept override { return counters; }

  std::vector<std::string> sent;
  std::map<std::uint32_t, SendStatus> refusals;  ///< by identifier
  PortStatistics counters;

 private:
  rt::Clock* clock_;
  std::deque<ReceivedFrame> arriving_;
};

/// Writes what it is told, and remembers what it was given.
class ToldMotion final : public motion::MotionControl {
 public:
  /// What a call was given.
  struct Call {
    std::string what;
    std::int64_t cycle = 0;
    std::int64_t missed = 0;
  };

  void read_inputs(std::span<const std::byte> image, std::span<const bool> now_valid, std::span<const bool> operational,
                   std::span<const bool> /*fresh*/, nanoseconds took, nanoseconds late) noexcept override {
    inputs.assign(image.begin(), image.end());
    valid.assign(now_valid.begin(), now_valid.end());
    supplied.assign(operational.begin(), operational.end());
    last_took = took;
    last_late = late;
    calls.push_back({"read"});
  }
  void update(std::int64_t cycle, std::span<std::byte> image) noexcept override {
    calls.push_back({"update", cycle});
    write(image);
  }
  motion::AbsenceEffect resume(std::int64_t cycle, std::int64_t missed, std::span<std::byte> image) noexcept override {
    calls.push_back({"resume", cycle, missed});
    if (resumed) std::copy(resumed->begin(), resumed->end(), image.begin());
    return motion::AbsenceEffect::kBridged;
  }
  [[nodiscard]] nanoseconds path_late() const noexcept override { return 7ms; }
  [[nodiscard]] bool failed() const noexcept override { return false; }
  [[nodiscard]] std::span<const motion::Axis> axes() const noexcept override { return {}; }
  [[nodiscard]] std::span<const trajectory::AxisSetpoint> setpoints() const noexcept override { return {}; }

  std::vector<std::byte> outputs;  ///< written by update(); empty: nothing
  std::optional<std::vector<std::byte>> resumed;
  std::vector<std::byte> inputs;
  std::vector<bool> valid;
  std::vector<bool> supplied;  ///< have taken their outputs
  nanoseconds last_took{};
  nanoseconds last_late{};
  std::vector<Call> calls;

 private:
  void write(std::span<std::byte> image) const {
    if (!outputs.empty()) std::copy(outputs.begin(), outputs.end(), image.begin());
  }
};

/// The standard PDOs of an axis on CAN.
inline NodePlan axis_node(const std::string& name, std::uint8_t id) {
  NodePlan node;
  node.name = name;
  node.id = id;
  node.rpdos = {{.number = 1,
                 .transmission = 255,
                 .exchange = PdoExchange::kOnChange,
                 .objects = {{0x6040, 0, 16}, {0x6060, 0, 8}}},
                {.number = 2, .objects = {{0x60C1, 1, 32}}}};
  node.tpdos = {{.number = 1, .objects = {{0x6041, 0, 16}, {0x6064, 0, 32}}},
                {.number = 2,
                 .transmission = 255,
                 .exchange = PdoExchange::kOnChange,
                 .objects = {{0x6061, 0, 8}, {0x603F, 0, 16}}}};
  return node;
}

/// A line of `axes` such nodes, 3, 4, ..., at 2 ms.
inline MasterPlan axes_plan(unsigned axes) {
  MasterPlan plan;
  for (unsigned i = 0; i < axes; ++i) {
    plan.nodes.push_back(axis_node("axis" + std::to_string(i), static_cast<std::uint8_t>(3 + i)));
  }
  return plan;
}

/// A cycle of two axes, 3 and 4, whose runner is the test.
class CycleRig {
 public:
  static constexpr nanoseconds kFirst = 10ms;

  explicit CycleRig(const MasterPlan& plan = axes_plan(2), CanCycle::Settings settings = {},
                    motion::SampleRings rings = {})
      : period(plan.period),
        cycle(port, clock, plan, *must(PdoImage::build(plan)), channel, &motion, rings, std::move(settings)) {
    for (std::size_t node = 0; node < plan.nodes.size(); ++node) cycle.set_operational(node, true);
  }

  [[nodiscard]] nanoseconds grid(std::int64_t instant) const { return kFirst + instant * period; }
  /// Runs the next cycle, `late` after its instant, behind so many skipped ones. Returns what was sent.
  std::vector<std::string> step(nanoseconds late = {}, std::int64_t missed = 0) {
    number += 1 + missed;
    clock.sleep_until(grid(number) + late);
    port.take_sent();
    cycle.cycle({number, grid(number), grid(number) + late, missed});
    return port.take_sent();
  }
  /// The work before the next cycle, `ahead` of it.
  void prepare(nanoseconds ahead) {
    clock.sleep_until(grid(number + 1) - ahead);
    cycle.prepare();
  }
  /// A frame comes this long after the last cycle.
  void comes(nanoseconds after, const std::string& frame) { port.arrives(grid(number) + after, frame); }
  /// The answers of both axes to the last SYNC.
  void both_answer() {
    comes(300us, "183#270000010000");
    comes(420us, "184#270000020000");
  }

  rt::VirtualClock clock;
  MemoryPort port{clock};
  AcyclicChannel channel{16, 16};
  ToldMotion motion;
  nanoseconds period;
  CanCycle cycle;
  std::int64_t number = -1;
};

}  // namespace driveline::canopen::cycle_test
