#include <gmock/gmock.h>

#include <thread>

#include "driveline/port/raw_socket_port.hpp"
#include "driveline/port/xdp_port.hpp"
#include "driveline/rt_guard/rt_guard.hpp"
#include "private_network.hpp"

namespace driveline::port {
namespace {

using namespace std::chrono_literals;

/// The ports at the two ends of the cable.
struct Ends {
  const char* name;
  std::optional<XdpMode> master;  ///< none: a packet socket
  std::optional<XdpMode> slave;
};

/// Two ports at the two ends of a virtual cable, as `driveline run` and `driveline simulate` use them.
class VethPair : public ::testing::TestWithParam<Ends> {
 protected:
  void SetUp() override {
    if (const std::string& obstacle = enter_private_network(); !obstacle.empty()) GTEST_SKIP() << obstacle;
    if (!run_quietly("ip link add name dlmaster type veth peer name dlslave") || !run_quietly("ip link show dlslave")) {
      GTEST_SKIP() << "no veth pair: the kernel lacks the driver or `ip` is not installed";
    }
    ASSERT_TRUE(run_quietly("ip link set dev dlmaster up && ip link set dev dlslave up"));
    open("dlmaster", GetParam().master, master);
    if (!IsSkipped()) open("dlslave", GetParam().slave, slave);
  }

  void open(const std::string& interface, std::optional<XdpMode> mode, std::unique_ptr<InterfacePort>& port) {
    if (!mode) {
      auto raw = RawSocketPort::open({.interface = interface}, clock);
      ASSERT_TRUE(raw) << raw.error().message;
      port = std::move(*raw);
      return;
    }
    auto xdp = XdpPort::open({.interface = interface, .first = *mode, .last = *mode}, clock);
    if (!xdp && xdp.error().code == PortErrorCode::kNoPermission) GTEST_SKIP() << xdp.error().message;
    ASSERT_TRUE(xdp) << xdp.error().message;
    port = std::move(*xdp);
  }

  void TearDown() override { run_quietly("ip link delete dlmaster"); }

  std::optional<Bytes> next(Port& port) {
    if (!port.wait_readable(clock.now() + 5s)) return std::nullopt;
    const auto frame = port.receive();
    if (!frame) return std::nullopt;
    return Bytes{frame->bytes.begin(), frame->bytes.end()};
  }

  Bytes frame_of(std::size_t size, unsigned seed) const {
    Bytes frame(size, static_cast<std::byte>(seed));
    wire::EthernetHeader{wire::kBroadcastMac, master->mac(), wire::kEtherTypeEtherCat}.encode(
        std::span{frame}.first<14>());
    return frame;
  }

  rt::MonotonicClock clock;
  std::unique_ptr<InterfacePort> master;
  std::unique_ptr<InterfacePort> slave;
};

TEST_P(VethPair, LineAtTheOtherEndAnswersAndNobodySeesHisOwnFrames) {
  for (unsigned i = 0; i < 200; ++i) {
    const Bytes request = frame_of(i % 2 == 0 ? 60 : 1514, i);
    ASSERT_EQ(master->send(request), SendStatus::kSent);
    auto on_the_line = next(*slave);
    ASSERT_EQ(on_the_line, request);
    (*on_the_line)[6] |= std::byte{0x02};  // the change by the first slave
    (*on_the_line)[20] ^= std::byte{0xFF};
    ASSERT_EQ(slave->send(*on_the_line), SendStatus::kSent);
    ASSERT_EQ(next(*master), on_the_line);
  }
  EXPECT_FALSE(master->receive());
  EXPECT_FALSE(slave->receive());
}

TEST_P(VethPair, NeitherEndAllocatesOrLocksInTheCycle) {
  if (!rt::RtGuard::available()) GTEST_SKIP() << "a sanitizer owns malloc and the locks in this build";
  const Bytes request = frame_of(200, 1);
  rt::RtGuard::Counts counts;
  unsigned back = 0;
  const auto guarded = [&](const auto& part) {
    rt::RtGuard::enter();
    part();
    const auto more = rt::RtGuard::leave();
    counts.allocations += more.allocations;
    counts.frees += more.frees;
    counts.locks += more.locks;
  };
  for (unsigned i = 0; i < 500; ++i) {
    guarded([&] { static_cast<void>(master->send(request)); });
    ASSERT_TRUE(slave->wait_readable(clock.now() + 5s));
    guarded([&] {
      if (const auto frame = slave->receive()) static_cast<void>(slave->send(frame->bytes));
    });
    bool there = false;
    guarded([&] { there = master->wait_readable(clock.now() + 5s); });
    ASSERT_TRUE(there);
    guarded([&] {
      if (master->receive()) ++back;
    });
  }
  EXPECT_EQ(back, 500U);
  EXPECT_EQ(counts.total(), 0U);
}

INSTANTIATE_TEST_SUITE_P(Ports, VethPair,
                         ::testing::Values(Ends{"Raw", {}, {}}, Ends{"XdpNative", XdpMode::kNative, {}},
                                           Ends{"XdpGeneric", XdpMode::kGeneric, {}},
                                           Ends{"XdpAtBothEnds", XdpMode::kNative, XdpMode::kNative}),
                         [](const auto& ends) { return ends.param.name; });

TEST_P(VethPair, OtherEndDownIsLinkDown) {
  ASSERT_TRUE(run_quietly("ip link set dev dlslave down"));
  EXPECT_NE(master->send(frame_of(60, 0)), SendStatus::kSent);  // at once
  // The kernel needs some time to spread the state of the carrier.
  const auto patience = clock.now() + 10s;
  while (master->link_up() && clock.now() < patience) std::this_thread::sleep_for(5ms);
  EXPECT_FALSE(master->link_up());
  EXPECT_EQ(master->send(frame_of(60, 0)), SendStatus::kLinkDown);
}

TEST_P(VethPair, DeletedPairIsLinkDown) {
  ASSERT_TRUE(run_quietly("ip link delete dlmaster"));
  EXPECT_EQ(master->send(frame_of(60, 0)), SendStatus::kLinkDown);
  EXPECT_EQ(slave->send(frame_of(60, 0)), SendStatus::kLinkDown);
}

}  // namespace
}  // namespace driveline::port
