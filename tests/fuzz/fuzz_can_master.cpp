// A stream of frames into the master of a CANopen line, beside those of a good device. Input: see can_frames.hpp.

#include <cstdlib>
#include <deque>

#include "can_frames.hpp"
#include "driveline/canopen_master/node_line.hpp"
#include "driveline/slaves/can/bus.hpp"
#include "support/canopen_sample.hpp"

namespace driveline::fuzz {
namespace {

using namespace canopen;
using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr std::uint8_t kNode = 5;
constexpr std::size_t kMostMasterFrames = 400;

/// The bus as its master sees it: what the device sends, and what the input has.
class StreamPort final : public CanPort, private slaves::can::Node {
 public:
  explicit StreamPort(slaves::can::Bus& bus) : bus_(&bus) { bus.attach(*this, {.automatic_recovery = true}); }

  void arrives(const Frame& frame) { received_.push_back({frame, bus_->now()}); }

  [[nodiscard]] SendStatus send(const Frame& frame) noexcept override {
    if (!frame.valid()) std::abort();  // the master sends what is possible on a bus
    return controller_->send(frame) ? SendStatus::kSent : SendStatus::kBusy;
  }
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override {
    if (received_.empty()) return std::nullopt;
    const auto frame = received_.front();
    received_.pop_front();
    return frame;
  }
  bool wait_readable(nanoseconds /*deadline*/) noexcept override { return !received_.empty(); }
  [[nodiscard]] PortStatistics statistics() const noexcept override { return {}; }

 private:
  void connected(slaves::can::Controller& controller) override { controller_ = &controller; }
  void receive(const Frame& frame, nanoseconds now) override { received_.push_back({frame, now}); }
  void advance(nanoseconds /*now*/) override {}
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return slaves::can::kNever; }

  slaves::can::Bus* bus_;
  slaves::can::Controller* controller_ = nullptr;
  std::deque<ReceivedFrame> received_;
};

MasterPlan plan_of_one() {
  MasterPlan plan;
  plan.master_id = 126;
  plan.master_heartbeat = 20ms;
  NodePlan node;
  node.name = "device";
  node.id = kNode;
  node.rpdos.push_back({.objects = {{0x2000, 0, 16}}});
  node.tpdos.push_back({.objects = {{0x2002, 0, 32}}});
  node.error_control.heartbeat = 20ms;
  node.timeouts = {30ms, 60ms, 60ms};
  plan.nodes.push_back(node);
  return plan;
}

/// A line that is operated by its master.
class OperatedLine {
 public:
  OperatedLine() {
    bus_.attach(device_);
    pass(5ms);
    line_.boot(bus_.now());
    pass(100ms);
    line_.watch(bus_.now());
    line_.start(bus_.now());
  }
  void pass(nanoseconds time) {
    const auto end = bus_.now() + time;
    do {
      bus_.advance(std::min(end, bus_.now() + 1ms));
      line_.pump(port_, bus_.now());
    } while (bus_.now() < end);
    static_cast<void>(line_.take_events());
  }
  void arrives(const Frame& frame) { port_.arrives(frame); }
  [[nodiscard]] bool operational() const { return line_.node(0).operational(); }
  [[nodiscard]] bool started() const { return device_.state() == NmtState::kOperational; }

 private:
  slaves::can::Bus bus_;
  slaves::ObjectDictionary dictionary_{slaves::cia301::sample_table()};
  slaves::cia301::SampleApplication application_;
  slaves::cia301::Device device_{dictionary_, application_, {}};
  StreamPort port_{bus_};
  NodeLine line_{plan_of_one(), {true, 50ms}};
};

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  OperatedLine line;
  for (std::size_t i = 0; i < kMostMasterFrames && input.size() >= 3; ++i) {
    line.arrives(take_frame(input));
    line.pass(take_time(input));
  }
  // Whatever has come, the line is in operation again soon after.
  line.pass(3s);
  if (!line.operational() || !line.started()) std::abort();
}

std::vector<Bytes> seeds() {
  Bytes states;
  append(states, 0x705, "00", 1);
  append(states, 0x705, "05", 20);
  append(states, 0x705, "7F", 20);
  append(states, 0x705, "85", 20);
  append(states, 0x085, "10 23 05 00 00 00 00 00", 5);
  append(states, 0x085, "00 00 00 00 00 00 00 00", 5);
  append(states, 0x000, "02 05", 5);
  append(states, 0x080, "", 5);
  append(states, 0x77E, "05", 5);
  Bytes answers;
  append(answers, 0x705, "00", 1);
  append(answers, 0x585, "43 00 10 00 92 01 02 00", 1);
  append(answers, 0x585, "41 18 10 01 FF FF FF 7F", 1);
  append(answers, 0x585, "00 11 22 33 44 55 66 77", 1);
  append(answers, 0x585, "4F 00 1A 00 40 00 00 00", 1);
  append(answers, 0x585, "80 00 1A 00 02 00 01 06", 1);
  append(answers, 0x585, "60 17 10 00 00 00 00 00", 1);
  return {states, answers};
}

}  // namespace driveline::fuzz
