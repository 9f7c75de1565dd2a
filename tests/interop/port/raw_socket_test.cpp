#include "driveline/port/raw_socket_port.hpp"

#include <gmock/gmock.h>
#include <linux/if_packet.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <thread>

#include "private_network.hpp"
#include "support/must.hpp"

namespace {

int unknown_option = 0;  // of SOL_PACKET; the kernel shall pretend not to know it
volatile std::sig_atomic_t alarms = 0;

}  // namespace

// Replaces the C library's function, so that tests can simulate kernels of other versions.
extern "C" int setsockopt(int socket, int level, int option, const void* value, socklen_t size) noexcept {
  if (level == SOL_PACKET && option == unknown_option) {
    errno = ENOPROTOOPT;
    return -1;
  }
  return static_cast<int>(syscall(SYS_setsockopt, socket, level, option, value, size));
}

namespace driveline::port {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr wire::MacAddress kMac{std::byte{0x00}, std::byte{0x10}, std::byte{0x20},
                                std::byte{0x30}, std::byte{0x40}, std::byte{0x50}};

/// An outgoing EtherCAT frame of the port: broadcast, the port's address as source, then bytes derived from `seed`.
Bytes frame_of(std::size_t size, unsigned seed, std::uint16_t ether_type = wire::kEtherTypeEtherCat) {
  Bytes frame(size);
  for (std::size_t i = 14; i < size; ++i) frame[i] = static_cast<std::byte>(seed + i * 31);
  wire::EthernetHeader{wire::kBroadcastMac, kMac, ether_type}.encode(std::span{frame}.first<14>());
  return frame;
}

/// The same frame on its return: the first slave has set the bit "locally administered" of the source.
Bytes returned(Bytes frame) {
  frame[6] |= std::byte{0x02};
  return frame;
}

class OnTap : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string& obstacle = enter_private_network(); !obstacle.empty()) GTEST_SKIP() << obstacle;
    tap = std::make_unique<TapInterface>("ecat0");
    if (!tap->error().empty()) GTEST_SKIP() << tap->error();
    tap->set_mac(kMac);
    tap->set_up(true);
  }

  std::unique_ptr<RawSocketPort> open(const RawSocketConfig& config) {
    auto port = RawSocketPort::open(config, clock);
    EXPECT_TRUE(port) << port.error().message;
    return port ? std::move(*port) : nullptr;
  }

  /// Waits for the next frame, with patience for a busy machine.
  std::optional<Bytes> next(RawSocketPort& port) {
    if (!port.wait_readable(clock.now() + 5s)) return std::nullopt;
    const auto frame = port.receive();
    if (!frame) return std::nullopt;
    return Bytes{frame->bytes.begin(), frame->bytes.end()};
  }

  /// The kernel needs some time to spread the state of the carrier.
  bool link_becomes(const RawSocketPort& port, bool up) {
    const auto patience = clock.now() + 10s;
    while (port.link_up() != up && clock.now() < patience) std::this_thread::sleep_for(5ms);
    return port.link_up() == up;
  }

  rt::MonotonicClock clock;
  std::unique_ptr<TapInterface> tap;
};

/// All tests with a receive ring and without.
class RawSocket : public OnTap, public ::testing::WithParamInterface<bool> {
 protected:
  std::unique_ptr<RawSocketPort> open(bool bypass_queue = true) {
    auto port = OnTap::open({.interface = "ecat0", .bypass_queue = bypass_queue, .receive_ring = GetParam()});
    EXPECT_EQ(port->has_receive_ring(), GetParam());
    return port;
  }
};

INSTANTIATE_TEST_SUITE_P(Receiving, RawSocket, ::testing::Bool(),
                         [](const auto& way) { return way.param ? "Ring" : "Queue"; });

using RawSocketOpening = OnTap;
using RawSocketRing = OnTap;

TEST_F(RawSocketRing, FramesBeyondItsEndAreDroppedAndThoseAfterThemArrive) {
  const auto port = open({.interface = "ecat0"});
  ASSERT_TRUE(port->has_receive_ring());
  for (unsigned turn = 0; turn < 3; ++turn) {
    for (unsigned i = 0; i < 200; ++i) ASSERT_TRUE(tap->inject(frame_of(60, i)));
    for (unsigned i = 0; i < 128; ++i) ASSERT_EQ(next(*port), frame_of(60, i)) << turn << ' ' << i;
    EXPECT_FALSE(port->receive());
  }
}

