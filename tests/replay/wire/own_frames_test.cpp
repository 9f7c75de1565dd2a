#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <random>

#include "driveline/wire/al.hpp"
#include "driveline/wire/coe.hpp"
#include "driveline/wire/dl.hpp"
#include "driveline/wire/fmmu.hpp"
#include "driveline/wire/foe.hpp"
#include "driveline/wire/frame.hpp"
#include "driveline/wire/mailbox.hpp"
#include "driveline/wire/registers.hpp"
#include "driveline/wire/sdo_abort.hpp"
#include "driveline/wire/soe.hpp"
#include "driveline/wire/sync_manager.hpp"
#include "tshark.hpp"

/// Frames of the builder under test, read by Wireshark's dissector.
namespace driveline::wire {
namespace {

using replay::DissectedPacket;
using replay::to_number;
using ::testing::ElementsAre;
using Bytes = std::vector<std::byte>;

constexpr MacAddress kMac{std::byte{2}, std::byte{0}, std::byte{0}, std::byte{0}, std::byte{0}, std::byte{1}};
constexpr std::uint16_t kStation = 0x1001;
constexpr std::uint16_t kMailboxAddress = 0x1800;

/// A frame with one datagram that carries `data`.
Bytes frame_with(Command command, DatagramAddress address, std::span<const std::byte> data, std::uint16_t counter = 1) {
  std::array<std::byte, 1514> buffer{};
  FrameBuilder builder(buffer, kMac);
  const auto place = builder.add(command, 0x42, address, data.size()).value();
  std::copy(data.begin(), data.end(), builder.data(place).begin());
  const auto frame = builder.finish();
  bytes::store_le(frame.subspan(place.working_counter()), counter);
  return {frame.begin(), frame.end()};
}

class OwnFrames : public ::testing::Test {
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
  std::vector<DissectedPacket> dissected(const std::vector<Bytes>& frames, const std::vector<std::string>& fields) {
    replay::write_pcap(file_, frames);
    const auto malformed = replay::dissect(file_, "_ws.malformed || _ws.expert.severity >= 0x600000", {"frame.number"});
    EXPECT_TRUE(malformed) << malformed.error();
    EXPECT_TRUE(!malformed || malformed->empty()) << malformed->size() << " malformed frames";
    const auto result = replay::dissect(file_, "ecatf", fields);
    EXPECT_TRUE(result) << result.error();
    EXPECT_TRUE(!result || result->size() == frames.size());
    return result.value_or(std::vector<DissectedPacket>{});
  }

