#include "driveline/port/xdp_port.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <thread>

#include "driveline/port/interface_check.hpp"
#include "driveline/port/raw_socket_port.hpp"
#include "driveline/rt_guard/rt_guard.hpp"
#include "private_network.hpp"
#include "support/must.hpp"

namespace driveline::port {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr wire::MacAddress kXdpMac{std::byte{0x00}, std::byte{0x10}, std::byte{0x20},
                                   std::byte{0x30}, std::byte{0x40}, std::byte{0x51}};

Bytes xdp_frame(std::size_t size, unsigned seed, std::uint16_t ether_type = wire::kEtherTypeEtherCat) {
  Bytes frame(size);
  for (std::size_t i = 14; i < size; ++i) frame[i] = static_cast<std::byte>(seed + i * 31);
  wire::EthernetHeader{wire::kBroadcastMac, kXdpMac, ether_type}.encode(std::span{frame}.first<14>());
  return frame;
}

/// The frame with a tag of `type` after its addresses.
Bytes tagged(const Bytes& frame, unsigned type) {
  Bytes result(frame.begin(), frame.begin() + 12);
  for (const unsigned octet : {type >> 8, type & 0xFF, 0x00U, 0x05U}) result.push_back(static_cast<std::byte>(octet));
  result.insert(result.end(), frame.begin() + 12, frame.end());
  return result;
}

class OnXdpTap : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string& obstacle = enter_private_network(); !obstacle.empty()) GTEST_SKIP() << obstacle;
    tap = std::make_unique<TapInterface>("xdp0");
    if (!tap->error().empty()) GTEST_SKIP() << tap->error();
    tap->set_mac(kXdpMac);
    tap->set_up(true);
    const auto possible = XdpPort::open({.interface = "xdp0", .first = XdpMode::kGeneric}, clock);
    if (!possible) GTEST_SKIP() << possible.error().message;
  }

  std::unique_ptr<XdpPort> open(XdpMode mode) {
    auto port = XdpPort::open({.interface = "xdp0", .first = mode, .last = mode}, clock);
    EXPECT_TRUE(port) << port.error().message;
    return port ? std::move(*port) : nullptr;
  }

  std::optional<Bytes> next(Port& port) {
    if (!port.wait_readable(clock.now() + 5s)) return std::nullopt;
    const auto frame = port.receive();
    if (!frame) return std::nullopt;
    return Bytes{frame->bytes.begin(), frame->bytes.end()};
  }

  static bool becomes(bool expected, const std::function<bool()>& look) {
    for (int i = 0; i < 2000 && look() != expected; ++i) std::this_thread::sleep_for(5ms);
    return look() == expected;
  }
  static bool program_there() { return has_xdp_program("xdp0"); }

  rt::MonotonicClock clock;
  std::unique_ptr<TapInterface> tap;
};

/// With the XDP program in the driver, and in the kernel.
class Xdp : public OnXdpTap, public ::testing::WithParamInterface<XdpMode> {
 protected:
  std::unique_ptr<XdpPort> open() { return OnXdpTap::open(GetParam()); }
};

INSTANTIATE_TEST_SUITE_P(Modes, Xdp, ::testing::Values(XdpMode::kNative, XdpMode::kGeneric),
                         [](const auto& way) { return way.param == XdpMode::kNative ? "Native" : "Generic"; });

using XdpOpening = OnXdpTap;

TEST_P(Xdp, FramesPassBothWaysUnchangedAndInOrder) {
  const auto port = open();
  for (unsigned round = 0; round < 20; ++round) {
    for (unsigned i = 0; i < 50; ++i) {
      ASSERT_EQ(port->send(xdp_frame(60 + (i * 97) % 1455, i)), SendStatus::kSent);
      ASSERT_TRUE(tap->inject(xdp_frame(60 + (i * 89) % 1455, i)));
    }
    for (unsigned i = 0; i < 50; ++i) {
      ASSERT_EQ(tap->take(), xdp_frame(60 + (i * 97) % 1455, i)) << round << ' ' << i;
      ASSERT_EQ(next(*port), xdp_frame(60 + (i * 89) % 1455, i)) << round << ' ' << i;
    }
  }
  EXPECT_FALSE(port->receive());
  EXPECT_EQ(port->statistics().sent, 1000U);
  EXPECT_EQ(port->statistics().received, 1000U);
  EXPECT_EQ(port->statistics().send_failures, 0U);
}

