// A stream of frames into a whole CANopen master, among those of a drive that behaves: while it boots the line, while
// the cycle runs, and while it is shut down. Input: see can_frames.hpp. Only the master gets these frames, so that the
// drive must be there for the next one.

#include <algorithm>
#include <cstdlib>
#include <deque>
#include <memory>
#include <string_view>

#include "can_frames.hpp"
#include "driveline/canopen_master/can_master.hpp"
#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/msd/can/msd_can_drive.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {
namespace {

using canopen::CanCycle;
using canopen::CanMaster;
using canopen::Frame;
using canopen::MasterPlan;
using canopen::NodePlan;
using canopen::PdoExchange;
using canopen::ReceivedFrame;
using std::chrono::nanoseconds;
using namespace std::chrono_literals;

constexpr std::uint8_t kNode = 5;
constexpr std::size_t kMostFrames = 500;
constexpr nanoseconds kOperation = 400ms;  ///< of the cycle
constexpr nanoseconds kLongest = 60s;      ///< of a whole run

/// The port of a master to a simulated bus on virtual time, which also receives frames that nobody has sent.
class LyingPort final : public canopen::CanPort, private slaves::can::Node {
 public:
  LyingPort(slaves::can::Bus& bus, rt::VirtualClock& clock) : bus_(&bus), clock_(&clock) { bus.attach(*this); }

  /// Frames that arrive beside those of the bus, in the order of their times.
  void lie(std::deque<ReceivedFrame> frames) { lies_ = std::move(frames); }

  [[nodiscard]] canopen::SendStatus send(const Frame& frame) noexcept override {
    advance_bus();
    return controller_->send(frame) ? canopen::SendStatus::kSent : canopen::SendStatus::kBusy;
  }
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override {
    advance_bus();
    if (received_.empty()) return std::nullopt;
    const auto frame = received_.front();
    received_.pop_front();
    return frame;
  }
  bool wait_readable(nanoseconds deadline) noexcept override {
    while (received_.empty() && clock_->now() < deadline) {
      clock_->sleep_until(std::min({deadline, bus_->next_event(), next_lie()}));
      advance_bus();
    }
    return !received_.empty();
  }
  [[nodiscard]] canopen::PortStatistics statistics() const noexcept override { return {}; }

 private:
  void connected(slaves::can::Controller& controller) override { controller_ = &controller; }
  void receive(const Frame& frame, nanoseconds now) override { received_.push_back({frame, now}); }
  void advance(nanoseconds /*now*/) override {}
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return slaves::can::kNever; }

  [[nodiscard]] nanoseconds next_lie() const noexcept {
    return lies_.empty() ? nanoseconds::max() : lies_.front().time;
  }
  void advance_bus() {
    for (; next_lie() <= clock_->now(); lies_.pop_front()) {
      bus_->advance(lies_.front().time);
      received_.push_back(lies_.front());
    }
    bus_->advance(clock_->now());
  }

  slaves::can::Bus* bus_;
  rt::VirtualClock* clock_;
  slaves::can::Controller* controller_ = nullptr;
  std::deque<ReceivedFrame> lies_;
  std::deque<ReceivedFrame> received_;
};

/// An MSD with the standard PDOs of an axis.
MasterPlan plan_of_an_axis() {
  NodePlan node;
  node.name = "x";
  node.id = kNode;
  node.error_control.heartbeat = 50ms;
  node.timeouts = {20ms, 200ms, 200ms};
  node.startup_sdos = {};
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
  MasterPlan plan;
  plan.period = 4ms;
  plan.master_heartbeat = 50ms;
  plan.nodes = {node};
  return plan;
}

/// The frames of an input, from `begin` on.
std::deque<ReceivedFrame> lies_of(std::span<const std::byte> input, nanoseconds begin) {
  std::deque<ReceivedFrame> lies;
  for (nanoseconds time = begin; lies.size() < kMostFrames && input.size() >= 3;) {
    const auto frame = take_frame(input);
    time += take_time(input);
    lies.push_back({frame, time});
  }
  return lies;
}

