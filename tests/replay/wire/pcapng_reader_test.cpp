#include "pcapng_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/must.hpp"

/// Tests the reader of the replay tests with files typed by hand from the format's specification.
namespace driveline::replay {
namespace {

using Bytes = std::vector<std::byte>;

/// Appends 32-bit words in the byte order of the section.
class Words {
 public:
  explicit Words(bool big_endian) : big_endian_(big_endian) {}
  Words& add(std::initializer_list<std::uint32_t> words) {
    for (const std::uint32_t word : words) {
      for (unsigned i = 0; i < 4; ++i) {
        bytes_.push_back(static_cast<std::byte>(word >> (8 * (big_endian_ ? 3 - i : i))));
      }
    }
    return *this;
  }
  Words& raw(std::initializer_list<unsigned> bytes) {
    for (const unsigned b : bytes) bytes_.push_back(static_cast<std::byte>(b));
    return *this;
  }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  bool big_endian_;
  Bytes bytes_;
};

/// A section, an interface with microseconds, a block of another kind, and one packet of five bytes.
Bytes small_file(bool big_endian) {
  Words words(big_endian);
  words.add({0x0A0D0D0A, 28, 0x1A2B3C4D}).raw({0, 0, 0, 0}).add({0xFFFFFFFF, 0xFFFFFFFF, 28});
  words.add({1, 20}).raw({0, 0, 0, 0}).add({0, 20});
  words.add({4, 12, 12});
  words.add({6, 40, 0, 0x00000001, 0x00000000, 5, 60}).raw({1, 2, 3, 4, 5, 0, 0, 0}).add({40});
  return words.bytes();
}

TEST(PcapngReader, BothByteOrders) {
  for (const bool big_endian : {false, true}) {
    const auto packets = must(parse_pcapng(small_file(big_endian)));
    ASSERT_EQ(packets->size(), 1U);
    const auto& packet = packets->front();
    EXPECT_EQ(packet.number, 1U);
    EXPECT_EQ(packet.original_length, 60U);
    EXPECT_EQ(packet.time, std::chrono::microseconds(std::int64_t{1} << 32));
    EXPECT_EQ(packet.bytes, (Bytes{std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}, std::byte{5}}));
  }
}

TEST(PcapngReader, NanosecondResolution) {
  Words words(false);
  words.add({0x0A0D0D0A, 28, 0x1A2B3C4D, 1, 0xFFFFFFFF, 0xFFFFFFFF, 28});
  words.add({1, 32, 1, 0}).raw({9, 0, 1, 0, 9, 0, 0, 0, 0, 0, 0, 0});  // if_tsresol: 10^-9
  Words packet(false);
  packet.add({32, 6, 32, 0, 0, 1234, 0, 0, 32});
  Bytes file = words.bytes();
  file.insert(file.end(), packet.bytes().begin(), packet.bytes().end());
  const auto packets = must(parse_pcapng(file));
  EXPECT_EQ(packets->at(0).time, std::chrono::nanoseconds(1234));
}

TEST(PcapngReader, EveryTruncationIsAnErrorWithItsPlace) {
  const auto file = small_file(false);
  for (std::size_t size = 0; size < file.size(); ++size) {
    const auto packets = parse_pcapng(std::span(file).first(size));
    if (size == 28 || size == 48 || size == 60) {
      EXPECT_TRUE(packets) << size;  // ends between two blocks
    } else {
      ASSERT_FALSE(packets) << size;
      EXPECT_THAT(packets.error(), ::testing::StartsWith("at byte "));
    }
  }
}

TEST(PcapngReader, MissingFile) {
  const auto packets = read_pcapng("/does/not/exist.pcapng");
  ASSERT_FALSE(packets);
  EXPECT_EQ(packets.error(), "cannot read /does/not/exist.pcapng");
}

}  // namespace
}  // namespace driveline::replay
