// Ports to a simulated CAN line: in this process, and through the entrances that other programs use.
#include <gmock/gmock.h>

#include <atomic>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "driveline/canopen_port/open_can_port.hpp"
#include "driveline/canopen_wire/frame_meter.hpp"
#include "driveline/runtime/can_line/can_line.hpp"
#include "driveline/runtime/can_line/can_server.hpp"
#include "driveline/runtime/can_line/simulated_can_port.hpp"
#include "driveline/slaves/can/frame_fault.hpp"
#include "support/bytes.hpp"
#include "support/must.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::runtime {
namespace {

using bytes_test::hex;
using canopen::BusState;
using canopen::Frame;
using canopen::SendStatus;
using std::chrono::nanoseconds;
using namespace std::chrono_literals;

constexpr std::string_view kLine = R"([bus]
type = "can"
bit_rate = 1000000
[[slave]]
name = "x"
node = 5
)";

CanLineConfig two_drives() {
  return must(parse_can_line_config(std::string(kLine) + "[[slave]]\nname = \"y\"\nnode = 6\n", "line.toml")).value();
}

/// Receives until a frame with this identifier has come, or until the deadline.
std::optional<canopen::ReceivedFrame> find(canopen::CanPort& port, std::uint32_t identifier, nanoseconds deadline) {
  while (port.wait_readable(deadline)) {
    const auto received = port.receive();
    if (received && received->frame.identifier.value == identifier) return received;
  }
  return std::nullopt;
}

/// A frame that must come within `patience`.
canopen::ReceivedFrame await(canopen::CanPort& port, rt::Clock& clock, std::uint32_t identifier, nanoseconds patience) {
  return must(find(port, identifier, clock.now() + patience)).value();
}

/// Sends a request until it is answered: a drive that still starts does not hear it.
canopen::ReceivedFrame ask(canopen::CanPort& port, rt::Clock& clock, const Frame& request, std::uint32_t identifier) {
  for (int i = 0; i < 300; ++i) {
    EXPECT_EQ(port.send(request), SendStatus::kSent);
    if (const auto answer = find(port, identifier, clock.now() + 200ms)) return *answer;
  }
  throw std::runtime_error("no answer");
}

const Frame kReadDeviceType = Frame::of(0x605, hex("40 00 10 00 00 00 00 00"));

// CiA 301: boot-up 700h + node, SDO 600h and 580h + node; 43h is an expedited answer of four bytes.
TEST(SimulatedCanPortTest, DrivesBootAndAnswerOnAVirtualClock) {
  rt::VirtualClock clock{7s};
  const auto port = open_simulated_can_port(two_drives(), {}, clock);
  await(*port, clock, 0x705, 10s);
  await(*port, clock, 0x706, 10s);
  const nanoseconds asked = clock.now();
  EXPECT_EQ(port->send(kReadDeviceType), SendStatus::kSent);
  const auto answer = await(*port, clock, 0x585, 1s);
  EXPECT_EQ(answer.frame.data[0], std::byte{0x43});
  EXPECT_GT(answer.time, asked);
  EXPECT_EQ(answer.time, clock.now());  // the clock has been moved to the event
  EXPECT_EQ(port->statistics().state, BusState::kErrorActive);
}

TEST(SimulatedCanPortTest, ItsOwnFramesDoNotArriveAndADeadlineMovesTheClock) {
  rt::VirtualClock clock;
  const auto port = open_simulated_can_port(two_drives(), {}, clock);
  await(*port, clock, 0x706, 10s);
  while (port->receive()) {
  }
  EXPECT_EQ(port->send(Frame::of(0x7FF, {})), SendStatus::kSent);
  const nanoseconds deadline = clock.now() + 5ms;
  EXPECT_FALSE(port->wait_readable(deadline));
  EXPECT_EQ(clock.now(), deadline);
  EXPECT_FALSE(port->receive());
}

TEST(SimulatedCanPortTest, FramesThatAreNotPossibleAreNotSent) {
  rt::VirtualClock clock;
  const auto port = open_simulated_can_port(two_drives(), {}, clock);
  EXPECT_EQ(port->send(Frame::of(0x800, {})), SendStatus::kNotValid);
  const auto listener = open_simulated_can_port(two_drives(), {.listen_only = true}, clock);
  EXPECT_EQ(listener->send(Frame::of(0x100, {})), SendStatus::kNotValid);
}

/// Notes the order of the frames on the bus.
class Listener final : public slaves::can::Node {
 public:
  void connected(slaves::can::Controller& /*controller*/) override {}
  void receive(const Frame& frame, nanoseconds now) override { heard.emplace_back(frame.identifier.value, now); }
  void advance(nanoseconds /*now*/) override {}
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return slaves::can::kNever; }
  std::vector<std::pair<std::uint32_t, nanoseconds>> heard;
};

