#include <gtest/gtest.h>

#include "driveline/motion/cia402/cia402.hpp"
#include "driveline/motion/drive/profile_handshake.hpp"

namespace driveline::motion {
namespace {

using namespace std::chrono_literals;
using State = ProfileHandshake::State;
using Change = ProfileHandshake::Change;

constexpr std::uint16_t kReachedBit = cia402::status_bit::kTargetReached;
constexpr std::uint16_t kAcknowledgeBit = cia402::status_bit::kSetpointAcknowledge;
constexpr std::uint16_t kGivenBits = cia402::command_bit::kNewSetpoint | cia402::command_bit::kImmediately;

TEST(ProfileHandshake, APositionIsGivenOnceAndReachedBehindThat) {
  ProfileHandshake handshake;
  handshake.start_position(Change::kAtOnce);
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

/// A target in progress.
ProfileHandshake under_way() {
  ProfileHandshake handshake;
  handshake.start_position(Change::kAtOnce);
  for (const std::uint16_t status : {std::uint16_t{0}, kAcknowledgeBit, std::uint16_t{0}})
    EXPECT_EQ(handshake.judge(status, 1ms), State::kRunning);
  EXPECT_TRUE(handshake.under_way());
  return handshake;
}

/// The target after the one in progress has been accepted.
ProfileHandshake with_next() {
  auto handshake = under_way();
  handshake.start_position(Change::kBehind);
  EXPECT_EQ(handshake.judge(0, 1ms), State::kRunning);
  EXPECT_EQ(handshake.command_bits(), cia402::command_bit::kNewSetpoint) << "bit 5 is 0";
  EXPECT_EQ(handshake.judge(kAcknowledgeBit, 2ms), State::kRunning);
  EXPECT_EQ(handshake.command_bits(), 0);
  return handshake;
}

TEST(ProfileHandshake, APositionThatIsToFollowWaitsInTheDrive) {
  auto handshake = with_next();
  EXPECT_EQ(handshake.judge(kAcknowledgeBit | kReachedBit, 10s), State::kRunning) << "as long as the one before takes";
  EXPECT_FALSE(handshake.under_way());
  EXPECT_EQ(handshake.judge(kReachedBit, 11s), State::kNext);
  EXPECT_TRUE(handshake.under_way());
  EXPECT_EQ(handshake.judge(kReachedBit, 1ms), State::kRunning) << "of the target before";
  EXPECT_EQ(handshake.judge(0, 2ms), State::kRunning);
  EXPECT_EQ(handshake.judge(kReachedBit, 3ms), State::kReached);
}

TEST(ProfileHandshake, APositionThatIsToFollowAndIsNotAcknowledgedHasNotBeenTaken) {
  auto handshake = under_way();
  handshake.start_position(Change::kBehind);
  EXPECT_EQ(handshake.judge(0, 500ms), State::kRunning);
  EXPECT_EQ(handshake.judge(0, 501ms), State::kNotTaken);
}

/// Bit 12 remains set then, whatever the drive has seen.
TEST(ProfileHandshake, ADriveWithoutRoomHasTimeToSeeBothEdgesOfBit4) {
  auto handshake = with_next();
  handshake.start_position(Change::kAtOnce);
  EXPECT_EQ(handshake.judge(kAcknowledgeBit, 49ms), State::kRunning);
  EXPECT_EQ(handshake.command_bits(), cia402::command_bit::kImmediately);
  EXPECT_EQ(handshake.judge(kAcknowledgeBit, 50ms), State::kRunning);
  EXPECT_EQ(handshake.command_bits(), kGivenBits);
  EXPECT_EQ(handshake.judge(kAcknowledgeBit, 99ms), State::kRunning);
  EXPECT_EQ(handshake.command_bits(), kGivenBits);
  EXPECT_EQ(handshake.judge(kAcknowledgeBit, 100ms), State::kRunning);
  EXPECT_EQ(handshake.command_bits(), cia402::command_bit::kImmediately);
  EXPECT_EQ(handshake.judge(0, 101ms), State::kRunning);
  EXPECT_EQ(handshake.judge(kReachedBit, 10s), State::kReached);
}

TEST(ProfileHandshake, ADriveThatHasGotRoomMeanwhileIsGivenTheTargetAtOnce) {
  auto handshake = with_next();
  handshake.start_position(Change::kAtOnce);
  EXPECT_EQ(handshake.judge(0, 1ms), State::kRunning);
  EXPECT_EQ(handshake.command_bits(), kGivenBits);
  EXPECT_EQ(handshake.judge(kAcknowledgeBit, 2ms), State::kRunning);
  EXPECT_EQ(handshake.command_bits(), cia402::command_bit::kImmediately);
}

TEST(ProfileHandshake, ADriveThatDoesNotAcknowledgeHasNotTakenIt) {
  ProfileHandshake handshake;
  handshake.start_position(Change::kAtOnce);
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

TEST(ProfileHandshake, ARampIsFollowedAsLongAsItsVelocityHolds) {
  ProfileHandshake handshake;
  handshake.start_velocity(0, cia402::command_bit::kFollowRamp);
  EXPECT_EQ(handshake.command_bits(), 0x70) << "enabled, not frozen, not set to zero (MSD manual Table 12.8)";
  EXPECT_EQ(handshake.judge(0, 1ms), State::kRunning);
  EXPECT_EQ(handshake.judge(kReachedBit, 2ms), State::kReached);
  EXPECT_EQ(handshake.command_bits(), 0x70);
  handshake.start_velocity(0);
  EXPECT_EQ(handshake.command_bits(), 0) << "profile velocity mode has none";
}

}  // namespace
}  // namespace driveline::motion