TEST_P(Xdp, FrameStaysWhileOthersArriveAndThoseBeyondTheEndAreDropped) {
  const auto port = open();
  ASSERT_TRUE(tap->inject(xdp_frame(1514, 1)));
  ASSERT_TRUE(port->wait_readable(clock.now() + 5s));
  const auto frame = must(port->receive());
  for (unsigned i = 0; i < 300; ++i) ASSERT_TRUE(tap->inject(xdp_frame(1514, i)));
  EXPECT_EQ(Bytes(frame->bytes.begin(), frame->bytes.end()), xdp_frame(1514, 1));
  for (unsigned i = 0; i < 127; ++i) ASSERT_EQ(next(*port), xdp_frame(1514, i)) << i;
  EXPECT_FALSE(port->receive());
  ASSERT_TRUE(tap->inject(xdp_frame(60, 9)));
  EXPECT_EQ(next(*port), xdp_frame(60, 9));
}

TEST_P(Xdp, TaggedFramesLookLikeUntaggedOnesAsWithAPacketSocket) {
  const Bytes frame = xdp_frame(100, 3);
  {
    const auto raw = must(RawSocketPort::open({.interface = "xdp0"}, clock));
    ASSERT_TRUE(tap->inject(tagged(frame, 0x8100)));
    ASSERT_EQ(next(**raw), frame);
  }
  const auto port = open();
  for (const unsigned type : {0x8100U, 0x88A8U}) {
    ASSERT_TRUE(tap->inject(tagged(frame, type)));
    ASSERT_EQ(next(*port), frame) << type;
  }
}

