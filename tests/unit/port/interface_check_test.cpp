#include "driveline/port/interface_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace driveline::port {
namespace {

using rt::Cost;
using testing::HasSubstr;

/// An interface without findings.
InterfaceFacts good() {
  InterfaceFacts facts;
  facts.name = "eth1";
  facts.driver = "igb";
  facts.up = true;
  facts.running = true;
  facts.mtu = 1500;
  facts.speed_mbit_s = 100;
  facts.full_duplex = true;
  facts.coalescing = Coalescing{};
  facts.receive_offload = false;
  facts.energy_saving = false;
  facts.flow_control = false;
  return facts;
}

rt::RealtimeItem item(const InterfaceFacts& facts, const std::string& name) {
  const auto items = inspect_interface(facts);
  const auto found = std::find_if(items.begin(), items.end(), [&](const auto& each) { return each.name == name; });
  if (found != items.end()) return *found;
  ADD_FAILURE() << "no item " << name;
  return {};
}

/// The names of the findings.
std::vector<std::string> findings(const InterfaceFacts& facts) {
  std::vector<std::string> names;
  for (const auto& each : inspect_interface(facts)) {
    if (each.ok) continue;
    names.push_back(each.name);
    EXPECT_FALSE(each.consequence.empty()) << each.name;
    EXPECT_THAT(each.remedy, HasSubstr(each.name == "link" && facts.up ? "slave" : "eth1")) << each.name;
  }
  return names;
}

TEST(InterfaceCheck, AGoodOneHasNoFinding) {
  EXPECT_THAT(findings(good()), testing::IsEmpty());
}

/// One end of a veth pair: it has no device, and its driver reports 10 Gbit/s.
TEST(InterfaceCheck, WhatADriverDoesNotTellIsNoFinding) {
  InterfaceFacts veth = good();
  veth.driver.clear();
  veth.speed_mbit_s = 10'000;
  veth.coalescing.reset();
  veth.receive_offload.reset();
  veth.energy_saving.reset();
  veth.flow_control.reset();
  EXPECT_THAT(findings(veth), testing::IsEmpty());
  EXPECT_EQ(item(veth, "interrupt coalescing").effective, "not reported by the driver");
}

TEST(InterfaceCheck, ALinkThatIsDownPrevents) {
  InterfaceFacts facts = good();
  facts.running = false;
  EXPECT_EQ(item(facts, "link").effective, "up, no carrier, driver igb");
  facts.up = false;
  EXPECT_EQ(item(facts, "link").cost, Cost::kPrevents);
  EXPECT_EQ(item(facts, "link").remedy, "`ip link set dev eth1 up`");
  EXPECT_THAT(findings(facts), testing::ElementsAre("link"));
}

TEST(InterfaceCheck, OtherSpeedsAreNoEtherCat) {
  InterfaceFacts facts = good();
  facts.speed_mbit_s = 1000;
  EXPECT_EQ(item(facts, "link speed").effective, "1000 Mbit/s, full duplex");
  EXPECT_THAT(findings(facts), testing::ElementsAre("link speed"));
  facts.speed_mbit_s = 100;
  facts.full_duplex = false;
  EXPECT_THAT(item(facts, "link speed").consequence, HasSubstr("collide"));
}

TEST(InterfaceCheck, FramesOfFullLengthMustPass) {
  InterfaceFacts facts = good();
  facts.mtu = 1499;
  EXPECT_EQ(item(facts, "MTU").cost, Cost::kPrevents);
  facts.mtu = 9000;
  EXPECT_TRUE(item(facts, "MTU").ok);
}

TEST(InterfaceCheck, CoalescingCostsWhatItWaits) {
  InterfaceFacts facts = good();
  facts.coalescing = Coalescing{.rx_usecs = 3, .tx_usecs = 0, .adaptive = false};
  EXPECT_EQ(item(facts, "interrupt coalescing").cost, Cost::kMicroseconds);
  EXPECT_EQ(item(facts, "interrupt coalescing").effective, "rx 3 us, tx 0 us");
  facts.coalescing->rx_usecs = 50;
  EXPECT_EQ(item(facts, "interrupt coalescing").cost, Cost::kPeriods);
  facts.coalescing = Coalescing{.rx_usecs = 0, .tx_usecs = 0, .adaptive = true};
  EXPECT_FALSE(item(facts, "interrupt coalescing").ok);
  facts.coalescing = Coalescing{.rx_usecs = 1, .tx_usecs = 1, .adaptive = false};
  EXPECT_TRUE(item(facts, "interrupt coalescing").ok) << "how some drivers write \"at once\"";
}

TEST(InterfaceCheck, WhatDelaysOrAddsFramesIsFound) {
  InterfaceFacts facts = good();
  facts.receive_offload = true;
  facts.energy_saving = true;
  facts.flow_control = true;
  facts.ip_addresses = {"192.168.0.2", "fe80::1"};
  EXPECT_THAT(findings(facts),
              testing::ElementsAre("receive offload", "energy saving (EEE)", "flow control", "other traffic"));
  EXPECT_EQ(item(facts, "other traffic").effective, "192.168.0.2, fe80::1");
}

TEST(InterfaceFactsOfThisMachine, AnInterfaceThatIsNotThereIsAnError) {
  const auto facts = read_interface_facts("dl-nowhere");
  ASSERT_FALSE(facts.has_value());
  EXPECT_EQ(facts.error().code, PortErrorCode::kNoSuchInterface);
  EXPECT_EQ(read_interface_facts("").error().code, PortErrorCode::kInvalidName);
  EXPECT_EQ(read_interface_facts("lo").error().code, PortErrorCode::kNotEthernet);
}

}  // namespace
}  // namespace driveline::port
