// A session with every service of CANopen on the simulated bus, as a log of candump: Wireshark's dissector names every
// frame as we do, and log2asc of can-utils reads the log.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <iomanip>
#include <optional>
#include <set>
#include <sstream>

#include "driveline/canopen_wire/candump.hpp"
#include "driveline/canopen_wire/nmt.hpp"
#include "driveline/canopen_wire/sdo.hpp"
#include "driveline/canopen_wire/sdo_block.hpp"
#include "driveline/canopen_wire/sync.hpp"
#include "driveline/slaves/msd/can/msd_can_drive.hpp"
#include "support/canopen_sample.hpp"
#include "support/scripted_node.hpp"
#include "tshark.hpp"

namespace driveline::slaves {
namespace {

using bytes_test::hex;
using canopen::Frame;
using canopen::FrameKind;
using canopen::NmtCommand;
using canopen::NmtState;
using ::testing::IsSupersetOf;
using ::testing::StartsWith;
using namespace std::chrono_literals;

constexpr std::uint8_t kDrive = 12;  ///< an MSD
constexpr std::uint8_t kSample = 5;  ///< a device with block transfer
constexpr std::string_view kInterface = "can0";

/// The nodes, and a session between them.
class Session {
 public:
  Session() : dictionary_(cia301::sample_table()), device_(dictionary_, application_, {.block_transfer = true}) {
    bus_.attach(master_);
    bus_.attach(drive_.device());
    bus_.attach(device_);
    bus_.attach(recorder_, {.listen_only = true, .error_frames = true});
    run(10ms);
  }
  [[nodiscard]] const std::vector<can::ScriptedNode::Seen>& frames() const { return recorder_.received; }
  /// Frames of block transfers without a command: their first byte is a sequence number.
  [[nodiscard]] bool is_block_segment(std::size_t frame) const { return block_segments_.count(frame) != 0; }

