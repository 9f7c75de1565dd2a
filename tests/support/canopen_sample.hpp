#pragma once

#include <deque>
#include <string>
#include <vector>

#include "driveline/slaves/canopen/device.hpp"

/// A CANopen device with all objects of the communication profile and some of an application.
namespace driveline::slaves::cia301 {

/// Rows of the sample device. The data types and rights of its communication objects are those of CiA 301 7.5.2.
class SampleRows {
 public:
  SampleRows() {
    using enum esi::DataType;
    namespace rights = access;
    constexpr std::uint16_t kSetting = rights::kReadWrite | rights::kBackup;
    add(0x1000, 0, kUnsigned32, rights::kRead, 0x0002'0192);
    add(0x1001, 0, kUnsigned8, rights::kRead | rights::kTxMappable);
    add(0x1003, 0, kUnsigned8, rights::kReadWrite);
    for (std::uint8_t sub = 1; sub <= 3; ++sub) add(0x1003, sub, kUnsigned32, rights::kRead);
    add(0x1005, 0, kUnsigned32, kSetting, 0x80);
    add(0x1006, 0, kUnsigned32, kSetting);
    add_text(0x1008, 0, kVisibleString, rights::kRead, "Sample device", 13);
    add(0x100C, 0, kUnsigned16, kSetting);
    add(0x100D, 0, kUnsigned8, kSetting);
    add_count(0x1010, 1);
    add(0x1010, 1, kUnsigned32, rights::kReadWrite, 1);
    add_count(0x1011, 1);
    add(0x1011, 1, kUnsigned32, rights::kReadWrite, 1);
    add(0x1012, 0, kUnsigned32, kSetting, 0x8000'0100);
    add(0x1014, 0, kUnsigned32, kSetting, 0x80);
    add(0x1015, 0, kUnsigned16, kSetting);
    add_count(0x1016, 3);
    for (std::uint8_t sub = 1; sub <= 3; ++sub) add(0x1016, sub, kUnsigned32, kSetting);
    add(0x1017, 0, kUnsigned16, kSetting);
    add(0x1019, 0, kUnsigned8, kSetting);
    add_count(0x1029, 1);
    add(0x1029, 1, kUnsigned8, kSetting);
    for (std::uint16_t i = 0; i < 4; ++i)
      add_communication(static_cast<std::uint16_t>(0x1400 + i), 0x200U + 0x100U * i);
    for (std::uint16_t i = 0; i < 4; ++i) add_mapping(static_cast<std::uint16_t>(0x1600 + i));
    for (std::uint16_t i = 0; i < 4; ++i)
      add_communication(static_cast<std::uint16_t>(0x1800 + i), 0x180U + 0x100U * i);
    for (std::uint16_t i = 0; i < 4; ++i) add_mapping(static_cast<std::uint16_t>(0x1A00 + i));
    add(0x2000, 0, kInteger16, rights::kReadWrite | rights::kRxMappable | rights::kTxMappable | rights::kBackup, -17);
    add(0x2001, 0, kUnsigned8, rights::kReadWrite | rights::kRxMappable | rights::kTxMappable, 5);
    add(0x2002, 0, kUnsigned32, rights::kReadWrite | rights::kRxMappable | rights::kTxMappable);
    add_text(0x2003, 0, kVisibleString, rights::kReadWrite, "X-Axis", 100);
    add(0x2004, 0, kUnsigned64, rights::kReadWrite | rights::kRxMappable | rights::kTxMappable);
    add(0x2005, 0, kInteger16, rights::kWrite);
    add(0x2006, 0, kInteger16, rights::kReadWrite);
    rows_.back().minimum = -5;
    rows_.back().maximum = 300;
    add(0x2007, 0, kUnsigned8, rights::kReadWrite);
    rows_.back().power_off_only = true;
    add_text(0x2008, 0, kOctetString, rights::kReadWrite, "", 2000);
  }
  [[nodiscard]] std::span<const EntryRow> rows() const noexcept { return rows_; }

 private:
  void add(std::uint16_t index, std::uint8_t subindex, esi::DataType type, std::uint16_t rights, double initial = 0) {
    EntryRow row;
    row.index = index;
    row.subindex = subindex;
    row.type = type;
    row.access = rights;
    row.initial = initial;
    row.name = "entry";
    rows_.push_back(row);
  }
  void add_text(std::uint16_t index, std::uint8_t subindex, esi::DataType type, std::uint16_t rights,
                std::string_view text, std::uint16_t length) {
    add(index, subindex, type, rights);
    rows_.back().text = text;
    rows_.back().string_length = length;
  }
  void add_count(std::uint16_t index, double entries) {
    add(index, 0, esi::DataType::kUnsigned8, access::kRead, entries);
  }
  void add_communication(std::uint16_t index, double cob_id) {
    constexpr std::uint16_t kSetting = access::kReadWrite | access::kBackup;
    add_count(index, 5);
    add(index, 1, esi::DataType::kUnsigned32, kSetting, cob_id);
    add(index, 2, esi::DataType::kUnsigned8, kSetting, 255);
    add(index, 3, esi::DataType::kUnsigned16, kSetting);
    add(index, 5, esi::DataType::kUnsigned16, kSetting);
  }
  void add_mapping(std::uint16_t index) {
    add(index, 0, esi::DataType::kUnsigned8, access::kReadWrite | access::kBackup);
    for (std::uint8_t sub = 1; sub <= 8; ++sub) {
      add(index, sub, esi::DataType::kUnsigned32, access::kReadWrite | access::kBackup);
    }
  }

  std::vector<EntryRow> rows_;
};

[[nodiscard]] inline const DictionaryTable& sample_table() {
  static const SampleRows kRows;
  static const DictionaryTable kTable({kRows.rows()}, 0);
  return kTable;
}

/// An application that remembers what it is told.
class SampleApplication : public Application {
 public:
  [[nodiscard]] SdoResult<void> accept(const EntryRow& /*row*/, std::uint64_t /*raw*/) override { return verdict; }
  void written(const EntryRow& row) override { told.push_back(row.index); }
  [[nodiscard]] bool power_stage_on() const noexcept override { return power; }
  [[nodiscard]] std::uint8_t node_id(Reset reset) override {
    if (reset != Reset::kCommunication) node = next_node;
    return node;
  }
  [[nodiscard]] std::uint32_t bit_rate(Reset /*reset*/) override { return rate; }
  void restart(Reset reset, nanoseconds /*now*/) override { restarts.push_back(reset); }
  void restore_communication() override { ++restored; }
  [[nodiscard]] nanoseconds start_up_time() const noexcept override { return start_up; }
  void advance(nanoseconds now) override {
    advances.push_back(now);
    if (wake <= now) wake = can::kNever;
  }
  [[nodiscard]] nanoseconds next_wake() const noexcept override { return wake; }
  void rpdo_received(std::size_t number, nanoseconds now) override { frames.emplace_back(number, now); }
  [[nodiscard]] bool may_start() const noexcept override { return start_permitted; }
  void sync(std::uint8_t counter, nanoseconds now) override { syncs.emplace_back(counter, now); }
  void rpdo_applied(std::size_t number, nanoseconds now) override { applied.emplace_back(number, now); }
  void time(const canopen::TimeOfDay& time, nanoseconds /*now*/) override { time_of_day = time; }
  void communication(CommunicationEvent event, nanoseconds now) override { events.emplace_back(event, now); }
  [[nodiscard]] std::uint64_t event_mask(std::size_t /*tpdo*/) const noexcept override { return mask; }
  [[nodiscard]] bool keep(const ObjectDictionary& /*stored*/) override { return can_keep; }

  SdoResult<void> verdict;
  std::uint8_t next_node = 5;
  std::uint8_t node = 5;
  std::uint32_t rate = 0;
  bool power = false;
  bool start_permitted = true;
  bool can_keep = true;
  std::uint64_t mask = ~std::uint64_t{0};
  nanoseconds start_up{0};
  nanoseconds wake = can::kNever;
  std::vector<nanoseconds> advances;
  std::vector<std::uint16_t> told;  ///< objects that were written
  std::vector<Reset> restarts;
  unsigned restored = 0;  ///< times that the communication was
  std::vector<std::pair<unsigned, nanoseconds>> syncs;
  std::vector<std::pair<std::size_t, nanoseconds>> frames;
  std::vector<std::pair<std::size_t, nanoseconds>> applied;
  std::vector<std::pair<CommunicationEvent, nanoseconds>> events;
  canopen::TimeOfDay time_of_day;
};

}  // namespace driveline::slaves::cia301
