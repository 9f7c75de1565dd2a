// Several slaves that are plugged in and removed together, identified by the first of them.
#include <gmock/gmock.h>

#include "movable_group.hpp"

namespace driveline::bus_test {
namespace {

using Place = MovableGroup::Place;
using testing::HasSubstr;
using wire::AlState;

TEST(HotConnectGroup, AbsentAtTheStartJoinsWhole) {
  MovableGroup group;
  ASSERT_EQ(sentence(group.start()), "");
  EXPECT_TRUE(group.supervisor->all_operational()) << "nobody waits for it";
  EXPECT_EQ(group.master.slaves().size(), 4U);
  group.live(milliseconds{300});
  EXPECT_EQ(group.told(), "");
  group.plug(Place::kA);
  ASSERT_TRUE(group.live_until_in_op(Place::kA)) << group.told();
  EXPECT_EQ(group.told(), "slave 2: joined the line and is in OP\nslave 3: joined the line and is in OP\n");
  EXPECT_TRUE(group.master.core()->slave_report(2).valid);
  EXPECT_TRUE(group.master.core()->slave_report(3).valid);
  EXPECT_EQ(group.master.slaves()[3].info.description.serial_number, 1002U) << "what it says, not one of its kind";
  EXPECT_EQ(group.master.core()->statistics().lost_frames, 0U);
}

TEST(HotConnectGroup, LeavesAndJoinsElsewhere) {
  MovableGroup group;
  ASSERT_EQ(sentence(group.start()), "");
  group.plug(Place::kA);
  ASSERT_TRUE(group.live_until_in_op(Place::kA)) << group.told();
  for (int round = 0; round < 2; ++round) {
    group.unplug(Place::kA);
    group.live(milliseconds{200});
    EXPECT_FALSE(group.supervisor->operational(2));
    EXPECT_FALSE(group.supervisor->operational(3));
    EXPECT_TRUE(group.supervisor->operational(0));
    EXPECT_TRUE(group.supervisor->operational(1)) << "mid has moved up, and is who it was";
    group.plug(Place::kB);
    ASSERT_TRUE(group.live_until_in_op(Place::kB)) << group.told();
    EXPECT_TRUE(group.supervisor->all_operational());
    group.unplug(Place::kB);
    group.live(milliseconds{200});
    group.plug(Place::kA);
    ASSERT_TRUE(group.live_until_in_op(Place::kA)) << group.told();
  }
  EXPECT_EQ(group.supervisor->recoveries(), 8U);
  EXPECT_EQ(sentence(group.master.shut_down()), "");
  for (const std::size_t drive : {0U, 1U, 2U, 3U}) EXPECT_EQ(group.line.slave(drive).state(), AlState::kInit) << drive;
}

TEST(HotConnectGroup, IsFoundInTheMiddleOfTheLineAtTheStart) {
  MovableGroup group;
  group.plug(Place::kA);
  ASSERT_EQ(sentence(group.start()), "");
  EXPECT_EQ(group.master.position_of(MovableGroup::kHead), 1U);
  EXPECT_EQ(group.master.position_of(MovableGroup::kFollower), 2U);
  EXPECT_EQ(group.master.position_of(1), 3U);
  group.unplug(Place::kA);
  group.live(milliseconds{200});
  group.plug(Place::kB);
  ASSERT_TRUE(group.live_until_in_op(Place::kB)) << group.told();
}

TEST(HotConnectGroup, FollowerThatComesLaterJoinsLater) {
  MovableGroup group;
  ASSERT_EQ(sentence(group.start()), "");
  group.line.line().set_power(1, true);
  group.live(std::chrono::seconds{1});
  EXPECT_TRUE(group.supervisor->operational(2)) << group.told();
  EXPECT_FALSE(group.supervisor->operational(3));
  EXPECT_TRUE(group.supervisor->operational(1)) << "mid stands where the follower should, and keeps its name";
  group.line.line().set_power(2, true);
  ASSERT_TRUE(group.live_until_in_op(Place::kA)) << group.told();
}

TEST(HotConnectGroup, WithoutItsHeadNobodyIsTakenForAFollower) {
  // Another drive at the position of the head: no alias.
  MovableGroup other([](std::size_t drive, auto& profile) {
    if (drive == 1) set_alias(profile, 0);
  });
  ASSERT_EQ(sentence(other.start()), "");
  other.plug(Place::kA);
  other.live(std::chrono::seconds{1});
  EXPECT_EQ(other.told(), "");
  EXPECT_EQ(other.line.slave(2).state(), AlState::kInit);
}

TEST(HotConnectGroup, AnotherDeviceBehindTheHeadIsNamedAndLeftAlone) {
  constexpr std::size_t kProductCodeByte = 20;  // words 10 and 11 of the EEPROM
  MovableGroup group([](std::size_t drive, auto& profile) {
    if (drive == 2) profile.sii_image[kProductCodeByte] ^= std::byte{0x40};
  });
  ASSERT_EQ(sentence(group.start()), "");
  group.plug(Place::kA);
  group.live(std::chrono::seconds{1});
  EXPECT_THAT(group.told(), HasSubstr("slave 2: joined the line and is in OP\n"));
  EXPECT_THAT(group.told(), HasSubstr("slave 3: not brought back to OP: slave 3: product code is 0x"));
  EXPECT_EQ(group.line.slave(2).state(), AlState::kInit);
}

TEST(HotConnectGroup, IncompleteAtTheStartIsRefused) {
  MovableGroup group;
  group.line.line().set_power(4, true);  // at the end of the line
  EXPECT_EQ(sentence(group.start()), "planned slave 3 is not on the line; 3 slaves answer, 4 are planned");
  const auto& differences = group.master.comparison().differences;
  ASSERT_EQ(differences.size(), 1U);
  EXPECT_EQ(differences[0].kind, ecat_master::Difference::Kind::kMissing);
  EXPECT_EQ(differences[0].plan, MovableGroup::kFollower);
}

}  // namespace
}  // namespace driveline::bus_test