  void transfers() {
    for (const std::uint8_t node : {kDrive, kSample}) {
      ask(node, "40 00 10 00 00 00 00 00");
      ask(node, "40 FF 5F 00 00 00 00 00");  // aborted by the server
      ask(node, "21 03 20 00 0A 00 00 00");
      ask(node, "00 41 42 43 44 45 46 47");
      ask(node, "19 48 49 4A 00 00 00 00");
      ask(node, "40 03 20 00 00 00 00 00");
      for (int i = 0; i < 15; ++i) ask(node, i % 2 == 0 ? "60 00 00 00 00 00 00 00" : "70 00 00 00 00 00 00 00");
      ask(node, "40 03 20 00 00 00 00 00");
      ask(node, "80 03 20 00 00 00 00 08");  // aborted by the client
    }
    block_download();
    block_upload();
    ask(kDrive, "2B 17 10 00 0A 00 00 00");  // heartbeats, which would be among the segments
  }
  void states() {
    for (const auto command : {NmtCommand::kStart, NmtCommand::kStop, NmtCommand::kEnterPreOperational}) {
      send(canopen::NmtRequest{command, 0}.frame());
      run(20ms);  // heartbeats of the drive
      for (int i = 0; i < 2; ++i) send(Frame::remote({0x700U + kSample, false}, 1));
    }
  }
  void process_data() {
    for (unsigned pdo = 0; pdo < 4; ++pdo) map_in_sample(pdo);
    send(canopen::NmtRequest{NmtCommand::kStart, kSample}.frame());
    run(5ms);
    for (unsigned pdo = 0; pdo < 4; ++pdo) send(Frame::of(0x200U + 0x100U * pdo + kSample, hex("2A")));
    for (std::uint8_t counter = 0; counter < 3; ++counter) send(canopen::Sync{counter}.frame({0x80, false}));
    send(canopen::TimeOfDay{73'530'123, 15'673}.frame({0x100, false}));
  }
  void emergencies() {
    drive_.core().set_cause(msd::Fault::kOvercurrent, true);
    device_.raise({0x4310, 8, {}}, bus_.now());
    run(5ms);
    drive_.core().set_cause(msd::Fault::kOvercurrent, false);
    device_.clear(0x4310, bus_.now());
    ask(kDrive, "2F 99 20 00 01 00 00 00");
  }
  void resets() {
    send(canopen::NmtRequest{NmtCommand::kResetCommunication, kDrive}.frame());
    send(canopen::NmtRequest{NmtCommand::kResetNode, 0}.frame());
    run(20ms);
  }

 private:
  void run(std::chrono::nanoseconds time) { bus_.advance(bus_.now() + time); }
  void send(const Frame& frame) {
    master_.send_at(bus_.now(), frame);
    run(3ms);
  }
  void ask(std::uint8_t node, std::string_view request) { send(Frame::of(0x600U + node, hex(request))); }
  void segment(std::string_view payload) {
    block_segments_.insert(frames().size());
    ask(kSample, payload);
  }
  void block_download() {
    ask(kSample, "C6 08 20 00 0A 00 00 00");
    segment("01 01 02 03 04 05 06 07");
    segment("82 08 09 0A 00 00 00 00");
    const auto crc = bytes::to_le_bytes(canopen::sdo_block::crc16(hex("01 02 03 04 05 06 07 08 09 0A")));
    std::array<std::byte, 8> end{std::byte{0xC1 | 4 << 2}, crc[0], crc[1]};
    send(Frame::of(0x600U + kSample, end));
  }
  void block_upload() {
    ask(kSample, "A4 03 20 00 7F 00 00 00");
    const std::size_t first = frames().size() + 1;
    ask(kSample, "A3 00 00 00 00 00 00 00");
    for (std::size_t i = first; i < frames().size(); ++i) block_segments_.insert(i);
    ask(kSample, "A2 0F 7F 00 00 00 00 00");
    ask(kSample, "A1 00 00 00 00 00 00 00");
  }
  /// An event-driven PDO of each direction with 2001h.
  void map_in_sample(unsigned pdo) {
    const auto write = [&](unsigned index, std::uint8_t subindex, std::uint32_t value, std::size_t size) {
      const auto command = canopen::expedited_command(canopen::SdoRequest::kInitiateDownload, size);
      send(Frame::of(0x600U + kSample, canopen::SdoMessage{command, static_cast<std::uint16_t>(index), subindex,
                                                           bytes::to_le_bytes(value)}
                                           .encode()));
    };
    for (const unsigned communication : {0x1400U + pdo, 0x1800U + pdo}) {
      const std::uint32_t cob_id = (communication < 0x1800 ? 0x200U : 0x180U) + 0x100U * pdo + kSample;
      write(communication, 1, cob_id | 0x8000'0000U, 4);
      write(communication + 0x200U, 1, 0x2001'0008, 4);
      write(communication + 0x200U, 0, 1, 1);
      write(communication, 1, cob_id, 4);
    }
  }

  can::Bus bus_;
  can::ScriptedNode master_;
  msd::MsdCanDrive drive_{{}, {msd::DipSwitch{kDrive}, {}, 500us}};
  ObjectDictionary dictionary_;
  cia301::SampleApplication application_;
  cia301::Device device_;
  can::ScriptedNode recorder_;  ///< hears everything and takes no part
  std::set<std::size_t> block_segments_;
};

/// Wireshark's name of a node: "[0xc]".
std::string in_brackets(unsigned node) {
  std::ostringstream text;
  text << " [0x" << std::hex << node << ']';
  return text.str();
}

std::string name_of_nmt(const Frame& frame) {
  const auto request = canopen::NmtRequest::decode(frame.payload());
  if (!request) return "no NMT request";
  const auto name = [&]() -> std::string {
    switch (request->command) {
      case NmtCommand::kStart:
        return "Start remote node";
      case NmtCommand::kStop:
        return "Stop remote node";
      case NmtCommand::kEnterPreOperational:
        return "Enter pre-operational state";
      case NmtCommand::kResetNode:
        return "Reset node";
      case NmtCommand::kResetCommunication:
        return "Reset communication";
    }
    return "?";
  }();
  return "NMT: " + name + (request->node == 0 ? " [All]" : in_brackets(request->node));
}

std::string name_of_error_control(const Frame& frame, unsigned node) {
  const auto message = canopen::ErrorControl::decode(frame.payload());
  if (!message) return "no error control";
  const auto name = [&]() -> std::string {
    switch (message->state) {
      case NmtState::kInitialising:
        return "Boot-up";
      case NmtState::kStopped:
        return "Stopped";
      case NmtState::kOperational:
        return "Operational";
      case NmtState::kPreOperational:
        return "Pre-operational";
    }
    return "?";
  }();
  return "NMT Error Control: " + name + in_brackets(node);
}

std::string name_of_sdo(const Frame& frame, bool request, bool segment_of_a_block) {
  static constexpr std::array kRequests{"Download segment request",
                                        "Initiate download request",
                                        "Initiate upload request",
                                        "Upload segment request",
                                        "Abort transfer",
                                        "Block upload",
                                        "Block download"};
  static constexpr std::array kResponses{"Upload segment response",
                                         "Download segment response",
                                         "Initiate upload response",
                                         "Initiate download response",
                                         "Abort transfer",
                                         "Block download",
                                         "Block upload"};
  std::string direction = request ? "Default-SDO (rx): " : "Default-SDO (tx): ";
  if (segment_of_a_block) return direction;
  const auto specifier = std::to_integer<std::size_t>(frame.data[0]) >> 5U;
  return direction + (request ? kRequests : kResponses).at(specifier);
}

/// What we call this frame, in Wireshark's words.
std::string name_of(const Frame& frame, bool segment_of_a_block) {
  namespace predefined = canopen::predefined;
  const std::uint32_t node = frame.identifier.value & 0x7FU;
  const std::uint32_t function = frame.identifier.value - node;
  if (frame.kind == FrameKind::kRemote) return "ID: " + std::to_string(frame.identifier.value);
  if (frame.identifier.value == predefined::kNmt) return name_of_nmt(frame);
  if (frame.identifier.value == predefined::kSync) {
    const auto sync = canopen::Sync::decode(frame.payload());
    return sync && sync->counter != 0 ? "SYNC [" + std::to_string(sync->counter) + "]" : "SYNC";
  }
  if (frame.identifier.value == predefined::kTime) return "TIME STAMP";
  if (function == predefined::kEmergency) return "EMCY";
  if (function == predefined::kErrorControl) return name_of_error_control(frame, node);
  if (function == predefined::kSdoClientToServer) return name_of_sdo(frame, true, segment_of_a_block);
  if (function == predefined::kSdoServerToClient) return name_of_sdo(frame, false, segment_of_a_block);
  const bool transmitted = (function & 0x80U) != 0;
  return "PDO" + std::to_string(transmitted ? function / 0x100 : function / 0x100 - 1) +
         (transmitted ? " (tx)" : " (rx)");
}

class CanSession : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    file_ = std::filesystem::path(::testing::TempDir()) /
            ("driveline_" + std::string(test->name()) + "_" + std::to_string(::getpid()) + ".log");
    session_.transfers();
    session_.states();
    session_.process_data();
    session_.emergencies();
    session_.resets();
    constexpr std::uint64_t kEpoch = 1'436'509'052'000'000;
    std::ofstream out(file_);
    for (const auto& [time, frame] : session_.frames()) {
      const auto us = static_cast<std::uint64_t>(time / 1us);
      out << canopen::candump::line_of(frame, kInterface, kEpoch + us).view() << '\n';
    }
  }
  void TearDown() override { std::filesystem::remove(file_); }

  std::filesystem::path file_;
  Session session_;
};

TEST_F(CanSession, WiresharkNamesEveryFrameAsWeDo) {
  if (!replay::tshark_available()) GTEST_SKIP() << replay::missing_tshark_text();
  const std::string decode_as = "can.subdissector,canopen";
  const auto malformed =
      replay::dissect(file_, "_ws.malformed || _ws.expert.severity >= 0x600000", {"frame.number"}, decode_as);
  ASSERT_TRUE(malformed) << malformed.error();
  EXPECT_TRUE(malformed->empty()) << malformed->size() << ", the first is frame " << malformed->front()[0][0];
  const auto packets = replay::dissect(file_, "", {"_ws.col.Info", "can.id", "canopen.node_id"}, decode_as);
  ASSERT_TRUE(packets) << packets.error();
  const auto& frames = session_.frames();
  ASSERT_EQ(packets->size(), frames.size());
  std::set<std::string> seen;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Frame& frame = frames[i].frame;
    const auto& packet = (*packets)[i];
    const std::string expected = name_of(frame, session_.is_block_segment(i));
    const bool whole = !session_.is_block_segment(i) && frame.kind == FrameKind::kData;
    EXPECT_THAT(packet[0][0], StartsWith(expected)) << "frame " << i + 1;
    if (whole) {
      EXPECT_EQ(packet[0][0], expected) << "frame " << i + 1;
      EXPECT_EQ(replay::to_number(packet[2].at(0)), frame.identifier.value & 0x7FU) << "frame " << i + 1;
    }
    EXPECT_EQ(replay::to_number(packet[1].at(0)), frame.identifier.value);
    seen.insert(whole ? packet[0][0] : expected);
  }
  // The session has everything.
  EXPECT_THAT(seen, IsSupersetOf({"NMT: Start remote node [All]",
                                  "NMT: Stop remote node [All]",
                                  "NMT: Enter pre-operational state [All]",
                                  "NMT: Reset communication [0xc]",
                                  "NMT: Reset node [All]",
                                  "SYNC",
                                  "SYNC [1]",
                                  "TIME STAMP",
                                  "EMCY",
                                  "PDO1 (tx)",
                                  "PDO2 (tx)",
                                  "PDO3 (tx)",
                                  "PDO4 (tx)",
                                  "PDO1 (rx)",
                                  "PDO2 (rx)",
                                  "PDO3 (rx)",
                                  "PDO4 (rx)",
                                  "NMT Error Control: Boot-up [0xc]",
                                  "NMT Error Control: Operational [0xc]",
                                  "NMT Error Control: Stopped [0xc]",
                                  "NMT Error Control: Pre-operational [0xc]",
                                  "ID: 1797"}));
  for (const std::string direction : {"Default-SDO (rx): ", "Default-SDO (tx): "}) {
    for (const std::string name : {"Abort transfer", "Block upload", "Block download"}) {
      EXPECT_TRUE(seen.contains(direction + name)) << direction << name;
    }
  }
}

/// The values in the frames, by the names that tell their meaning.
TEST_F(CanSession, WiresharkReadsTheirValues) {
  if (!replay::tshark_available()) GTEST_SKIP() << replay::missing_tshark_text();
  const auto values = [&](const std::string& filter, const std::string& field) {
    const auto packets = replay::dissect(file_, filter, {field}, "can.subdissector,canopen");
    if (!packets) throw std::runtime_error(packets.error());
    std::vector<std::uint64_t> out;
    for (const auto& packet : *packets) out.push_back(replay::to_number(packet[0].at(0)));
    return out;
  };
  using ::testing::ElementsAre;
  EXPECT_THAT(values("can.id == 0x8C", "canopen.em.err_code"), ElementsAre(0x2310, 0));
  EXPECT_THAT(values("can.id == 0x85", "canopen.em.err_code"), ElementsAre(0x4310, 0));
  EXPECT_THAT(values("can.id == 0x705 && can.flags.rtr == 0", "canopen.nmt_guard.toggle"),
              ElementsAre(0, 0, 1, 0, 1, 0, 1, 0))
      << "the boot-up messages, and guarding between them";
  // A segment of a block without "more", 82h, looks like an abort.
  EXPECT_THAT(values("can.id == 0x585 && canopen.sdo.abort_code != 0", "canopen.sdo.abort_code"),
              ElementsAre(0x0602'0000));
  EXPECT_THAT(values("can.id == 0x605 && canopen.sdo.abort_code != 0", "canopen.sdo.abort_code"),
              ElementsAre(0x0800'0000));
  EXPECT_THAT(values("canopen.time_stamp_ms", "canopen.time_stamp_ms"), ElementsAre(73'530'123));
}

/// Standard output of a command; empty: it failed.
std::string output_of_command(const std::string& command) {
  std::string output;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  std::array<char, 4096> buffer{};
  for (std::size_t size = 0; (size = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    output.append(buffer.data(), size);
  }
  return ::pclose(pipe) == 0 ? output : std::string();
}

/// A line of the log of a CANalyzer: "   0.123456 1  60C             Rx   d 8 40 00 10 00 00 00 00 00".
struct AscLine {
  double seconds = 0;
  std::string identifier;
  char kind = ' ';
  std::string content;  ///< length and bytes, separated by one blank

  static std::optional<AscLine> parse(const std::string& line) {
    std::istringstream words(line);
    AscLine out;
    std::string channel;
    std::string direction;
    if (!(words >> out.seconds >> channel >> out.identifier >> direction >> out.kind) || channel != "1") return {};
    for (std::string word; words >> word;) out.content += (out.content.empty() ? "" : " ") + word;
    return out;
  }
};

TEST_F(CanSession, Log2ascReadsTheLog) {
  if (output_of_command("command -v log2asc 2>/dev/null").empty()) {
    GTEST_SKIP() << "log2asc is not installed (Debian package can-utils); it is the oracle of this test";
  }
  std::istringstream text(output_of_command("log2asc -I '" + file_.string() + "' " + std::string(kInterface)));
  std::vector<AscLine> lines;
  for (std::string line; std::getline(text, line);) {
    if (const auto parsed = AscLine::parse(line)) lines.push_back(*parsed);
  }
  const auto& frames = session_.frames();
  ASSERT_EQ(lines.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Frame& frame = frames[i].frame;
    std::ostringstream identifier;
    identifier << std::hex << std::uppercase << frame.identifier.value;
    EXPECT_EQ(lines[i].identifier, identifier.str());
    EXPECT_NEAR(lines[i].seconds, std::chrono::duration<double>(frames[i].time - frames[0].time).count(), 2e-6);
    if (frame.kind == FrameKind::kRemote) {
      EXPECT_EQ(lines[i].kind, 'r');
      continue;
    }
    std::ostringstream content;
    content << int{frame.length};
    for (const std::byte byte : frame.payload()) {
      content << ' ' << std::hex << std::uppercase << std::setw(2) << std::setfill('0') << std::to_integer<int>(byte);
    }
    EXPECT_EQ(lines[i].kind, 'd');
    EXPECT_EQ(lines[i].content, content.str());
  }
}

}  // namespace
}  // namespace driveline::slaves
