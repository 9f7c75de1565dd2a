#pragma once

#include <gmock/gmock.h>

#include <initializer_list>
#include <ostream>
#include <vector>

#include "driveline/slaves/mailbox/coe_server.hpp"

namespace driveline::slaves {

using Bytes = std::vector<unsigned>;  // prints well in failures

/// A device with CoE and mailboxes of a given size. Requests and replies are plain numbers, independent of the encoder
/// under test.
class MailboxRig : private DictionaryOwner {
 public:
  explicit MailboxRig(std::size_t size = 512) : MailboxRig(size, table(), {}) {}
  MailboxRig(std::size_t size, const DictionaryTable& table, const CoeServer::Options& options)
      : dictionary(table), size_(size), coe_server(dictionary, *this, options) {}

  /// Writes a mailbox message of `size` bytes that starts with `start`.
  void write(Bytes start) {
    std::vector<std::byte> mailbox(size_);
    for (std::size_t i = 0; i < start.size(); ++i) mailbox.at(i) = static_cast<std::byte>(start[i]);
    server.request(mailbox);
  }
  /// The next mailbox message of the device, including the header; empty: there is none.
  Bytes read() {
    std::vector<std::byte> out(size_, std::byte{0xEE});
    const std::size_t length = server.reply(out, state);
    EXPECT_LE(length, size_);
    Bytes result;
    for (std::size_t i = 0; i < length; ++i) result.push_back(std::to_integer<unsigned>(out[i]));
    return result;
  }
  /// Sends CoE service data in a mailbox with the next counter; returns the service data of the answer.
  Bytes coe(Bytes data) {
    counter_ = counter_ % 7 + 1;
    Bytes mailbox = {static_cast<unsigned>(data.size() & 0xFF),
                     static_cast<unsigned>(data.size() >> 8),
                     0,
                     0,
                     0,
                     0x03 | counter_ << 4};
    mailbox.insert(mailbox.end(), data.begin(), data.end());
    write(mailbox);
    return service_data(read());
  }
  /// Sends an SDO request, the bytes after the CoE header. Returns the answer without its CoE header, which must be an
  /// SDO response, or an SDO request if it aborts the transfer (ETG.1000.6 5.6.2.7).
  Bytes sdo(Bytes request) {
    request.insert(request.begin(), {0x00, 0x20});
    Bytes answer = coe(request);
    if (answer.empty()) return answer;
    EXPECT_THAT(Bytes(answer.begin(), answer.begin() + 2),
                testing::ElementsAre(0x00, answer.at(2) == 0x80 ? 0x20 : 0x30));
    return {answer.begin() + 2, answer.end()};
  }
  static Bytes service_data(const Bytes& mailbox) {
    if (mailbox.empty()) return {};
    EXPECT_EQ(mailbox.size(), 6 + mailbox[0] + 256 * mailbox[1]);
    return {mailbox.begin() + 6, mailbox.end()};
  }

  wire::AlState state = wire::AlState::kPreOp;
  bool power = false;
  std::vector<unsigned> written_objects;
  ObjectDictionary dictionary;

 private:
  static const DictionaryTable& table();
  SdoResult<void> accept(const EntryRow& row, std::uint64_t raw) override {
    if (row.index == 0x8000 && row.subindex == 3 && raw == 13) return tl::unexpected(wire::SdoAbort::kLocalControl);
    if (row.index == 0x2008 && raw == 13) return tl::unexpected(wire::SdoAbort::kLocalControl);
    return {};
  }
  void written(const EntryRow& row) override { written_objects.push_back(row.index); }
  bool power_stage_on() const noexcept override { return power; }

  std::size_t size_;
  unsigned counter_ = 0;

 public:
  CoeServer coe_server;
  MailboxServer server{std::array<MailboxProtocol*, 1>{&coe_server}, size_};
};

inline const DictionaryTable& MailboxRig::table() {
  using esi::DataType;
  using esi::ObjectCode;
  constexpr std::uint16_t kRw = access::kReadWrite;
  static const std::array kRows = {
      EntryRow{.index = 0x2000,
               .type = DataType::kUnsigned8,
               .access = kRw,
               .name = "Byte",
               .initial = 0x11,
               .maximum = 0x7F},
      EntryRow{.index = 0x2001,
               .type = DataType::kUnsigned16,
               .access = kRw | access::kRxMappable,
               .name = "Word",
               .initial = 0x2211,
               .minimum = 0x10},
      EntryRow{.index = 0x2002, .access = kRw, .name = "Long", .initial = 0x44332211},
      EntryRow{.index = 0x2003,
               .type = DataType::kVisibleString,
               .access = kRw | access::kBackup,
               .name = "DV_DeviceAliasName",
               .text = "X-Axis",
               .string_length = 100},
      EntryRow{
          .index = 0x2004, .type = DataType::kVisibleString, .name = "Short text", .text = "MSD", .string_length = 3},
      EntryRow{.index = 0x2005, .type = DataType::kUnsigned8, .access = access::kWrite, .name = "Command"},
      EntryRow{.index = 0x2006, .type = DataType::kUnsigned8, .name = "Fact", .initial = 7},
      EntryRow{
          .index = 0x2007, .type = DataType::kUnsigned8, .access = access::kReadWriteConfiguring, .name = "Setting"},
      EntryRow{.index = 0x2008, .access = kRw, .name = "Locked", .power_off_only = true},
      EntryRow{.index = 0x6091,
               .code = ObjectCode::kArray,
               .type = DataType::kUnsigned8,
               .slot = slot::kConstant,
               .name = "Gear ratio",
               .initial = 2},
      EntryRow{.index = 0x6091,
               .subindex = 1,
               .code = ObjectCode::kArray,
               .access = kRw,
               .name = "Motor",
               .initial = 1,
               .minimum = 1,
               .maximum = 1000},
      EntryRow{.index = 0x6091,
               .subindex = 2,
               .code = ObjectCode::kArray,
               .access = kRw | access::kTxMappable,
               .name = "Shaft"},
      EntryRow{.index = 0x1018,
               .code = ObjectCode::kRecord,
               .type = DataType::kUnsigned8,
               .slot = slot::kConstant,
               .name = "Identity",
               .record_type = 0x23},
  };
  static const DictionaryTable kTable({kRows}, 0);
  return kTable;
}

/// The bytes of an SDO abort on the wire.
inline Bytes aborted(unsigned index, unsigned sub, std::uint32_t code) {
  return {0x80, index & 0xFF, index >> 8, sub, code & 0xFF, code >> 8 & 0xFF, code >> 16 & 0xFF, code >> 24};
}

}  // namespace driveline::slaves
