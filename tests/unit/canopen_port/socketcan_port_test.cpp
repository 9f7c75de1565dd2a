// The port to interfaces of the kernel, at a pair of sockets that carries messages as a CAN socket does: struct
// can_frame of linux/can.h, in the byte order of this machine.
#include "driveline/canopen_port/socketcan_port.hpp"

#include <gmock/gmock.h>
#include <linux/can.h>
#include <linux/can/error.h>

#include <cstring>

#include "peer.hpp"
#include "support/bytes.hpp"
#include "support/must.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::hex;
using port_test::Connection;
using port_test::kLong;
using port_test::receive_one;
using testing::AnyOf;
using testing::HasSubstr;
using namespace std::chrono_literals;

can_frame message(canid_t identifier, std::uint8_t length, std::string_view data = "") {
  can_frame out{};
  out.can_id = identifier;
  out.len = length;
  const auto bytes = hex(data);
  if (!bytes.empty()) std::memcpy(out.data, bytes.data(), bytes.size());
  return out;
}

class SocketCanTest : public testing::Test {
 protected:
  void bus_has(const void* data, std::size_t size) {
    ASSERT_EQ(::send(line.far_end.get(), data, size, MSG_NOSIGNAL), static_cast<ssize_t>(size));
  }
  void bus_has(const can_frame& frame) { bus_has(&frame, sizeof frame); }
  /// The next message of the port.
  can_frame sent() {
    can_frame frame{};
    EXPECT_EQ(::recv(line.far_end.get(), &frame, sizeof frame, MSG_DONTWAIT), static_cast<ssize_t>(sizeof frame));
    return frame;
  }

  rt::VirtualClock clock;
  Connection line{SOCK_SEQPACKET};
  SocketCanPort port{std::move(line.near_end), {}, clock};
};

TEST_F(SocketCanTest, SendsTheStructureOfTheKernel) {
  EXPECT_EQ(port.send(Frame::of(0x123, hex("11 22 33"))), SendStatus::kSent);
  EXPECT_EQ(port.send(Frame::of(Identifier{0x123, true}, hex("AA"))), SendStatus::kSent);
  EXPECT_EQ(port.send(Frame::remote({0x70A, false}, 1)), SendStatus::kSent);
  const can_frame data = sent();
  EXPECT_EQ(data.can_id, 0x123U);
  EXPECT_EQ(data.len, 3);
  EXPECT_EQ(std::memcmp(data.data, "\x11\x22\x33\0\0\0\0\0", 8), 0);
  const can_frame extended = sent();
  EXPECT_EQ(extended.can_id, 0x123U | CAN_EFF_FLAG);
  EXPECT_EQ(extended.data[0], 0xAA);
  const can_frame remote = sent();
  EXPECT_EQ(remote.can_id, 0x70AU | CAN_RTR_FLAG);
  EXPECT_EQ(remote.len, 1);
  EXPECT_EQ(port.send(Frame::of(0x800, {})), SendStatus::kNotValid);
  EXPECT_EQ(port.statistics().sent, 3U);
}

TEST_F(SocketCanTest, ReceivesTheStructureOfTheKernel) {
  bus_has(message(0x123, 3, "11 22 33"));
  bus_has(message(0x123 | CAN_EFF_FLAG, 1, "AA"));
  bus_has(message(0x70A | CAN_RTR_FLAG, 1));
  clock.advance(3ms);
  const auto first = port.receive();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->frame, Frame::of(0x123, hex("11 22 33")));
  EXPECT_EQ(first->time, 3ms);
  EXPECT_EQ(receive_one(port, clock), Frame::of(Identifier{0x123, true}, hex("AA")));
  EXPECT_EQ(receive_one(port, clock), Frame::remote({0x70A, false}, 1));
  EXPECT_FALSE(port.receive());
  EXPECT_EQ(port.statistics().received, 3U);
}

TEST_F(SocketCanTest, WhatIsNoClassicFrameIsCountedAndSkipped) {
  canfd_frame fd{};
  fd.can_id = 0x123;
  fd.len = 12;
  bus_has(&fd, sizeof fd);
  bus_has(message(0x800, 0));
  bus_has(message(0x123, 9));
  bus_has("short", 5);
  std::array<char, 200> longer{};
  bus_has(longer.data(), longer.size());
  bus_has(message(0x124, 0));
  EXPECT_EQ(receive_one(port, clock), Frame::of(0x124, {}));
  EXPECT_EQ(port.statistics().malformed, 5U);
  EXPECT_EQ(port.statistics().received, 1U);
}