/// One life of a master; whether the line was in operation without an error.
bool operate(LyingPort& port, rt::VirtualClock& clock, nanoseconds duration) {
  CanMaster::Settings settings;
  settings.listen = 10ms;
  settings.retry_pause = 50ms;
  settings.first_pdos = 100ms;
  CanMaster master(port, clock, plan_of_an_axis(), settings);
  const auto told = [](const canopen::NodeErrors& errors) {
    for (const auto& error : errors) {
      if (canopen::describe(error, "x").empty()) std::abort();
    }
    return errors.empty();
  };
  const auto booted = master.boot();
  static_cast<void>(told(master.take_notes()));
  if (!booted) return told(booted.error());
  const auto started = master.start_cycle(
      nullptr, {}, {}, [&](CanCycle& cycle) { return std::make_unique<motion::InlineRunner>(cycle, clock); });
  if (!started) std::abort();
  const auto operational = master.go_operational();
  if (!operational) static_cast<void>(told(operational.error()));
  for (const auto end = clock.now() + duration; clock.now() < end;) {
    master.pass(10ms);
    while (const auto event = master.take_event()) {
      if (canopen::describe(*event, "x").empty()) std::abort();
    }
  }
  const bool good = operational && master.all_operational();
  static_cast<void>(master.shut_down());
  return good;
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  rt::VirtualClock clock;
  slaves::can::Bus bus;
  slaves::msd::MsdCanDrive drive({}, slaves::msd::CanConnection{slaves::msd::DipSwitch{kNode}, {}, 500us});
  bus.attach(drive.device());
  LyingPort port(bus, clock);
  clock.advance(20ms);
  const auto begin = clock.now();
  port.lie(lies_of(input, begin));
  static_cast<void>(operate(port, clock, kOperation));
  if (clock.now() - begin > kLongest) std::abort();
  // What has come lies behind; the drive is as it was.
  port.lie({});
  while (port.receive()) {
  }
  if (!operate(port, clock, 50ms)) std::abort();
}

std::vector<Bytes> seeds() {
  Bytes transfers;  // other answers to the questions of a boot
  append(transfers, 0x705, "05", 200);
  append(transfers, 0x705, "00", 1);
  append(transfers, 0x585, "43 00 10 00 92 01 02 00", 1);
  append(transfers, 0x585, "80 18 10 01 00 00 02 06", 1);
  append(transfers, 0x585, "41 18 10 02 00 00 00 80", 1);
  append(transfers, 0x585, "60 00 14 01 00 00 00 00", 1);
  append(transfers, 0x585, "10 00 00 00 00 00 00 00", 1);
  append(transfers, 0x085, "00 FF 11 0C 05 00 00 00", 1);
  append(transfers, 0x705, "04", 1);
  Bytes others;  // another master, and a node that is not planned
  append(others, 0x000, "01 00", 1);
  append(others, 0x080, "", 1);
  append(others, 0x77F, "05", 1);
  append(others, 0x305, "00 00 00 00", 1);
  append(others, 0x709, "00", 1);
  append(others, 0x8705, "", 1);
  Bytes operation;  // in the cycle
  for (int i = 0; i < 8; ++i) append(operation, 0x705, "05", 250);
  append(operation, 0x185, "37 02 10", 3);
  append(operation, 0x185, "37 02 10 00 00 00 00 00", 3);
  append(operation, 0x285, "07 10 86", 3);
  append(operation, 0x4185, "37 02 10 00 00 00", 3);
  append(operation, 0x8185, "", 3);
  append(operation, 0x705, "7F", 3);
  append(operation, 0x705, "00", 3);
  append(operation, 0x085, "00 00 00 00 00 00 00 00", 3);
  append(operation, 0x085, "10 86 21", 3);
  append(operation, 0x000, "81 05", 3);
  return {transfers, others, operation};
}

}  // namespace driveline::fuzz
