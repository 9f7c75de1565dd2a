#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <ostream>

#include "driveline/wire/al.hpp"
#include "driveline/wire/coe.hpp"
#include "driveline/wire/dl.hpp"
#include "driveline/wire/fmmu.hpp"
#include "driveline/wire/frame.hpp"
#include "driveline/wire/mailbox.hpp"
#include "driveline/wire/registers.hpp"
#include "driveline/wire/sync_manager.hpp"
#include "pcapng_reader.hpp"
#include "support/must.hpp"
#include "tshark.hpp"

/// Whole captures of real masters and a real drive: the decoder under test compared with Wireshark's, and the builder
/// with the masters that sent the frames.
namespace driveline::wire {
namespace {

using replay::CapturedPacket;
using replay::DissectedPacket;
using replay::FieldValues;
using replay::to_number;

struct Capture {
  const char* file;
  std::size_t packets;  ///< as counted by capinfos
};

std::ostream& operator<<(std::ostream& out, const Capture& capture) {
  return out << capture.file;
}

class CaptureTest : public ::testing::TestWithParam<Capture> {
 protected:
  void SetUp() override {
    const auto found = replay::find_capture(GetParam().file);
    if (!found) GTEST_SKIP() << replay::missing_capture_text(GetParam().file);
    file_ = *found;
    auto read = must(replay::read_pcapng(file_));
    packets_ = std::move(*read);
    ASSERT_EQ(packets_.size(), GetParam().packets);
  }

  [[nodiscard]] const std::vector<CapturedPacket>& packets() const { return packets_; }

  /// The fields that tshark reports for the packets that match the filter.
  [[nodiscard]] std::vector<DissectedPacket> dissected(const std::string& filter,
                                                       const std::vector<std::string>& fields) const {
    auto result = replay::dissect(file_, filter, fields);
    EXPECT_TRUE(result) << result.error();
    return result ? std::move(*result) : std::vector<DissectedPacket>{};
  }