 private:
  std::filesystem::path file_;
};

TEST_F(OwnFrames, AllCommandsInFramesOfSeveralDatagrams) {
  struct Sent {
    Command command;
    std::uint8_t index;
    std::uint32_t address;
    std::size_t length;
    std::uint16_t counter;
  };
  std::mt19937 random(1);
  std::vector<std::vector<Sent>> sent;
  std::vector<Bytes> frames;
  for (int round = 0; round < 60; ++round) {
    std::array<std::byte, 1514> buffer{};
    FrameBuilder builder(buffer, kMac);
    std::vector<Sent> list;
    std::vector<DatagramPlace> places;
    for (int n = 0; n <= round % 8; ++n) {
      const auto command = static_cast<Command>((round + n) % 15);
      // A memory offset beyond the mailbox addresses known to the dissector, so that the data are plain data.
      const std::uint32_t address = is_logical(command)
                                        ? static_cast<std::uint32_t>(random())
                                        : 0x3000'0000U + static_cast<std::uint32_t>(random() % 0xFFFFFFU);
      const Sent one{command, static_cast<std::uint8_t>(random()), address, 1 + random() % 150,
                     static_cast<std::uint16_t>(random())};
      const auto place = builder.add(one.command, one.index, {one.address}, one.length);
      ASSERT_TRUE(place);
      places.push_back(*place);
      list.push_back(one);
    }
    const auto frame = builder.finish();
    for (std::size_t n = 0; n < places.size(); ++n) {
      bytes::store_le(frame.subspan(places[n].working_counter()), list[n].counter);
    }
    frames.emplace_back(frame.begin(), frame.end());
    sent.push_back(list);
  }

  const auto packets = dissected(frames, {"ecat.cmd", "ecat.idx", "ecat.lad", "ecat.adp", "ecat.ado",
                                          "ecat.subframe.length", "ecat.subframe.more", "ecat.cnt"});
  ASSERT_EQ(packets.size(), frames.size());
  for (std::size_t i = 0; i < packets.size(); ++i) {
    SCOPED_TRACE(i);
    std::size_t logical = 0;
    std::size_t physical = 0;
    ASSERT_EQ(packets[i][0].size(), sent[i].size());
    for (std::size_t n = 0; n < sent[i].size(); ++n) {
      const auto value = [&](std::size_t field, std::size_t at) { return to_number(packets[i][field].at(at)); };
      EXPECT_EQ(value(0, n), static_cast<unsigned>(sent[i][n].command));
      EXPECT_EQ(value(1, n), sent[i][n].index);
      if (is_logical(sent[i][n].command)) {
        EXPECT_EQ(value(2, logical++), sent[i][n].address);
      } else {
        EXPECT_EQ(value(3, physical), sent[i][n].address & 0xFFFF);
        EXPECT_EQ(value(4, physical++), sent[i][n].address >> 16);
      }
      EXPECT_EQ(value(5, n), sent[i][n].length);
      EXPECT_EQ(value(6, n) != 0, n + 1 < sent[i].size());
      EXPECT_EQ(value(7, n), sent[i][n].counter);
    }
  }
}

TEST_F(OwnFrames, LongestFrame) {
  const Bytes data(kMaxDatagramData, std::byte{0x5A});
  const auto packets = dissected({frame_with(Command::kLrw, DatagramAddress::logical(0), data)},
                                 {"frame.len", "ecatf.length", "ecat.subframe.length"});
  EXPECT_THAT(packets.at(0), ElementsAre(ElementsAre("1514"), ElementsAre("0x05da"), ElementsAre("1486")));
}

// --- Registers ---------------------------------------------------------------------------------------------------

TEST_F(OwnFrames, AlControlAndStatus) {
  const auto read = [](std::uint16_t raw) {
    return frame_with(Command::kFprd, DatagramAddress::physical(kStation, reg::kAlStatus.address),
                      bytes::to_le_bytes(raw));
  };
  const auto write = [](std::uint16_t raw) {
    return frame_with(Command::kFpwr, DatagramAddress::physical(kStation, reg::kAlControl.address),
                      bytes::to_le_bytes(raw));
  };
  const auto packets = dissected(
      {read(AlStatus{AlState::kSafeOp, true, false}.raw()), read(AlStatus{AlState::kOp, false, true}.raw()),
       write(AlControl{AlState::kPreOp, true, false}.raw()), write(AlControl{AlState::kBootstrap, false, true}.raw())},
      {"ecat.reg.alstatus.status", "ecat.reg.alstatus.err", "ecat.reg.alstatus.id", "ecat.reg.alctrl.ctrl",
       "ecat.reg.alctrl.errack", "ecat.reg.alctrl.id"});
  ASSERT_EQ(packets.size(), 4U);
  const auto value = [&](std::size_t packet, std::size_t field) { return to_number(packets[packet][field].at(0)); };
  EXPECT_EQ((std::array{value(0, 0), value(0, 1), value(0, 2)}), (std::array<std::uint64_t, 3>{4, 1, 0}));
  EXPECT_EQ((std::array{value(1, 0), value(1, 1), value(1, 2)}), (std::array<std::uint64_t, 3>{8, 0, 1}));
  EXPECT_EQ((std::array{value(2, 3), value(2, 4), value(2, 5)}), (std::array<std::uint64_t, 3>{2, 1, 0}));
  EXPECT_EQ((std::array{value(3, 3), value(3, 4), value(3, 5)}), (std::array<std::uint64_t, 3>{3, 0, 1}));
}

TEST_F(OwnFrames, DlStatus) {
  DlStatus status;
  status.pdi_operational = true;
  status.enhanced_link_detection = true;
  status.ports[0] = {true, false, true};
  status.ports[2] = {true, false, false};
  const auto packets =
      dissected({frame_with(Command::kFprd, DatagramAddress::physical(kStation, reg::kDlStatus.address),
                            bytes::to_le_bytes(status.raw()))},
                {"ecat.reg.dlstatus1.operation", "ecat.reg.dlstatus1.pdiwatchdog", "ecat.reg.dlstatus1.enhlinkdetect",
                 "ecat.reg.dlstatus1.physlink.port0", "ecat.reg.dlstatus1.physlink.port1",
                 "ecat.reg.dlstatus1.physlink.port2", "ecat.reg.dlstatus1.physlink.port3", "ecat.reg.dlstatus2.port0",
                 "ecat.reg.dlstatus2.port1", "ecat.reg.dlstatus2.port2", "ecat.reg.dlstatus2.port3"});
  ASSERT_EQ(packets.size(), 1U);
  std::vector<std::uint64_t> values;
  for (const auto& field : packets[0]) values.push_back(to_number(field.at(0)));
  // Ports: 0 open without communication, 1 closed, 2 open with communication.
  EXPECT_THAT(values, ElementsAre(1, 0, 1, 1, 0, 1, 0, 2, 1, 0, 1));
}

TEST_F(OwnFrames, SyncManagersAndFmmu) {
  Bytes channels(16);
  const SyncManagerControl mailbox{SyncManagerMode::kMailbox, SyncManagerDirection::kWrite, false, true, false};
  const SyncManagerControl outputs{SyncManagerMode::kThreeBuffer, SyncManagerDirection::kWrite, true, false, true};
  SyncManagerChannel{0x1800, 0x0123, mailbox.raw(), 0, SyncManagerActivate::kEnable, 0}.encode(
      std::span(channels).first<8>());
  SyncManagerChannel{0x1100, 0x0006, outputs.raw(), 0, 0, 0}.encode(std::span(channels).last<8>());
  Bytes fmmu(16);
  FmmuEntity{0x12345678, 0x0123, 3, 5, 0x1140, 6, FmmuEntity::kTypeRead, true}.encode(std::span(fmmu).first<16>());
  const auto address = [](std::uint16_t ado) { return DatagramAddress::physical(kStation, ado); };
  const auto packets =
      dissected({frame_with(Command::kFpwr, address(reg::kSyncManager.at(0)), channels),
                 frame_with(Command::kFpwr, address(reg::kFmmu.at(0)), fmmu)},
                {"ecat.syncman.start", "ecat.syncman.len", "ecat.syncman.opmode", "ecat.syncman.access",
                 "ecat.syncman.irq.ecat", "ecat.syncman.irq.pdi", "ecat.syncman.wdt", "ecat.syncman.enable",
                 "ecat.fmmu.lstart", "ecat.fmmu.llen", "ecat.fmmu.lstartbit", "ecat.fmmu.lendbit", "ecat.fmmu.pstart",
                 "ecat.fmmu.pstartbit", "ecat.fmmu.typeread", "ecat.fmmu.typewrite", "ecat.fmmu.activate0"});
  ASSERT_EQ(packets.size(), 2U);
  std::vector<std::vector<std::uint64_t>> channel_values;
  for (std::size_t field = 0; field < 8; ++field) {
    channel_values.push_back({to_number(packets[0][field].at(0)), to_number(packets[0][field].at(1))});
  }
  EXPECT_THAT(channel_values,
              ElementsAre(ElementsAre(0x1800, 0x1100), ElementsAre(0x0123, 6), ElementsAre(2, 0), ElementsAre(1, 1),
                          ElementsAre(0, 1), ElementsAre(1, 0), ElementsAre(0, 1), ElementsAre(1, 0)));
  std::vector<std::uint64_t> fmmu_values;
  for (std::size_t field = 8; field < packets[1].size(); ++field) {
    fmmu_values.push_back(to_number(packets[1][field].at(0)));
  }
  EXPECT_THAT(fmmu_values, ElementsAre(0x12345678, 0x0123, 3, 5, 0x1140, 6, 1, 0, 1));
}

// --- Mailbox -----------------------------------------------------------------------------------------------------

template <typename T>
void append(Bytes& bytes, const T& value) {
  std::array<std::byte, T::kSize> out{};
  value.encode(out);
  bytes.insert(bytes.end(), out.begin(), out.end());
}

Bytes mailbox(MailboxType type, std::uint8_t counter, const Bytes& service) {
  Bytes bytes;
  append(bytes, MailboxHeader{static_cast<std::uint16_t>(service.size()), 0x1234, 0, 2, type, counter});
  bytes.insert(bytes.end(), service.begin(), service.end());
  return bytes;
}

template <typename T>
Bytes coe(CoeService service, const T& message, const Bytes& data = {}) {
  Bytes bytes;
  append(bytes, CoeHeader{0, service});
  append(bytes, message);
  bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

Bytes segment(CoeService service, const SdoSegmentHeader& header) {
  Bytes bytes;
  append(bytes, CoeHeader{0, service});
  bytes.push_back(static_cast<std::byte>(header.raw()));
  bytes.resize(bytes.size() + SdoSegmentHeader::kMinData, std::byte{0x11});
  return bytes;
}

/// A frame in which the master writes the mailbox.
Bytes to_slave(const Bytes& service, std::uint8_t counter = 1) {
  return frame_with(Command::kFpwr, DatagramAddress::physical(kStation, kMailboxAddress),
                    mailbox(MailboxType::kCoe, counter, service));
}

TEST_F(OwnFrames, MailboxHeaders) {
  std::vector<Bytes> frames;
  for (std::uint8_t counter = 0; counter < 8; ++counter) {
    frames.push_back(to_slave(coe(CoeService::kSdoRequest, SdoHeader{0x40, 0x1000, 0, {}}), counter));
  }
  // The priority is not compared: the dissector takes it from bits 0-1 of the fifth byte, but ETG.1000.4 Table 29 has
  // it in bits 6-7 after the channel.
  const auto packets =
      dissected(frames, {"ecat_mailbox.length", "ecat_mailbox.address", "ecat_mailbox.type", "ecat_mailbox.counter"});
  ASSERT_EQ(packets.size(), 8U);
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const auto value = [&](std::size_t field) { return to_number(packets[i][field].at(0)); };
    EXPECT_EQ(value(0), 10U);
    EXPECT_EQ(value(1), 0x1234U);
    EXPECT_EQ(value(2), 3U);
    EXPECT_EQ(value(3), i);
  }
}

TEST_F(OwnFrames, SdoInitiate) {
  const auto request = static_cast<std::uint8_t>(SdoRequestCommand::kInitiateDownload);
  const auto answer = static_cast<std::uint8_t>(SdoResponseCommand::kInitiateUpload);
  const SdoHeader download{expedited_command(request, 2), 0x6040, 3, {std::byte{0x0F}, std::byte{0x01}}};
  const SdoHeader upload{
      expedited_command(answer, 4), 0x6064, 0, {std::byte{0x78}, std::byte{0x56}, std::byte{0x34}, std::byte{0x12}}};
  const SdoHeader complete{static_cast<std::uint8_t>(0x40 | SdoHeader::kCompleteAccess), 0x1C12, 1, {}};
  const auto packets = dissected(
      {to_slave(coe(CoeService::kSdoRequest, download)), to_slave(coe(CoeService::kSdoResponse, upload)),
       to_slave(coe(CoeService::kSdoRequest, complete))},
      {"ecat_mailbox.coe.type", "ecat_mailbox.coe.sdoidx", "ecat_mailbox.coe.sdosub", "ecat_mailbox.coe.sdodata",
       "ecat_mailbox.coe.sdoreq", "ecat_mailbox.coe.sdores", "ecat_mailbox.coe.sdoccsid.expedited",
       "ecat_mailbox.coe.sdoccsid.sizeind", "ecat_mailbox.coe.sdoscsiu_expedited"});
  ASSERT_EQ(packets.size(), 3U);
  const auto value = [&](std::size_t packet, std::size_t field) { return to_number(packets[packet][field].at(0)); };
  EXPECT_EQ(value(0, 0), 2U);
  EXPECT_EQ(value(0, 1), 0x6040U);
  EXPECT_EQ(value(0, 2), 3U);
  EXPECT_EQ(value(0, 3), 0x010FU);
  EXPECT_EQ(value(0, 4), 1U);
  EXPECT_EQ(value(0, 6), 1U);
  EXPECT_EQ(value(0, 7), 1U);
  EXPECT_EQ(value(1, 0), 3U);
  EXPECT_EQ(value(1, 1), 0x6064U);
  EXPECT_EQ(value(1, 3), 0x12345678U);
  EXPECT_EQ(value(1, 5), 2U);
  EXPECT_EQ(value(1, 8), 1U);
  EXPECT_EQ(value(2, 1), 0x1C12U);
  EXPECT_EQ(value(2, 2), 1U);
  EXPECT_EQ(value(2, 4), 2U);
}

TEST_F(OwnFrames, SdoAbortCode) {
  const auto command = static_cast<std::uint8_t>(static_cast<unsigned>(SdoRequestCommand::kAbort) << 5);
  const SdoHeader abort{command, 0x2000, 7,
                        bytes::to_le_bytes(static_cast<std::uint32_t>(SdoAbort::kObjectDoesNotExist))};
  const auto packets = dissected({to_slave(coe(CoeService::kSdoRequest, abort))},
                                 {"ecat_mailbox.coe.sdoreq", "ecat_mailbox.coe.abortcode"});
  ASSERT_EQ(packets.size(), 1U);
  EXPECT_EQ(to_number(packets[0][0].at(0)), 4U);
  EXPECT_EQ(to_number(packets[0][1].at(0)), 0x06020000U);
}

TEST_F(OwnFrames, SdoSegments) {
  const auto download = static_cast<std::uint8_t>(SdoRequestCommand::kDownloadSegment);
  const auto download_answer = static_cast<std::uint8_t>(SdoResponseCommand::kDownloadSegment);
  const auto upload = static_cast<std::uint8_t>(SdoRequestCommand::kUploadSegment);
  const auto upload_answer = static_cast<std::uint8_t>(SdoResponseCommand::kUploadSegment);
  const auto packets = dissected(
      {to_slave(segment(CoeService::kSdoRequest, {download, true, 5, true})),
       to_slave(segment(CoeService::kSdoResponse, {download_answer, true, 0, false})),
       to_slave(segment(CoeService::kSdoRequest, {upload, true, 0, false})),
       to_slave(segment(CoeService::kSdoResponse, {upload_answer, true, 3, true}))},
      {"ecat_mailbox.coe.sdoreq", "ecat_mailbox.coe.sdores", "ecat_mailbox.coe.sdoccsds.lastseg",
       "ecat_mailbox.coe.sdoccsds.size", "ecat_mailbox.coe.sdoccsds.toggle", "ecat_mailbox.coe.sdoscsds_toggle",
       "ecat_mailbox.coe.sdoccsus_toggle", "ecat_mailbox.coe.sdoscsus_lastseg", "ecat_mailbox.coe.sdoscsus_bytes",
       "ecat_mailbox.coe.sdoscsus_toggle"});
  ASSERT_EQ(packets.size(), 4U);
  const auto value = [&](std::size_t packet, std::size_t field) { return to_number(packets[packet][field].at(0)); };
  EXPECT_EQ(value(0, 0), 0U);
  EXPECT_EQ(value(0, 2), 1U);
  EXPECT_EQ(value(0, 3), 5U);
  EXPECT_EQ(value(0, 4), 1U);
  EXPECT_EQ(value(1, 1), 1U);
  EXPECT_EQ(value(1, 5), 1U);
  EXPECT_EQ(value(2, 0), 3U);
  EXPECT_EQ(value(2, 6), 1U);
  EXPECT_EQ(value(3, 1), 0U);
  EXPECT_EQ(value(3, 7), 1U);
  EXPECT_EQ(value(3, 8), 3U);
  EXPECT_EQ(value(3, 9), 1U);
}

/// Converts hexadecimal text to bytes.
Bytes by_hand(std::string_view text) {
  Bytes bytes;
  unsigned high = 0;
  bool half = false;
  for (const char c : text) {
    if (c == ' ') continue;
    const auto digit = static_cast<unsigned>(c <= '9' ? c - '0' : c - 'a' + 10);
    if (half) bytes.push_back(static_cast<std::byte>(high << 4 | digit));
    high = digit;
    half = !half;
  }
  return bytes;
}

/// A frame without any part from the encoder under test: Ethernet; EtherCAT with one datagram; FPWR to 1001h, 1800h;
/// mailbox header; service; working counter.
Bytes frame_by_hand(const Bytes& service, MailboxType type) {
  auto frame = by_hand("ff ff ff ff ff ff 02 00 00 00 00 01 88 a4");
  const auto size = static_cast<std::uint8_t>(service.size());
  const auto append_all = [&frame](const Bytes& bytes) { frame.insert(frame.end(), bytes.begin(), bytes.end()); };
  append_all({static_cast<std::byte>(10 + 6 + size + 2), std::byte{0x10}});
  append_all(by_hand("05 42 01 10 00 18"));
  append_all({static_cast<std::byte>(6 + size), std::byte{0}, std::byte{0}, std::byte{0}});
  append_all({static_cast<std::byte>(size), std::byte{0}});
  append_all(by_hand("00 00 00"));
  append_all({static_cast<std::byte>(0x10 | static_cast<unsigned>(type))});
  append_all(service);
  append_all(by_hand("01 00"));
  frame.resize(std::max<std::size_t>(frame.size(), 60));
  return frame;
}

/// The dissector reads FoE messages in frames composed without the encoder; the encoder makes the same bytes.
TEST_F(OwnFrames, FoeMailsMadeByHand) {
  struct Mail {
    std::string_view service;
    FoeHeader header;
  };
  const Mail mails[] = {
      {"01 00 78 56 34 12 66 2e 65 66 77", {FoeOpCode::kReadRequest, 0x12345678}},  // "f.efw"
      {"02 00 01 00 00 00 66 2e 65 66 77", {FoeOpCode::kWriteRequest, 1}},
      {"03 00 02 01 00 00 61 62 63 64", {FoeOpCode::kData, 258}},
      {"04 00 02 01 00 00", {FoeOpCode::kAck, 258}},
      {"05 00 01 80 00 00 6e 6f 6e 65", {FoeOpCode::kError, 0x8001}},  // "none"
      {"06 00 32 00 64 00 77 61 69 74", {FoeOpCode::kBusy, FoeBusy{50, 100}.value()}},
  };
  std::vector<Bytes> frames;
  for (const auto& mail : mails) {
    const auto service = by_hand(mail.service);
    std::array<std::byte, FoeHeader::kSize> made{};
    mail.header.encode(made);
    EXPECT_TRUE(std::equal(made.begin(), made.end(), service.begin())) << mail.service;
    frames.push_back(frame_by_hand(service, MailboxType::kFoe));
  }
  const auto packets =
      dissected(frames, {"ecat_mailbox.type", "ecat_mailbox.foe_opmode", "ecat_mailbox.foe_filelength",
                         "ecat_mailbox.foe_filename", "ecat_mailbox.foe_packetno", "ecat_mailbox.foe_errcode",
                         "ecat_mailbox.foe_errtext", "ecat_mailbox.foe_busydone", "ecat_mailbox.foe_busyentire"});
  ASSERT_EQ(packets.size(), std::size(mails));
  const auto value = [&](std::size_t packet, std::size_t field) { return to_number(packets[packet][field].at(0)); };
  for (std::size_t i = 0; i < packets.size(); ++i) {
    EXPECT_EQ(value(i, 0), static_cast<unsigned>(MailboxType::kFoe)) << i;
    EXPECT_EQ(value(i, 1), i + 1);
  }
  EXPECT_EQ(value(0, 2), 0x12345678U);
  EXPECT_EQ(packets[0][3].at(0), "f.efw");
  EXPECT_EQ(packets[1][3].at(0), "f.efw");
  EXPECT_EQ(value(2, 4), 258U);
  EXPECT_EQ(value(3, 4), 258U);
  EXPECT_EQ(value(4, 5), 0x8001U);
  EXPECT_EQ(packets[4][6].at(0), "none");
  EXPECT_EQ(value(5, 7), 50U);
  EXPECT_EQ(value(5, 8), 100U);
}

/// The dissector reads SoE messages in frames composed without the encoder; the encoder makes the same bytes.
TEST_F(OwnFrames, SoeMailsMadeByHand) {
  using E = SoeElement;
  struct Mail {
    std::string_view service;
    SoeHeader header;
    std::string_view read_as;
  };
  const auto everything = E::kState | E::kName | E::kAttribute | E::kUnit | E::kMin | E::kMax | E::kValue | E::kDefault;
  const Mail mails[] = {
      {"01 40 11 00", {SoeOpCode::kReadRequest, false, false, 0, E::kValue, 0x0011}, "RRQ (S-0-0017, 'V')"},
      {"81 ff 01 80", {SoeOpCode::kReadRequest, false, false, 4, everything, 0x8001}, "RRQ (P-0-0001, 'DNAUIXV')"},
      {"02 40 11 00 04 00 08 00 01 00 0b 00",
       {SoeOpCode::kReadResponse, false, false, 0, E::kValue, 0x0011},
       "RRS (S-0-0017, 'V') : 8 Bytes"},
      {"0a 40 02 00 61 62 63 64", {SoeOpCode::kReadResponse, true, false, 0, E::kValue, 2}, "FragmentsLeft 2"},
      {"32 40 12 00 08 70", {SoeOpCode::kReadResponse, false, true, 1, E::kValue, 0x0012}, "Error 7008"},
      {"43 50 2f 80 01 02 03 04",
       {SoeOpCode::kWriteRequest, false, false, 2, E::kMin | E::kValue, 0x802F},
       "WRQ (P-0-0047, 'IV') : 4 Bytes"},
      {"04 40 07 00", {SoeOpCode::kWriteResponse, false, false, 0, E::kValue, 7}, "WRS (S-0-0007, 'V')"},
      {"05 01 63 00 03 00",
       {SoeOpCode::kNotification, false, false, 0, E::kState, 99},
       "NFC (S-0-0099, 'D') : 2 Bytes"},
      {"46 00 00 00 30 81 0a 01 02 03 04 05", {SoeOpCode::kEmergency, false, false, 2, {}, 0}, "EMGCY"},
  };
  std::vector<Bytes> frames;
  for (const auto& mail : mails) {
    const auto service = by_hand(mail.service);
    std::array<std::byte, SoeHeader::kSize> made{};
    mail.header.encode(made);
    EXPECT_TRUE(std::equal(made.begin(), made.end(), service.begin())) << mail.service;
    frames.push_back(frame_by_hand(service, MailboxType::kSoe));
  }
  const auto packets =
      dissected(frames, {"ecat_mailbox.type", "ecat_mailbox.soe_opcode", "ecat_mailbox.soe_header_incomplete",
                         "ecat_mailbox.soe_header_error", "ecat_mailbox.soe_header_driveno", "_ws.col.Info"});
  ASSERT_EQ(packets.size(), std::size(mails));
  for (std::size_t i = 0; i < packets.size(); ++i) {
    SCOPED_TRACE(mails[i].service);
    const auto value = [&](std::size_t field) { return to_number(packets[i][field].at(0)); };
    EXPECT_EQ(value(0), static_cast<unsigned>(MailboxType::kSoe));
    EXPECT_EQ(value(1), static_cast<unsigned>(mails[i].header.op_code));
    EXPECT_EQ(value(2) != 0, mails[i].header.incomplete);
    EXPECT_EQ(value(3) != 0, mails[i].header.error);
    EXPECT_EQ(value(4), mails[i].header.drive);
    // The dissector's summary contains a comma, the separator of its fields.
    std::string summary;
    for (const auto& part : packets[i][5]) summary += (summary.empty() ? "" : ",") + part;
    EXPECT_THAT(summary, ::testing::HasSubstr("SoE: " + std::string(mails[i].read_as)));
  }
}

TEST_F(OwnFrames, SdoInformationAndEmergency) {
  const Bytes list_type{std::byte{1}, std::byte{0}};
  const Bytes indices{std::byte{1}, std::byte{0}, std::byte{0x18}, std::byte{0x10}};
  const auto packets = dissected(
      {to_slave(coe(CoeService::kSdoInformation, SdoInfoHeader{SdoInfoOpCode::kListRequest, false, 0}, list_type)),
       to_slave(coe(CoeService::kSdoInformation, SdoInfoHeader{SdoInfoOpCode::kListResponse, true, 258}, indices)),
       to_slave(coe(CoeService::kEmergency, Emergency{0x8130, 0x11, {}}))},
      {"ecat_mailbox.coe.type", "ecat_mailbox.coe.sdoinfoopcode", "ecat_mailbox.coe.sdoinfofrag",
       "ecat_mailbox.coe.sdoinfolisttype"});
  ASSERT_EQ(packets.size(), 3U);
  const auto value = [&](std::size_t packet, std::size_t field) { return to_number(packets[packet][field].at(0)); };
  EXPECT_EQ(value(0, 0), 8U);
  EXPECT_EQ(value(0, 1) & 0x7FU, 1U);
  EXPECT_EQ(value(0, 3), 1U);
  EXPECT_EQ(value(1, 1) & 0x7FU, 2U);
  EXPECT_EQ(value(1, 2), 258U);
  EXPECT_EQ(value(2, 0), 1U);
}

}  // namespace
}  // namespace driveline::wire
