#include "driveline/slaves/bit_copy.hpp"

#include <gtest/gtest.h>

#include <random>

#include "sample_dictionary.hpp"

namespace driveline::slaves {
namespace {

TEST(BitCopy, LoadsAcrossByteBorders) {
  const auto data = bytes({0b1010'1100, 0b0101'0011, 0xFF});
  EXPECT_EQ(load_bits(data, 2, 3), 0b011U);
  EXPECT_EQ(load_bits(data, 6, 6), 0b0011'10U);
  EXPECT_EQ(load_bits(data, 4, 16), 0xF53AU);
}

TEST(BitCopy, StoresAndLeavesTheNeighboursAlone) {
  auto data = bytes({0xFF, 0xFF, 0xFF});
  store_bits(data, 6, 4, 0);
  EXPECT_EQ(data, bytes({0x3F, 0xFC, 0xFF}));
  store_bits(data, 7, 2, 0xFFFF);  // more than two bits of value
  EXPECT_EQ(data, bytes({0xBF, 0xFD, 0xFF}));
}

TEST(BitCopy, AgreesWithNumbersForAnyPlace) {
  std::mt19937_64 random(7);
  for (int run = 0; run < 10000; ++run) {
    const std::size_t count = 1 + random() % 64;
    const std::size_t bit = random() % 60;
    const std::uint64_t value = random();
    const std::uint64_t kept = count == 64 ? value : value & ((std::uint64_t{1} << count) - 1);
    std::vector<std::byte> data(16, std::byte{0xA5});
    store_bits(data, bit, count, value);
    ASSERT_EQ(load_bits(data, bit, count), kept) << bit << " " << count;
    store_bits(data, bit, count, load_bits(std::vector<std::byte>(16, std::byte{0xA5}), bit, count));
    ASSERT_EQ(data, std::vector<std::byte>(16, std::byte{0xA5})) << "only its own bits";
  }
}

TEST(BitCopy, SignExtends) {
  EXPECT_EQ(sign_extended(0b101, 3), static_cast<std::uint64_t>(-3));
  EXPECT_EQ(sign_extended(0b011, 3), 3U);
  EXPECT_EQ(sign_extended(0xFFFF, 16), static_cast<std::uint64_t>(-1));
  EXPECT_EQ(sign_extended(0x8000000000000000U, 64), 0x8000000000000000U);
}

}  // namespace
}  // namespace driveline::slaves
