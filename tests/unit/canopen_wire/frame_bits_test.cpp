#include "driveline/canopen_wire/frame_bits.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "support/bytes.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::hex;

std::string binary(std::uint32_t value, int digits) {
  std::string text;
  for (int i = digits; i-- > 0;) text += (value >> i & 1U) != 0 ? '1' : '0';
  return text;
}

/// CRC by division of the text, as on paper: another way than that of the code.
std::string crc_by_hand(const std::string& bits) {
  const std::string divisor = binary(1U << 15 | 0x4599, 16);
  std::string rest = bits + std::string(15, '0');
  for (std::size_t i = 0; i + 15 < rest.size(); ++i) {
    if (rest[i] == '0') continue;
    for (std::size_t k = 0; k < divisor.size(); ++k) rest[i + k] = rest[i + k] == divisor[k] ? '0' : '1';
  }
  return rest.substr(rest.size() - 15);
}

/// Frame from start of frame to CRC as text, in the order of ISO 11898-1, 10.4.
std::string text_of(const Frame& frame) {
  const std::string remote = frame.kind == FrameKind::kRemote ? "1" : "0";
  std::string bits = "0";
  if (frame.identifier.extended) {
    const std::string identifier = binary(frame.identifier.value, 29);
    bits += identifier.substr(0, 11) + "11" + identifier.substr(11) + remote + "00";
  } else {
    bits += binary(frame.identifier.value, 11) + remote + "00";
  }
  bits += binary(frame.length, 4);
  for (const auto byte : frame.payload()) bits += binary(std::to_integer<std::uint32_t>(byte), 8);
  return bits + crc_by_hand(bits);
}

/// Inserts the stuff bits into the text.
std::string stuffed(const std::string& bits) {
  std::string out;
  for (const char bit : bits) {
    out += bit;
    if (out.ends_with(std::string(5, bit))) out += bit == '0' ? '1' : '0';
  }
  return out;
}

Frame random_frame(std::mt19937& random) {
  Frame frame;
  frame.identifier.extended = random() % 3 == 0;
  frame.identifier.value = static_cast<std::uint32_t>(random()) &
                           (frame.identifier.extended ? Identifier::kExtendedMask : Identifier::kBaseMask);
  frame.length = static_cast<std::uint8_t>(random() % 9);
  if (random() % 5 == 0) return Frame::remote(frame.identifier, frame.length);
  const bool equal = random() % 2 == 0;  // long runs are what makes stuff bits
  for (std::size_t i = 0; i < frame.length; ++i) {
    frame.data.at(i) =
        equal ? std::byte{static_cast<unsigned char>(random() % 2 == 0 ? 0 : 255)} : static_cast<std::byte>(random());
  }
  return frame;
}

TEST(FrameBits, TheReferenceHasTheCheckValueOfTheCatalogue) {
  // CRC-15/CAN in the catalogue of parametrised CRC algorithms: check value 059Eh of "123456789".
  std::string bits;
  for (const char c : std::string("123456789")) bits += binary(static_cast<unsigned char>(c), 8);
  EXPECT_EQ(crc_by_hand(bits), binary(0x059E, 15));
  EXPECT_EQ(stuffed("0000001111100000"), "0000010111110000010");
}

TEST(FrameBits, BitsAndCrcAreThoseOfTheReference) {
  std::mt19937 random(11898);
  for (int i = 0; i < 2000; ++i) {
    const Frame frame = random_frame(random);
    const FrameBits bits(frame);
    std::string text;
    for (std::size_t k = 0; k < bits.size(); ++k) text += bits[k] ? '1' : '0';
    ASSERT_EQ(text, text_of(frame));
    ASSERT_EQ(binary(bits.crc(), 15), text.substr(text.size() - 15));
    ASSERT_EQ(bits.stuff_bits(), stuffed(text).size() - text.size());
    // CRC delimiter, acknowledge slot and delimiter, seven bits of end of frame, three of interframe space.
    ASSERT_EQ(bit_count(frame), stuffed(text).size() + 3 + 7 + 3);
  }
}

TEST(FrameBits, AMeterServesAllFramesOfItsIdentifierAndLength) {
  std::mt19937 random(15);
  for (int i = 0; i < 200; ++i) {
    Frame frame = random_frame(random);
    const FrameMeter meter(frame);
    for (int content = 0; content < 20; ++content) {
      for (std::size_t k = 0; k < frame.payload().size(); ++k) frame.data.at(k) = static_cast<std::byte>(random());
      ASSERT_EQ(meter.bits(frame.payload()), stuffed(text_of(frame)).size() + 13);
    }
  }
}

// C2: 47 + 8n bits plus the stuff bits that the content really causes, within the limits.
TEST(FrameBits, C2CountsWithinTheLimits) {
  struct Row {
    std::uint8_t length;
    std::size_t least;
    std::size_t most;
  };
  std::mt19937 random(301);
  for (const auto& row : {Row{0, 47, 55}, Row{2, 63, 75}, Row{4, 79, 95}, Row{6, 95, 115}, Row{8, 111, 135}}) {
    for (int i = 0; i < 3000; ++i) {
      Frame frame = random_frame(random);
      frame = Frame::of(frame.identifier.value & 0x7FF, std::span<const std::byte>(frame.data).first(row.length));
      ASSERT_GE(bit_count(frame), row.least);
      ASSERT_LE(bit_count(frame), row.most);
      ASSERT_EQ(bit_count(frame), stuffed(text_of(frame)).size() + 13);
    }
  }
}

TEST(FrameBits, C2StuffBitsDependOnTheContent) {
  // Identifier 555h has no run, and eight bytes 55h neither. Eight bytes 00h behind the three zeros of the length code
  // are 67 equal bits: 13 times five.
  EXPECT_LE(bit_count(Frame::of(0x555, hex("5555555555555555"))), 113U);
  EXPECT_GE(bit_count(Frame::of(0x555, hex("0000000000000000"))), 111U + 13);
  // A remote frame that asks for eight bytes carries none.
  EXPECT_LE(bit_count(Frame::remote({0x555, false}, 8)), 55U);
  // An extended frame has 20 bits more.
  EXPECT_GE(bit_count(Frame::of(Identifier{0x1555'5555, true}, {})), 67U);
}

}  // namespace
}  // namespace driveline::canopen
