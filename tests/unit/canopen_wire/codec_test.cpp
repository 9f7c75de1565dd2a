#include <gtest/gtest.h>

#include <set>

#include "driveline/canopen_wire/emergency.hpp"
#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/canopen_wire/sdo.hpp"
#include "driveline/canopen_wire/sdo_block.hpp"
#include "driveline/canopen_wire/sync.hpp"
#include "support/bytes.hpp"

/// Golden bytes come from figures of CiA 301, the trace in MSD manual 8.2.4, and published check values; Wireshark's
/// dissection of the same encoders is in tests/replay/canopen_wire.
namespace driveline::canopen {
namespace {

using bytes_test::copy_of;
using bytes_test::hex;

TEST(NmtCodec, GoldenBytesAndLengths) {
  const auto frame = NmtRequest{NmtCommand::kEnterPreOperational, 0x2A}.frame();  // CiA 301 Figure 47
  EXPECT_EQ(frame.identifier, (Identifier{0, false}));
  EXPECT_EQ(copy_of(frame.payload()), hex("80 2A"));
  EXPECT_EQ(NmtRequest::decode(hex("82 05")), (NmtRequest{NmtCommand::kResetCommunication, 5}));
  EXPECT_EQ(NmtRequest::decode(hex("33 05"))->command, static_cast<NmtCommand>(0x33));  // unknown ones are retained
  for (const char* wrong : {"", "01", "01 05 00"}) EXPECT_FALSE(NmtRequest::decode(hex(wrong))) << wrong;
}

TEST(ErrorControlCodec, GoldenBytesAndLengths) {
  EXPECT_EQ((ErrorControl{NmtState::kPreOperational, true}.encode()), std::byte{0xFF});
  EXPECT_EQ((ErrorControl{NmtState::kOperational, false}.encode()), std::byte{0x05});
  EXPECT_EQ((ErrorControl{NmtState::kStopped, true}.encode()), std::byte{0x84});
  EXPECT_EQ(ErrorControl::decode(hex("85")), (ErrorControl{NmtState::kOperational, true}));
  EXPECT_FALSE(ErrorControl::decode({}));  // CANopenNode #102: state messages without data
  EXPECT_FALSE(ErrorControl::decode(hex("05 05")));
}

TEST(SyncCodec, WithAndWithoutCounter) {
  EXPECT_EQ((Sync{}.frame({0x80, false}).length), 0);
  EXPECT_EQ(copy_of(Sync{0x17}.frame({0x85, false}).payload()), hex("17"));
  EXPECT_EQ(Sync::decode(hex("F0")), Sync{240});
  EXPECT_EQ(Sync::decode({}), Sync{0});
  EXPECT_FALSE(Sync::decode(hex("01 02")));
}

TEST(TimeCodec, GoldenBytes) {
  // 29 November 2026, 20:25:30.123: 15,673 days since 1 January 1984 (`date -d 2026-11-29 +%s` and of 1984-01-01),
  // 73,530,123 ms since midnight.
  const TimeOfDay time{73'530'123, 15'673};
  EXPECT_EQ(copy_of(time.frame({0x100, false}).payload()), hex("0B FB 61 04 39 3D"));
  EXPECT_EQ(TimeOfDay::decode(hex("0B FB 61 F4 39 3D")), time);  // the four reserved bits are ignored
  EXPECT_FALSE(TimeOfDay::decode(hex("0B FB 61 04 39")));
  EXPECT_FALSE(TimeOfDay::decode(hex("0B FB 61 04 39 3D 00")));
}

TEST(EmergencyCodec, GoldenBytes) {  // CANopenNode #402: bytes in the wrong order
  // CiA 301 Figure 46: error code low byte first, error register, five manufacturer bytes.
  const Emergency emergency{0x8130, 0x11, {std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}, std::byte{5}}};
  EXPECT_EQ(copy_of(emergency.frame({0x87, false}).payload()), hex("30 81 11 01 02 03 04 05"));
  EXPECT_EQ(Emergency::decode(hex("30 81 11 01 02 03 04 05")), emergency);
  EXPECT_FALSE(Emergency::decode(hex("30 81 11 01 02 03 04")));
}

TEST(SdoCodec, MessagesOfTheTraceInTheManual) {
  // MSD manual 8.2.4, first exchange: upload of 2003h:00, answered with a size of 100 bytes.
  const auto request = SdoMessage::decode(hex("40 03 20 00 00 00 00 00"));
  ASSERT_TRUE(request);
  EXPECT_EQ(static_cast<SdoRequest>(request->specifier()), SdoRequest::kInitiateUpload);
  EXPECT_EQ(request->index, 0x2003);
  EXPECT_EQ(request->subindex, 0);
  const SdoMessage answer{sdo_command(SdoResponse::kInitiateUpload, SdoMessage::kSizeIndicated), 0x2003, 0,
                          bytes::to_le_bytes(std::uint32_t{100})};
  EXPECT_EQ(copy_of(answer.encode()), hex("41 03 20 00 64 00 00 00"));
  EXPECT_EQ(answer.number(), 100U);
}

TEST(SdoCodec, SegmentBytesOfTheTraceInTheManual) {
  const auto upload = static_cast<std::uint8_t>(SdoRequest::kUploadSegment);
  EXPECT_EQ((SdoSegment{upload, false, 0, false}.encode()), std::byte{0x60});
  EXPECT_EQ((SdoSegment{upload, true, 0, false}.encode()), std::byte{0x70});
  EXPECT_EQ((SdoSegment{0, true, 0, false}.encode()), std::byte{0x10});
  // The last one has 2 of 7 bytes: 100 = 14 x 7 + 2.
  EXPECT_EQ((SdoSegment{0, false, 5, true}.encode()), std::byte{0x0B});
  for (unsigned raw = 0; raw <= 255; ++raw) {
    EXPECT_EQ(SdoSegment::decode(static_cast<std::byte>(raw)).encode(), static_cast<std::byte>(raw));
  }
}

TEST(SdoCodec, ExpeditedCommandsStateTheUnusedBytes) {
  // CiA 301 Figure 21: scs, x, n, e, s. 4Fh, 4Bh, 47h, 43h are the answers to uploads of 1 to 4 bytes.
  EXPECT_EQ(expedited_command(SdoResponse::kInitiateUpload, 1), 0x4F);
  EXPECT_EQ(expedited_command(SdoResponse::kInitiateUpload, 2), 0x4B);
  EXPECT_EQ(expedited_command(SdoResponse::kInitiateUpload, 3), 0x47);
  EXPECT_EQ(expedited_command(SdoResponse::kInitiateUpload, 4), 0x43);
  EXPECT_EQ(expedited_command(SdoRequest::kInitiateDownload, 2), 0x2B);
  EXPECT_EQ((SdoMessage{0x2B, 0, 0, {}}.expedited_size()), 2U);
  EXPECT_EQ((SdoMessage{0x22, 0, 0, {}}.expedited_size()), 4U);  // without size
}

TEST(SdoCodec, AbortAndShortFrames) {
  EXPECT_EQ(copy_of(abort_message(0x6040, 3, SdoAbort::kSubindexDoesNotExist).encode()),
            hex("80 40 60 03 11 00 09 06"));
  EXPECT_FALSE(SdoMessage::decode(hex("40 03 20 00 00 00 00")));  // C32
}

TEST(SdoBlockCodec, CrcAndSegments) {
  // CRC-16/XMODEM in the catalogue of parametrised CRC algorithms: 31C3h of "123456789".
  EXPECT_EQ(sdo_block::crc16(hex("31 32 33 34 35 36 37 38 39")), 0x31C3);
  EXPECT_EQ(sdo_block::crc16(hex("36 37 38 39"), sdo_block::crc16(hex("31 32 33 34 35"))), 0x31C3);
  EXPECT_EQ((sdo_block::Segment{true, 0x15}.encode()), std::byte{0x95});
  for (unsigned raw = 0; raw <= 255; ++raw) {
    EXPECT_EQ(sdo_block::Segment::decode(static_cast<std::byte>(raw)).encode(), static_cast<std::byte>(raw));
  }
}

}  // namespace
}  // namespace driveline::canopen
