// What adapters and servers send, byte by byte.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "driveline/canopen_port/slcan_reader.hpp"
#include "driveline/canopen_port/socketcand_reader.hpp"
#include "support/bytes.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::hex;

/// All events but kNone.
template <typename Reader>
std::vector<typename Reader::Event> events(Reader& reader, std::string_view text) {
  std::vector<typename Reader::Event> out;
  for (const char c : text) {
    const auto event = reader.take(c);
    if (event != Reader::Event::kNone) out.push_back(event);
  }
  return out;
}

using SlcanEvents = std::vector<SlcanReader::Event>;
using ServerEvents = std::vector<SocketcandReader::Event>;

// Lines of the CANUSB manual: frames with and without a time stamp, answers.
TEST(SlcanReader, FramesAndAnswers) {
  SlcanReader reader;
  using E = SlcanReader::Event;
  EXPECT_EQ(events(reader, "\r\aZ\rz\r"), (SlcanEvents{E::kOk, E::kRefused, E::kSent, E::kSent}));
  EXPECT_EQ(events(reader, "t10021133\r"), SlcanEvents{E::kFrame});
  EXPECT_EQ(reader.frame(), Frame::of(0x100, hex("11 33")));
  EXPECT_EQ(events(reader, "T0000010021133A05F\r\n"), SlcanEvents{E::kFrame});
  EXPECT_EQ(reader.frame(), Frame::of(Identifier{0x100, true}, hex("11 33")));
  EXPECT_EQ(events(reader, "R000001002\r"), SlcanEvents{E::kFrame});
  EXPECT_EQ(reader.frame(), Frame::remote({0x100, true}, 2));
  EXPECT_EQ(events(reader, "FA4\r"), SlcanEvents{E::kFlags});
  EXPECT_EQ(reader.flags(), 0xA4);
  EXPECT_EQ(events(reader, "V1013\rNA123\rv0100\r"), SlcanEvents{});
  EXPECT_EQ(reader.malformed(), 0U);
}

TEST(SlcanReader, WhatIsNoLineOfTheProtocolIsCountedAndSkipped) {
  SlcanReader reader;
  using E = SlcanReader::Event;
  EXPECT_EQ(events(reader, "t8000\rt1239\rhello\rFXX\r\xFF\x01\r"), SlcanEvents{});
  EXPECT_EQ(reader.malformed(), 5U);
  EXPECT_EQ(events(reader, "t12\a"), SlcanEvents{E::kRefused});
  EXPECT_EQ(reader.malformed(), 6U);
  EXPECT_EQ(events(reader, "t1230\r"), SlcanEvents{E::kFrame});
}

TEST(SlcanReader, ALineWithoutEndIsOneMalformedLine) {
  SlcanReader reader;
  EXPECT_EQ(events(reader, std::string(1 << 20, 't')), SlcanEvents{});
  EXPECT_EQ(reader.malformed(), 1U);
  EXPECT_EQ(events(reader, "\rt1230\r"), SlcanEvents{SlcanReader::Event::kFrame});
  EXPECT_EQ(reader.malformed(), 1U);
}

// Elements of socketcand's doc/protocol.md.
TEST(SocketcandReader, FramesAndAnswers) {
  SocketcandReader reader;
  using E = SocketcandReader::Event;
  EXPECT_EQ(events(reader, "< hi >< ok >\r\n< echo >"), (ServerEvents{E::kGreeting, E::kOk}));
  EXPECT_EQ(events(reader, "< frame 123 23.424242 11 22 33 44 >"), ServerEvents{E::kFrame});
  EXPECT_EQ(reader.frame(), Frame::of(0x123, hex("11 22 33 44")));
  EXPECT_EQ(events(reader, "<rtr 123 23.424242 4>"), ServerEvents{E::kFrame});
  EXPECT_EQ(reader.frame(), Frame::remote({0x123, false}, 4));
  EXPECT_EQ(events(reader, "< stat 1 2 3 4 >"), ServerEvents{});
  EXPECT_EQ(reader.malformed(), 0U);
}

TEST(SocketcandReader, ErrorsAreFramesOrReasons) {
  SocketcandReader reader;
  using E = SocketcandReader::Event;
  EXPECT_EQ(events(reader, "< error 20000040 23.424242 >"), ServerEvents{E::kErrorFrame});
  EXPECT_EQ(reader.error_classes(), 0x40U);
  EXPECT_EQ(reader.frame().kind, FrameKind::kError);
  EXPECT_EQ(events(reader, "< error 080 >"), ServerEvents{E::kErrorFrame});
  EXPECT_EQ(reader.error_classes(), 0x80U);
  EXPECT_EQ(events(reader, "< error could not open bus >"), ServerEvents{E::kFailure});
  EXPECT_EQ(reader.reason(), "could not open bus");
  EXPECT_EQ(events(reader, "< error add failed >"), ServerEvents{E::kFailure});
  EXPECT_EQ(reader.reason(), "add failed");
  EXPECT_EQ(events(reader, "< error>"), ServerEvents{E::kFailure});
  EXPECT_EQ(reader.reason(), "");
}

TEST(SocketcandReader, WhatIsNoElementIsCountedAndSkipped) {
  SocketcandReader reader;
  using E = SocketcandReader::Event;
  EXPECT_EQ(events(reader, "< frame 800 1.0 11 >< hello >< frame 123 1.0 1 >< rtr 123 1.0 9 >"), ServerEvents{});
  EXPECT_EQ(reader.malformed(), 4U);
  EXPECT_EQ(events(reader, "garbage \xFF < frame 12"), ServerEvents{});  // a run with blanks is one
  EXPECT_EQ(reader.malformed(), 5U);
  EXPECT_EQ(events(reader, "< frame 123 1.0 >"), ServerEvents{E::kFrame});  // the one before has no end
  EXPECT_EQ(reader.malformed(), 6U);
}

TEST(SocketcandReader, AnElementWithoutEndIsOneMalformedElement) {
  SocketcandReader reader;
  EXPECT_EQ(events(reader, "<" + std::string(1 << 20, 'x')), ServerEvents{});
  EXPECT_EQ(reader.malformed(), 1U);
  EXPECT_EQ(events(reader, "> < frame 123 1.0 >"), ServerEvents{SocketcandReader::Event::kFrame});
  EXPECT_EQ(reader.malformed(), 1U);
}

}  // namespace
}  // namespace driveline::canopen
