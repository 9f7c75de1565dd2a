// Operation data on the line in Wireshark's dissector: each service with its bytes and their meaning.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>
#include <string_view>
#include <vector>

#include "drive_line.hpp"
#include "driveline/ecat_master/coe/coe_client.hpp"
#include "driveline/ecat_master/master.hpp"
#include "driveline/ecat_master/soe/soe_client.hpp"
#include "soe_line.hpp"
#include "traffic.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::SoeClient;
using ecat_master::facts::SoeDatum;
using wire::SoeElement;
using Bytes = std::vector<std::byte>;

/// Address of the answers of soe_device().
constexpr std::uint16_t kSoeReplies = 0x1400;
/// Mailboxes with room for 26 bytes after the header of SoE.
constexpr std::uint16_t kShortMailbox = 36;
constexpr SoeDatum kCycleTime{0, {1}};

std::string hex_text(std::span<const std::byte> bytes) {
  std::string text;
  for (const auto byte : bytes) text += fmt::format("{}{:02x}", text.empty() ? "" : " ", std::to_integer<int>(byte));
  return text;
}

/// Stores the frames that carry an SoE message to a slave or from it, as returned by the line, and the services in
/// them.
class SoeMails final : public PassingPort {
 public:
  explicit SoeMails(port::Port& inner) : PassingPort(inner) {}
  std::optional<port::ReceivedFrame> receive() noexcept override {
    const auto frame = PassingPort::receive();
    if (frame) keep(frame->bytes);
    return frame;
  }

  std::vector<Bytes> frames;
  std::vector<std::string> services;  ///< service of each frame, in hexadecimal

 private:
  void keep(std::span<const std::byte> frame) {
    std::string found;
    auto cursor = wire::DatagramCursor::open(frame);
    while (cursor && !cursor->done()) {
      const auto datagram = cursor->next();
      if (!datagram) return;
      const auto ado = datagram->header.address.ado();
      const bool mail = (datagram->header.command == wire::Command::kFpwr && ado == kRequests) ||
                        (datagram->header.command == wire::Command::kFprd && ado == kSoeReplies);
      if (!mail || datagram->working_counter() != 1) continue;
      const auto header = wire::MailboxHeader::decode(datagram->data);
      if (!header || header->length == 0 || header->type != wire::MailboxType::kSoe) continue;
      if (!found.empty()) found += " and ";
      found += hex_text(datagram->data.subspan(wire::MailboxHeader::kSize, header->length));
    }
    if (found.empty()) return;
    frames.emplace_back(frame.begin(), frame.end());
    services.push_back(std::move(found));
  }
};

/// An SoE message according to ETG.1000.6 5.9 and IEC 61800-7-204, written by hand, and its dissection: elements are D
/// data state, N name, A attribute, U unit, I minimum, X maximum and V value; the default, bit 7, is dissected as
/// reserved.
struct KnownMail {
  std::string_view service;
  std::string_view read_as;
  unsigned drive = 0;
};

