#include "device_rig.hpp"

namespace driveline::slaves::cia301 {
namespace {

/// C33: block transfer as an option of the stack. Bytes of the messages as in CiA 301 Figures 28 to 38.
class CanopenBlock : public ::testing::Test {
 protected:
  CanopenBlock() { rig.run(2ms); }

  /// Segment of a download with seven bytes of the text.
  static std::vector<std::byte> segment(unsigned sequence, std::size_t first, bool last = false) {
    std::vector<std::byte> out{static_cast<std::byte>(sequence | (last ? 0x80U : 0U))};
    for (std::size_t i = first; i < first + 7; ++i)
      out.push_back(i < kText.size() ? static_cast<std::byte>(kText[i]) : std::byte{0});
    return out;
  }
  void send_segment(unsigned sequence, std::size_t first, bool last = false) {
    rig.send(Frame::of(0x605, segment(sequence, first, last)));
  }
  [[nodiscard]] std::string stored() const { return rig.dictionary.text(rig.dictionary.table().find(0x2003, 0)->slot); }

  static constexpr std::string_view kText = "The quick brown fox jumps over";  // 30 bytes
  DeviceRig rig{{.block_transfer = true}};
};

/// CRC of the text by division, bit by bit: another way than that of the code.
std::uint16_t crc_of(std::string_view text) {
  std::uint32_t rest = 0;
  const auto shift_in = [&](unsigned bit) {
    rest = rest << 1 | bit;
    if ((rest & 0x10000U) != 0) rest ^= 0x11021U;
  };
  for (const char c : text) {
    for (int i = 8; i-- > 0;) shift_in(static_cast<unsigned>(c) >> i & 1U);
  }
  for (int i = 0; i < 16; ++i) shift_in(0);
  return static_cast<std::uint16_t>(rest);
}

std::string end_of_download(std::string_view text, unsigned unused, unsigned crc_error = 0) {
  const unsigned crc = crc_of(text) ^ crc_error;
  std::array<char, 40> out{};
  std::snprintf(out.data(), out.size(), "%02X %02X %02X 00 00 00 00 00", 0xC1U | unused << 2, crc & 0xFFU, crc >> 8);
  return out.data();
}

TEST_F(CanopenBlock, C33Download) {
  ASSERT_EQ(crc_of("123456789"), 0x31C3);
  EXPECT_EQ(rig.ask("C6 03 20 00 1E 00 00 00"), hex("A4 03 20 00 7F 00 00 00"));
  for (unsigned i = 0; i < 4; ++i) send_segment(i + 1, i * 7);
  EXPECT_EQ(rig.answers().size(), 1U);  // no answer within a sub-block
  send_segment(5, 28, true);
  EXPECT_EQ(rig.answers().back(), hex("A2 05 7F 00 00 00 00 00"));
  EXPECT_EQ(rig.ask(end_of_download(kText, 5)), hex("A1 00 00 00 00 00 00 00"));
  EXPECT_EQ(stored(), kText);
}

// CANopenNode #170: a block download goes on after a lost segment.
TEST_F(CanopenBlock, C33ALostSegmentIsRepeatedFromTheLastGoodOne) {
  ASSERT_EQ(rig.ask("C6 03 20 00 1E 00 00 00"), hex("A4 03 20 00 7F 00 00 00"));
  send_segment(1, 0);
  send_segment(2, 7);
  send_segment(4, 21);  // 3 is lost
  send_segment(5, 28, true);
  EXPECT_EQ(rig.answers().back(), hex("A2 02 7F 00 00 00 00 00"));
  send_segment(1, 14);
  send_segment(2, 21);
  send_segment(3, 28, true);
  EXPECT_EQ(rig.answers().back(), hex("A2 03 7F 00 00 00 00 00"));
  EXPECT_EQ(rig.ask(end_of_download(kText, 5)), hex("A1 00 00 00 00 00 00 00"));
  EXPECT_EQ(stored(), kText);
}

TEST_F(CanopenBlock, C33ErrorsOfADownload) {
  const auto transfer = [&](const char* initiate, const std::string& end) {
    EXPECT_EQ(rig.ask(initiate).front(), std::byte{0xA4});
    for (unsigned i = 0; i < 5; ++i) send_segment(i + 1, i * 7, i == 4);
    return rig.ask(end);
  };
  EXPECT_EQ(transfer("C6 03 20 00 1E 00 00 00", end_of_download(kText, 5, 1)), hex("80 03 20 00 04 00 04 05"));
  EXPECT_EQ(transfer("C6 03 20 00 1F 00 00 00", end_of_download(kText, 5)), hex("80 03 20 00 10 00 07 06"));
  EXPECT_EQ(stored(), "X-Axis");
  EXPECT_EQ(transfer("C0 03 20 00 00 00 00 00", end_of_download(kText, 5, 1)),
            hex("A1 00 00 00 00 00 00 00"));                                      // no CRC
  EXPECT_EQ(rig.ask("C6 03 20 00 65 00 00 00"), hex("80 03 20 00 12 00 07 06"));  // announced too long
  EXPECT_EQ(rig.ask("C6 00 10 00 04 00 00 00"), hex("80 00 10 00 02 00 01 06"));
  EXPECT_EQ(rig.ask("C1 00 00 00 00 00 00 00"), hex("80 00 00 00 01 00 04 05"));  // an end without a transfer
}

TEST_F(CanopenBlock, C33ADownloadLongerThanTheObjectEnds) {
  ASSERT_EQ(rig.ask("C4 02 20 00 00 00 00 00").front(), std::byte{0xA4});  // UNSIGNED32, size not announced
  send_segment(1, 0);
  EXPECT_EQ(rig.answers().back(), hex("80 02 20 00 12 00 07 06"));
  ASSERT_EQ(rig.ask("C4 02 20 00 00 00 00 00").front(), std::byte{0xA4});
  rig.send(0x605, "00 01 02 03 04 05 06 07");  // a sequence number that there is not
  EXPECT_EQ(rig.answers().back(), hex("80 02 20 00 03 00 04 05"));
}

TEST_F(CanopenBlock, C33AnAbortOfTheClientEndsADownload) {
  ASSERT_EQ(rig.ask("C6 03 20 00 1E 00 00 00").front(), std::byte{0xA4});
  EXPECT_THAT(rig.ask("80 03 20 00 00 00 04 05"), IsEmpty());
  EXPECT_EQ(rig.ask("40 01 20 00 00 00 00 00"), hex("4F 01 20 00 05 00 00 00"));
}

TEST_F(CanopenBlock, C33Upload) {
  auto& text = rig.dictionary.text(rig.dictionary.table().find(0x1008, 0)->slot);
  ASSERT_EQ(text, "Sample device");
  EXPECT_EQ(rig.ask("A4 08 10 00 02 00 00 00"), hex("C6 08 10 00 0D 00 00 00"));
  rig.ask("A3 00 00 00 00 00 00 00");
  const auto all = rig.answers();
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[1], hex("01 53 61 6D 70 6C 65 20"));
  EXPECT_EQ(all[2], hex("82 64 65 76 69 63 65 00"));
  // 13 = 7 + 6: one byte unused.
  const unsigned crc = crc_of("Sample device");
  auto end = hex("C5 00 00 00 00 00 00 00");
  end[1] = static_cast<std::byte>(crc & 0xFFU);
  end[2] = static_cast<std::byte>(crc >> 8);
  EXPECT_EQ(rig.ask("A2 02 7F 00 00 00 00 00"), end);
  EXPECT_THAT(rig.ask("A1 00 00 00 00 00 00 00"), IsEmpty());
}

TEST_F(CanopenBlock, C33AnUploadIsRepeatedFromTheLastConfirmedSegment) {
  ASSERT_EQ(rig.ask("A0 03 20 00 04 00 00 00"), hex("C6 03 20 00 64 00 00 00"));  // 100 bytes, no CRC
  rig.ask("A3 00 00 00 00 00 00 00");
  ASSERT_EQ(rig.answers().size(), 5U);
  EXPECT_EQ(rig.answers()[1], hex("01 58 2D 41 78 69 73 00"));
  rig.set(0x2001, 9);
  rig.ask("A2 00 03 00 00 00 00 00");  // none has arrived; three next
  ASSERT_EQ(rig.answers().size(), 8U);
  EXPECT_EQ(rig.answers()[5], hex("01 58 2D 41 78 69 73 00"));
  rig.ask("A2 03 7F 00 00 00 00 00");
  rig.run(5ms);
  ASSERT_EQ(rig.answers().size(), 8U + 12U);  // 15 segments in all
  EXPECT_EQ(rig.answers().back()[0], std::byte{0x8C});
  EXPECT_EQ(rig.ask("A2 0C 7F 00 00 00 00 00"), hex("D5 00 00 00 00 00 00 00"));  // 100 = 14 x 7 + 2
}

TEST_F(CanopenBlock, C33ErrorsOfAnUpload) {
  EXPECT_EQ(rig.ask("A4 03 20 00 00 00 00 00"), hex("80 03 20 00 02 00 04 05"));  // block size 0
  EXPECT_EQ(rig.ask("A4 03 20 00 80 00 00 00"), hex("80 03 20 00 02 00 04 05"));
  EXPECT_EQ(rig.ask("A4 05 20 00 10 00 00 00"), hex("80 05 20 00 01 00 01 06"));
  EXPECT_EQ(rig.ask("A3 00 00 00 00 00 00 00"), hex("80 00 00 00 01 00 04 05"));
  ASSERT_EQ(rig.ask("A4 03 20 00 02 00 00 00").front(), std::byte{0xC6});
  rig.ask("A3 00 00 00 00 00 00 00");
  EXPECT_EQ(rig.ask("A2 03 7F 00 00 00 00 00"), hex("80 03 20 00 03 00 04 05"));  // more than were sent
  ASSERT_EQ(rig.ask("A4 03 20 00 02 00 00 00").front(), std::byte{0xC6});
  EXPECT_EQ(rig.ask("A1 00 00 00 00 00 00 00"), hex("80 03 20 00 01 00 04 05"));  // an end before the data
}

}  // namespace
}  // namespace driveline::slaves::cia301