TEST_F(RawSocketRing, FrameStaysWhileOthersArrive) {
  const auto port = open({.interface = "ecat0"});
  ASSERT_TRUE(tap->inject(frame_of(1514, 1)));
  ASSERT_TRUE(port->wait_readable(clock.now() + 5s));
  const auto frame = must(port->receive());
  for (unsigned i = 0; i < 200; ++i) ASSERT_TRUE(tap->inject(frame_of(1514, 7)));
  EXPECT_EQ(Bytes(frame->bytes.begin(), frame->bytes.end()), frame_of(1514, 1));
}

TEST_F(RawSocketRing, FrameThatWasReadDoesNotEndTheNextWait) {
  const auto port = open({.interface = "ecat0"});
  ASSERT_TRUE(tap->inject(frame_of(60, 1)));
  ASSERT_TRUE(port->wait_readable(clock.now() + 5s));
  ASSERT_TRUE(port->receive());
  EXPECT_FALSE(port->wait_readable(clock.now() + 1ms));
}

TEST_F(RawSocketRing, KernelWithoutItQueuesFrames) {
  unknown_option = PACKET_RX_RING;
  const auto port = open({.interface = "ecat0"});
  unknown_option = 0;
  EXPECT_FALSE(port->has_receive_ring());
  ASSERT_TRUE(tap->inject(frame_of(60, 1)));
  EXPECT_EQ(next(*port), frame_of(60, 1));
}

TEST_P(RawSocket, SendsFramesUnchangedAndInOrder) {
  const auto port = open();
  for (unsigned i = 0; i < 200; ++i) {
    const Bytes frame = frame_of(60 + (i * 97) % 1455, i);
    ASSERT_EQ(port->send(frame), SendStatus::kSent);
    if (i % 50 == 49) {
      for (unsigned k = i - 49; k <= i; ++k) ASSERT_EQ(tap->take(), frame_of(60 + (k * 97) % 1455, k)) << k;
    }
  }
}

TEST_P(RawSocket, SendsThroughTheQueueingDisciplineToo) {
  const auto port = open(false);
  const Bytes frame = frame_of(100, 1);
  EXPECT_EQ(port->send(frame), SendStatus::kSent);
  EXPECT_EQ(tap->take(), frame);
}

TEST_P(RawSocket, ReceivesFramesUnchangedAndInOrder) {
  const auto port = open();
  for (unsigned i = 0; i < 50; ++i) ASSERT_TRUE(tap->inject(returned(frame_of(60 + (i * 97) % 1455, i))));
  for (unsigned i = 0; i < 50; ++i) ASSERT_EQ(next(*port), returned(frame_of(60 + (i * 97) % 1455, i))) << i;
  EXPECT_FALSE(port->receive());
}

TEST_P(RawSocket, LongestFrameOfTheInterfacePassesBothWays) {
  const auto port = open();
  const Bytes frame = frame_of(1514, 9);
  EXPECT_EQ(port->send(frame), SendStatus::kSent);
  EXPECT_EQ(tap->take(), frame);
  ASSERT_TRUE(tap->inject(returned(frame)));
  EXPECT_EQ(next(*port), returned(frame));
}

TEST_P(RawSocket, FrameThatWentRoundTheLineComesBack) {
  const auto port = open();
  for (unsigned i = 0; i < 20; ++i) {
    ASSERT_EQ(port->send(frame_of(80, i)), SendStatus::kSent);
    const auto on_the_line = must(tap->take());
    ASSERT_TRUE(tap->inject(returned(*on_the_line)));
    ASSERT_EQ(next(*port), returned(frame_of(80, i)));
  }
  const RawSocketStatistics statistics = port->statistics();
  EXPECT_EQ(statistics.sent, 20U);
  EXPECT_EQ(statistics.received, 20U);
  EXPECT_EQ(statistics.send_failures + statistics.too_short + statistics.too_long, 0U);
}

TEST_P(RawSocket, TimeStampsLieAroundTheExchange) {
  const auto port = open();
  EXPECT_EQ(port->last_send_time(), 0ns);
  const auto start = clock.now();
  ASSERT_EQ(port->send(frame_of(60, 0)), SendStatus::kSent);
  const auto sent = clock.now();
  EXPECT_GE(port->last_send_time(), start);
  EXPECT_LE(port->last_send_time(), sent);

  ASSERT_TRUE(tap->inject(frame_of(60, 0)));
  ASSERT_TRUE(port->wait_readable(clock.now() + 5s));
  const auto before = clock.now();
  const auto frame = must(port->receive());
  EXPECT_GE(frame->time, before);
  EXPECT_LE(frame->time, clock.now());
}

