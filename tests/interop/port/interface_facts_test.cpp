#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "driveline/port/interface_check.hpp"
#include "private_network.hpp"

namespace driveline::port {
namespace {

/// Compares what the kernel reports about a real interface with the settings made by `ip` and `ethtool`.
class InterfaceFactsTest : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string& obstacle = enter_private_network(); !obstacle.empty()) GTEST_SKIP() << obstacle;
    if (!run_quietly("ip link add name dlfacts type veth peer name dlother")) {
      GTEST_SKIP() << "no veth pair: the kernel lacks the driver or `ip` is not installed";
    }
  }
  void TearDown() override { run_quietly("ip link delete dlfacts"); }

  static InterfaceFacts read() {
    const auto facts = read_interface_facts("dlfacts");
    if (facts) return *facts;
    ADD_FAILURE() << facts.error().message;
    return {};
  }
};

TEST_F(InterfaceFactsTest, FollowTheInterface) {
  EXPECT_FALSE(read().up);
  EXPECT_FALSE(read().running);
  EXPECT_EQ(read().mtu, 1500u);
  EXPECT_EQ(read().driver, "") << "there is no device";
  ASSERT_TRUE(run_quietly("ip link set dev dlfacts mtu 1400 up"));
  EXPECT_TRUE(read().up);
  EXPECT_FALSE(read().running) << "the other end is down";
  EXPECT_EQ(read().mtu, 1400u);
  ASSERT_TRUE(run_quietly("ip link set dev dlother up"));
  // The kernel reports a carrier from a work queue, which may be late on a busy machine.
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds{30};
  while (!read().running && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
  EXPECT_TRUE(read().running);
}

TEST_F(InterfaceFactsTest, AddressesOfTheInterfaceAloneAreListed) {
  ASSERT_TRUE(run_quietly("sysctl -q -w net.ipv6.conf.dlfacts.disable_ipv6=1"));
  ASSERT_TRUE(run_quietly("ip address add 10.9.8.7/24 dev dlfacts && ip address add 10.1.1.1/24 dev dlother"));
  ASSERT_TRUE(run_quietly("ip link set dev dlfacts up && ip link set dev dlother up"));
  EXPECT_THAT(read().ip_addresses, testing::ElementsAre("10.9.8.7"));
}

TEST_F(InterfaceFactsTest, ReceiveOffloadFollowsEthtool) {
  if (!run_quietly("ethtool -K dlfacts gro on")) GTEST_SKIP() << "ethtool is not installed";
  EXPECT_EQ(read().receive_offload, true);
  ASSERT_TRUE(run_quietly("ethtool -K dlfacts gro off"));
  EXPECT_EQ(read().receive_offload, false);
}

TEST_F(InterfaceFactsTest, RawSocketsAreForThoseWhoMay) {
  EXPECT_TRUE(inspect_raw_socket().ok);
  rt::RealtimeItem refused;
  std::thread{[&] {
    drop_capabilities();  // of this thread only
    refused = inspect_raw_socket();
  }}.join();
  EXPECT_FALSE(refused.ok);
  EXPECT_EQ(refused.error_number, EPERM);
  EXPECT_EQ(refused.cost, rt::Cost::kPrevents);
  EXPECT_THAT(refused.remedy, testing::HasSubstr("cap_net_raw"));
}

}  // namespace
}  // namespace driveline::port
