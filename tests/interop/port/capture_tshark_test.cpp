#include <gmock/gmock.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "driveline/port/capture_port.hpp"
#include "private_network.hpp"
#include "support/temporary_directory.hpp"

namespace driveline::port {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Standard output of a command.
std::string output_of(const std::string& command) {
  std::string output;
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe{popen(command.c_str(), "r"), pclose};
  for (int character = 0; pipe && (character = fgetc(pipe.get())) != EOF;) output += static_cast<char>(character);
  return output;
}

/// BRD of AL status (0x0130, 2 bytes), composed by hand from ETG.1000.4 5.3 and 5.4; padded to 60 bytes.
/// @param source_bit bits that the first slave adds to the source address
Bytes brd_al_status(unsigned index, unsigned source_bit, unsigned al_status, unsigned wkc) {
  Bytes frame(60);
  const std::array<unsigned, 30> values{0xFF,       0xFF,  0xFF, 0xFF, 0xFF, 0xFF,  // broadcast
                                        source_bit, 0x10,  0x20, 0x30, 0x40, 0x50,  // source
                                        0x88,       0xA4,  0x0E, 0x10,              // 14 bytes, datagrams
                                        0x07,       index, 0x00, 0x00, 0x30, 0x01,
                                        0x02,       0x00,  0,    0,  // BRD 0:0x0130, 2 bytes
                                        al_status,  0x00,  wkc,  0x00};
  for (std::size_t i = 0; i < values.size(); ++i) frame[i] = static_cast<std::byte>(values[i]);
  return frame;
}

/// Returns every sent frame as answered by two slaves in OP.
class TwoSlaves final : public Port {
 public:
  explicit TwoSlaves(rt::VirtualClock& clock) : clock_{clock} {}
  SendStatus send(std::span<const std::byte> frame) noexcept override {
    clock_.advance(125us);
    sent_at_ = clock_.now();
    answer_ = brd_al_status(std::to_integer<unsigned>(frame[17]), 0x02, 0x08, 2);
    return SendStatus::kSent;
  }
  std::optional<ReceivedFrame> receive() noexcept override {
    clock_.advance(1234ns);
    return ReceivedFrame{answer_, clock_.now()};
  }
  bool wait_readable(std::chrono::nanoseconds) noexcept override { return true; }
  std::chrono::nanoseconds last_send_time() const noexcept override { return sent_at_; }

 private:
  rt::VirtualClock& clock_;
  std::chrono::nanoseconds sent_at_{};
  Bytes answer_;
};

class CaptureInWireshark : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!run_quietly("tshark --version") || !run_quietly("capinfos --version"))
      GTEST_SKIP() << "tshark is not installed";
    const auto port = CapturePort::open(
        line, clock,
        {.file = file(), .interface_name = "line8", .ring_frames = 4096, .unix_time_of_zero = 1'700'000'000s});
    ASSERT_TRUE(port) << port.error().message;
    for (unsigned i = 0; i < kExchanges; ++i) {
      ASSERT_EQ((*port)->send(brd_al_status(i, 0x00, 0x00, 0)), SendStatus::kSent);
      ASSERT_TRUE((*port)->receive());
    }
    ASSERT_TRUE((*port)->close());
  }

  std::string file() const { return folder.path / "capture.pcapng"; }

  static constexpr unsigned kExchanges = 3;
  rt::VirtualClock clock;
  TwoSlaves line{clock};
  test::TemporaryFolder folder;
};

TEST_F(CaptureInWireshark, DissectsEveryFrame) {
  EXPECT_EQ(
      output_of("tshark -n -r " + file() +
                " -T fields -E separator=/s -e frame.time_epoch -e frame.interface_name -e frame.packet_flags_direction"
                " -e eth.src -e ecat.idx -e ecat.ado -e ecat.cnt 2>/dev/null"),
      "1700000000.000125000 line8 0x00000002 00:10:20:30:40:50 0x00 0x0130 0\n"
      "1700000000.000126234 line8 0x00000001 02:10:20:30:40:50 0x00 0x0130 2\n"
      "1700000000.000251234 line8 0x00000002 00:10:20:30:40:50 0x01 0x0130 0\n"
      "1700000000.000252468 line8 0x00000001 02:10:20:30:40:50 0x01 0x0130 2\n"
      "1700000000.000377468 line8 0x00000002 00:10:20:30:40:50 0x02 0x0130 0\n"
      "1700000000.000378702 line8 0x00000001 02:10:20:30:40:50 0x02 0x0130 2\n");
}

TEST_F(CaptureInWireshark, NothingIsMalformedAndNoFcsIsGuessed) {
  EXPECT_THAT(output_of("tshark -n -r " + file() + " -Y '_ws.malformed || eth.fcs || _ws.expert' 2>/dev/null"),
              IsEmpty());
}

TEST_F(CaptureInWireshark, FileInformationIsComplete) {
  const std::string information = output_of("capinfos -M " + file() + " 2>/dev/null");
  EXPECT_THAT(information, HasSubstr("File type:           pcapng"));
  EXPECT_THAT(information, HasSubstr("Encapsulation = Ethernet"));
  EXPECT_THAT(information, HasSubstr("File timestamp precision:  nanoseconds (9)"));
  EXPECT_THAT(information, HasSubstr("Number of packets:   6"));
  EXPECT_THAT(information, HasSubstr("Capture application: driveline"));
  EXPECT_THAT(information, HasSubstr("Name = line8"));
  EXPECT_THAT(information, HasSubstr("FCS length = 0"));
  EXPECT_THAT(information, HasSubstr("Number of stat entries = 1"));
}

TEST_F(CaptureInWireshark, FileCutShortIsReadUpToTheLastCompleteBlock) {
  // As after a power failure: the end of the last packet block is missing.
  const auto size = std::filesystem::file_size(file());
  std::filesystem::resize_file(file(), size - 52 - 20);
  EXPECT_EQ(output_of("tshark -n -r " + file() + " -T fields -e frame.number 2>/dev/null"), "1\n2\n3\n4\n5\n");
}

}  // namespace
}  // namespace driveline::port