TEST_P(RawSocket, FramesAreStampedWhenTheyArriveHoweverLateSomebodyReadsThem) {
  const auto port = OnTap::open({.interface = "ecat0", .receive_ring = GetParam(), .arrival_times = true});
  constexpr auto kLate = 40ms;
  // Without a ring the kernel starts time-stamping a little after the request.
  int stamped = 0;
  for (unsigned i = 0; i < 100 && stamped < 3; ++i) {
    const auto before = clock.now();
    ASSERT_TRUE(tap->inject(frame_of(60, i)));
    ASSERT_TRUE(port->wait_readable(clock.now() + 5s));
    const auto there = clock.now();
    std::this_thread::sleep_for(kLate);
    const auto frame = must(port->receive());
    ASSERT_LE(frame->time, clock.now());
    // The kernel stamps with another clock; the small time between the readings does not matter here.
    ASSERT_GE(frame->time, before - kLate / 4);
    stamped = frame->time <= there + kLate / 4 ? stamped + 1 : 0;
  }
  EXPECT_EQ(stamped, 3);
}

TEST_P(RawSocket, RefusedFrameLeavesTheSendTimeAlone) {
  const auto port = open();
  ASSERT_EQ(port->send(frame_of(60, 0)), SendStatus::kSent);
  const auto time = port->last_send_time();
  EXPECT_EQ(port->send(frame_of(1519, 0)), SendStatus::kTooLong);
  EXPECT_EQ(port->last_send_time(), time);
}

TEST_P(RawSocket, OwnFramesAndOtherProtocolsAreNotSeen) {
  const auto port = open();
  ASSERT_EQ(port->send(frame_of(60, 1)), SendStatus::kSent);
  ASSERT_TRUE(tap->inject(frame_of(60, 2, 0x0806)));
  ASSERT_TRUE(tap->inject(frame_of(60, 3, wire::kEtherTypeIpv4)));
  ASSERT_TRUE(tap->inject(returned(frame_of(60, 4))));
  EXPECT_EQ(next(*port), returned(frame_of(60, 4)));
  EXPECT_FALSE(port->receive());
}

TEST_P(RawSocket, OwnFramesAreNotSeenOnKernelsBefore420Either) {
  unknown_option = PACKET_IGNORE_OUTGOING;
  const auto direct = open();
  const auto queued = open(false);
  unknown_option = 0;
  ASSERT_EQ(direct->send(frame_of(60, 1)), SendStatus::kSent);
  ASSERT_EQ(queued->send(frame_of(60, 2)), SendStatus::kSent);
  ASSERT_TRUE(tap->inject(returned(frame_of(60, 3))));
  EXPECT_EQ(next(*direct), returned(frame_of(60, 3)));
  EXPECT_EQ(next(*queued), returned(frame_of(60, 3)));
}

TEST_P(RawSocket, FramesOfAnotherInterfaceAreNotSeen) {
  TapInterface other{"ecat1"};
  ASSERT_EQ(other.error(), "");
  other.set_up(true);
  const auto port = open();
  ASSERT_TRUE(other.inject(frame_of(60, 1)));
  ASSERT_TRUE(tap->inject(frame_of(60, 2)));
  EXPECT_EQ(next(*port), frame_of(60, 2));
  EXPECT_FALSE(port->receive());
}

TEST_P(RawSocket, FramesThatCannotBeEtherCatAreDiscardedAndCounted) {
  tap->set_mtu(9000);
  const auto port = open();
  ASSERT_TRUE(tap->inject(frame_of(14, 0)));
  ASSERT_TRUE(tap->inject(frame_of(15, 0)));
  ASSERT_TRUE(tap->inject(frame_of(1519, 0)));
  ASSERT_TRUE(tap->inject(frame_of(9000, 0)));
  ASSERT_TRUE(tap->inject(frame_of(16, 1)));
  ASSERT_TRUE(tap->inject(frame_of(1518, 2)));
  EXPECT_EQ(next(*port), frame_of(16, 1));
  EXPECT_EQ(next(*port), frame_of(1518, 2));
  EXPECT_EQ(port->statistics().too_short, 2U);
  EXPECT_EQ(port->statistics().too_long, 2U);
  EXPECT_EQ(port->statistics().received, 2U);
}