// The first one finds the wire free; the lowest identifier among the waiting frames wins.
TEST(SimulatedCanPortTest, AFrameStartsAtOnceWhileTheClockStandsStill) {
  rt::VirtualClock clock;
  const auto port = open_simulated_can_port(two_drives(), {}, clock);
  Listener listener;
  port->line().bus().attach(listener);
  await(*port, clock, 0x706, 10s);
  while (port->receive()) {
  }
  clock.advance(3ms);
  EXPECT_FALSE(port->receive());
  listener.heard.clear();
  const nanoseconds sent = clock.now();
  for (const auto identifier : {0x7A3U, 0x7A2U, 0x7A1U}) {
    EXPECT_EQ(port->send(Frame::of(identifier, {})), SendStatus::kSent);
  }
  EXPECT_FALSE(port->receive());
  clock.advance(1ms);
  EXPECT_FALSE(port->receive());
  ASSERT_EQ(listener.heard.size(), 3U);
  EXPECT_EQ(listener.heard[0].first, 0x7A3U);
  EXPECT_EQ(listener.heard[1].first, 0x7A1U);
  EXPECT_EQ(listener.heard[2].first, 0x7A2U);
  // The bits of the frame up to the interframe space, at 1 Mbit/s.
  EXPECT_EQ(listener.heard[0].second, sent + (canopen::bit_count(Frame::of(0x7A3, {})) - 3) * 1us);
}

TEST(SimulatedCanPortTest, WhatOthersDoToTheLineCountsWhileTheClockStandsStill) {
  rt::VirtualClock clock;
  const auto port = open_simulated_can_port(two_drives(), {}, clock);
  await(*port, clock, 0x706, 10s);
  while (port->receive()) {
  }
  port->line().device(1).restart();
  EXPECT_FALSE(port->receive());
  const auto boot_up = find(*port, 0x706, clock.now() + 10s);
  ASSERT_TRUE(boot_up);
  // The same by a call of another thread, which the port makes.
  std::thread other([&] { EXPECT_TRUE(port->calls().make([](CanLine& line) { line.device(0).restart(); }, 10s)); });
  while (!find(*port, 0x705, clock.now() + 1ms)) {
  }
  other.join();
}

TEST(SimulatedCanPortTest, AFullQueueIsBusyUntilTheBusHasTakenAFrame) {
  rt::VirtualClock clock;
  const auto port = open_simulated_can_port(two_drives(), {}, clock);
  unsigned sent = 0;
  while (port->send(Frame::of(0x100, {})) == SendStatus::kSent && sent < 1000) ++sent;
  EXPECT_EQ(port->send(Frame::of(0x100, {})), SendStatus::kBusy);
  EXPECT_EQ(port->statistics().sent, sent);
  clock.advance(1ms);
  EXPECT_EQ(port->send(Frame::of(0x100, {})), SendStatus::kSent);
}

TEST(SimulatedCanPortTest, ErrorFramesAreReportedWhenAskedFor) {
  rt::VirtualClock clock;
  const auto port = open_simulated_can_port(two_drives(), {.error_frames = true}, clock);
  await(*port, clock, 0x706, 10s);
  slaves::can::FrameFault fault;
  fault.kind = slaves::can::FrameFaultKind::kBitError;
  port->line().bus().inject(fault);
  EXPECT_EQ(port->send(kReadDeviceType), SendStatus::kSent);
  await(*port, clock, 0x585, 1s);
  EXPECT_EQ(port->statistics().error_frames, 1U);
}

/// A line that is served by a thread of its own until the object ends.
class ServedLine {
 public:
  explicit ServedLine(const CanEntrances& entrances)
      : config_(two_drives()), line_(config_), server_(must(CanServer::open(line_, "can0", entrances, clock)).value()) {
    places = server_->places();
    thread_ = std::thread([this] {
      while (!stopping_) server_->turn(1ms);
    });
  }
  ~ServedLine() {
    stopping_ = true;
    thread_.join();
  }
  ServedLine(const ServedLine&) = delete;
  ServedLine& operator=(const ServedLine&) = delete;

  /// "127.0.0.1:1234" of the first entrance.
  [[nodiscard]] std::string address() const { return places.front().substr(places.front().rfind(' ') + 1); }

  rt::MonotonicClock clock;
  std::vector<std::string> places;

 private:
  CanLineConfig config_;
  CanLine line_;
  std::unique_ptr<CanServer> server_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

/// Two exchanges: data with an answer, and NMT with the boot-up message of a drive.
void exchange(std::string_view text, rt::Clock& clock) {
  const std::unique_ptr<canopen::CanPort> port = std::move(*must(canopen::open_can_port(text, {}, clock)));
  EXPECT_EQ(ask(*port, clock, kReadDeviceType, 0x585).frame.data[0], std::byte{0x43});
  ask(*port, clock, Frame::of(0x000, hex("81 06")), 0x706);
  EXPECT_EQ(port->statistics().malformed, 0U);
  EXPECT_EQ(port->statistics().lost, 0U);
}

TEST(CanPortsAtAServedLine, SlcanOverTcp) {
  CanEntrances entrances;
  entrances.slcan.push_back({});
  ServedLine line(entrances);
  exchange("slcan:tcp:" + line.address(), line.clock);
  exchange("slcan:tcp:" + line.address(), line.clock);  // the next client
}

TEST(CanPortsAtAServedLine, SlcanAtATerminal) {
  const test::TemporaryFolder folder;
  CanEntrances entrances;
  entrances.ptys.push_back(folder.path / "can");
  ServedLine line(entrances);
  exchange("slcan:" + (folder.path / "can").string(), line.clock);
}

TEST(CanPortsAtAServedLine, Socketcand) {
  CanEntrances entrances;
  entrances.socketcand.push_back({});
  ServedLine line(entrances);
  exchange("socketcand:" + line.address() + "/can0", line.clock);
  EXPECT_THAT(failure_text(canopen::open_can_port("socketcand:" + line.address() + "/can1", {}, line.clock)),
              testing::HasSubstr("could not open bus"));
}

}  // namespace
}  // namespace driveline::runtime
