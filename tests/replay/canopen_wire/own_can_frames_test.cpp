#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "driveline/canopen_wire/emergency.hpp"
#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/canopen_wire/sdo.hpp"
#include "driveline/canopen_wire/sync.hpp"
#include "tshark.hpp"

/// Frames of the codec, read by Wireshark's dissector of CANopen.
namespace driveline::canopen {
namespace {

using replay::DissectedPacket;
using replay::to_number;
using Bytes = std::vector<std::byte>;

/// A frame with the header of SocketCAN (linux/can.h): identifier and flags in the order of the network, length,
/// padding.
Bytes socketcan(const Frame& frame) {
  constexpr std::uint32_t kExtended = 0x8000'0000;
  constexpr std::uint32_t kRemote = 0x4000'0000;
  const std::uint32_t word = frame.identifier.value | (frame.identifier.extended ? kExtended : 0) |
                             (frame.kind == FrameKind::kRemote ? kRemote : 0);
  Bytes out;
  for (const int shift : {24, 16, 8, 0}) out.push_back(static_cast<std::byte>(word >> shift & 0xFFU));
  out.push_back(static_cast<std::byte>(frame.length));
  out.resize(8);
  out.insert(out.end(), frame.data.begin(), frame.data.end());
  return out;
}

class OwnCanFrames : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!replay::tshark_available()) GTEST_SKIP() << replay::missing_tshark_text();
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    file_ = std::filesystem::path(::testing::TempDir()) /
            ("driveline_" + std::string(test->name()) + "_" + std::to_string(::getpid()) + ".pcap");
  }
  void TearDown() override {
    if (!file_.empty()) std::filesystem::remove(file_);
  }
  /// Returns tshark's dissection of the frames; none of them may be malformed.
  std::vector<DissectedPacket> dissected(const std::vector<Frame>& frames, const std::vector<std::string>& fields) {
    std::vector<Bytes> packets;
    for (const Frame& frame : frames) packets.push_back(socketcan(frame));
    replay::write_pcap(file_, packets, replay::kSocketCanLink);
    const std::string canopen = "can.subdissector,canopen";
    const auto malformed = replay::dissect(file_, "_ws.malformed", {"frame.number"}, canopen);
    EXPECT_TRUE(malformed && malformed->empty());
    const auto result = replay::dissect(file_, "canopen", fields, canopen);
    EXPECT_TRUE(result) << result.error();
    EXPECT_TRUE(!result || result->size() == frames.size());
    return result.value_or(std::vector<DissectedPacket>{});
  }

 private:
  std::filesystem::path file_;
};

std::uint64_t number(const DissectedPacket& packet, std::size_t field) {
  return to_number(packet.at(field).at(0));
}

TEST_F(OwnCanFrames, Nmt) {
  const std::vector<NmtRequest> requests{{NmtCommand::kStart, 0},
                                         {NmtCommand::kStop, 3},
                                         {NmtCommand::kEnterPreOperational, 127},
                                         {NmtCommand::kResetNode, 42},
                                         {NmtCommand::kResetCommunication, 1}};
  std::vector<Frame> frames;
  for (const auto& request : requests) frames.push_back(request.frame());
  const auto packets = dissected(frames, {"canopen.nmt_ctrl.cd", "canopen.nmt_ctrl.node_id"});
  for (std::size_t i = 0; i < packets.size(); ++i) {
    EXPECT_EQ(number(packets[i], 0), static_cast<unsigned>(requests[i].command));
    EXPECT_EQ(number(packets[i], 1), requests[i].node);
  }
}

TEST_F(OwnCanFrames, ErrorControl) {
  const std::vector<ErrorControl> states{
      {NmtState::kPreOperational, true}, {NmtState::kOperational, false}, {NmtState::kStopped, true}};
  std::vector<Frame> frames;
  for (const auto& state : states)
    frames.push_back(Frame::of(predefined::kErrorControl + 9, std::array{state.encode()}));
  const auto packets = dissected(frames, {"canopen.node_id", "canopen.nmt_guard.toggle", "canopen.nmt_guard.state"});
  for (std::size_t i = 0; i < packets.size(); ++i) {
    EXPECT_EQ(number(packets[i], 0), 9U);
    EXPECT_EQ(number(packets[i], 1), states[i].toggle ? 1U : 0U);
    EXPECT_EQ(number(packets[i], 2), static_cast<unsigned>(states[i].state));
  }
}

TEST_F(OwnCanFrames, SyncTimeAndEmergency) {
  const Emergency emergency{0x8130, 0x11, {std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4}, std::byte{5}}};
  const auto packets = dissected(
      {Sync{0x2B}.frame({predefined::kSync, false}), TimeOfDay{73'530'123, 15'673}.frame({predefined::kTime, false}),
       emergency.frame({predefined::kEmergency + 7, false})},
      {"canopen.sync.counter", "canopen.time_stamp_ms", "canopen.time_stamp_days", "canopen.node_id",
       "canopen.em.err_code", "canopen.em.err_reg_co", "canopen.em.err_field"});
  ASSERT_EQ(packets.size(), 3U);
  EXPECT_EQ(number(packets[0], 0), 0x2BU);
  EXPECT_EQ(number(packets[1], 1), 73'530'123U);
  EXPECT_EQ(number(packets[1], 2), 15'673U);
  EXPECT_EQ(number(packets[2], 3), 7U);
  EXPECT_EQ(number(packets[2], 4), 0x8130U);
  EXPECT_EQ(number(packets[2], 5), 1U);
  EXPECT_EQ(packets[2].at(6).at(0), "0102030405");
}

TEST_F(OwnCanFrames, Sdo) {
  const auto to_server = [](const SdoMessage& message) {
    return Frame::of(predefined::kSdoClientToServer + 3, message.encode());
  };
  const auto from_server = [](const SdoMessage& message) {
    return Frame::of(predefined::kSdoServerToClient + 3, message.encode());
  };
  const std::array value{std::byte{0xA1}, std::byte{0xB2}, std::byte{0}, std::byte{0}};
  const auto packets =
      dissected({to_server({sdo_command(SdoRequest::kInitiateUpload), 0x6041, 2, {}}),
                 from_server({expedited_command(SdoResponse::kInitiateUpload, 2), 0x6041, 2, value}),
                 to_server({expedited_command(SdoRequest::kInitiateDownload, 2), 0x6040, 5, value}),
                 from_server({sdo_command(SdoResponse::kInitiateDownload), 0x6040, 5, {}}),
                 from_server(abort_message(0x6042, 7, SdoAbort::kSubindexDoesNotExist))},
                {"canopen.sdo.main_idx", "canopen.sdo.sub_idx", "canopen.sdo.n", "canopen.sdo.abort_code"});
  ASSERT_EQ(packets.size(), 5U);
  const std::array<std::array<unsigned, 2>, 5> objects{
      {{0x6041, 2}, {0x6041, 2}, {0x6040, 5}, {0x6040, 5}, {0x6042, 7}}};
  for (std::size_t i = 0; i < packets.size(); ++i) {
    EXPECT_EQ(number(packets[i], 0), objects[i][0]);
    EXPECT_EQ(number(packets[i], 1), objects[i][1]);
  }
  EXPECT_EQ(number(packets[1], 2), 2U);  // unused bytes
  EXPECT_EQ(number(packets[2], 2), 2U);
  EXPECT_EQ(number(packets[4], 3), 0x06090011U);
}

}  // namespace
}  // namespace driveline::canopen