TEST_F(SocketCanTest, ErrorFramesTellTheStateOfTheBus) {
  const auto state_after = [&](const can_frame& frame) {
    bus_has(frame);
    EXPECT_FALSE(port.receive());  // not asked for
    return port.statistics().state;
  };
  EXPECT_EQ(port.statistics().state, BusState::kUnknown);
  EXPECT_EQ(state_after(message(CAN_ERR_FLAG | CAN_ERR_CRTL, 8, "00 08 00 00 00 00 60 05")), BusState::kErrorWarning);
  EXPECT_EQ(port.statistics().send_errors, 0x60);
  EXPECT_EQ(port.statistics().receive_errors, 5);
  EXPECT_EQ(state_after(message(CAN_ERR_FLAG | CAN_ERR_CRTL, 8, "00 10 00 00 00 00 00 80")), BusState::kErrorPassive);
  EXPECT_EQ(state_after(message(CAN_ERR_FLAG | CAN_ERR_CRTL, 8, "00 40")), BusState::kErrorActive);
  EXPECT_EQ(port.statistics().receive_errors, 0x80);  // told nothing new
  EXPECT_EQ(state_after(message(CAN_ERR_FLAG | CAN_ERR_CNT, 8, "00 00 00 00 00 00 00 07")), BusState::kErrorActive);
  EXPECT_EQ(port.statistics().receive_errors, 7);
  EXPECT_EQ(state_after(message(CAN_ERR_FLAG | CAN_ERR_CRTL, 8, "00 01")), BusState::kErrorActive);
  EXPECT_EQ(port.statistics().lost, 1U);  // overflow of the receive buffer
  EXPECT_EQ(port.statistics().error_frames, 0U);
}

TEST_F(SocketCanTest, NothingIsSentInBusOffAndItsEndIsNoticed) {
  bus_has(message(CAN_ERR_FLAG | CAN_ERR_BUSOFF, 8));
  EXPECT_FALSE(port.receive());
  EXPECT_EQ(port.statistics().state, BusState::kBusOff);
  EXPECT_EQ(port.send(Frame::of(0x100, {})), SendStatus::kDown);
  EXPECT_FALSE(port.statistics().down);  // the interface is there
  bus_has(message(CAN_ERR_FLAG | CAN_ERR_RESTARTED, 8));
  EXPECT_EQ(port.send(Frame::of(0x100, {})), SendStatus::kSent);
}

TEST_F(SocketCanTest, AnInterfaceThatDoesNotSendMakesThePortBusy) {
  auto status = SendStatus::kSent;
  for (int i = 0; i < 1'000'000 && status == SendStatus::kSent; ++i) status = port.send(Frame::of(0x100, {}));
  EXPECT_EQ(status, SendStatus::kBusy);
  static_cast<void>(sent());
  while (port.send(Frame::of(0x100, {})) == SendStatus::kBusy) static_cast<void>(sent());
}

TEST_F(SocketCanTest, ADescriptorThatEndsIsDown) {
  bus_has(message(0x123, 0));
  line.far_end = {};
  EXPECT_EQ(receive_one(port, clock), Frame::of(0x123, {}));
  EXPECT_FALSE(port.wait_readable(clock.now() + kLong));  // at once
  EXPECT_TRUE(port.statistics().down);
  EXPECT_EQ(port.send(Frame::of(0x100, {})), SendStatus::kDown);
  EXPECT_FALSE(port.wait_readable(clock.now() + 7s));
  EXPECT_EQ(clock.now(), 7s);  // sleeps: no program spins
}

TEST(SocketCanErrors, AreReportedWhenAskedFor) {
  rt::VirtualClock clock;
  Connection line(SOCK_DGRAM);
  SocketCanPort port(std::move(line.near_end), {.error_frames = true}, clock);
  const can_frame error = message(CAN_ERR_FLAG | CAN_ERR_BUSERROR, 8);
  ASSERT_EQ(::send(line.far_end.get(), &error, sizeof error, 0), static_cast<ssize_t>(sizeof error));
  EXPECT_EQ(receive_one(port, clock), (Frame{{}, FrameKind::kError, 0, {}}));
  EXPECT_EQ(port.statistics().error_frames, 1U);
}

TEST(SocketCanOpen, SaysWhyAnInterfaceCannotBeUsed) {
  rt::MonotonicClock clock;
  const auto failure_of = [&](std::string_view name) { return failure_text(SocketCanPort::open(name, {}, clock)); };
  EXPECT_EQ(failure_of("lo"), "the network interface 'lo' is none of CAN.");
  EXPECT_THAT(failure_of("no_such_can"), AnyOf(HasSubstr("the kernel of this machine has no CAN"),
                                               HasSubstr("there is no network interface 'no_such_can'")));
  EXPECT_THAT(failure_of("a_name_that_is_too_long"), HasSubstr("1 to 15 characters"));
  EXPECT_THAT(failure_of(""), HasSubstr("1 to 15 characters"));
}

}  // namespace
}  // namespace driveline::canopen