 private:
  std::filesystem::path file_;
  std::vector<CapturedPacket> packets_;
};

INSTANTIATE_TEST_SUITE_P(Captures, CaptureTest,
                         ::testing::Values(Capture{"soem-sdinfo-akd.pcapng", 6759},
                                           Capture{"twincat-akd-nc-mode.pcapng", 18793}),
                         [](const auto& capture) { return std::string(capture.param.file).substr(0, 4); });

std::vector<DatagramView> datagrams_of(std::span<const std::byte> frame) {
  std::vector<DatagramView> list;
  auto cursor = DatagramCursor::open(frame);
  EXPECT_TRUE(cursor) << to_text(cursor.error());
  while (cursor && !cursor->done()) {
    const auto datagram = cursor->next();
    EXPECT_TRUE(datagram) << to_text(datagram.error());
    if (!datagram) break;
    list.push_back(*datagram);
  }
  return list;
}

/// The decoder's result for a frame in the form of tshark's fields.
DissectedPacket as_fields(const CapturedPacket& packet) {
  DissectedPacket fields(11);
  fields[0] = {std::to_string(packet.number)};
  const auto put = [&fields](std::size_t field, std::uint64_t value) {
    fields[field].push_back(std::to_string(value));
  };
  for (const auto& datagram : datagrams_of(packet.bytes)) {
    const DatagramHeader& header = datagram.header;
    put(1, static_cast<std::uint64_t>(header.command));
    put(2, header.index);
    if (is_logical(header.command)) {
      put(3, header.address.raw);
    } else {
      put(4, header.address.adp());
      put(5, header.address.ado());
    }
    put(6, header.length);
    put(7, header.circulating ? 1 : 0);
    put(8, header.more ? 1 : 0);
    put(9, header.irq);
    put(10, datagram.working_counter());
  }
  return fields;
}

TEST_P(CaptureTest, EveryDatagramReadsAsInWireshark) {
  if (!replay::tshark_available()) GTEST_SKIP() << replay::missing_tshark_text();
  auto dissection =
      dissected("", {"frame.number", "ecat.cmd", "ecat.idx", "ecat.lad", "ecat.adp", "ecat.ado", "ecat.subframe.length",
                     "ecat.subframe.circulating", "ecat.subframe.more", "ecat.int", "ecat.cnt"});
  ASSERT_EQ(dissection.size(), packets().size());
  for (std::size_t i = 0; i < packets().size(); ++i) {
    for (FieldValues& values : dissection[i]) {
      for (std::string& value : values) value = std::to_string(to_number(value));
    }
    ASSERT_EQ(as_fields(packets()[i]), dissection[i]) << "packet " << packets()[i].number;
  }
}

TEST_P(CaptureTest, MailboxesReadAsInWireshark) {
  if (!replay::tshark_available()) GTEST_SKIP() << replay::missing_tshark_text();
  const auto dissection = dissected("ecat_mailbox", {"frame.number", "ecat_mailbox.length", "ecat_mailbox.address",
                                                     "ecat_mailbox.type", "ecat_mailbox.counter"});
  ASSERT_FALSE(dissection.empty());
  for (const auto& fields : dissection) {
    const auto number = to_number(fields[0].at(0));
    SCOPED_TRACE(number);
    const auto datagrams = datagrams_of(packets().at(number - 1).bytes);
    ASSERT_FALSE(datagrams.empty());
    const auto header = must(MailboxHeader::decode(datagrams[0].data));
    EXPECT_EQ(header->length, to_number(fields[1].at(0)));
    EXPECT_EQ(header->address, to_number(fields[2].at(0)));
    EXPECT_EQ(static_cast<unsigned>(header->type), to_number(fields[3].at(0)));
    EXPECT_EQ(header->counter, to_number(fields[4].at(0)));
  }
}

TEST_P(CaptureTest, SdosReadAsInWireshark) {
  if (!replay::tshark_available()) GTEST_SKIP() << replay::missing_tshark_text();
  const auto dissection = dissected(
      "ecat_mailbox.coe.sdoidx",
      {"frame.number", "ecat_mailbox.coe.number", "ecat_mailbox.coe.type", "ecat_mailbox.coe.sdoidx",
       "ecat_mailbox.coe.sdosub", "ecat_mailbox.coe.sdoreq", "ecat_mailbox.coe.sdores", "ecat_mailbox.coe.sdodata",
       "ecat_mailbox.coe.sdoscsiu_expedited", "ecat_mailbox.coe.sdoscsiu_sizeind"});
  const bool has_coe = std::string_view(GetParam().file).starts_with("soem");
  ASSERT_EQ(!dissection.empty(), has_coe);
  for (const auto& fields : dissection) {
    const auto number = to_number(fields[0].at(0));
    SCOPED_TRACE(number);
    const auto data = datagrams_of(packets().at(number - 1).bytes).at(0).data;
    const auto coe = CoeHeader::decode(data.subspan(MailboxHeader::kSize));
    const auto sdo = SdoHeader::decode(data.subspan(MailboxHeader::kSize + CoeHeader::kSize));
    ASSERT_TRUE(coe && sdo);
    EXPECT_EQ(coe->number, to_number(fields[1].at(0)));
    EXPECT_EQ(static_cast<unsigned>(coe->service), to_number(fields[2].at(0)));
    EXPECT_EQ(sdo->index, to_number(fields[3].at(0)));
    EXPECT_EQ(sdo->subindex, to_number(fields[4].at(0)));
    const bool request = coe->service == CoeService::kSdoRequest;
    EXPECT_EQ(sdo->specifier(), to_number(fields[request ? 5 : 6].at(0)));
    if (!fields[7].empty()) {
      EXPECT_EQ(sdo->data_u32(), to_number(fields[7][0]));
    }
    if (!fields[8].empty()) {
      EXPECT_EQ(sdo->expedited(), to_number(fields[8][0]) != 0);
      EXPECT_EQ(sdo->size_indicated(), to_number(fields[9].at(0)) != 0);
    }
  }
}

/// First datagram of the packet that accesses the register.
std::optional<DatagramView> datagram_at(const CapturedPacket& packet, std::uint16_t address) {
  const auto datagrams = datagrams_of(packet.bytes);
  const auto found = std::find_if(datagrams.begin(), datagrams.end(), [&](const DatagramView& datagram) {
    return !is_logical(datagram.header.command) && datagram.header.address.ado() == address;
  });
  if (found == datagrams.end()) return std::nullopt;
  return *found;
}

TEST_P(CaptureTest, AlStatusReadsAsInWireshark) {
  if (!replay::tshark_available()) GTEST_SKIP() << replay::missing_tshark_text();
  const auto dissection = dissected("ecat.reg.alstatus", {"frame.number", "ecat.reg.alstatus.status",
                                                          "ecat.reg.alstatus.err", "ecat.reg.alstatus.id"});
  ASSERT_GT(dissection.size(), 100U);
  for (const auto& fields : dissection) {
    const auto number = to_number(fields[0].at(0));
    SCOPED_TRACE(number);
    const auto datagram = must(datagram_at(packets().at(number - 1), reg::kAlStatus.address));
    const auto status = AlStatus::from_raw(bytes::load_le<std::uint16_t>(datagram->data));
    EXPECT_EQ(static_cast<unsigned>(status.state), to_number(fields[1].at(0)));
    EXPECT_EQ(status.error, to_number(fields[2].at(0)) != 0);
    EXPECT_EQ(status.id_loaded, to_number(fields[3].at(0)) != 0);
  }
}

TEST_P(CaptureTest, SyncManagersAndFmmusReadAsInWireshark) {
  if (!replay::tshark_available()) GTEST_SKIP() << replay::missing_tshark_text();
  const auto dissection = dissected(
      "ecat.cmd == 5 && (ecat.syncman || ecat.fmmu)",
      {"frame.number", "ecat.ado", "ecat.syncman.start", "ecat.syncman.len", "ecat.syncman.opmode",
       "ecat.syncman.access", "ecat.syncman.irq.pdi", "ecat.syncman.wdt", "ecat.syncman.enable", "ecat.fmmu.lstart",
       "ecat.fmmu.llen", "ecat.fmmu.lendbit", "ecat.fmmu.pstart", "ecat.fmmu.type", "ecat.fmmu.activate0"});
  ASSERT_FALSE(dissection.empty());
  int sync_managers = 0;
  int fmmus = 0;
  for (const auto& fields : dissection) {
    SCOPED_TRACE(fields[0].at(0));
    const auto value = [&fields](std::size_t field, std::size_t n) { return to_number(fields[field].at(n)); };
    auto data = datagrams_of(packets().at(value(0, 0) - 1).bytes).at(0).data;
    for (std::size_t n = 0; n < fields[2].size(); ++n, ++sync_managers) {
      const auto channel = SyncManagerChannel::decode(data.subspan(n * SyncManagerChannel::kSize)).value();
      const auto control = SyncManagerControl::from_raw(channel.control);
      EXPECT_EQ(channel.start_address, value(2, n));
      EXPECT_EQ(channel.length, value(3, n));
      EXPECT_EQ(static_cast<unsigned>(control.mode), value(4, n));
      EXPECT_EQ(static_cast<unsigned>(control.direction), value(5, n));
      EXPECT_EQ(control.interrupt_pdi, value(6, n) != 0);
      EXPECT_EQ(control.watchdog_trigger, value(7, n) != 0);
      EXPECT_EQ((channel.activate & SyncManagerActivate::kEnable) != 0, value(8, n) != 0);
    }
    for (std::size_t n = 0; n < fields[9].size(); ++n, ++fmmus) {
      const auto fmmu = FmmuEntity::decode(data.subspan(n * FmmuEntity::kSize)).value();
      EXPECT_EQ(fmmu.logical_start, value(9, n));
      EXPECT_EQ(fmmu.length, value(10, n));
      EXPECT_EQ(fmmu.logical_stop_bit, value(11, n));
      EXPECT_EQ(fmmu.physical_start, value(12, n));
      EXPECT_EQ(fmmu.type, value(13, n));
      EXPECT_EQ(fmmu.active, value(14, n) != 0);
    }
  }
  EXPECT_GT(sync_managers, 3);
  EXPECT_GT(fmmus, 0);
}

TEST_P(CaptureTest, BuilderMakesTheSameFrames) {
  std::array<std::byte, 1514> buffer{};
  for (const auto& packet : packets()) {
    const auto ethernet = EthernetHeader::decode(packet.bytes).value();
    FrameBuilder builder(buffer, ethernet.source, ethernet.destination);
    std::vector<DatagramPlace> places;
    const auto datagrams = datagrams_of(packet.bytes);
    for (const auto& datagram : datagrams) {
      ASSERT_FALSE(datagram.header.circulating) << packet.number;
      const auto place =
          builder.add(datagram.header.command, datagram.header.index, datagram.header.address, datagram.data.size());
      ASSERT_TRUE(place) << packet.number;
      std::copy(datagram.data.begin(), datagram.data.end(), builder.data(*place).begin());
      places.push_back(*place);
    }
    const auto frame = builder.finish();
    for (std::size_t i = 0; i < places.size(); ++i) {
      // The working counters added by the slaves.
      bytes::store_le(frame.subspan(places[i].working_counter()), datagrams[i].working_counter());
      bytes::store_le(frame.subspan(places[i].header + 8), datagrams[i].header.irq);
    }
    // In some frames TwinCAT counts a padding byte as part of the datagrams; the first of them was sent with 0x0E
    // instead of 13.
    const auto sent = EtherCatHeader::decode(std::span(packet.bytes).subspan(EthernetHeader::kSize)).value();
    const std::size_t own_length = places.back().working_counter() + 2 - kDatagramsOffset;
    ASSERT_LE(sent.length - own_length, 1U) << packet.number;
    sent.encode(frame.subspan<EthernetHeader::kSize, EtherCatHeader::kSize>());
    // Outgoing frames were captured before the network card padded them.
    const std::size_t size = std::min(packet.bytes.size(), frame.size());
    ASSERT_TRUE(std::equal(frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(size), packet.bytes.begin()))
        << packet.number;
    ASSERT_GE(packet.bytes.size(), places.back().working_counter() + 2) << packet.number;
  }
}

TEST_P(CaptureTest, EveryTruncationOfEveryKindOfFrameIsRejected) {
  std::size_t tried = 0;
  for (std::size_t i = 0; i < packets().size(); i += 37) {
    const auto& bytes = packets()[i].bytes;
    const auto datagrams = datagrams_of(bytes);
    const std::size_t end = datagrams.back().place.working_counter() + 2;
    for (std::size_t size = 0; size < end; ++size, ++tried) {
      ASSERT_FALSE(DatagramCursor::open(std::span(bytes).first(size))) << packets()[i].number << " at " << size;
    }
  }
  EXPECT_GT(tried, 1000U);
}

}  // namespace
}  // namespace driveline::wire
