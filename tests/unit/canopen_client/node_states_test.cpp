#include "driveline/canopen_client/node_states.hpp"

#include "scripted_port.hpp"

namespace driveline::canopen {
namespace {

class NodeStatesTest : public ::testing::Test {
 protected:
  void hear(nanoseconds time, const std::string& frame) { states.receive({*candump::parse_frame(frame), time}); }
  NodeStates states;
};

TEST_F(NodeStatesTest, BootUpHeartbeatsAndGuarding) {
  EXPECT_FALSE(states.of(3).state);
  hear(1s, "703#00");
  EXPECT_EQ(states.of(3).state, NmtState::kPreOperational) << "the boot-up message leads there";
  EXPECT_EQ(states.of(3).boot_ups, 1U);
  hear(2s, "703#05");
  hear(3s, "703#05");
  EXPECT_EQ(states.of(3).state, NmtState::kOperational);
  EXPECT_EQ(states.of(3).period, 1s);
  hear(4s, "703#84");
  EXPECT_EQ(states.of(3).state, NmtState::kStopped);
  EXPECT_EQ(states.of(3).heartbeats, 3U);
}

// CANopenNode #102: a state message without data tells no state, and a request for it neither.
TEST_F(NodeStatesTest, WhatTellsNoStateIsIgnored) {
  for (const auto* frame : {"703#", "703#0505", "703#R1", "00000703#05", "700#05", "780#05"}) hear(1s, frame);
  for (std::uint8_t node = 0; node <= kMaxNodeId; ++node) EXPECT_FALSE(states.of(node).state) << int{node};
}

// MSD manual 13.1: FF00h, register 11h, number 14, location 6.
TEST_F(NodeStatesTest, Emergencies) {
  hear(1s, "083#00FF110E06000000");
  ASSERT_TRUE(states.of(3).emergency);
  EXPECT_EQ(states.of(3).emergency->code, 0xFF00);
  EXPECT_EQ(states.of(3).emergency->error_register, 0x11);
  hear(2s, "083#00FF11");
  hear(2s, "080#");
  EXPECT_EQ(states.of(3).emergencies, 1U);
}

}  // namespace
}  // namespace driveline::canopen
