#include "driveline/ecat_master/process_image.hpp"

#include <gmock/gmock.h>

namespace driveline::ecat_master {
namespace {

ProcessImage lay_out(std::vector<ProcessDataDemand> demands) {
  auto image = ProcessImage::lay_out(demands);
  EXPECT_TRUE(image.has_value());
  return image.value_or(ProcessImage{});
}

TEST(ProcessImage, OverlapsOutputsAndInputsOfASlaveButNotSlaves) {
  const auto image = lay_out({{8, 12}, {20, 4}, {0, 0}, {6, 0}, {0, 2}});
  const auto places = image.places();
  ASSERT_EQ(places.size(), 5U);
  EXPECT_EQ(places[0].offset, 0U);
  EXPECT_EQ(places[1].offset, 12U);
  EXPECT_EQ(places[2].offset, 32U);
  EXPECT_EQ(places[3].offset, 32U);
  EXPECT_EQ(places[4].offset, 38U);
  EXPECT_EQ(image.outputs().size(), 40U);
  EXPECT_EQ(image.inputs().size(), 40U);
  ASSERT_EQ(image.segments().size(), 1U);
  EXPECT_EQ(image.segments()[0].bytes, 40U);
  EXPECT_EQ(image.segments()[0].expected_working_counter, 3 + 3 + 0 + 2 + 1);
}

TEST(ProcessImage, CutsNoSlaveInTwo) {
  // 1500 - 2 - 12 bytes of data, less the AL status broadcast (14) and the drift compensation (20).
  EXPECT_EQ(ProcessImage::kMaxSegmentBytes, 1452U);
  const auto image = lay_out({{1000, 0}, {400, 0}, {60, 0}, {1452, 1}, {1, 0}});
  ASSERT_EQ(image.segments().size(), 4U);
  const std::size_t expected_bytes[] = {1400, 60, 1452, 1};
  const std::size_t expected_offsets[] = {0, 1400, 1460, 2912};
  const std::uint16_t expected_counters[] = {4, 2, 3, 2};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(image.segments()[i].bytes, expected_bytes[i]);
    EXPECT_EQ(image.segments()[i].offset, expected_offsets[i]);
    EXPECT_EQ(image.segments()[i].expected_working_counter, expected_counters[i]);
    EXPECT_LE(image.segments()[i].bytes, ProcessImage::kMaxSegmentBytes);
  }
  for (const auto& place : image.places()) {
    const auto& segment = image.segments()[place.segment];
    EXPECT_GE(place.offset, segment.offset);
    EXPECT_LE(place.offset + std::max(place.output_bytes, place.input_bytes), segment.offset + segment.bytes);
  }
}

TEST(ProcessImage, RefusesASlaveThatFitsNoFrame) {
  const std::vector<ProcessDataDemand> demands{{1, 1}, {0, 1453}};
  const auto image = ProcessImage::lay_out(demands);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().kind, ErrorKind::kProcessDataSize);
  EXPECT_EQ(image.error().slave, 1);
  EXPECT_EQ(image.error().expected, 1452U);
  EXPECT_EQ(image.error().received, 1453U);
}

TEST(ProcessImage, WithoutProcessDataHasNoSegment) {
  EXPECT_TRUE(lay_out({}).segments().empty());
  const auto image = lay_out({{0, 0}, {0, 0}});
  EXPECT_TRUE(image.segments().empty());
  EXPECT_EQ(image.places().size(), 2U);
  EXPECT_TRUE(image.outputs().empty());
}

TEST(ProcessImage, StartsAtItsLogicalAddress) {
  EXPECT_EQ(ProcessImage::logical_address(0), 0x00010000U);
  EXPECT_EQ(ProcessImage::logical_address(38), 0x00010026U);
}

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

TEST(WireTime, MatchesACalculationByHand) {
  // One frame: Ethernet 14, EtherCAT 2, BRD 12 + 2, LRW 12 + data; preamble 8, FCS 4, gap 12; 80 ns a byte.
  EXPECT_EQ(wire_time_ns(lay_out({{19, 19}}), 1, 0), (14U + 2 + 14 + 12 + 19 + 24) * 80);
  EXPECT_EQ(wire_time_ns(lay_out(std::vector<ProcessDataDemand>(8, {19, 19})), 8, 1000), 218U * 80 + 8 * 1000);
  // Nothing but the broadcast: the shortest frame, 60 bytes.
  EXPECT_EQ(wire_time_ns(lay_out({{0, 0}}), 1, 500), 84U * 80 + 500);
  // Two frames, the second without the broadcast: 16 + 14 + 12 + 1440 + 24, 16 + 12 + 100 + 24.
  EXPECT_EQ(wire_time_ns(lay_out({{1440, 0}, {100, 0}}), 0, 0), (1506U + 152) * 80);
  // A short second frame is padded to 60 bytes.
  EXPECT_EQ(wire_time_ns(lay_out({{1440, 0}, {20, 0}}), 0, 0), (1506U + 84) * 80);
}

}  // namespace
}  // namespace driveline::ecat_master