TEST_P(RawSocket, FloodOfRubbishDoesNotHoldReceive) {
  const auto port = open();
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(tap->inject(frame_of(14, 0)));
  ASSERT_TRUE(port->wait_readable(clock.now() + 5s));
  EXPECT_FALSE(port->receive());
  EXPECT_LT(port->statistics().too_short, 40U);
}

TEST_P(RawSocket, FramesLongerThanTheInterfaceTakesAreRefused) {
  const auto port = open();
  EXPECT_EQ(port->send(frame_of(kMaxFrameBytes + 1, 0)), SendStatus::kTooLong);
  EXPECT_EQ(port->send(frame_of(1515, 0)), SendStatus::kTooLong);  // the MTU is 1500
  EXPECT_EQ(port->statistics().send_failures, 2U);
  EXPECT_EQ(port->statistics().sent, 0U);
}

TEST_P(RawSocket, FullQueueIsBusyAndRecovers) {
  const auto port = open();
  unsigned sent = 0;
  SendStatus status = SendStatus::kSent;
  while (status == SendStatus::kSent && sent < 100'000) {
    status = port->send(frame_of(60, sent));
    if (status == SendStatus::kSent) ++sent;
  }
  EXPECT_EQ(status, SendStatus::kBusy);
  EXPECT_EQ(port->statistics().sent, sent);
  EXPECT_EQ(port->statistics().send_failures, 1U);
  for (unsigned i = 0; i < sent; ++i) ASSERT_EQ(tap->take(), frame_of(60, i)) << i;
  EXPECT_EQ(port->send(frame_of(60, 7)), SendStatus::kSent);
  EXPECT_EQ(tap->take(), frame_of(60, 7));
}

TEST_P(RawSocket, PulledCableIsLinkDownUntilItIsBack) {
  const auto port = open();
  EXPECT_TRUE(link_becomes(*port, true));
  tap->set_carrier(false);
  EXPECT_NE(port->send(frame_of(60, 0)), SendStatus::kSent);  // at once
  EXPECT_TRUE(link_becomes(*port, false));
  EXPECT_EQ(port->send(frame_of(60, 0)), SendStatus::kLinkDown);
  tap->set_carrier(true);
  EXPECT_EQ(port->send(frame_of(60, 1)), SendStatus::kSent);
  EXPECT_EQ(tap->take(), frame_of(60, 1));
  EXPECT_TRUE(link_becomes(*port, true));
}

TEST_P(RawSocket, InterfaceTakenDownIsLinkDownAndWorksAgainAtOnceWhenUp) {
  const auto port = open();
  tap->set_up(false);
  EXPECT_FALSE(port->link_up());
  EXPECT_EQ(port->send(frame_of(60, 0)), SendStatus::kLinkDown);
  EXPECT_FALSE(port->receive());

  // An unnoticed outage must not cost the first frame afterwards, in either direction.
  tap->set_up(true);
  tap->set_up(false);
  tap->set_up(true);
  EXPECT_EQ(port->send(frame_of(60, 1)), SendStatus::kSent);
  tap->set_up(false);
  tap->set_up(true);
  ASSERT_TRUE(tap->inject(frame_of(60, 2)));
  EXPECT_EQ(next(*port), frame_of(60, 2));
}

TEST_P(RawSocket, DeletedInterfaceIsLinkDown) {
  const auto port = open();
  tap->remove();
  EXPECT_EQ(port->send(frame_of(60, 0)), SendStatus::kLinkDown);
  EXPECT_EQ(port->send(frame_of(60, 0)), SendStatus::kLinkDown);
  EXPECT_FALSE(port->receive());
  EXPECT_FALSE(port->wait_readable(clock.now() + 1ms));
  EXPECT_FALSE(port->link_up());

  // A new interface with the same name is another one; the port does not reconnect to it.
  TapInterface successor{"ecat0"};
  ASSERT_EQ(successor.error(), "");
  successor.set_up(true);
  EXPECT_FALSE(port->link_up());
}

TEST_P(RawSocket, WaitEndsNotBeforeTheDeadline) {
  const auto port = open();
  const auto deadline = clock.now() + 3ms;
  EXPECT_FALSE(port->wait_readable(deadline));
  EXPECT_GE(clock.now(), deadline);
}

