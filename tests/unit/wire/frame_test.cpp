#include "driveline/wire/frame.hpp"

#include <gtest/gtest.h>

#include <random>

#include "bytes.hpp"
#include "support/must.hpp"

namespace driveline::wire {
namespace {

using test::Bytes;
using test::bytes_of;

/// twincat packet 18: BWR of 8 bytes to 0x0300 and BRD of 2 bytes from 0x0130, as returned by a slave.
constexpr std::string_view kTwoDatagrams =
    "01 01 05 01 00 00 02 00 00 00 00 00 88 a4 22 10 08 83 01 00 00 03 08 80 00 00 00 00 00 00 00 00"
    "00 00 01 00 07 00 01 00 30 01 02 00 00 00 01 00 01 00 00 00 00 00 00 00 00 00 00 00";

constexpr MacAddress kMac{std::byte{2}, std::byte{0}, std::byte{0}, std::byte{0}, std::byte{0}, std::byte{0}};
constexpr MacAddress kMulticast{std::byte{1}, std::byte{1}, std::byte{5}, std::byte{1}, std::byte{0}, std::byte{0}};

Bytes to_bytes(std::span<const std::byte> bytes) {
  return {bytes.begin(), bytes.end()};
}

/// Three datagrams with 4, 0 and 3 bytes of data, without padding behind them.
Bytes three_datagrams() {
  std::array<std::byte, 1514> buffer{};
  FrameBuilder builder(buffer, kMac);
  builder.add(Command::kFprd, 1, DatagramAddress::physical(0x1001, 0x0110), 4);
  builder.add(Command::kNop, 2, DatagramAddress::logical(0), 0);
  builder.add(Command::kLrw, 3, DatagramAddress::logical(0x10000), 30);
  return to_bytes(builder.finish());
}

/// Number of datagrams, or the error.
Decoded<int> walk(std::span<const std::byte> frame) {
  auto cursor = DatagramCursor::open(frame);
  if (!cursor) return tl::unexpected(cursor.error());
  int count = 0;
  while (!cursor->done()) {
    const auto datagram = cursor->next();
    if (!datagram) return tl::unexpected(datagram.error());
    ++count;
  }
  return count;
}

TEST(FrameBuilder, BuildsACapturedFrame) {
  std::array<std::byte, 1514> buffer{};
  buffer.fill(std::byte{0xEE});
  FrameBuilder builder(buffer, kMac, kMulticast);
  EXPECT_TRUE(builder.empty());
  const auto write = builder.add(Command::kBwr, 0x83, DatagramAddress::physical(1, 0x0300), 8);
  const auto read = builder.add(Command::kBrd, 0, DatagramAddress::physical(1, 0x0130), 2);
  ASSERT_TRUE(write && read);
  EXPECT_FALSE(builder.empty());
  bytes::store_le<std::uint16_t>(builder.data(*read), 1);
  auto frame = builder.finish();
  bytes::store_le<std::uint16_t>(frame.subspan(write->working_counter()), 1);
  bytes::store_le<std::uint16_t>(frame.subspan(read->working_counter()), 1);
  EXPECT_EQ(to_bytes(frame), bytes_of(kTwoDatagrams));
}

TEST(FrameBuilder, PlacesLieBehindEachOther) {
  std::array<std::byte, 200> buffer{};
  FrameBuilder builder(buffer, kMac);
  const auto first = builder.add(Command::kBrd, 0, {}, 5).value();
  const auto second = builder.add(Command::kBrd, 0, {}, 6).value();
  EXPECT_EQ(first.header, 16U);
  EXPECT_EQ(first.data(), 26U);
  EXPECT_EQ(first.working_counter(), 31U);
  EXPECT_EQ(second.header, 33U);
  EXPECT_EQ(builder.data(second).size(), 6U);
}

TEST(FrameBuilder, FillsAnEthernetFrameToTheLastByte) {
  std::array<std::byte, 3000> buffer{};
  FrameBuilder builder(buffer, kMac);
  EXPECT_EQ(builder.room(), 1486U);
  EXPECT_EQ(kMaxDatagramData, 1486U);
  EXPECT_FALSE(builder.add(Command::kLrw, 0, {}, 1487));
  EXPECT_TRUE(builder.empty());
  EXPECT_TRUE(builder.add(Command::kLrw, 0, {}, 1486));
  EXPECT_EQ(builder.room(), 0U);
  EXPECT_FALSE(builder.add(Command::kNop, 0, {}, 0));
  const auto frame = builder.finish();
  EXPECT_EQ(frame.size(), 1514U);
  EXPECT_EQ(walk(frame), 1);
}

TEST(FrameBuilder, RoomIsExactlyWhatFits) {
  std::mt19937 random(3);
  for (int round = 0; round < 500; ++round) {
    Bytes buffer(60 + random() % 1500);
    FrameBuilder builder(buffer, kMac);
    int datagrams = 0;
    while (builder.room() > 0) {
      const std::size_t length = 1 + random() % builder.room();
      ASSERT_FALSE(builder.add(Command::kLrw, 0, {}, builder.room() + 1));
      ASSERT_TRUE(builder.add(Command::kLrw, 0, {}, length));
      ++datagrams;
    }
    const auto frame = builder.finish();
    ASSERT_LE(frame.size(), buffer.size());
    ASSERT_EQ(walk(frame), datagrams);
  }
}

TEST(FrameBuilder, RefusedDatagramLeavesTheFrameAsItWas) {
  std::array<std::byte, 60> buffer{};
  FrameBuilder builder(buffer, kMac);
  ASSERT_TRUE(builder.add(Command::kBrd, 0, {}, 20));
  ASSERT_FALSE(builder.add(Command::kBrd, 0, {}, 20));
  EXPECT_EQ(walk(builder.finish()), 1);  // no "more" flag without a follower
}

TEST(FrameBuilder, PadsWithZerosToTheEthernetMinimum) {
  std::array<std::byte, 100> buffer{};
  buffer.fill(std::byte{0xEE});
  FrameBuilder builder(buffer, kMac);
  builder.add(Command::kBrd, 0, {}, 1);
  const auto frame = builder.finish();
  ASSERT_EQ(frame.size(), 60U);
  for (std::size_t i = 29; i < 60; ++i) EXPECT_EQ(frame[i], std::byte{0}) << i;
}

TEST(DatagramCursor, WalksACapturedFrame) {
  const auto frame = bytes_of(kTwoDatagrams);
  auto cursor = must(DatagramCursor::open(frame));
  const auto write = must(cursor->next());
  EXPECT_FALSE(cursor->done());
  EXPECT_EQ(write->header.command, Command::kBwr);
  EXPECT_EQ(write->header.address, DatagramAddress::physical(1, 0x0300));
  EXPECT_EQ(write->data.size(), 8U);
  EXPECT_EQ(write->working_counter(), 1);
  const auto read = must(cursor->next());
  EXPECT_TRUE(cursor->done());
  EXPECT_EQ(read->header.command, Command::kBrd);
  EXPECT_EQ(bytes::load_le<std::uint16_t>(read->data), 1);
  EXPECT_EQ(read->place.header, 36U);
  EXPECT_EQ(read->working_counter(), 1);
}

TEST(DatagramCursor, MutableCursorWritesInPlace) {
  auto frame = bytes_of(kTwoDatagrams);
  auto cursor = must(MutableDatagramCursor::open(frame));
  const auto datagram = must(cursor->next());
  datagram->data[0] = std::byte{0x77};
  bytes::store_le<std::uint16_t>(datagram->working_counter_bytes, 0x1234);
  EXPECT_EQ(frame[26], std::byte{0x77});
  EXPECT_EQ(frame[34], std::byte{0x34});
  EXPECT_EQ(frame[35], std::byte{0x12});
}

TEST(DatagramCursor, FrameWithoutDatagramsIsDoneAtOnce) {
  std::array<std::byte, 60> buffer{};
  FrameBuilder builder(buffer, kMac);
  EXPECT_EQ(walk(builder.finish()), 0);
}

TEST(DatagramCursor, EveryTruncationIsRejected) {
  const auto frame = three_datagrams();
  ASSERT_EQ(walk(frame), 3);
  ASSERT_EQ(frame.size(), 86U);
  for (std::size_t size = 0; size < frame.size(); ++size) {
    const auto result = walk(std::span(frame).first(size));
    ASSERT_FALSE(result) << size;
    EXPECT_EQ(result.error(), size < 16 ? DecodeError::kTooShort : DecodeError::kBadLength) << size;
  }
}

/// `frame` with the 16-bit word at `offset` replaced.
Bytes with_word(Bytes frame, std::size_t offset, std::uint16_t value) {
  bytes::store_le<std::uint16_t>(std::span(frame).subspan(offset), value);
  return frame;
}

TEST(DatagramCursor, EtherCatLengthThatLies) {
  const auto frame = three_datagrams();  // 70 bytes of datagrams: 16 + 12 + 42
  for (std::uint16_t length = 0; length <= 0x7FF; ++length) {
    const auto result = walk(with_word(frame, 14, static_cast<std::uint16_t>(0x1000 | length)));
    if (length == 70) {
      EXPECT_EQ(result, 3);
    } else if (length == 0) {
      EXPECT_EQ(result, 0);
    } else {
      ASSERT_FALSE(result) << length;
      // Cut in a header: too short. Cut behind it or longer than the frame: bad length.
      const bool in_header = length < 10 || (length >= 16 && length < 26) || (length >= 28 && length < 38);
      EXPECT_EQ(result.error(), in_header ? DecodeError::kTooShort : DecodeError::kBadLength) << length;
    }
  }
}

TEST(DatagramCursor, DatagramLengthThatLies) {
  const auto frame = three_datagrams();
  for (std::uint16_t length = 0; length <= 0x7FF; ++length) {
    const auto last = walk(with_word(frame, 16 + 28 + 6, length));
    if (length <= 30) {
      EXPECT_EQ(last, 3) << length;  // bytes behind the last datagram are ignored
    } else {
      ASSERT_FALSE(last) << length;
      EXPECT_EQ(last.error(), DecodeError::kBadLength);
    }
  }
}

TEST(DatagramCursor, MoreFlagWithoutFollower) {
  const auto frame = three_datagrams();
  const auto result = walk(with_word(frame, 16 + 28 + 6, 0x801E));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error(), DecodeError::kTooShort);
}

TEST(DatagramCursor, ErrorEndsTheWalk) {
  const auto frame = with_word(three_datagrams(), 22, 0x87FF);
  auto cursor = must(DatagramCursor::open(frame));
  EXPECT_FALSE(cursor->next());
  EXPECT_TRUE(cursor->done());
}

TEST(DatagramCursor, OtherEtherTypes) {
  for (const unsigned type : {0x0000U, 0x0800U, 0x88A3U, 0x88A5U, 0xA488U, 0x88CCU, 0xFFFFU}) {
    auto frame = three_datagrams();
    bytes::store_be16(std::span(frame).subspan(12), static_cast<std::uint16_t>(type));
    const auto result = walk(frame);
    ASSERT_FALSE(result) << type;
    EXPECT_EQ(result.error(), DecodeError::kNotEtherCat) << type;
  }
}

TEST(DatagramCursor, OtherEtherCatTypes) {
  for (unsigned type = 0; type < 16; ++type) {
    const auto result = walk(with_word(three_datagrams(), 14, static_cast<std::uint16_t>((type << 12) | 70U)));
    if (type == 1) {
      EXPECT_EQ(result, 3);
    } else {
      ASSERT_FALSE(result) << type;
      EXPECT_EQ(result.error(), DecodeError::kNotCommands) << type;
    }
  }
}

Bytes with_vlan(const Bytes& frame) {
  Bytes tagged(frame.begin(), frame.begin() + 12);
  const auto tag = bytes_of("81 00 60 05");
  tagged.insert(tagged.end(), tag.begin(), tag.end());
  tagged.insert(tagged.end(), frame.begin() + 12, frame.end());
  return tagged;
}

TEST(DatagramCursor, VlanTag) {
  const auto frame = with_vlan(three_datagrams());
  EXPECT_EQ(walk(frame), 3);
  auto cursor = DatagramCursor::open(frame);
  EXPECT_EQ(cursor->next()->place.header, 20U);
  for (std::size_t size = 0; size < frame.size(); ++size) {
    ASSERT_FALSE(walk(std::span(frame).first(size))) << size;
  }
}

TEST(DatagramCursor, TwoVlanTagsAreNotEtherCat) {
  const auto result = walk(with_vlan(with_vlan(three_datagrams())));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error(), DecodeError::kNotEtherCat);
}

