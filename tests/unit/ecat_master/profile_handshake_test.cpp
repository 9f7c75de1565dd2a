#include <gtest/gtest.h>

#include "driveline/ecat_master/cia402/cia402.hpp"
#include "driveline/ecat_master/single_axis/profile_handshake.hpp"

namespace driveline::ecat_master {
namespace {

using namespace std::chrono_literals;
using State = ProfileHandshake::State;

constexpr std::uint16_t kReachedBit = cia402::status_bit::kTargetReached;
constexpr std::uint16_t kAcknowledgeBit = cia402::status_bit::kSetpointAcknowledge;
constexpr std::uint16_t kGivenBits = cia402::command_bit::kNewSetpoint | cia402::command_bit::kImmediately;

TEST(ProfileHandshake, APositionIsGivenOnceAndReachedBehindThat) {
  ProfileHandshake handshake;
  handshake.start_position();
  EXPECT_EQ(handshake.command_bits(), cia402::command_bit::kImmediately);
  EXPECT_EQ(handshake.judge(kReachedBit | kAcknowledgeBit, 1ms), State::kRunning) << "of the target before";
  EXPECT_EQ(handshake.command_bits(), cia402::command_bit::kImmediately);
  EXPECT_EQ(handshake.judge(kReachedBit, 2ms), State::kRunning);
  EXPECT_EQ(handshake.command_bits(), kGivenBits);
  EXPECT_EQ(handshake.judge(kReachedBit, 3ms), State::kRunning) << "not taken yet";
  EXPECT_EQ(handshake.judge(kAcknowledgeBit, 4ms), State::kRunning);
  EXPECT_EQ(handshake.command_bits(), cia402::command_bit::kImmediately);
  EXPECT_EQ(handshake.judge(kAcknowledgeBit | kReachedBit, 5ms), State::kRunning);
  EXPECT_EQ(handshake.judge(0, 6ms), State::kRunning);
  EXPECT_EQ(handshake.judge(kReachedBit, 10s), State::kReached);
}

TEST(ProfileHandshake, ADriveThatDoesNotAcknowledgeHasNotTakenIt) {
  ProfileHandshake handshake;
  handshake.start_position();
  EXPECT_EQ(handshake.judge(kReachedBit, 500ms), State::kRunning);
  EXPECT_EQ(handshake.judge(kReachedBit, 501ms), State::kNotTaken);
}

TEST(ProfileHandshake, AnOldVelocityIsNotTheNewOne) {
  ProfileHandshake handshake;
  handshake.start_velocity(kReachedBit);
  EXPECT_EQ(handshake.command_bits(), 0);
  EXPECT_EQ(handshake.judge(kReachedBit, 1ms), State::kRunning);
  EXPECT_EQ(handshake.judge(0, 2ms), State::kRunning);
  EXPECT_EQ(handshake.judge(kReachedBit, 3ms), State::kReached);
  handshake.start_velocity(kReachedBit);
  EXPECT_EQ(handshake.judge(kReachedBit, 49ms), State::kRunning);
  EXPECT_EQ(handshake.judge(kReachedBit, 50ms), State::kReached) << "the same velocity again";
}

}  // namespace
}  // namespace driveline::ecat_master
