// Room in /dev/shm for a segment of Fast DDS.
#include "shared_room.hpp"

#include <gtest/gtest.h>

namespace driveline::bridge {
namespace {

struct statvfs figures(std::uint64_t block, std::uint64_t blocks, std::uint64_t free, std::uint64_t available) {
  struct statvfs facts = {};
  facts.f_frsize = block;
  facts.f_blocks = blocks;
  facts.f_bfree = free;
  facts.f_bavail = available;
  return facts;
}

TEST(SharedRoom, IsWhatAProcessWithoutPrivilegesMayUse) {
  constexpr std::uint64_t kBlock = 4096;
  constexpr std::uint64_t kNeeded = kSharedRoomBytes / kBlock;
  EXPECT_TRUE(has_shared_room(figures(kBlock, 1000, kNeeded, kNeeded)));
  EXPECT_FALSE(has_shared_room(figures(kBlock, 1000, 500, kNeeded - 1))) << "the rest is kept for root";
  EXPECT_FALSE(has_shared_room(figures(kBlock, 1000, 0, 0)));
  EXPECT_TRUE(has_shared_room(figures(65536, 1000, 8, 8))) << "large blocks";
  EXPECT_TRUE(has_shared_room(figures(kBlock, 0, 0, 0))) << "a tmpfs without limit";
}

}  // namespace
}  // namespace driveline::bridge
