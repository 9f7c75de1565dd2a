#include <gmock/gmock.h>

#include <thread>

#include "driveline/port/raw_socket_port.hpp"
#include "private_network.hpp"

namespace driveline::port {
namespace {

using namespace std::chrono_literals;

/// Two ports at the two ends of a virtual cable, as `driveline run` and `driveline simulate` use them.
class VethPair : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string& obstacle = enter_private_network(); !obstacle.empty()) GTEST_SKIP() << obstacle;
    if (!run_quietly("ip link add name dlmaster type veth peer name dlslave") || !run_quietly("ip link show dlslave")) {
      GTEST_SKIP() << "no veth pair: the kernel lacks the driver or `ip` is not installed";
    }
    ASSERT_TRUE(run_quietly("ip link set dev dlmaster up && ip link set dev dlslave up"));
    auto master_port = RawSocketPort::open({.interface = "dlmaster"}, clock);
    auto slave_port = RawSocketPort::open({.interface = "dlslave"}, clock);
    ASSERT_TRUE(master_port) << master_port.error().message;
    ASSERT_TRUE(slave_port) << slave_port.error().message;
    master = std::move(*master_port);
    slave = std::move(*slave_port);
  }

  void TearDown() override { run_quietly("ip link delete dlmaster"); }

  std::optional<Bytes> next(RawSocketPort& port) {
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
  std::unique_ptr<RawSocketPort> master;
  std::unique_ptr<RawSocketPort> slave;
};

TEST_F(VethPair, LineAtTheOtherEndAnswersAndNobodySeesHisOwnFrames) {
  for (unsigned i = 0; i < 200; ++i) {
    const Bytes request = frame_of(i % 2 == 0 ? 60 : 1514, i);
    ASSERT_EQ(master->send(request), SendStatus::kSent);
    auto on_the_line = next(*slave);
    ASSERT_EQ(on_the_line, request);
    (*on_the_line)[6] |= std::byte{0x02};  // what the first slave does
    (*on_the_line)[20] ^= std::byte{0xFF};
    ASSERT_EQ(slave->send(*on_the_line), SendStatus::kSent);
    ASSERT_EQ(next(*master), on_the_line);
  }
  EXPECT_FALSE(master->receive());
  EXPECT_FALSE(slave->receive());
  for (const auto& statistics : {master->statistics(), slave->statistics()}) {
    EXPECT_EQ(statistics.sent, 200U);
    EXPECT_EQ(statistics.received, 200U);
  }
}

TEST_F(VethPair, OtherEndDownIsLinkDown) {
  ASSERT_TRUE(run_quietly("ip link set dev dlslave down"));
  EXPECT_NE(master->send(frame_of(60, 0)), SendStatus::kSent);  // at once
  // The kernel takes its time to spread news about the carrier.
  const auto patience = clock.now() + 10s;
  while (master->link_up() && clock.now() < patience) std::this_thread::sleep_for(5ms);
  EXPECT_FALSE(master->link_up());
  EXPECT_EQ(master->send(frame_of(60, 0)), SendStatus::kLinkDown);
}

TEST_F(VethPair, DeletedPairIsLinkDown) {
  ASSERT_TRUE(run_quietly("ip link delete dlmaster"));
  EXPECT_EQ(master->send(frame_of(60, 0)), SendStatus::kLinkDown);
  EXPECT_EQ(slave->send(frame_of(60, 0)), SendStatus::kLinkDown);
}

}  // namespace
}  // namespace driveline::port
