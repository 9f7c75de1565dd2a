// The client of serial CAN adapters against scripted adapters.
#include "driveline/canopen_port/slcan_port.hpp"

#include <gmock/gmock.h>
#include <stdlib.h>

#include "peer.hpp"
#include "support/bytes.hpp"
#include "support/must.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::hex;
using port_test::Connection;
using port_test::kLong;
using port_test::Peer;
using port_test::read_now;
using port_test::receive_one;
using port_test::write_all;
using testing::ElementsAre;
using testing::HasSubstr;
using namespace std::chrono_literals;

using Lines = std::vector<std::string>;

std::string good_adapter(const std::string& line) {
  return line == "\r" ? "" : "\r";
}

/// A port that is open, on a clock that the test advances.
class SlcanPortTest : public testing::Test {
 protected:
  void open(const CanPortOptions& options = {}) {
    Peer adapter(line.far_end.get(), '\r', good_adapter);
    port = *must(SlcanPort::on(std::move(line.near_end), "test", options, clock, kLong));
    commands = adapter.stop();
  }
  void adapter_sends(std::string_view text) { write_all(line.far_end.get(), text); }
  std::string adapter_gets() { return read_now(line.far_end.get()); }

  rt::VirtualClock clock;
  Connection line;
  std::unique_ptr<SlcanPort> port;
  Lines commands;
};