/// Every service of SoE, in the order of say_everything().
const std::vector<KnownMail> kEveryMail = {
    {"01 01 63 00", "RRQ (S-0-0099, 'D')"},
    {"02 01 63 00 00 00", "RRS (S-0-0099, 'D') : 2 Bytes"},
    {"01 02 01 00", "RRQ (S-0-0001, 'N')"},
    {"02 02 01 00 15 00 15 00 4e 43 20 63 79 63 "
     "6c 65 20 74 69 6d 65 20 28 54 4e 63 79 63 29",
     "RRS (S-0-0001, 'N') : 25 Bytes"},
    {"01 04 01 00", "RRQ (S-0-0001, 'A')"},
    {"02 04 01 00 01 00 11 60", "RRS (S-0-0001, 'A') : 4 Bytes"},
    {"01 08 01 00", "RRQ (S-0-0001, 'U')"},
    {"02 08 01 00 02 00 02 00 75 73", "RRS (S-0-0001, 'U') : 6 Bytes"},
    {"01 10 01 00", "RRQ (S-0-0001, 'I')"},
    {"02 10 01 00 7d 00", "RRS (S-0-0001, 'I') : 2 Bytes"},
    {"01 20 01 00", "RRQ (S-0-0001, 'X')"},
    {"02 20 01 00 00 fa", "RRS (S-0-0001, 'X') : 2 Bytes"},
    {"01 40 01 00", "RRQ (S-0-0001, 'V')"},
    {"02 40 01 00 e8 03", "RRS (S-0-0001, 'V') : 2 Bytes"},
    {"01 80 01 00", "RRQ (S-0-0001, '')"},
    {"02 80 01 00 e8 03", "RRS (S-0-0001, '') : 2 Bytes"},
    {"21 fe 01 00", "RRQ (S-0-0001, 'NAUIXV')", 1},
    {"2a fe 01 00 15 00 15 00 4e 43 20 63 79 63 "
     "6c 65 20 74 69 6d 65 20 28 54 4e 63 79 63 29 01",
     "FragmentsLeft 1", 1},
    {"22 fe 01 00 00 11 60 02 00 02 00 75 73 7d 00 00 fa e8 03 e8 03", "RRS (S-0-0001, 'NAUIXV') : 17 Bytes", 1},
    {"01 40 11 00", "RRQ (S-0-0017, 'V')"},
    {"02 40 11 00 14 00 14 00 01 00 0b 00 0e 00 "
     "11 00 28 00 33 00 5f 00 63 00 64 00 8e 00",
     "RRS (S-0-0017, 'V') : 24 Bytes"},
    {"23 40 64 00 2c 01", "WRQ (S-0-0100, 'V') : 2 Bytes", 1},
    {"24 40 64 00", "WRS (S-0-0100, 'V')", 1},
    {"0b 40 02 00 3c 00 3c 00 78 78 78 78 78 78 "
     "78 78 78 78 78 78 78 78 78 78 78 78 78 78 78 78",
     "FragmentsLeft 2"},
    {"0b 40 01 00 78 78 78 78 78 78 78 78 78 78 "
     "78 78 78 78 78 78 78 78 78 78 78 78 78 78 78 78",
     "FragmentsLeft 1"},
    {"03 40 8e 00 78 78 78 78 78 78 78 78 78 78 78 78", "WRQ (S-0-0142, 'V') : 12 Bytes"},
    {"04 40 8e 00", "WRS (S-0-0142, 'V')"},
    {"03 40 63 00 03 00", "WRQ (S-0-0099, 'V') : 2 Bytes"},
    {"04 40 63 00", "WRS (S-0-0099, 'V')"},
    {"01 01 63 00", "RRQ (S-0-0099, 'D')"},
    {"02 01 63 00 07 00", "RRS (S-0-0099, 'D') : 2 Bytes"},
    {"01 01 63 00", "RRQ (S-0-0099, 'D')"},
    {"05 01 63 00 03 00", "NFC (S-0-0099, 'D') : 2 Bytes"},
    {"02 01 63 00 03 00", "RRS (S-0-0099, 'D') : 2 Bytes"},
    {"03 40 63 00 00 00", "WRQ (S-0-0099, 'V') : 2 Bytes"},
    {"04 40 63 00", "WRS (S-0-0099, 'V')"},
    {"06 00 00 00 00 75 10 00 00 00 00 00", "EMGCY"},
    {"26 00 00 00 00 75 10 00 00 00 00 00", "EMGCY", 1},
    {"01 40 ff 8f", "RRQ (P-0-4095, 'V')"},
    {"12 40 ff 8f 01 10", "Error 1001"},
    {"e1 40 01 00", "RRQ (S-0-0001, 'V')", 7},
    {"f2 40 01 00 0a 80", "Error 800a", 7},
    {"03 40 64 00 00 00", "WRQ (S-0-0100, 'V') : 2 Bytes"},
    {"14 40 64 00 06 70", "Error 7006"},
};

Bytes text(std::size_t size) {
  return Bytes(size, std::byte{'x'});
}