TEST_P(RawSocket, WaitWithPastDeadlineOnlyLooks) {
  const auto port = open();
  EXPECT_FALSE(port->wait_readable(clock.now() - 1h));
  ASSERT_TRUE(tap->inject(frame_of(60, 0)));
  ASSERT_TRUE(port->wait_readable(clock.now() + 5s));
  EXPECT_TRUE(port->wait_readable(clock.now() - 1h));
}

TEST_P(RawSocket, WaitSurvivesSignals) {
  const auto port = open();
  struct sigaction action {};
  struct sigaction before {};
  action.sa_handler = [](int) { alarms = alarms + 1; };  // without SA_RESTART: interrupts the wait
  sigaction(SIGALRM, &action, &before);
  const itimerval every_millisecond{{0, 1000}, {0, 1000}};
  setitimer(ITIMER_REAL, &every_millisecond, nullptr);
  const auto deadline = clock.now() + 30ms;
  EXPECT_FALSE(port->wait_readable(deadline));
  EXPECT_GE(clock.now(), deadline);
  const itimerval never{};
  setitimer(ITIMER_REAL, &never, nullptr);
  sigaction(SIGALRM, &before, nullptr);
  EXPECT_GT(alarms, 0);
}

TEST_P(RawSocket, WaitIsNotEndedByTheInterfaceGoingDown) {
  const auto port = open();
  tap->set_up(false);
  EXPECT_FALSE(port->wait_readable(clock.now() + 2ms));
}

TEST_P(RawSocket, KnowsItsHardwareAddress) {
  EXPECT_EQ(open()->mac(), kMac);
}

TEST_F(RawSocketOpening, RefusesAnInterfaceThatIsDown) {
  tap->set_up(false);
  const auto port = RawSocketPort::open({.interface = "ecat0"}, clock);
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().code, PortErrorCode::kInterfaceDown);
  EXPECT_EQ(port.error().message, "Interface 'ecat0' is down; bring it up with `ip link set dev ecat0 up`.");
}

TEST_F(RawSocketOpening, OffersTheEthernetInterfacesOfTheMachine) {
  const TapInterface other{"ecat1"};
  const TapInterface tunnel{"tunnel0", false};
  ASSERT_EQ(other.error() + tunnel.error(), "");
  const auto port = RawSocketPort::open({.interface = "ecat2"}, clock);
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().message, "There is no interface 'ecat2'; choose one of: ecat0, ecat1.");
}

TEST_F(RawSocketOpening, SaysWhenThereIsNoEthernetAtAll) {
  tap->remove();
  const auto port = RawSocketPort::open({.interface = "ecat0"}, clock);
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().message, "There is no interface 'ecat0'; this machine has no Ethernet interface.");
}

TEST_F(RawSocketOpening, RefusesInterfacesWithoutEthernetFrames) {
  TapInterface tunnel{"tunnel0", false};
  ASSERT_EQ(tunnel.error(), "");
  tunnel.set_up(true);
  const auto port = RawSocketPort::open({.interface = "tunnel0"}, clock);
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().code, PortErrorCode::kNotEthernet);
  EXPECT_THAT(port.error().message, HasSubstr("'tunnel0' carries no Ethernet frames"));
}

TEST_F(RawSocketOpening, WithoutPrivilegeNamesTheRemedy) {
  PortError error;
  std::thread{[&] {
    drop_capabilities();  // of this thread only
    const auto port = RawSocketPort::open({.interface = "ecat0"}, clock);
    if (!port) error = port.error();
  }}.join();
  EXPECT_EQ(error.code, PortErrorCode::kNoPermission);
  EXPECT_EQ(error.error_number, EPERM);
  EXPECT_EQ(error.message,
            "Opening interface 'ecat0' needs the capability CAP_NET_RAW; run as root or grant it with "
            "`setcap cap_net_raw,cap_sys_nice,cap_ipc_lock+ep build/driveline`.");
}

TEST_F(RawSocketOpening, ReportsWhatTheKernelRefuses) {
  unknown_option = PACKET_QDISC_BYPASS;
  const auto port = RawSocketPort::open({.interface = "ecat0"}, clock);
  unknown_option = 0;
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().code, PortErrorCode::kSystem);
  EXPECT_EQ(port.error().error_number, ENOPROTOOPT);
  EXPECT_EQ(port.error().message,
            "Cannot bypass the queueing discipline on interface 'ecat0': Protocol not available.");
}

}  // namespace
}  // namespace driveline::port
