// SDO transfers that take several mailbox messages, and complete access, between the master and an emulated device
// whose mailbox holds 64 bytes.
#include <gmock/gmock.h>

#include "driveline/slaves/generic/generic_device.hpp"
#include "edited_line.hpp"
#include "fault_ports.hpp"

namespace driveline::bus_test {
namespace {

using ecat_master::CoeClient;
namespace facts = ecat_master::facts;
using ecat_master::Master;
using slaves::generic::DeviceModel;
using slaves::generic::GenericDevice;
using Bytes = std::vector<std::byte>;

constexpr std::size_t kTextBytes = 300;
constexpr std::uint16_t kText = 0x2000;
constexpr std::uint16_t kTexts = 0x3000;  ///< index of the first text; the length is added
constexpr std::uint16_t kRecord = 0x2010;
constexpr std::uint16_t kMailboxOut = 0x1000;  ///< for the master's requests
constexpr std::uint16_t kMailboxIn = 0x1080;
constexpr std::size_t kMailboxBytes = 64;

std::uint32_t abort_code(const ecat_master::Error& error) {
  return static_cast<std::uint32_t>(std::get<facts::SdoAbort>(error.facts).code);
}

/// Lengths around the capacities of the first message (48 bytes) and of each segment (55).
bool borders(std::size_t length) {
  return length < 10 || (length > 40 && length < 60) || (length > 48 && (length - 48) % 55 < 3) ||
         (length > 48 && (length - 48) % 55 > 46);
}

/// A text of 300 bytes, texts of all critical lengths, a record with a text in it, and an entry of process data in each
/// direction.
esi::DeviceDescription device_with(bool complete_access) {
  using esi::DataType;
  using Use = esi::SyncManager::Use;
  esi::DeviceDescription device;
  device.vendor_id = 0xE0000DD1;
  device.product_code = complete_access ? 0x51 : 0x52;
  device.revision = 1;
  device.name = "segments";
  device.mailbox.coe = true;
  device.mailbox.coe_complete_access = complete_access;
  device.fmmus = {esi::FmmuUse::kOutputs, esi::FmmuUse::kInputs};
  device.sync_managers = {{Use::kMailboxOut, kMailboxOut, kMailboxBytes, 0, 0, 0x26, true},
                          {Use::kMailboxIn, kMailboxIn, kMailboxBytes, 0, 0, 0x22, true},
                          {Use::kOutputs, 0x1100, 2, 0, 0, 0x64, true},
                          {Use::kInputs, 0x1180, 2, 0, 0, 0x20, true}};
  device.rx_pdos = {{0x1600, "Out", true, true, std::uint8_t{2}, {{0x7000, 1, 16, "Set", DataType::kUnsigned16}}}};
  device.tx_pdos = {{0x1A00, "In", true, true, std::uint8_t{3}, {{0x6000, 1, 16, "Actual", DataType::kUnsigned16}}}};
  const auto entry = [](std::uint8_t subindex, DataType type, std::size_t bytes, bool writable, std::string value) {
    esi::ObjectEntry made;
    made.subindex = subindex;
    made.name = "entry";
    made.type = type;
    made.bit_length = static_cast<std::uint16_t>(8 * bytes);
    made.writable = writable;
    made.default_hex = std::move(value);
    return made;
  };
  device.objects = {
      {kText, "Text", esi::ObjectCode::kVariable, {entry(0, DataType::kVisibleString, kTextBytes, true, "41")}},
      {kRecord,
       "Record",
       esi::ObjectCode::kRecord,
       {entry(0, DataType::kUnsigned8, 1, false, "03"), entry(1, DataType::kUnsigned16, 2, true, "1122"),
        entry(2, DataType::kUnsigned32, 4, true, "33445566"), entry(3, DataType::kVisibleString, 100, true, "42")}},
      {0x2020,
       "Short",
       esi::ObjectCode::kRecord,
       {entry(0, DataType::kUnsigned8, 1, false, "01"), entry(1, DataType::kUnsigned16, 2, true, "7788")}},
      {0x2030,
       "Fixed",
       esi::ObjectCode::kRecord,
       {entry(0, DataType::kUnsigned8, 1, false, "01"), entry(1, DataType::kUnsigned16, 2, false, "99AA")}}};
  for (std::uint16_t length = 1; length <= kTextBytes; ++length) {
    if (!borders(length)) continue;
    device.objects.push_back({static_cast<std::uint16_t>(kTexts + length),
                              "Text of its own length",
                              esi::ObjectCode::kVariable,
                              {entry(0, DataType::kVisibleString, length, true, "41")}});
  }
  return device;
}

Bytes text_of(std::size_t length) {
  Bytes text(length);
  for (std::size_t i = 0; i < length; ++i) text[i] = static_cast<std::byte>('A' + i % 57);
  return text;
}

/// The answer of the device: its whole length, with zeros after the text.
Bytes padded(std::size_t length) {
  auto text = text_of(length);
  text.resize(kTextBytes);
  return text;
}

Bytes bytes_of(std::initializer_list<unsigned> values) {
  Bytes bytes;
  for (const auto value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

Bytes mail(std::uint8_t type, std::initializer_list<unsigned> service) {
  auto bytes = bytes_of({static_cast<unsigned>(service.size()), 0, 0, 0, 0, type});
  for (const auto byte : service) bytes.push_back(static_cast<std::byte>(byte));
  return bytes;
}

class CoeOfASmallMailbox : public testing::Test {
 protected:
  CoeOfASmallMailbox() {
    std::vector<std::unique_ptr<slaves::Slave>> made;
    for (const bool complete : {true, false}) {
      auto model = DeviceModel::create(device_with(complete));
      if (!model) throw std::runtime_error(describe(model.error()));
      auto inner = std::make_unique<GenericDevice>(*model, slaves::generic::GenericOptions{});
      inners.push_back(inner.get());
      auto profile = inner->profile();
      auto device = std::make_unique<EditedDevice>(std::move(inner), std::move(profile));
      devices.push_back(device.get());
      made.push_back(std::make_unique<slaves::Slave>(std::move(device)));
    }
    line = std::make_unique<slaves::SimulatedLine>(clock, std::move(made));
  }
  void start(port::Port& port) {
    master = std::make_unique<Master>(port, clock);
    ASSERT_EQ(sentence(master->scan()), "");
    ASSERT_EQ(sentence(master->enter_pre_op()), "");
  }
  void start() { start(*line); }
  CoeClient coe(std::uint16_t slave = 0) { return CoeClient(master->mailboxes(), slave); }

  /// The text as stored in the device, without a read by the master.
  Bytes inside() {
    Bytes text(kTextBytes);
    const auto length = inners[0]->dictionary().upload(kText, 0, slaves::AccessPhase::kConfiguring, text);
    text.resize(length.value_or(0));
    return text;
  }
  /// Changes answer number `number` (1: the first) of the first device.
  void change_answer(int number, const std::function<std::size_t(std::span<std::byte>, std::size_t)>& change) {
    answers = 0;
    devices[0]->changes_answer = [this, number, change](std::span<std::byte> out, std::size_t length) {
      return ++answers == number ? change(out, length) : length;
    };
  }
  void expect_it_still_works() {
    devices[0]->changes_answer = {};
    ASSERT_EQ(sentence(coe().download(kText, 0, text_of(250))), "");
    EXPECT_EQ(coe().upload(kText, 0).value_or(Bytes{}), padded(250));
    EXPECT_EQ(inside(), padded(250));
  }

  rt::VirtualClock clock{milliseconds{1}};
  std::vector<EditedDevice*> devices;
  std::vector<GenericDevice*> inners;
  std::unique_ptr<slaves::SimulatedLine> line;
  std::unique_ptr<Master> master;
  int answers = 0;
};

TEST_F(CoeOfASmallMailbox, CarriesObjectsOfEveryLengthBothWays) {
  start();
  std::size_t lengths = 0;
  for (std::size_t length = 1; length <= kTextBytes; ++length) {
    if (!borders(length)) continue;
    ++lengths;
    const auto index = static_cast<std::uint16_t>(kTexts + length);
    ASSERT_EQ(sentence(coe().download(index, 0, text_of(length))), "") << length;
    Bytes stored(kTextBytes);
    stored.resize(inners[0]->dictionary().upload(index, 0, slaves::AccessPhase::kConfiguring, stored).value_or(0));
    ASSERT_TRUE(stored == text_of(length)) << length;
    const auto back = coe().upload(index, 0);
    ASSERT_EQ(sentence(back), "") << length;
    ASSERT_TRUE(*back == text_of(length)) << length;
  }
  EXPECT_GT(lengths, 50U);
}

TEST_F(CoeOfASmallMailbox, LongOnesTakeSegments) {
  start();
  change_answer(0, {});
  ASSERT_EQ(sentence(coe().download(kText, 0, text_of(kTextBytes))), "");
  // 48 bytes with the initiate request (64 - 6 mailbox, 2 CoE, 8 SDO header), 55 with each segment.
  EXPECT_EQ(answers, 1 + 5);
  answers = 0;
  EXPECT_EQ(coe().upload(kText, 0).value_or(Bytes{}), padded(kTextBytes));
  EXPECT_EQ(answers, 1 + 5);
}

TEST_F(CoeOfASmallMailbox, OneByteTooManyIsAborted) {
  start();
  ASSERT_EQ(sentence(coe().download(kText, 0, text_of(40))), "");
  const auto done = coe().download(kText, 0, text_of(kTextBytes + 1));
  ASSERT_FALSE(done);
  EXPECT_TRUE(done.error().is<facts::SdoAbort>());
  EXPECT_EQ(abort_code(done.error()), 0x06070012U);
  EXPECT_EQ(inside(), padded(40));
  expect_it_still_works();
}

TEST_F(CoeOfASmallMailbox, AnAbortAmidSegmentsEndsTheTransferAndTheNextOneWorks) {
  start();
  ASSERT_EQ(sentence(coe().download(kText, 0, text_of(200))), "");
  const auto abort = [](std::span<std::byte> out, std::size_t) {
    // SDO response, abort of 2000h:00 with 08000021h (ETG.1000.6 Table 41); the header's counter stays.
    const auto service = bytes_of({0x00, 0x30, 0x80, 0x00, 0x20, 0x00, 0x21, 0x00, 0x00, 0x08});
    out[0] = static_cast<std::byte>(service.size());
    std::copy(service.begin(), service.end(), out.begin() + 6);
    return 6 + service.size();
  };
  change_answer(3, abort);
  const auto up = coe().upload(kText, 0);
  ASSERT_FALSE(up);
  EXPECT_TRUE(up.error().is<facts::SdoAbort>());
  EXPECT_EQ(abort_code(up.error()), 0x08000021U);
  EXPECT_THAT(sentence(up), testing::StartsWith("slave 0: object 2000h:00 aborted with 0x08000021 ("));
  expect_it_still_works();
  change_answer(3, abort);
  const auto down = coe().download(kText, 0, text_of(280));
  ASSERT_FALSE(down);
  EXPECT_EQ(abort_code(down.error()), 0x08000021U);
  EXPECT_EQ(inside(), padded(250)) << "nothing was stored";
  expect_it_still_works();
}

TEST_F(CoeOfASmallMailbox, AToggleThatDoesNotAlternateEndsTheTransferForBoth) {
  start();
  ASSERT_EQ(sentence(coe().download(kText, 0, text_of(200))), "");
  for (const int number : {2, 3}) {
    const auto flip = [](std::span<std::byte> out, std::size_t length) {
      out[8] ^= std::byte{0x10};
      return length;
    };
    change_answer(number, flip);
    const auto up = coe().upload(kText, 0);
    ASSERT_FALSE(up) << number;
    EXPECT_EQ(sentence(up), "slave 0: sent a malformed mailbox for object 2000h:00") << number;
    expect_it_still_works();
    change_answer(number, flip);
    const auto down = coe().download(kText, 0, text_of(280));
    ASSERT_FALSE(down) << number;
    EXPECT_EQ(sentence(down), "slave 0: sent a malformed mailbox for object 2000h:00") << number;
    EXPECT_EQ(inside(), padded(250)) << "the device was told, and stored nothing";
    expect_it_still_works();
  }
}

/// The toggle bit of a request is changed on its way: the device aborts with 05030000h.
TEST_F(CoeOfASmallMailbox, ADeviceThatSeesTheSameToggleTwiceAborts) {
  int segments = -1;
  ChangingPort port(*line,
                    [&](std::span<std::byte> frame) {
                      auto cursor = wire::MutableDatagramCursor::open(frame);
                      while (segments >= 0 && cursor && !cursor->done()) {
                        auto datagram = cursor->next();
                        if (!datagram) return;
                        const bool request = datagram->header.command == wire::Command::kFpwr &&
                                             datagram->header.address.ado() == kMailboxOut &&
                                             datagram->data.size() == kMailboxBytes;
                        // Upload segment request: command specifier 3.
                        if (!request || (datagram->data[8] & std::byte{0xE0}) != std::byte{0x60}) continue;
                        if (++segments == 2) datagram->data[8] ^= std::byte{0x10};
                      }
                    },
                    {});
  start(port);
  ASSERT_EQ(sentence(coe().download(kText, 0, text_of(200))), "");
  segments = 0;
  const auto up = coe().upload(kText, 0);
  ASSERT_FALSE(up);
  EXPECT_TRUE(up.error().is<facts::SdoAbort>());
  EXPECT_EQ(abort_code(up.error()), 0x05030000U);
  segments = -1;
  expect_it_still_works();
}

TEST_F(CoeOfASmallMailbox, WhatComesAmidSegmentsGoesWhereItBelongs) {
  start();
  const auto emergency = mail(3, {0x00, 0x10, 0x20, 0x32, 5, 1, 2, 3, 4, 5});
  const auto eoe_fragment = mail(2, {0x00, 0x00, 0x00, 0x00, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF});
  for (const int amid : {1, 2, 4}) {
    for (const bool upload : {true, false}) {
      ASSERT_EQ(sentence(coe().download(kText, 0, text_of(260))), "");
      const auto unclaimed = master->mailboxes().statistics(0).unclaimed;
      answers = 0;
      devices[0]->changes_answer = [&](std::span<std::byte>, std::size_t length) {
        if (++answers == amid) devices[0]->says_first = {emergency, eoe_fragment, emergency};
        return length;
      };
      if (upload) {
        EXPECT_EQ(coe().upload(kText, 0).value_or(Bytes{}), padded(260)) << amid;
      } else {
        EXPECT_EQ(sentence(coe().download(kText, 0, text_of(299))), "") << amid;
        EXPECT_EQ(inside(), padded(299)) << amid;
      }
      EXPECT_GT(answers, amid) << "it was amid the transfer";
      EXPECT_TRUE(devices[0]->says_first.empty()) << "all of it has been read";
      devices[0]->changes_answer = {};
      const auto emergencies = master->emergencies().take(0);
      ASSERT_EQ(emergencies.size(), 2U) << amid;
      EXPECT_EQ(master->mailboxes().statistics(0).unclaimed, unclaimed + 3) << "the transfer took none of them";
    }
  }
}

TEST_F(CoeOfASmallMailbox, LostFramesAmidSegmentsCostNothingButTime) {
  for (const auto way : {LossyPort::Direction::kOut, LossyPort::Direction::kBack}) {
    for (const std::uint16_t address : {kMailboxOut, kMailboxIn}) {
      int seen = -1;
      LossyPort port(*line, way, [&](std::uint64_t, std::span<const std::byte> frame) {
        const auto first = first_datagram(frame);
        const bool mailbox =
            first.ado == address && (first.command == wire::Command::kFprd || first.command == wire::Command::kFpwr);
        // Every third one, including the initiate request.
        return seen >= 0 && mailbox && ++seen % 3 == 0;
      });
      start(port);
      seen = 1;
      ASSERT_EQ(sentence(coe().download(kText, 0, text_of(290))), "") << address;
      EXPECT_EQ(inside(), padded(290));
      EXPECT_EQ(coe().upload(kText, 0).value_or(Bytes{}), padded(290)) << address;
      EXPECT_GE(port.lost(), 3U) << address;
      master.reset();
    }
  }
}

TEST_F(CoeOfASmallMailbox, SegmentsTravelBesideTheProcessData) {
  master = std::make_unique<Master>(*line, clock);
  ASSERT_EQ(sentence(master->scan()), "");
  ASSERT_EQ(sentence(master->configure({})), "");
  ecat_master::CyclicCore::Settings settings;
  settings.acyclic_bytes = 120;
  const auto started = master->start_cycle(nullptr, {}, settings, [this](ecat_master::CyclicCore& core) {
    return std::make_unique<motion::InlineRunner>(core, clock);
  });
  ASSERT_TRUE(started.has_value());
  ASSERT_EQ(sentence(master->go_operational()), "");
  master->core()->count(false);
  master->pass(milliseconds{1});
  master->core()->count(true);
  const auto cycles = master->core()->cycles();
  expect_it_still_works();
  auto other = coe(1).start_upload({kText, 0, false});
  auto first = coe(0).start_upload({kText, 0, false});
  EXPECT_EQ(first.get().value_or(Bytes{}), padded(250));
  EXPECT_EQ(sentence(other.get()), "");
  EXPECT_GT(master->core()->cycles(), cycles + 10);
  EXPECT_EQ(master->core()->statistics().lost_frames, 0U);
  EXPECT_EQ(master->core()->statistics().wkc_errors, 0U);
}

TEST_F(CoeOfASmallMailbox, WholeObjectsAreReadFromSubIndex0And1) {
  start();
  // ETG.1000.6 5.6.2: sub-index 0 takes 16 bits, the others follow.
  auto expected = bytes_of({3, 0, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66});
  expected.push_back(std::byte{'B'});
  expected.resize(8 + 100);
  EXPECT_EQ(coe().upload(kRecord, 0, true).value_or(Bytes{}), expected) << "in segments";
  expected.erase(expected.begin(), expected.begin() + 2);
  EXPECT_EQ(coe().upload(kRecord, 1, true).value_or(Bytes{}), expected);
  EXPECT_EQ(coe().upload(0x2020, 0, true).value_or(Bytes{}), bytes_of({1, 0, 0x77, 0x88})) << "expedited";
  EXPECT_EQ(coe().upload(0x2020, 1, true).value_or(Bytes{}), bytes_of({0x77, 0x88}));
}

TEST_F(CoeOfASmallMailbox, WholeObjectsAreWrittenFromSubIndex0And1) {
  start();
  auto data = bytes_of({3, 0, 0xA1, 0xA2, 0xB1, 0xB2, 0xB3, 0xB4});
  const auto text = text_of(100);
  data.insert(data.end(), text.begin(), text.end());
  ASSERT_EQ(sentence(coe().download(kRecord, 0, data, true)), "");
  EXPECT_EQ(coe().upload_as<std::uint16_t>(kRecord, 1).value_or(0), 0xA2A1);
  EXPECT_EQ(coe().upload_as<std::uint32_t>(kRecord, 2).value_or(0), 0xB4B3B2B1);
  EXPECT_EQ(coe().upload(kRecord, 3).value_or(Bytes{}), text);
  EXPECT_EQ(coe().upload(kRecord, 0, true).value_or(Bytes{}), data);
  data[2] = std::byte{0xC1};
  data.erase(data.begin(), data.begin() + 2);
  ASSERT_EQ(sentence(coe().download(kRecord, 1, data, true)), "");
  EXPECT_EQ(coe().upload_as<std::uint16_t>(kRecord, 1).value_or(0), 0xA2C1);
  ASSERT_EQ(sentence(coe().download(0x2020, 1, bytes_of({0x12, 0x34}), true)), "");
  EXPECT_EQ(coe().upload_as<std::uint16_t>(0x2020, 1).value_or(0), 0x3412);
}

TEST_F(CoeOfASmallMailbox, WholeObjectsThatCannotBeHadAreAbortedWithTheReason) {
  start();
  const auto code = [](const auto& result) {
    EXPECT_FALSE(result);
    return result ? 0U : abort_code(result.error());
  };
  EXPECT_EQ(code(coe().upload(kText, 0, true)), 0x06010000U) << "a variable";
  EXPECT_EQ(code(coe().upload(kRecord, 2, true)), 0x06010000U) << "neither 0 nor 1";
  EXPECT_EQ(code(coe().upload(0x2999, 0, true)), 0x06020000U) << "not there";
  EXPECT_EQ(code(coe().download(kRecord, 0, Bytes(200), true)), 0x06070012U) << "too long";
  EXPECT_EQ(code(coe().download(0x2030, 1, Bytes(2), true)), 0x06010002U) << "read only";
  EXPECT_EQ(code(coe(1).upload(kRecord, 0, true)), 0x06010004U) << "a device without complete access";
  EXPECT_EQ(code(coe(1).download(kRecord, 0, Bytes(108), true)), 0x06010004U);
  EXPECT_EQ(coe().upload_as<std::uint16_t>(kRecord, 1).value_or(0), 0x2211) << "nothing was stored";
  EXPECT_EQ(coe(1).upload_as<std::uint16_t>(kRecord, 1).value_or(0), 0x2211);
}

}  // namespace
}  // namespace driveline::bus_test
