#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "driveline/wire/frame.hpp"
#include "driveline/wire/mailbox.hpp"
#include "fault_ports.hpp"
#include "support/must.hpp"
#include "tshark.hpp"

/// Checks the traffic of a simulated line with Wireshark's dissector.
namespace driveline::bus_test {

/// Mailboxes of the drives (MSD manual, EEPROM): addresses for writing requests and reading replies.
inline constexpr std::uint16_t kRequests = 0x1000;
inline constexpr std::uint16_t kReplies = 0x1200;

/// Stores every frame in both directions, and counts the transferred mailbox messages of a protocol.
class Recorder final : public PassingPort {
 public:
  explicit Recorder(port::Port& inner, std::uint16_t replies_at = kReplies,
                    wire::MailboxType type = wire::MailboxType::kCoe)
      : PassingPort(inner), replies_at_(replies_at), type_(type) {}
  port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    const auto status = PassingPort::send(frame);
    if (status == port::SendStatus::kSent) keep(frame, wire::Command::kFpwr, kRequests, false);
    return status;
  }
  std::optional<port::ReceivedFrame> receive() noexcept override {
    const auto frame = PassingPort::receive();
    if (frame) keep(frame->bytes, wire::Command::kFprd, replies_at_, true);
    return frame;
  }

  std::vector<std::vector<std::byte>> frames;
  std::size_t requests = 0;
  std::size_t replies = 0;

 private:
  std::uint16_t replies_at_;
  wire::MailboxType type_;

  void keep(std::span<const std::byte> frame, wire::Command command, std::uint16_t address, bool answered) {
    frames.emplace_back(frame.begin(), frame.end());
    auto cursor = wire::DatagramCursor::open(frame);
    while (cursor && !cursor->done()) {
      const auto datagram = cursor->next();
      if (!datagram) return;
      if (datagram->header.command != command || datagram->header.address.ado() != address) continue;
      if (answered && datagram->working_counter() != 1) continue;
      const auto mailbox = wire::MailboxHeader::decode(datagram->data);
      if (!mailbox || mailbox->length == 0 || mailbox->type != type_) continue;
      ++(answered ? replies : requests);
    }
  }
};

class BusTraffic : public testing::Test {
 protected:
  void SetUp() override {
    if (!replay::tshark_available()) GTEST_SKIP() << replay::missing_tshark_text();
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    file_ = std::filesystem::path(testing::TempDir()) /
            ("driveline_" + std::string(test->name()) + "_" + std::to_string(::getpid()) + ".pcap");
  }
  void TearDown() override {
    if (!file_.empty()) std::filesystem::remove(file_);
  }

  /// Expects that nothing is malformed or suspicious, and that everything is EtherCAT, unless frames were damaged on
  /// purpose.
  void expect_clean(const std::vector<std::vector<std::byte>>& frames) {
    replay::write_pcap(file_, frames);
    const auto bad = must(replay::dissect(file_, "_ws.malformed || _ws.expert.severity >= 0x600000", {"frame.number"}));
    EXPECT_TRUE(bad->empty()) << bad->size() << " of " << frames.size() << ", the first is frame "
                              << bad->front()[0][0];
    const auto all = must(replay::dissect(file_, "ecat", {"frame.number"}));
    EXPECT_EQ(all->size(), frames.size());
  }
  /// Number of occurrences of a field in the matching frames.
  std::size_t occurrences(const std::string& filter, const std::string& field) {
    const auto packets = replay::dissect(file_, filter, {field});
    if (!packets) throw std::runtime_error(packets.error());
    std::size_t count = 0;
    for (const auto& packet : *packets) count += packet[0].size();
    return count;
  }
  /// A field of each matching frame; the values may contain commas.
  std::vector<std::string> texts(const std::string& filter, const std::string& field) {
    const auto packets = replay::dissect(file_, filter, {field});
    if (!packets) throw std::runtime_error(packets.error());
    std::vector<std::string> texts;
    for (const auto& packet : *packets) {
      auto& text = texts.emplace_back();
      for (const auto& part : packet[0]) text += (text.empty() ? "" : ",") + part;
    }
    return texts;
  }
  /// Number of occurrences of each value of a field in the matching frames.
  std::map<std::string, std::size_t> values(const std::string& filter, const std::string& field) {
    const auto packets = replay::dissect(file_, filter, {field});
    if (!packets) throw std::runtime_error(packets.error());
    std::map<std::string, std::size_t> counts;
    for (const auto& packet : *packets) {
      for (const auto& value : packet[0]) ++counts[value];
    }
    return counts;
  }

 private:
  std::filesystem::path file_;
};

}  // namespace driveline::bus_test