TEST_P(Xdp, OtherProtocolsGoOnToTheKernelAndEtherCatDoesNot) {
  const auto port = open();
  const rt::FileDescriptor others{::socket(AF_PACKET, SOCK_RAW | SOCK_NONBLOCK, htons(0x0003))};
  ASSERT_TRUE(others.valid());
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(0x0003);
  address.sll_ifindex = static_cast<int>(if_nametoindex("xdp0"));
  ASSERT_EQ(bind(others.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_TRUE(tap->inject(xdp_frame(60, 1)));
  ASSERT_TRUE(tap->inject(xdp_frame(60, 2, 0x0806)));
  ASSERT_TRUE(tap->inject(tagged(xdp_frame(60, 3, wire::kEtherTypeIpv4), 0x8100)));
  ASSERT_TRUE(tap->inject(Bytes(14, std::byte{0x88})));  // shorter than the bytes that the program checks after a tag
  EXPECT_EQ(next(*port), xdp_frame(60, 1));
  EXPECT_FALSE(port->receive());
  std::vector<Bytes> seen;
  const auto end = clock.now() + 30s;
  while (seen.size() < 2 && clock.now() < end) {
    Bytes buffer(2048);
    const auto size = recv(others.get(), buffer.data(), buffer.size(), 0);
    if (size < 16) continue;
    buffer.resize(static_cast<std::size_t>(size));
    ASSERT_NE(buffer, xdp_frame(60, 1));
    if (std::equal(kXdpMac.begin(), kXdpMac.end(), buffer.begin() + 6)) seen.push_back(buffer);
  }
  EXPECT_EQ(seen.size(), 2U);
}

TEST_P(Xdp, FramesThatCannotBeEtherCatAreDiscardedAndCounted) {
  const auto port = open();
  ASSERT_TRUE(tap->inject(xdp_frame(14, 0)));
  ASSERT_TRUE(tap->inject(xdp_frame(15, 0)));
  ASSERT_TRUE(tap->inject(xdp_frame(1519, 0)));
  ASSERT_TRUE(tap->inject(xdp_frame(16, 1)));
  ASSERT_TRUE(tap->inject(xdp_frame(1518, 2)));
  EXPECT_EQ(next(*port), xdp_frame(16, 1));
  EXPECT_EQ(next(*port), xdp_frame(1518, 2));
  EXPECT_EQ(port->statistics().too_short, 2U);
  EXPECT_EQ(port->statistics().too_long, 1U);
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(tap->inject(xdp_frame(14, 0)));
  ASSERT_TRUE(port->wait_readable(clock.now() + 5s));
  EXPECT_FALSE(port->receive());
  EXPECT_LT(port->statistics().too_short, 42U) << "a flood does not hold receive()";
}

TEST_P(Xdp, FramesLongerThanTheInterfaceTakesAreRefused) {
  const auto port = open();
  EXPECT_EQ(port->send(xdp_frame(kMaxFrameBytes + 1, 0)), SendStatus::kTooLong);
  EXPECT_EQ(port->send(xdp_frame(1515, 0)), SendStatus::kTooLong);  // the MTU is 1500
  EXPECT_EQ(port->statistics().send_failures, 2U);
  EXPECT_EQ(port->last_send_time(), 0ns);
}

TEST_P(Xdp, FullQueueIsBusyAndRecovers) {
  const auto port = open();
  unsigned sent = 0;
  SendStatus status = SendStatus::kSent;
  while (status == SendStatus::kSent && sent < 100'000) {
    status = port->send(xdp_frame(60, sent));
    if (status == SendStatus::kSent) ++sent;
  }
  EXPECT_EQ(status, SendStatus::kBusy);
  for (unsigned i = 0; i < sent; ++i) ASSERT_EQ(tap->take(), xdp_frame(60, i)) << i;
  for (unsigned i = 0; i < 200; ++i) {
    ASSERT_EQ(port->send(xdp_frame(60, i)), SendStatus::kSent);
    ASSERT_EQ(tap->take(), xdp_frame(60, i));
  }
}

TEST_P(Xdp, PulledCableIsLinkDownUntilItIsBackAndNothingOldIsSentThen) {
  const auto port = open();
  tap->set_carrier(false);
  EXPECT_NE(port->send(xdp_frame(60, 0)), SendStatus::kSent);  // at once
  EXPECT_TRUE(becomes(false, [&] { return port->link_up(); }));
  for (unsigned i = 0; i < 300; ++i) ASSERT_EQ(port->send(xdp_frame(60, i)), SendStatus::kLinkDown);
  tap->set_carrier(true);
  EXPECT_TRUE(becomes(true, [&] { return port->link_up(); }));
  EXPECT_EQ(port->send(xdp_frame(60, 1)), SendStatus::kSent);
  EXPECT_EQ(tap->take(), xdp_frame(60, 1));
  EXPECT_FALSE(tap->take(10ms));
}

TEST_P(Xdp, InterfaceTakenDownIsLinkDownAndWorksAgainWhenUpWithNothingOld) {
  const auto port = open();
  tap->set_up(false);
  EXPECT_FALSE(port->link_up());
  for (unsigned i = 0; i < 300; ++i) ASSERT_EQ(port->send(xdp_frame(60, i)), SendStatus::kLinkDown);
  EXPECT_FALSE(port->receive());
  EXPECT_FALSE(port->wait_readable(clock.now() + 2ms));
  tap->set_up(true);
  EXPECT_EQ(port->send(xdp_frame(80, 1)), SendStatus::kSent);
  EXPECT_EQ(tap->take(), xdp_frame(80, 1));
  EXPECT_FALSE(tap->take(10ms));
  ASSERT_TRUE(tap->inject(xdp_frame(60, 2)));
  EXPECT_EQ(next(*port), xdp_frame(60, 2));
}

TEST_P(Xdp, DeletedInterfaceIsLinkDown) {
  const auto port = open();
  tap->remove();
  EXPECT_EQ(port->send(xdp_frame(60, 0)), SendStatus::kLinkDown);
  EXPECT_EQ(port->send(xdp_frame(60, 0)), SendStatus::kLinkDown);
  EXPECT_FALSE(port->receive());
  EXPECT_FALSE(port->wait_readable(clock.now() + 1ms));
  EXPECT_FALSE(port->link_up());
}

TEST_P(Xdp, TimeStampsLieAroundTheExchange) {
  const auto port = open();
  const auto start = clock.now();
  ASSERT_EQ(port->send(xdp_frame(60, 0)), SendStatus::kSent);
  EXPECT_GE(port->last_send_time(), start);
  EXPECT_LE(port->last_send_time(), clock.now());
  ASSERT_TRUE(tap->inject(xdp_frame(60, 0)));
  ASSERT_TRUE(port->wait_readable(clock.now() + 5s));
  const auto before = clock.now();
  const auto frame = must(port->receive());
  EXPECT_GE(frame->time, before);
  EXPECT_EQ(port->mac(), kXdpMac);
  const auto deadline = clock.now() + 3ms;
  EXPECT_FALSE(port->wait_readable(deadline));
  EXPECT_GE(clock.now(), deadline);
}

TEST_P(Xdp, KilledProcessLeavesNoProgramBehind) {
  EXPECT_FALSE(program_there());
  int pipe_ends[2];
  ASSERT_EQ(pipe(pipe_ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    const auto port = OnXdpTap::open(GetParam());
    const char answer = port ? 'y' : 'n';
    static_cast<void>(!write(pipe_ends[1], &answer, 1));
    while (true) pause();
  }
  char answer = 0;
  ASSERT_EQ(read(pipe_ends[0], &answer, 1), 1);
  EXPECT_EQ(answer, 'y');
  EXPECT_TRUE(program_there());
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(becomes(false, program_there)) << "the program outlives its process";
  close(pipe_ends[0]);
  close(pipe_ends[1]);
  const auto raw = must(RawSocketPort::open({.interface = "xdp0"}, clock));
  ASSERT_TRUE(tap->inject(xdp_frame(60, 5)));
  EXPECT_EQ(next(**raw), xdp_frame(60, 5));
}

TEST_P(Xdp, TheCycleNeitherAllocatesNorLocks) {
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc and the locks in this build";
  const auto port = open();
  const Bytes frame = xdp_frame(200, 1);
  unsigned back = 0;
  rt::RtGuard::Counts counts;
  for (unsigned i = 0; i < 1000; ++i) {
    rt::RtGuard::enter();
    static_cast<void>(port->send(frame));
    while (port->receive()) ++back;
    static_cast<void>(port->wait_readable(clock.now() + 10us));
    const auto more = rt::RtGuard::leave();
    counts.allocations += more.allocations;
    counts.frees += more.frees;
    counts.locks += more.locks;
    const bool carrier = i <= 500 || i > 510;
    if (const auto there = tap->take(carrier ? 5s : 0s)) tap->inject(*there);
    if (i == 500) tap->set_carrier(false);
    if (i == 510) tap->set_carrier(true);
  }
  EXPECT_GT(back, 900U);
  EXPECT_EQ(counts.total(), 0U);
}

TEST_F(XdpOpening, StepsDownFromZeroCopyWithTheReason) {
  const auto port = must(XdpPort::open({.interface = "xdp0"}, clock));
  EXPECT_EQ((*port)->mode(), XdpMode::kNative);
  EXPECT_EQ((*port)->access_method(), "AF_XDP, native, copied");
  ASSERT_FALSE((*port)->steps_down().empty());
  EXPECT_EQ((*port)->steps_down().front(),
            "No AF_XDP (zero copy) on interface 'xdp0': the driver does not support zero copy.");
}

TEST_F(XdpOpening, StepsDownToGenericWhereTheDriverRefusesWithTheReason) {
  if (!run_quietly("ip link add name dlbig type veth peer name dlbigger")) GTEST_SKIP() << "no veth pair";
  ASSERT_TRUE(run_quietly("ip link set dev dlbigger mtu 9000 up && ip link set dev dlbig up"));
  {
    const auto port = must(XdpPort::open({.interface = "dlbig"}, clock));
    EXPECT_EQ((*port)->mode(), XdpMode::kGeneric);
    EXPECT_THAT(
        (*port)->steps_down(),
        ::testing::Contains(HasSubstr("No AF_XDP (native, copied) on interface 'dlbig': the MTU of the interface, "
                                      "or of its other end, is too large for XDP; `ip link set dev IF mtu 1500`.")));
  }
  EXPECT_TRUE(run_quietly("ip link delete dlbig"));
}

TEST_F(XdpOpening, WithoutPrivilegeNamesTheRemedyAndAutoTakesAPacketSocket) {
  PortError error;
  std::thread{[&] {
    drop_capabilities();  // of this thread only
    const auto port = XdpPort::open({.interface = "xdp0"}, clock);
    if (!port) error = port.error();
  }}.join();
  EXPECT_EQ(error.code, PortErrorCode::kNoPermission);
  EXPECT_EQ(error.message,
            "Opening an AF_XDP socket on interface 'xdp0' needs the capability CAP_NET_RAW; run as root or grant it "
            "with `setcap cap_net_raw,cap_net_admin,cap_bpf,cap_sys_nice,cap_ipc_lock+ep build/driveline`, or use "
            "port = \"raw\".");
  PortError missing;
  tl::expected<OpenInterface, PortError> fallen;
  std::thread{[&] {
    keep_only_net_raw();
    const auto port = XdpPort::open({.interface = "xdp0"}, clock);
    if (!port) missing = port.error();
    fallen = open_interface("xdp0", PortChoice::kXdp, true, clock);
  }}.join();
  EXPECT_EQ(missing.code, PortErrorCode::kNoPermission);
  EXPECT_THAT(missing.message, HasSubstr("CAP_NET_ADMIN and CAP_BPF"));
  ASSERT_TRUE(fallen) << fallen.error().message;
  EXPECT_EQ(fallen->port->access_method(), "packet socket with a receive ring");
  ASSERT_EQ(fallen->steps_down.size(), 1U);
  EXPECT_EQ(fallen->steps_down.front(), missing.message);
}

TEST_F(XdpOpening, OpensAgainAtOnceAfterItWasClosed) {
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(open(XdpMode::kNative)) << i;
}

TEST_F(XdpOpening, OneProgramAtATimeAndTheOtherIsTold) {
  const auto first = open(XdpMode::kNative);
  const auto second = XdpPort::open({.interface = "xdp0"}, clock);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message, HasSubstr("another"));
  const auto raw = must(open_interface("xdp0", PortChoice::kRaw, false, clock));
  ASSERT_EQ(raw->steps_down.size(), 1U);
  EXPECT_THAT(raw->steps_down.front(), HasSubstr("XDP program is attached to interface 'xdp0'"));
  const auto refused = open_interface("xdp0", PortChoice::kXdp, false, clock);
  EXPECT_FALSE(refused);
}

TEST_F(XdpOpening, AutoTakesAPacketSocketWhereTheDriverCopiesAndSaysWhy) {
  const auto opened = must(open_interface("xdp0", PortChoice::kAuto, false, clock));
  EXPECT_EQ(opened->port->access_method(), "packet socket with a receive ring");
  ASSERT_EQ(opened->steps_down.size(), 1U);
  EXPECT_THAT(opened->steps_down.front(), HasSubstr("does not support zero copy"));
  EXPECT_FALSE(program_there());
}

TEST_F(XdpOpening, InterfaceThatIsDownOrMissingIsRefusedAsByAPacketSocket) {
  tap->set_up(false);
  for (const auto choice : {PortChoice::kAuto, PortChoice::kRaw, PortChoice::kXdp}) {
    const auto port = open_interface("xdp0", choice, true, clock);
    ASSERT_FALSE(port);
    EXPECT_EQ(port.error().message, "Interface 'xdp0' is down; bring it up with `ip link set dev xdp0 up`.");
    EXPECT_FALSE(open_interface("xdp1", choice, true, clock));
  }
}

}  // namespace
}  // namespace driveline::port
