#include "driveline/bytes/endian.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <vector>

#include "support/bytes.hpp"

namespace driveline::bytes {
namespace {

using bytes_test::hex;

TEST(Endian, LittleEndianLoads) {
  const auto bytes = hex("f1 e2 d3 c4 b5 a6 97 88");
  EXPECT_EQ(load_le<std::uint8_t>(bytes), 0xF1);
  EXPECT_EQ(load_le<std::uint16_t>(bytes), 0xE2F1);
  EXPECT_EQ(load_le<std::uint32_t>(bytes), 0xC4D3E2F1U);
  EXPECT_EQ(load_le<std::uint64_t>(bytes), 0x8897A6B5C4D3E2F1U);
  EXPECT_EQ(load_le<std::int8_t>(bytes), -15);
  EXPECT_EQ(load_le<std::int16_t>(bytes), -0x1D0F);
  EXPECT_EQ(load_le<std::int32_t>(bytes), -0x3B2C1D0F);
  EXPECT_LT(load_le<std::int64_t>(bytes), 0);
}

TEST(Endian, LittleEndianStores) {
  std::array<std::byte, 9> out{};
  out.fill(std::byte{0xEE});
  store_le<std::int64_t>(out, -2);
  EXPECT_EQ(std::vector(out.begin(), out.end()), hex("fe ff ff ff ff ff ff ff ee"));
  store_le<std::uint16_t>(out, 0x1234);
  EXPECT_EQ(std::vector(out.begin(), out.begin() + 3), hex("34 12 ff"));
}

TEST(Endian, BigEndian) {
  EXPECT_EQ(load_be16(hex("88 a4")), 0x88A4);
  std::array<std::byte, 2> out{};
  store_be16(out, 0x88A4);
  EXPECT_EQ(std::vector(out.begin(), out.end()), hex("88 a4"));
}

template <typename T>
class EndianLimits : public ::testing::Test {};
using Integers = ::testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
                                  std::uint64_t, std::int64_t>;
TYPED_TEST_SUITE(EndianLimits, Integers);

TYPED_TEST(EndianLimits, SurviveTheRoundTrip) {
  using Limits = std::numeric_limits<TypeParam>;
  for (const TypeParam value : {Limits::min(), TypeParam{0}, TypeParam{1}, Limits::max()}) {
    const auto bytes = to_le_bytes(value);
    EXPECT_EQ(bytes.size(), sizeof(TypeParam));
    EXPECT_EQ(load_le<TypeParam>(bytes), value);
  }
}

static_assert(load_le<std::uint16_t>(to_le_bytes<std::uint16_t>(0xABCD)) == 0xABCD, "usable at compile time");

}  // namespace
}  // namespace driveline::bytes
