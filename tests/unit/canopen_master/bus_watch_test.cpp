#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "driveline/canopen_master/bus_watch.hpp"
#include "driveline/canopen_wire/candump.hpp"

namespace driveline::canopen {
namespace {

using namespace std::chrono_literals;
using Kind = MasterEvent::Kind;

class BusWatchTest : public ::testing::Test {
 protected:
  static MasterPlan plan() {
    MasterPlan plan;
    plan.master_id = 126;
    plan.nodes.push_back({.name = "a", .id = 10, .rpdos = {{.number = 1}, {.number = 2, .identifier = 0x3F1}}});
    return plan;
  }
  void receive(const std::string& frame, std::chrono::nanoseconds time = 1s) {
    watch.receive({*candump::parse_frame(frame), time});
  }
  std::vector<MasterEvent> take() {
    std::vector<MasterEvent> events;
    while (const auto event = watch.take_event()) events.push_back(*event);
    return events;
  }

  BusWatch watch{plan()};
};

TEST_F(BusWatchTest, SignsOfAnotherMaster) {
  for (const auto& [frame, sign] : {std::pair{"000#0100", OtherMasterSign::kNmt},
                                    {"080#", OtherMasterSign::kSync},
                                    {"080#07", OtherMasterSign::kSync},
                                    {"77E#05", OtherMasterSign::kHeartbeat},
                                    {"20A#0600", OtherMasterSign::kRpdo},
                                    {"3F1#00000000", OtherMasterSign::kRpdo}}) {
    BusWatch one{plan()};
    one.receive({*candump::parse_frame(frame), 1s});
    EXPECT_EQ(one.other_master(), sign) << frame;
    EXPECT_EQ(one.take_event()->other, sign) << frame;
  }
}

TEST_F(BusWatchTest, WhatNodesSendIsNoSign) {
  for (const auto* frame : {"18A#0000", "58A#4300100000000000", "60A#4000100000000000", "70A#05",
                            "08A#0000000000000000", "77E#R1", "00000080#", "30A#00"}) {
    receive(frame);
  }
  EXPECT_FALSE(watch.other_master());
  EXPECT_TRUE(take().empty());
}

TEST_F(BusWatchTest, AMasterThatGoesOnIsToldNowAndThen) {
  for (int i = 0; i < 1000; ++i) receive("080#", 1s + i * 21ms);
  EXPECT_EQ(take().size(), 3U);
}

TEST_F(BusWatchTest, AStrangerIsToldOnce) {
  for (int i = 0; i < 3; ++i) receive("711#7F");
  const auto events = take();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(describe(events[0], ""), "node 17 is on this bus and not in the line description");
}

TEST_F(BusWatchTest, TheStateOfTheAdapter) {
  PortStatistics port;
  port.state = BusState::kErrorPassive;
  watch.look(port, 1s);
  EXPECT_TRUE(take().empty());
  port.state = BusState::kBusOff;
  watch.look(port, 2s);
  watch.look(port, 3s);
  port.state = BusState::kErrorActive;
  watch.look(port, 4s);
  port.down = true;
  watch.look(port, 5s);
  const auto events = take();
  ASSERT_EQ(events.size(), 3U);
  EXPECT_EQ(events[0].kind, Kind::kBusOff);
  EXPECT_EQ(events[1].kind, Kind::kBusBack);
  EXPECT_EQ(events[2].kind, Kind::kBusDown);
  EXPECT_EQ(events[2].time, 5s);
}

}  // namespace
}  // namespace driveline::canopen