// CANUSB manual: C closes, S6 is 500 kbit/s, O opens.
TEST_F(SlcanPortTest, OpensTheChannelWithTheBitRate) {
  open({.bit_rate = 500'000});
  EXPECT_THAT(commands, ElementsAre("\r", "C\r", "S6\r", "O\r"));
}

TEST_F(SlcanPortTest, AListenerOpensTheChannelToListenAndSendsNothing) {
  open({.bit_rate = 10'000, .listen_only = true});
  EXPECT_THAT(commands, ElementsAre("\r", "C\r", "S0\r", "L\r"));
  EXPECT_EQ(port->send(Frame::of(0x100, {})), SendStatus::kNotValid);
  EXPECT_EQ(adapter_gets(), "");
}

TEST_F(SlcanPortTest, ARateWithoutANumberGoesByBusTimingRegisters) {
  open({.bit_rate = 200'000});
  ASSERT_EQ(commands.size(), 4U);
  ASSERT_EQ(commands[2].front(), 's');
  EXPECT_EQ(slcan::bit_rate_of(static_cast<std::uint16_t>(std::stoul(commands[2].substr(1), nullptr, 16))), 200'000U);
}

TEST_F(SlcanPortTest, ARateThatNoRegistersMakeIsAnErrorOfUse) {
  const auto failed = SlcanPort::on(std::move(line.near_end), "test", {.bit_rate = 333'333}, clock, kLong);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, CanPortErrorCode::kUsage);
  EXPECT_THAT(failed.error().message, HasSubstr("333333"));
}

// Lines of the CANUSB and CAN232 manuals, commands t, T, r and R.
TEST_F(SlcanPortTest, FramesAreLinesOfTheManual) {
  open();
  for (const auto& frame : {Frame::of(0x100, hex("11 33")), Frame::of(Identifier{0x100, true}, hex("11 33")),
                            Frame::remote({0x100, false}, 2), Frame::remote({0x100, true}, 2)}) {
    EXPECT_EQ(port->send(frame), SendStatus::kSent);
  }
  EXPECT_EQ(adapter_gets(), "t10021133\rT0000010021133\rr1002\rR000001002\r");
  adapter_sends("z\rZ\r\r\rt3FF0\rT1FFFFFFF1AB\rr70A4\r");
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x3FF, {}));
  EXPECT_EQ(receive_one(*port, clock), Frame::of(Identifier{0x1FFF'FFFF, true}, hex("AB")));
  EXPECT_EQ(receive_one(*port, clock), Frame::remote({0x70A, false}, 4));
  EXPECT_FALSE(port->receive());
  const auto statistics = port->statistics();
  EXPECT_EQ(statistics.sent, 4U);
  EXPECT_EQ(statistics.received, 3U);
  EXPECT_EQ(statistics.lost + statistics.malformed, 0U);
}

TEST_F(SlcanPortTest, FramesThatAreNotPossibleAreNotSent) {
  open();
  EXPECT_EQ(port->send(Frame::of(0x800, {})), SendStatus::kNotValid);
  EXPECT_EQ(port->send(Frame{{}, FrameKind::kError, 0, {}}), SendStatus::kNotValid);
  EXPECT_EQ(adapter_gets(), "");
}

TEST_F(SlcanPortTest, AFrameInPiecesArrivesWhenItIsComplete) {
  open();
  adapter_sends("t12");
  EXPECT_FALSE(port->receive());
  adapter_sends("331122");
  EXPECT_FALSE(port->receive());
  adapter_sends("33\r");
  clock.advance(5ms);
  const auto received = port->receive();
  ASSERT_TRUE(received);
  EXPECT_EQ(received->frame, Frame::of(0x123, hex("11 22 33")));
  EXPECT_EQ(received->time, clock.now());
}

TEST_F(SlcanPortTest, ARefusedFrameIsLost) {
  open();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(port->send(Frame::of(0x100, {})), SendStatus::kSent);
  adapter_sends("z\r\az\r");
  EXPECT_FALSE(port->receive());
  EXPECT_EQ(port->statistics().lost, 1U);
}

// CANUSB manual, command F: bit 2 error warning, bit 3 data overrun, bit 5 error passive.
TEST_F(SlcanPortTest, FlagsTellTheStateOfTheBus) {
  open();
  EXPECT_EQ(port->statistics().state, BusState::kUnknown);
  clock.advance(1s);
  EXPECT_FALSE(port->receive());
  EXPECT_EQ(adapter_gets(), "F\r");
  adapter_sends("F04\r");
  EXPECT_FALSE(port->receive());
  EXPECT_EQ(port->statistics().state, BusState::kErrorWarning);
  clock.advance(1s);
  EXPECT_EQ(port->send(Frame::of(0x100, {})), SendStatus::kSent);
  EXPECT_EQ(adapter_gets(), "F\rt1000\r");
  adapter_sends("F28\rz\r");
  EXPECT_FALSE(port->receive());
  EXPECT_EQ(port->statistics().state, BusState::kErrorPassive);
  EXPECT_EQ(port->statistics().lost, 1U);
  clock.advance(1s);
  EXPECT_FALSE(port->receive());
  adapter_sends("F00\r");
  EXPECT_FALSE(port->receive());
  EXPECT_EQ(port->statistics().state, BusState::kErrorActive);
}

TEST_F(SlcanPortTest, AnAdapterWithoutFlagsIsAskedOnce) {
  open();
  EXPECT_EQ(port->send(Frame::of(0x100, {})), SendStatus::kSent);
  clock.advance(1s);
  EXPECT_EQ(port->send(Frame::of(0x100, {})), SendStatus::kSent);
  EXPECT_EQ(adapter_gets(), "t1000\rF\rt1000\r");
  adapter_sends("z\r\az\r");  // the frame before, F, the frame behind
  EXPECT_FALSE(port->receive());
  clock.advance(5s);
  EXPECT_FALSE(port->receive());
  EXPECT_EQ(adapter_gets(), "");
  EXPECT_EQ(port->statistics().lost, 0U);
  EXPECT_EQ(port->statistics().state, BusState::kUnknown);
}

TEST_F(SlcanPortTest, AnAdapterThatSaysNothingToFlagsIsAskedOnce) {
  open();
  clock.advance(1s);
  EXPECT_FALSE(port->receive());
  clock.advance(1s);
  EXPECT_FALSE(port->receive());
  clock.advance(1s);
  EXPECT_FALSE(port->receive());
  EXPECT_EQ(adapter_gets(), "F\r");
}

TEST_F(SlcanPortTest, GarbageIsCountedAndTheNextFrameIsGood) {
  open();
  adapter_sends(std::string("\x00\xFF\x80\r", 4) + "t8000\rt1\r" + "t1230\r");
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x123, {}));
  EXPECT_EQ(port->statistics().malformed, 3U);
}

TEST_F(SlcanPortTest, AMebibyteWithoutALineEndIsSkipped) {
  open();
  std::thread writer([&] { adapter_sends(std::string(1 << 20, 'x') + "\rt1230\r"); });
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x123, {}));
  writer.join();
  EXPECT_EQ(port->statistics().malformed, 1U);
}

TEST_F(SlcanPortTest, AnAdapterThatDoesNotReadMakesThePortBusy) {
  open();
  const auto frame = Frame::of(0x100, hex("00 11 22 33 44 55 66 77"));
  unsigned sent = 0;
  auto status = SendStatus::kSent;
  while ((status = port->send(frame)) == SendStatus::kSent && sent < 10'000'000) ++sent;
  EXPECT_EQ(status, SendStatus::kBusy);
  EXPECT_EQ(port->statistics().sent, sent);
  // Whole lines have been sent, and go on to be when the adapter reads again.
  std::string all;
  for (int i = 0; i < 1000 && all.size() < sent * 22U; ++i) {
    all += adapter_gets();
    EXPECT_FALSE(port->receive());
  }
  EXPECT_EQ(all.size(), sent * 22U);
  EXPECT_EQ(all.substr(all.size() - 22), "t10080011223344556677\r");
  EXPECT_EQ(port->send(frame), SendStatus::kSent);
}

TEST_F(SlcanPortTest, AConnectionThatEndsIsDown) {
  open();
  adapter_sends("t1230\r");
  line.far_end = {};
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x123, {}));
  EXPECT_FALSE(port->wait_readable(clock.now() + kLong));  // at once
  EXPECT_TRUE(port->statistics().down);
  EXPECT_EQ(port->send(Frame::of(0x100, {})), SendStatus::kDown);
  const auto before = clock.now();
  EXPECT_FALSE(port->wait_readable(before + 7s));
  EXPECT_EQ(clock.now(), before + 7s);  // sleeps: no program spins
}

TEST_F(SlcanPortTest, ADeadlineWithoutAFrameGivesFalse) {
  open();
  EXPECT_FALSE(port->wait_readable(clock.now()));
  EXPECT_FALSE(port->wait_readable(clock.now() + 1ms));
}

TEST_F(SlcanPortTest, TheDestructorClosesTheChannel) {
  open();
  port.reset();
  EXPECT_EQ(adapter_gets(), "C\r");
}

/// What opening says about an adapter.
std::string failure(const Peer::Answer& answer, std::chrono::nanoseconds patience = kLong) {
  Connection line;
  rt::VirtualClock clock;
  Peer adapter(line.far_end.get(), '\r', answer);
  const auto port = SlcanPort::on(std::move(line.near_end), "/dev/ttyX", {.bit_rate = 800'000}, clock, patience);
  return failure_text(port);
}

TEST(SlcanOpen, AClosedChannelIsNoError) {
  EXPECT_EQ(failure([](const std::string& text) { return text == "C\r" ? "\a" : good_adapter(text); }), "");
}

TEST(SlcanOpen, FramesOfAnOpenChannelAreNoAnswers) {
  EXPECT_EQ(failure([](const std::string& text) { return text == "C\r" ? "t1230\rz\rt12\a" : good_adapter(text); }),
            "");
}

TEST(SlcanOpen, ALateAnswerOfAnEarlierProgramIsNoRefusal) {
  int count = 0;
  EXPECT_EQ(
      failure([&count](const std::string& text) { return text == "S7\r" && count++ == 0 ? "\a" : good_adapter(text); }),
      "");
}

TEST(SlcanOpen, ARateThatTheAdapterRefuses) {
  EXPECT_EQ(failure([](const std::string& text) { return text == "S7\r" ? "\a" : good_adapter(text); }),
            "the serial CAN adapter at /dev/ttyX refuses the command S7.");
}

TEST(SlcanOpen, AnAdapterThatSaysNothing) {
  EXPECT_EQ(
      failure([](const std::string&) { return ""; }, 20ms),
      "the serial CAN adapter at /dev/ttyX does not answer the command C; a carriage return or BEL was expected.");
}

TEST(SlcanOpen, AnAdapterThatSendsHalfLines) {
  EXPECT_THAT(failure([](const std::string& text) { return text == "S7\r" ? "t12" : good_adapter(text); }, 20ms),
              HasSubstr("does not answer the command S7"));
}

TEST(SlcanOpen, AConnectionThatEndsMeanwhile) {
  Connection line;
  rt::VirtualClock clock;
  line.far_end = {};
  const auto port = SlcanPort::on(std::move(line.near_end), "/dev/ttyX", {}, clock, kLong);
  EXPECT_EQ(failure_text(port), "the serial CAN adapter at /dev/ttyX has gone away at the command C.");
}

TEST(SlcanTerminal, APseudoTerminalPassesAllBytes) {
  const rt::FileDescriptor adapter{::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)};
  ASSERT_TRUE(adapter.valid());
  ASSERT_EQ(::grantpt(adapter.get()) | ::unlockpt(adapter.get()), 0);
  std::array<char, 64> name{};
  ASSERT_EQ(::ptsname_r(adapter.get(), name.data(), name.size()), 0);
  rt::MonotonicClock clock;
  std::unique_ptr<SlcanPort> port;
  {
    // Held open, so that the near end does not hang up before the port is there.
    const rt::FileDescriptor holder{::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC)};
    Peer peer(adapter.get(), '\r', good_adapter);
    port = *must(SlcanPort::open_terminal(name.data(), {}, clock));
    EXPECT_THAT(peer.stop(), ElementsAre("\r", "C\r", "S8\r", "O\r"));
  }
  EXPECT_EQ(port->send(Frame::of(0x203, hex("0D 0A"))), SendStatus::kSent);
  EXPECT_THAT(port_test::read_until(adapter.get(), "0A\r"), HasSubstr("t20320D0A\r"));
  write_all(adapter.get(), "t1230\r");
  EXPECT_EQ(receive_one(*port, clock), Frame::of(0x123, {}));
}

TEST(SlcanTerminal, WhatIsNoTerminalIsRefused) {
  rt::MonotonicClock clock;
  EXPECT_EQ(failure_text(SlcanPort::open_terminal("/nonexistent/tty", {}, clock)),
            "cannot open /nonexistent/tty: No such file or directory.");
  EXPECT_THAT(failure_text(SlcanPort::open_terminal("/dev/null", {}, clock)),
              HasSubstr("cannot use as a terminal /dev/null"));
}

}  // namespace
}  // namespace driveline::canopen