TEST(DatagramCursor, PayloadOfUdp) {
  const auto frame = three_datagrams();
  Bytes udp(42, std::byte{0xEE});
  udp.insert(udp.end(), frame.begin() + 14, frame.end());
  auto cursor = must(DatagramCursor::open_payload(udp, 42));
  EXPECT_EQ(cursor->next()->header.command, Command::kFprd);
  EXPECT_FALSE(DatagramCursor::open_payload(udp, udp.size() + 1));
  EXPECT_FALSE(DatagramCursor::open_payload(udp, udp.size()));
  EXPECT_FALSE(DatagramCursor::open_payload(udp, udp.size() - 1));
}

TEST(DatagramCursor, RandomFramesNeverLeaveTheBuffer) {
  std::mt19937 random(99);
  int walked = 0;
  for (int round = 0; round < 20000; ++round) {
    Bytes frame(16 + random() % 120);
    for (auto& b : frame) b = static_cast<std::byte>(random() % 3 == 0 ? random() : random() % 3);
    bytes::store_be16(std::span(frame).subspan(12), kEtherTypeEtherCat);
    bytes::store_le<std::uint16_t>(std::span(frame).subspan(14),
                                   static_cast<std::uint16_t>(0x1000U | (random() % frame.size())));
    auto cursor = DatagramCursor::open(frame);
    while (cursor && !cursor->done()) {
      const auto datagram = cursor->next();
      if (!datagram) break;
      ASSERT_LE(datagram->place.working_counter() + 2, frame.size());
      ASSERT_EQ(datagram->data.data(), frame.data() + datagram->place.data());
      ASSERT_EQ(datagram->working_counter_bytes.size(), 2U);
      ++walked;
    }
  }
  EXPECT_GT(walked, 1000);
}

}  // namespace
}  // namespace driveline::wire
