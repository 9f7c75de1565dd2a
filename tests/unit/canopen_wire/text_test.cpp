#include <gtest/gtest.h>

#include <string>

#include "driveline/canopen_wire/candump.hpp"
#include "driveline/canopen_wire/cannelloni.hpp"
#include "driveline/canopen_wire/slcan.hpp"
#include "driveline/canopen_wire/socketcand.hpp"
#include "support/bytes.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::copy_of;
using bytes_test::hex;

const Frame kBase = Frame::of(0x100, hex("11 33"));
const Frame kExtended = Frame::of(Identifier{0x1AAA'AAAA, true}, hex("01 F1"));
const Frame kRemote = Frame::remote({0x70A, false}, 4);
const Frame kExtendedRemote = Frame::remote({0x100, true}, 2);
const Frame kEmpty = Frame::of(0x020, {});
const Frame kFull = Frame::of(Identifier{0x1FFF'FFFF, true}, hex("01 23 45 67 89 AB CD EF"));
const Frame kErrorFrame{{}, FrameKind::kError, 0, {}};

/// Frames with their text in each format; those of slcan are examples of the CAN232 manual (commands t, T, r, R) and of
/// the same kind.
struct TextRow {
  Frame frame;
  std::string slcan, element, command, log;
};

const std::vector<TextRow> kTextRows{
    {kBase, "t10021133", "< frame 100 23.424242 1133 >", "< send 100 2 11 33 >", "100#1133"},
    {kEmpty, "t0200", "< frame 020 23.424242  >", "< send 020 0 >", "020#"},
    {kExtended, "T1AAAAAAA201F1", "< frame 1AAAAAAA 23.424242 01F1 >", "< send 1AAAAAAA 2 01 F1 >", "1AAAAAAA#01F1"},
    {kRemote, "r70A4", "< rtr 70A 23.424242 4 >", "< sendrtr 70A 4 >", "70A#R4"},
    {kExtendedRemote, "R000001002", "< rtr 00000100 23.424242 2 >", "< sendrtr 00000100 2 >", "00000100#R2"},
    {kFull, "T1FFFFFFF80123456789ABCDEF", "< frame 1FFFFFFF 23.424242 0123456789ABCDEF >",
     "< send 1FFFFFFF 8 01 23 45 67 89 AB CD EF >", "1FFFFFFF#0123456789ABCDEF"},
};

TEST(CanText, FramesInEveryFormat) {
  for (const auto& row : kTextRows) {
    EXPECT_EQ(slcan::line_of(row.frame).view(), row.slcan + '\r');
    EXPECT_EQ(slcan::line_of(row.frame, std::uint16_t{0xA05F}).view(), row.slcan + "A05F\r");
    EXPECT_EQ(socketcand::element_of(row.frame, 23'424'242).view(), row.element);
    EXPECT_EQ(socketcand::command_of(row.frame).view(), row.command);
    EXPECT_EQ(candump::line_of(row.frame, "can3", 1'436'509'052'000'213).view(), "(1436509052.000213) can3 " + row.log);
  }
}

TEST(CanText, FramesAreReadFromEveryFormat) {
  for (const auto& row : kTextRows) {
    EXPECT_EQ(slcan::parse_line(row.slcan), (slcan::StampedFrame{row.frame, std::nullopt})) << row.slcan;
    EXPECT_EQ(slcan::parse_line(row.slcan + "0107"), (slcan::StampedFrame{row.frame, std::uint16_t{0x107}}));
    EXPECT_EQ(socketcand::parse_element(row.element.substr(2, row.element.size() - 4)), row.frame) << row.element;
    const std::string words = row.command.substr(2, row.command.size() - 4);
    const auto verb = words.find(' ');
    EXPECT_EQ(socketcand::parse_command(words.substr(0, verb) == "send" ? FrameKind::kData : FrameKind::kRemote,
                                        std::string_view(words).substr(verb)),
              row.frame)
        << row.command;
    EXPECT_EQ(candump::parse_frame(row.log), row.frame) << row.log;
  }
}

/// Examples of socketcand's doc/protocol.md: bytes of one digit, and data with blanks between the bytes.
TEST(CanText, SpellingsOfOtherPrograms) {
  EXPECT_EQ(socketcand::parse_command(FrameKind::kData, " 1AAAAAAA 2 1 F1"), kExtended);
  EXPECT_EQ(socketcand::parse_element("frame 123 23.424242 11 22 33 44"), Frame::of(0x123, hex("11 22 33 44")));
  EXPECT_EQ(slcan::parse_line("t10021a3f"), (slcan::StampedFrame{Frame::of(0x100, hex("1A 3F")), std::nullopt}));
  EXPECT_EQ(candump::parse_frame("123#R"), Frame::remote({0x123, false}, 0));
}

TEST(CanText, AnErrorFrameIsOnlyWhereTheFormatHasIt) {
  EXPECT_TRUE(slcan::line_of(kErrorFrame).view().empty());
  EXPECT_TRUE(socketcand::command_of(kErrorFrame).view().empty());
  EXPECT_EQ(socketcand::element_of(kErrorFrame, 7).view(), "< error 00000080 >");
  EXPECT_EQ(candump::line_of(kErrorFrame, "can3", 70'000'001).view(),
            "(0000000070.000001) can3 20000080#0000000000000000");
}

TEST(CanText, WhatIsNoFrameIsNotRead) {
  for (const std::string_view line :
       {"", "t", "t12", "t123", "t1239", "t80001", "t12321", "t1232112", "t12321122334", "t1232GG11", "T123211",
        "T200000000", "T12345678A", "r1238112", "x1230", "t123011223", "t1230FFFF", "t12321133EA60", "t+1230"}) {
    EXPECT_FALSE(slcan::parse_line(line)) << line;
  }
  for (const std::string_view words : {"", "123", "800 0", "123 9", "123 2 11", "123 1 11 22", "123 1 111", "G 0",
                                       "123456789 0", "20000000 0", "123 -1", "123 1 0x"}) {
    EXPECT_FALSE(socketcand::parse_command(FrameKind::kData, words)) << words;
  }
  EXPECT_FALSE(socketcand::parse_command(FrameKind::kRemote, "123 2 11 22"));
  for (const std::string_view words : {"", "frame", "frame 123", "rtr 123 1.0", "rtr 123 1.0 9", "rtr 123 1.0 1 2",
                                       "frame 800 1.0 11", "frame 123 1.0 1", "frame 123 1.0 112233445566778899",
                                       "frame 123 1.0 11 22 33 44 55 66 77 88 99 AA", "hello"}) {
    EXPECT_FALSE(socketcand::parse_element(words)) << words;
  }
  for (const std::string_view text : {"", "123", "12#11", "1234#11", "800#", "123#1", "123##011", "123#R9", "123#R44",
                                      "123#112233445566778899", "123#1G", "20000000#"}) {
    EXPECT_FALSE(candump::parse_frame(text)) << text;
  }
}

TEST(CanText, TextsAreNeverLongerThanTheirRoom) {
  Text<5> text;
  text.add("abc").add_decimal(0, 1).add_hex(0x1F, 2).add('x');
  EXPECT_EQ(text.view(), "abc01");
}

TEST(CanText, NumbersAndWords) {
  EXPECT_EQ(hex_number("1aF0"), 0x1AF0U);
  EXPECT_FALSE(hex_number("123456789"));
  EXPECT_EQ(decimal_number("0420"), 420U);
  EXPECT_FALSE(decimal_number("1234567890123456789"));
  EXPECT_FALSE(decimal_number("4 "));
  std::string_view words = " open \t can0\n";
  EXPECT_EQ(next_word(words), "open");
  EXPECT_EQ(next_word(words), "can0");
  EXPECT_EQ(next_word(words), "");
}

// SJA1000 application note AN97076: 0x001C is 500 kbit/s, 0x0014 1 Mbit/s, 0x031C 125 kbit/s, 0x311C 10 kbit/s.
TEST(CanText, BusTimingRegistersOfSlcan) {
  EXPECT_EQ(slcan::bit_rate_of(0x001C), 500'000U);
  EXPECT_EQ(slcan::bit_rate_of(0x0014), 1'000'000U);
  EXPECT_EQ(slcan::bit_rate_of(0x031C), 125'000U);
  EXPECT_EQ(slcan::bit_rate_of(0x311C), 10'000U);
}

// Bytes by the tables of cannelloni's doc/udp_format.md and the flags of linux/can.h.
TEST(Cannelloni, PacketOfThreeFrames) {
  std::array<std::byte, 64> buffer{};
  cannelloni::Writer writer(buffer, 0xA7);
  for (const auto& frame : {kBase, kExtended, kRemote}) EXPECT_TRUE(writer.add(frame));
  EXPECT_FALSE(writer.add(kErrorFrame));
  const auto packet = hex("02 00 A7 00 03  00 00 01 00 02 11 33  9A AA AA AA 02 01 F1  40 00 07 0A 04");
  EXPECT_EQ(copy_of(writer.packet()), packet);
  EXPECT_EQ(writer.count(), 3);
  cannelloni::Reader reader(packet);
  EXPECT_EQ(reader.sequence(), 0xA7);
  for (const auto& frame : {kBase, kExtended, kRemote}) EXPECT_EQ(reader.next(), frame);
  EXPECT_FALSE(reader.next());
  EXPECT_TRUE(reader.good());
}

TEST(Cannelloni, APacketTakesWhatFits) {
  std::array<std::byte, 5 + 7 + 12> buffer{};
  cannelloni::Writer writer(buffer, 3);
  EXPECT_TRUE(writer.add(kBase));
  EXPECT_FALSE(writer.add(kFull));
  EXPECT_TRUE(writer.add(kRemote));
  EXPECT_EQ(copy_of(writer.packet()), hex("02 00 03 00 02  00 00 01 00 02 11 33  40 00 07 0A 04"));
}

TEST(Cannelloni, FramesOfOtherKindsArePassedOver) {
  const auto packet =
      hex("02 00 01 00 03  00 00 01 23 82 00 AA BB  20 00 00 80 08 00 00 00 00 00 00 00 00  00 00 02 34 01 55");
  cannelloni::Reader reader(packet);
  EXPECT_EQ(reader.next(), Frame::of(0x234, hex("55")));
  EXPECT_FALSE(reader.next());
  EXPECT_TRUE(reader.good());
}

TEST(Cannelloni, WhatIsNoPacketHasNoFrames) {
  for (const std::string_view text :
       {"", "02 00 01 00", "01 00 01 00 01 00 00 01 23 00", "02 01 01 00 01 00 00 01 23 00",
        "02 00 01 00 01 00 00 01 23", "02 00 01 00 01 00 00 01 23 02 AA",
        "02 00 01 00 01 00 00 01 23 09 01 02 03 04 05 06 07 08 09"}) {
    const auto packet = hex(text);
    cannelloni::Reader reader(packet);
    EXPECT_FALSE(reader.next()) << text;
    EXPECT_FALSE(reader.good()) << text;
  }
}

}  // namespace
}  // namespace driveline::canopen
