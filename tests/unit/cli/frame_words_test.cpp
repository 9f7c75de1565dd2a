#include "can/frame_words.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "can/bus_figures.hpp"
#include "can/frame_printer.hpp"
#include "driveline/canopen_wire/candump.hpp"
#include "driveline/canopen_wire/frame_meter.hpp"

namespace driveline::cli {
namespace {

using namespace std::chrono_literals;

class FrameWordsTest : public ::testing::Test {
 protected:
  FrameWords read(const std::string& frame) { return reader.read(*canopen::candump::parse_frame(frame)); }
  /// Name and meaning.
  std::string words(const std::string& frame) {
    const auto found = read(frame);
    return found.name + ": " + found.meaning;
  }
  FrameReader reader;
};

// Identifiers and payloads of CiA 301 7.3.3 and 7.2.8; EMCY of MSD manual 13.1.
TEST_F(FrameWordsTest, ThePredefinedConnectionSet) {
  EXPECT_EQ(words("000#0103"), "NMT: start node 3");
  EXPECT_EQ(words("000#8100"), "NMT: reset all nodes");
  EXPECT_EQ(words("000#827F"), "NMT: reset communication of node 127");
  EXPECT_EQ(words("000#01"), "NMT: not two bytes");
  EXPECT_EQ(words("000#0703"), "NMT: unknown command 0x07 to node 3");
  EXPECT_EQ(words("080#"), "SYNC: ");
  EXPECT_EQ(words("080#05"), "SYNC: counter 5");
  EXPECT_EQ(words("083#1082110102030405"),
            "EMCY node 3: 0x8210, PDO not processed because of its length, error register 0x11, 01 02 03 04 05");
  EXPECT_EQ(words("083#0000000000000000"), "EMCY node 3: no error, error register 0x00, 00 00 00 00 00");
  EXPECT_EQ(words("083#1123010000000000").substr(0, 40), "EMCY node 3: 0x2311, continuous overcurr");
  EXPECT_EQ(words("100#E80300000A00"), "TIME: day 10 after 1 January 1984, 1.000 s");
  EXPECT_EQ(words("183#00"), "TPDO1 node 3: ");
  EXPECT_EQ(words("483#R8"), "TPDO4 node 3: request of its values");
  EXPECT_EQ(words("57F#00"), "RPDO4 node 127: ");
  EXPECT_EQ(words("703#00"), "boot-up node 3: ");
  EXPECT_EQ(words("703#05"), "heartbeat node 3: operational");
  EXPECT_EQ(words("703#FF"), "heartbeat node 3: pre-operational, toggle 1");
  EXPECT_EQ(words("703#R1"), "guarding request node 3: ");
  EXPECT_EQ(words("7FF#00"), ": ");
  EXPECT_EQ(words("00000703#05"), ": ");
  EXPECT_EQ(reader.read({{}, canopen::FrameKind::kError, 0, {}}).name, "error frame");
}

// MSD manual 8.2.4.
TEST_F(FrameWordsTest, ASegmentedUpload) {
  EXPECT_EQ(words("601#4003200000000000"), "SDO request node 1: upload 0x2003:00");
  EXPECT_EQ(words("581#4103200064000000"), "SDO answer node 1: 0x2003:00 has 100 bytes");
  EXPECT_EQ(words("601#6000000000000000"), "SDO request node 1: next segment, toggle 0");
  EXPECT_EQ(words("581#00582D4178697300"), "SDO answer node 1: segment, toggle 0: 58 2D 41 78 69 73 00");
  EXPECT_EQ(words("581#0B00000000000000"), "SDO answer node 1: segment, toggle 0, last: 00 00");
}

TEST_F(FrameWordsTest, ExpeditedTransfersAndAborts) {
  EXPECT_EQ(words("601#2B4060000F000000"), "SDO request node 1: download 0x6040:00 = 0x000F");
  EXPECT_EQ(words("581#4F616000FF000000"), "SDO answer node 1: 0x6061:00 = 0xFF");
  EXPECT_EQ(words("581#4300100092010200"), "SDO answer node 1: 0x1000:00 = 0x00020192");
  EXPECT_EQ(words("581#8003200000000206"),
            "SDO answer node 1: abort of 0x2003:00: 0x06020000 (object does not exist in the object dictionary)");
  EXPECT_EQ(words("601#40032000"), "SDO request node 1: not eight bytes");
}

// A segment of a block begins with any byte: only what went before tells that it is no command.
TEST_F(FrameWordsTest, SegmentsOfABlockAreNoCommands) {
  EXPECT_EQ(words("601#C6032000BD030000"), "SDO request node 1: block download 0x2003:00, 957 bytes");
  EXPECT_EQ(words("581#A403200041000000"), "SDO answer node 1: block download 0x2003:00, 65 segments");
  EXPECT_EQ(words("601#4000000000000000"), "SDO request node 1: block segment 64: 00 00 00 00 00 00 00");
  EXPECT_EQ(words("601#C100000000000000"), "SDO request node 1: block segment 65, last: 00 00 00 00 00 00 00");
  EXPECT_EQ(words("581#A240410000000000"),
            "SDO answer node 1: sub-block received up to segment 64, next with 65 segments");
  EXPECT_EQ(words("601#8100000000000000"), "SDO request node 1: block segment 1, last: 00 00 00 00 00 00 00");
  EXPECT_EQ(words("581#A201410000000000"),
            "SDO answer node 1: sub-block received up to segment 1, next with 65 segments");
  EXPECT_EQ(words("601#C100000000000000"), "SDO request node 1: end of the block download");
  EXPECT_EQ(words("602#4003200000000000"), "SDO request node 2: upload 0x2003:00") << "each node by itself";
}

TEST_F(FrameWordsTest, ALineOfTheDump) {
  const canopen::ReceivedFrame frame{*canopen::candump::parse_frame("703#7F"), 3s};
  EXPECT_EQ(frame_line(frame, 1s, reader.read(frame.frame)),
            "    2.000000       703  1  7F                       heartbeat node 3      pre-operational\n");
  EXPECT_NE(frame_json_line(frame, 1s, reader.read(frame.frame)).find(R"("identifier":1795)"), std::string::npos);
}

TEST(BusFiguresTest, TheLoadIsThatOfTheBits) {
  BusFigures figures;
  const auto frame = *canopen::candump::parse_frame("123#0102030405060708");
  figures.add(frame);
  figures.add(frame);
  figures.add({{}, canopen::FrameKind::kError, 0, {}});
  EXPECT_EQ(figures.frames(), 2U);
  // 2 frames within 1 ms, in which 500 bits pass at 500 kbit/s.
  EXPECT_DOUBLE_EQ(figures.load(500'000, 1ms), 2.0 * static_cast<double>(canopen::bit_count(frame)) / 500.0);
  const auto document = figures.to_json("can0", 500'000, 1ms, {});
  EXPECT_EQ(document["identifiers"].size(), 1U);
  EXPECT_EQ(document["identifiers"][0]["frames"], 2);
  EXPECT_EQ(document["state"], "unknown");
  EXPECT_DOUBLE_EQ(figures.load(500'000, 0ms), 0.0);
}

}  // namespace
}  // namespace driveline::cli
