// What a capture writes, as log of candump and as pcapng.
#include "driveline/canopen_port/can_capture.hpp"

#include <gmock/gmock.h>

#include "support/bytes.hpp"
#include "support/must.hpp"
#include "support/pcapng_blocks.hpp"
#include "support/scripted_can_port.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::canopen {
namespace {

using bytes_test::hex;
using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

class CanCaptureTest : public test::TemporaryDirectory {
 protected:
  /// Sends and receives frames of every kind through a capture.
  void capture(const std::filesystem::path& file) {
    const auto port = *must(CanCapture::open(
        inner, clock, {.file = file, .interface_name = "can3", .unix_time_of_zero = 1'436'509'052s + 249'713us}));
    inner.counters.sent = 42;
    inner.arriving = {Frame::of(Identifier{0x1AAA'AAAA, true}, hex("01 F1")), Frame::remote({0x70A, false}, 4),
                      Frame{{}, FrameKind::kError, 0, {}}};
    EXPECT_EQ(port->send(Frame::of(0x123, hex("11"))), SendStatus::kSent);
    clock.advance(1ms);
    inner.status = SendStatus::kBusy;
    EXPECT_EQ(port->send(Frame::of(0x124, {})), SendStatus::kBusy);
    EXPECT_TRUE(port->wait_readable(clock.now()));
    for (const Frame& frame : inner.arriving) EXPECT_EQ(port->receive().value().frame, frame);
    EXPECT_FALSE(port->receive());
    EXPECT_EQ(port->statistics().sent, 42U);  // those of the inner port
    const auto statistics = *must(port->close());
    EXPECT_EQ(statistics.frames, 4U);
    EXPECT_EQ(statistics.written, 4U);
    EXPECT_EQ(statistics.dropped, 0U);
  }

  rt::VirtualClock clock;
  port_test::ScriptedCanPort inner{clock};
};

// The line of candump(1) with 123#11; linux/can/error.h for the error frame.
TEST_F(CanCaptureTest, ALogOfCandump) {
  capture(directory / "can.log");
  EXPECT_EQ(read(directory / "can.log"),
            "(1436509052.249713) can3 123#11\n"
            "(1436509052.250713) can3 1AAAAAAA#01F1\n"
            "(1436509052.250713) can3 70A#R4\n"
            "(1436509052.250713) can3 20000080#0000000000000000\n");
}

// LINKTYPE_CAN_SOCKETCAN of tcpdump.org: identifier with flags in big endian, length, three bytes, data.
TEST_F(CanCaptureTest, APcapngFileWithTheLinkTypeOfCan) {
  capture(directory / "can.pcapng");
  const auto file = pcapng_test::read_bytes(directory / "can.pcapng");
  EXPECT_EQ(pcapng_test::number(pcapng_test::pcapng_blocks(file).at(1).body, 0, 2), 227U);
  const auto packets = pcapng_test::pcapng_packets(file);
  ASSERT_EQ(packets.size(), 4U);
  EXPECT_EQ(packets[0].frame, hex("00 00 01 23 01 00 00 00 11 00 00 00 00 00 00 00"));
  EXPECT_EQ(packets[1].frame, hex("9A AA AA AA 02 00 00 00 01 F1 00 00 00 00 00 00"));
  EXPECT_EQ(packets[2].frame, hex("40 00 07 0A 04 00 00 00 00 00 00 00 00 00 00 00"));
  EXPECT_EQ(packets[3].frame, hex("20 00 00 80 08 00 00 00 00 00 00 00 00 00 00 00"));
  EXPECT_THAT(packets[0].options, ElementsAre(Pair(2, 2)));  // outbound
  EXPECT_THAT(packets[1].options, ElementsAre(Pair(2, 1)));  // inbound
  EXPECT_EQ(packets[0].time_ns, 1'436'509'052'249'713'000U);
}

TEST_F(CanCaptureTest, WithoutANameTheInterfaceIsCan0) {
  const auto port = *must(CanCapture::open(inner, clock, {.file = directory / "x.log", .unix_time_of_zero = 0s}));
  EXPECT_EQ(port->send(Frame::of(0x123, {})), SendStatus::kSent);
  EXPECT_TRUE(port->close());
  EXPECT_EQ(read(directory / "x.log"), "(0000000000.000000) can0 123#\n");
  EXPECT_EQ(port->send(Frame::of(0x123, {})), SendStatus::kSent);  // passed on, not recorded
  EXPECT_EQ(port->capture_statistics().frames, 1U);
}

TEST_F(CanCaptureTest, AFileThatCannotBeWrittenIsAnError) {
  EXPECT_THAT(failure_text(CanCapture::open(inner, clock, {.file = directory / "no" / "such.log"})),
              HasSubstr("Cannot create capture file"));
}

TEST_F(CanCaptureTest, AFullDiskIsReportedAtTheEndAndDelaysNothing) {
  const auto port = *must(CanCapture::open(inner, clock, {.file = "/dev/full"}));
  EXPECT_EQ(port->send(Frame::of(0x123, {})), SendStatus::kSent);
  EXPECT_THAT(failure_text(port->close()), HasSubstr("No space left on device"));
  EXPECT_EQ(port->capture_statistics().dropped, 1U);
}

}  // namespace
}  // namespace driveline::canopen
