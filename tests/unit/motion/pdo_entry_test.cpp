#include "driveline/motion/cia301/pdo_entry.hpp"

#include <gtest/gtest.h>

#include <array>

namespace driveline::motion {
namespace {

TEST(PdoEntry, IsLittleEndianAtItsOffset) {
  std::array<std::byte, 8> image{};
  PdoEntry<std::int32_t>(3).set(image, -2);
  EXPECT_EQ(image[2], std::byte{0});
  EXPECT_EQ(image[3], std::byte{0xFE});
  EXPECT_EQ(image[6], std::byte{0xFF});
  EXPECT_EQ(image[7], std::byte{0});
  EXPECT_EQ(PdoEntry<std::int32_t>(3).get(image), -2);
  EXPECT_EQ(PdoEntry<std::uint16_t>(3).get(image), 0xFFFE);
}

TEST(PdoEntry, OfAFloatingPointNumberIsItsIeee754Bits) {
  std::array<std::byte, 16> image{};
  PdoEntry<float>(1).set(image, -0.5F);
  EXPECT_EQ(PdoEntry<std::uint32_t>(1).get(image), 0xBF000000U);
  EXPECT_EQ(PdoEntry<float>(1).get(image), -0.5F);
  PdoEntry<double>(5).set(image, 1.0);
  EXPECT_EQ(PdoEntry<std::uint64_t>(5).get(image), 0x3FF0000000000000U);
  EXPECT_EQ(PdoEntry<double>(5).get(image), 1.0);
}

TEST(PdoEntry, OfABitLeavesItsNeighboursAlone) {
  std::array<std::byte, 2> image{std::byte{0xA5}, std::byte{0x00}};
  const PdoEntry<bool> bit(0, 1);
  EXPECT_FALSE(bit.get(image));
  bit.set(image, true);
  EXPECT_EQ(image[0], std::byte{0xA7});
  EXPECT_TRUE(bit.get(image));
  bit.set(image, false);
  EXPECT_EQ(image[0], std::byte{0xA5});
}

TEST(PdoBits, LieAcrossByteBorders) {
  std::array<std::byte, 6> image{};
  PdoBits(5, 7).set(image, 0x7F);
  EXPECT_EQ(image[0], std::byte{0xE0});
  EXPECT_EQ(image[1], std::byte{0x0F});
  PdoBits(12, 32).set(image, 0x12345678);
  EXPECT_EQ(PdoBits(12, 32).get(image), 0x12345678U);
  EXPECT_EQ(PdoBits(5, 7).get(image), 0x7FU) << "its neighbour";
  EXPECT_EQ(image[5], std::byte{0x01});
  PdoBits(5, 7).set(image, 0x80);
  EXPECT_EQ(PdoBits(5, 7).get(image), 0U) << "more bits than there is room for";
  EXPECT_EQ(PdoBits(12, 32).get(image), 0x12345678U);
}

}  // namespace
}  // namespace driveline::motion
