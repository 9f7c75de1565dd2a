#include "driveline/runtime/can_line/simulated_can_port.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "driveline/slaves/can/bus.hpp"

namespace driveline::runtime {
namespace {

using canopen::BusState;
using canopen::Frame;
using canopen::ReceivedFrame;
using canopen::SendStatus;
using std::chrono::nanoseconds;

std::uint8_t counter_byte(unsigned count) noexcept {
  return static_cast<std::uint8_t>(std::min(count, 255U));
}

BusState bus_state(const slaves::can::ErrorCounters& errors) noexcept {
  switch (errors.state()) {
    case slaves::can::ErrorState::kBusOff:
      return BusState::kBusOff;
    case slaves::can::ErrorState::kPassive:
      return BusState::kErrorPassive;
    case slaves::can::ErrorState::kActive:
      break;
  }
  return errors.warning() ? BusState::kErrorWarning : BusState::kErrorActive;
}

}  // namespace

/// The node on the bus, with the frames that wait for receive().
class SimulatedCanPort::Adapter final : public slaves::can::Node {
 public:
  /// `start`: time 0 of the bus on the port's clock.
  explicit Adapter(nanoseconds start) : start_(start), frames_(kQueueFrames) {}

  void connected(slaves::can::Controller& controller) override { controller_ = &controller; }
  void receive(const Frame& frame, nanoseconds now) override {
    if (count_ == frames_.size()) {
      ++counters.lost;
      return;
    }
    frames_[(first_ + count_++) % frames_.size()] = {frame, start_ + now};
  }
  void advance(nanoseconds /*now*/) override {}
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return slaves::can::kNever; }

  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  /// Precondition: not empty.
  [[nodiscard]] ReceivedFrame pop() noexcept {
    const ReceivedFrame frame = frames_[first_];
    first_ = (first_ + 1) % frames_.size();
    --count_;
    return frame;
  }
  [[nodiscard]] slaves::can::Controller& controller() noexcept { return *controller_; }

  canopen::PortStatistics counters;

 private:
  slaves::can::Controller* controller_ = nullptr;
  nanoseconds start_;
  std::vector<ReceivedFrame> frames_;  ///< a ring
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

SimulatedCanPort::SimulatedCanPort(const CanLineConfig& config, const canopen::CanPortOptions& options,
                                   rt::Clock& clock)
    : line_(config), clock_(&clock), start_(clock.now()), adapter_(std::make_unique<Adapter>(start_)) {
  slaves::can::ControllerOptions controller;
  controller.bit_rate = config.bit_rate;
  controller.listen_only = options.listen_only;
  controller.error_frames = options.error_frames;
  controller.automatic_recovery = options.automatic_recovery;
  line_.bus().attach(*adapter_, controller);
}

SimulatedCanPort::~SimulatedCanPort() = default;

/// A cycle calls the port many times at the same instant of a virtual clock: only the first call finds work.
void SimulatedCanPort::advance() {
  const nanoseconds now = clock_->now() - start_;
  if (settled_at_ != now) advance_line(now);
  if (calls_.serve(line_)) settled_at_.reset();
}

void SimulatedCanPort::advance_line(nanoseconds now) {
  line_.advance(now);
  settled_at_ = now;
}

SendStatus SimulatedCanPort::send(const Frame& frame) noexcept {
  auto& controller = adapter_->controller();
  if (!frame.valid() || controller.options().listen_only) return SendStatus::kNotValid;
  advance();
  if (controller.errors().state() == slaves::can::ErrorState::kBusOff) return SendStatus::kDown;
  if (!controller.send(frame)) return SendStatus::kBusy;
  ++adapter_->counters.sent;
  line_.transmit();  // the frame is on the wire from now on
  return SendStatus::kSent;
}

std::optional<ReceivedFrame> SimulatedCanPort::receive() noexcept {
  advance();
  if (adapter_->empty()) return std::nullopt;
  const ReceivedFrame frame = adapter_->pop();
  ++adapter_->counters.received;
  if (frame.frame.kind == canopen::FrameKind::kError) ++adapter_->counters.error_frames;
  return frame;
}

bool SimulatedCanPort::wait_readable(nanoseconds deadline) noexcept {
  while (true) {
    settled_at_.reset();  // the next event may be now
    advance();
    if (!adapter_->empty()) return true;
    if (clock_->now() >= deadline) return false;
    const nanoseconds event = line_.next_event();
    clock_->sleep_until(event == slaves::can::kNever ? deadline : std::min(deadline, start_ + event));
  }
}

canopen::PortStatistics SimulatedCanPort::statistics() const noexcept {
  canopen::PortStatistics statistics = adapter_->counters;
  const auto& errors = adapter_->controller().errors();
  statistics.state = bus_state(errors);
  statistics.send_errors = counter_byte(errors.transmit());
  statistics.receive_errors = counter_byte(errors.receive());
  return statistics;
}

std::unique_ptr<SimulatedCanPort> open_simulated_can_port(const CanLineConfig& config,
                                                          const canopen::CanPortOptions& options, rt::Clock& clock) {
  return std::make_unique<SimulatedCanPort>(config, options, clock);
}

}  // namespace driveline::runtime