void say_everything(SoeLine& line, ecat_master::Master& master) {
  SoeClient soe(master.mailboxes(), 0);
  for (const auto element : wire::kSoeElements) {
    ASSERT_EQ(sentence(soe.read(element == SoeElement::kState ? kReset : kCycleTime, element)), "");
  }
  ASSERT_EQ(sentence(soe.read({1, {1}}, wire::SoeElementSet::of(0xFE))), "") << "all in fragments";
  ASSERT_EQ(sentence(soe.read({0, {17}}, SoeElement::kValue)), "");
  ASSERT_EQ(sentence(soe.write({1, {100}}, SoeElement::kValue, Bytes{std::byte{0x2C}, std::byte{0x01}})), "");
  ASSERT_EQ(sentence(soe.write(kApplication, SoeElement::kValue, as_list(text(60)))), "") << "in fragments";
  ASSERT_EQ(sentence(soe.execute(kReset)), "");
  line.lose_process_data(0);
  line.clock.advance(milliseconds{1});
  ASSERT_EQ(sentence(master.mailbox(0)->poll()), "");
  ASSERT_FALSE(soe.read({0, {0x8FFF}}, SoeElement::kValue));
  ASSERT_FALSE(soe.read({7, {1}}, SoeElement::kValue));
  ASSERT_FALSE(soe.write(kGain, SoeElement::kValue, Bytes(2)));
}

TEST_F(BusTraffic, EveryServiceOfSoeIsReadAsItIsMeant) {
  SoeLine line(kShortMailbox);
  SoeMails mails(*line.line);
  ecat_master::Master master(mails, line.clock);
  ASSERT_EQ(sentence(master.scan()), "");
  ASSERT_EQ(sentence(master.enter_pre_op()), "");
  say_everything(line, master);
  expect_clean(mails.frames);
  const auto summaries = texts("ecat", "_ws.col.Info");
  const auto drives = texts("ecat", "ecat_mailbox.soe_header_driveno");
  ASSERT_EQ(summaries.size(), mails.frames.size());
  ASSERT_EQ(mails.services.size(), kEveryMail.size());
  for (std::size_t i = 0; i < kEveryMail.size(); ++i) {
    EXPECT_EQ(mails.services[i], kEveryMail[i].service) << i;
    EXPECT_THAT(summaries[i], testing::EndsWith(fmt::format("(SoE: {})", kEveryMail[i].read_as)));
    EXPECT_EQ(replay::to_number(drives.at(i)), kEveryMail[i].drive);
  }
}

TEST_F(BusTraffic, ASessionOfOperationData) {
  SoeLine line(kShortMailbox);
  Recorder recorder(*line.line, kSoeReplies, wire::MailboxType::kSoe);
  ecat_master::Master master(recorder, line.clock);
  ASSERT_EQ(sentence(master.scan()), "");
  ASSERT_EQ(sentence(master.enter_pre_op()), "");
  say_everything(line, master);
  // Both slaves at once, every drive, and SDOs in between.
  SoeClient first(master.mailboxes(), 0);
  SoeClient second(master.mailboxes(), 1);
  ecat_master::CoeClient coe(master.mailboxes(), 0);
  const auto list = second.start_read({1, {17}}, SoeElement::kValue);
  const auto write = second.start_write({1, {142}}, SoeElement::kValue, as_list(text(300)));
  const auto sdo = coe.start_upload({0x1018, 2}, {}, 3);
  for (std::uint8_t drive = 0; drive < 2; ++drive) {
    const auto idns = first.idn_list({drive, {17}});
    ASSERT_EQ(sentence(idns), "");
    for (const auto idn : *idns) ASSERT_EQ(sentence(first.parameter({drive, idn})), "");
  }
  master.mailboxes().wait(*write);
  EXPECT_EQ(sentence(list->result()), "");
  EXPECT_EQ(sentence(write->result()), "");
  EXPECT_EQ(sentence(sdo.get()), "");
  expect_clean(recorder.frames);
  EXPECT_EQ(occurrences("ecat.cnt == 0", "ecat_mailbox.soe_opcode"), recorder.requests);
  EXPECT_GT(recorder.requests, 150U);
  EXPECT_GT(recorder.replies, 150U);
  const auto op_codes = values("ecat.cnt == 1", "ecat_mailbox.soe_opcode");
  for (const auto* code : {"1", "2", "3", "4", "5", "6"}) EXPECT_EQ(op_codes.count(code), 1U) << code;
  EXPECT_EQ(op_codes.size(), 6U);
  EXPECT_GT(occurrences("ecat.cnt == 0", "ecat_mailbox.soe_frag"), 12U) << "of writes";
  EXPECT_EQ(occurrences("ecat_mailbox.soe.invalid", "frame.number"), 0U);
}

}  // namespace
}  // namespace driveline::bus_test
