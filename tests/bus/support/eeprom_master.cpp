#include "eeprom_master.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>

namespace driveline::bus_test {
namespace {

using std::chrono::milliseconds;
using Bytes = std::vector<std::uint8_t>;

// Commands (ETG.1000.4 5.4).
constexpr std::uint8_t kApwr = 2;
constexpr std::uint8_t kFprd = 4;
constexpr std::uint8_t kFpwr = 5;
constexpr std::uint8_t kBrd = 7;
constexpr std::uint8_t kLrw = 12;

// Registers (ETG.1000.4 chapter 6, ETG.1000.6 chapter 5).
constexpr std::uint16_t kStationAddress = 0x0010;
constexpr std::uint16_t kAlControl = 0x0120;
constexpr std::uint16_t kAlStatus = 0x0130;
constexpr std::uint16_t kEepromOwner = 0x0500;
constexpr std::uint16_t kEepromControl = 0x0502;
constexpr std::uint16_t kEepromData = 0x0508;
constexpr std::uint16_t kFmmu = 0x0600;
constexpr std::uint16_t kFmmuBytes = 16;
constexpr std::uint16_t kSyncManager = 0x0800;
constexpr std::uint16_t kSyncManagerBytes = 8;
constexpr std::uint16_t kMailboxState = 0x080D;  ///< status of sync manager 1

constexpr std::uint16_t kFirstStation = 0x0201;
constexpr std::uint32_t kImageStart = 0x00010000;
constexpr int kPatience = 5000;  ///< polls, a millisecond apart

// Uses of sync managers (ETG.1000.6 Table 23) and FMMUs (Table 22).
constexpr std::uint8_t kMailboxOut = 1;
constexpr std::uint8_t kMailboxIn = 2;
constexpr std::uint8_t kOutputs = 3;
constexpr std::uint8_t kInputs = 4;
constexpr std::uint8_t kFmmuOutputs = 1;
constexpr std::uint8_t kFmmuInputs = 2;
constexpr std::uint8_t kFmmuMailboxState = 3;

void append(Bytes& bytes, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

std::uint32_t number(const Bytes& bytes, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = size; i > 0; --i) value = value << 8 | bytes.at(at + i - 1);
  return value;
}

Bytes frame_of(std::uint8_t command, std::uint8_t index, std::uint32_t address, const Bytes& data) {
  Bytes frame(6, 0xFF);  // to all
  frame.insert(frame.end(), {0x02, 0, 0, 0, 0, 0x01, 0x88, 0xA4});
  append(frame, 0x1000U | (12U + data.size()), 2);
  frame.push_back(command);
  frame.push_back(index);
  append(frame, address, 4);
  append(frame, data.size(), 2);
  append(frame, 0, 2);
  frame.insert(frame.end(), data.begin(), data.end());
  append(frame, 0, 2);
  frame.resize(std::max<std::size_t>(frame.size(), 60));
  return frame;
}

/// Content of the categories of one type, from the words of an EEPROM behind its header (ETG.1000.6 Table 17).
Bytes category(const std::vector<std::uint16_t>& words, std::uint16_t type) {
  Bytes content;
  for (std::size_t at = 0; words.at(at) != 0xFFFF; at += 2U + words.at(at + 1)) {
    if (words[at] != type) continue;
    for (std::size_t i = 0; i < words.at(at + 1); ++i) append(content, words.at(at + 2 + i), 2);
  }
  return content;
}

/// Appends the PDOs of category 50 or 51 to the sync managers that they name (ETG.1000.6 Tables 24 and 25).
void add_pdos(EepromMaster::Slave& slave, const Bytes& content) {
  for (std::size_t at = 0; at + 8 <= content.size();) {
    const std::size_t entries = content[at + 2];
    const std::uint8_t assigned = content[at + 3];
    at += 8;
    for (std::size_t i = 0; i < entries; ++i, at += 8) {
      if (assigned >= slave.sync_managers.size()) continue;  // 0xFF: assigned to none
      auto& manager = slave.sync_managers[assigned];
      const std::size_t bits = content.at(at + 5);
      slave.entries.push_back(
          {static_cast<std::uint16_t>(number(content, at, 2)), content[at + 2], assigned, manager.bits, bits});
      manager.bits += bits;
    }
  }
}

bool carries_process_data(const EepromMaster::SyncManager& manager) {
  return (manager.use == kOutputs || manager.use == kInputs) && manager.length > 0;
}

}  // namespace

std::uint16_t EepromMaster::transfer(std::uint8_t command, std::uint32_t address, Bytes& data) {
  const auto sent = frame_of(command, ++frame_index_, address, data);
  if (port_.send(std::as_bytes(std::span(sent))) != port::SendStatus::kSent) throw std::runtime_error("not sent");
  const auto deadline = clock_.now() + milliseconds{100};
  while (port_.wait_readable(deadline)) {
    const auto received = port_.receive();
    if (!received) continue;
    Bytes frame;
    for (const auto byte : received->bytes) frame.push_back(std::to_integer<std::uint8_t>(byte));
    constexpr std::size_t kIndex = 17;
    constexpr std::size_t kData = 26;
    if (frame.size() != sent.size() || frame[kIndex] != frame_index_) continue;
    std::copy_n(frame.begin() + kData, data.size(), data.begin());
    return static_cast<std::uint16_t>(number(frame, kData + data.size(), 2));
  }
  throw std::runtime_error("no answer");
}

Bytes EepromMaster::read(std::size_t slave, std::uint16_t address, std::size_t length) {
  Bytes data(length);
  const auto station = static_cast<std::uint32_t>(kFirstStation + slave);
  if (transfer(kFprd, station | std::uint32_t{address} << 16, data) != 1) throw std::runtime_error("not read");
  return data;
}

void EepromMaster::write(std::size_t slave, std::uint16_t address, Bytes data) {
  const auto station = static_cast<std::uint32_t>(kFirstStation + slave);
  if (transfer(kFpwr, station | std::uint32_t{address} << 16, data) != 1) throw std::runtime_error("not written");
}

void EepromMaster::pause() {
  clock_.sleep_until(clock_.now() + milliseconds{1});
}

std::uint16_t EepromMaster::read_eeprom_word(std::size_t slave, std::uint32_t word) {
  Bytes command = {0x00, 0x01};  // read
  append(command, word, 4);
  write(slave, kEepromControl, command);
  for (int poll = 0; poll < kPatience; ++poll) {
    const auto status = number(read(slave, kEepromControl, 2), 0, 2);
    if ((status & 0x6000U) != 0) throw std::runtime_error("the EEPROM is not read");
    if ((status & 0x8000U) == 0) return static_cast<std::uint16_t>(number(read(slave, kEepromData, 2), 0, 2));
    pause();
  }
  throw std::runtime_error("the EEPROM stays busy");
}

EepromMaster::Slave EepromMaster::read_eeprom(std::size_t slave) {
  constexpr std::uint32_t kVendor = 0x08;
  constexpr std::uint32_t kCategories = 0x40;
  write(slave, kEepromOwner, {0});
  const auto word = [&](std::uint32_t at) { return std::uint32_t{read_eeprom_word(slave, at)}; };
  Slave out;
  out.vendor_id = word(kVendor) | word(kVendor + 1) << 16;
  out.product_code = word(kVendor + 2) | word(kVendor + 3) << 16;
  std::vector<std::uint16_t> words;
  const auto next = [&] {
    words.push_back(read_eeprom_word(slave, kCategories + static_cast<std::uint32_t>(words.size())));
    return words.back();
  };
  while (next() != 0xFFFF) {  // a type, its length, and as many words
    for (auto left = next(); left > 0; --left) next();
  }
  out.fmmus = category(words, 40);
  const auto managers = category(words, 41);
  for (std::size_t at = 0; at + 8 <= managers.size(); at += 8) {
    out.sync_managers.push_back({static_cast<std::uint16_t>(number(managers, at, 2)),
                                 static_cast<std::uint16_t>(number(managers, at + 2, 2)), managers[at + 4],
                                 (managers[at + 6] & 1U) != 0, managers[at + 7], 0});
  }
  add_pdos(out, category(words, 51));
  add_pdos(out, category(words, 50));
  for (auto& manager : out.sync_managers) {
    if (manager.bits > 0) manager.length = static_cast<std::uint16_t>((manager.bits + 7) / 8);
  }
  return out;
}

void EepromMaster::scan() {
  Bytes type(1);
  const auto count = transfer(kBrd, 0, type);
  slaves_.clear();
  image_.clear();
  for (std::uint16_t i = 0; i < count; ++i) {
    Bytes station;
    append(station, kFirstStation + i, 2);
    const auto position = static_cast<std::uint16_t>(0 - i);
    if (transfer(kApwr, position | std::uint32_t{kStationAddress} << 16, station) != 1) {
      throw std::runtime_error("no station address");
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    slaves_.push_back(read_eeprom(i));
    auto& slave = slaves_.back();
    for (const auto& manager : slave.sync_managers) {
      slave.logical.push_back(image_.size());
      if (carries_process_data(manager)) image_.resize(image_.size() + manager.length);
    }
    slave.logical.push_back(image_.size());  // state of the mailbox
    image_.push_back(0);
  }
}

void EepromMaster::write_sync_managers(std::size_t slave, bool mailboxes) {
  const auto& managers = slaves_[slave].sync_managers;
  for (std::size_t n = 0; n < managers.size(); ++n) {
    const auto& manager = managers[n];
    if ((manager.use == kMailboxOut || manager.use == kMailboxIn) != mailboxes) continue;
    const auto address = static_cast<std::uint16_t>(kSyncManager + kSyncManagerBytes * n);
    // The registers of an enabled sync manager cannot be written (ETG.1000.4 6.6).
    write(slave, static_cast<std::uint16_t>(address + 6), {0});
    Bytes channel;
    append(channel, manager.start, 2);
    append(channel, manager.length, 2);
    append(channel, manager.control, 1);
    append(channel, 0, 1);
    append(channel, manager.enable && manager.length > 0 ? 1 : 0, 1);
    append(channel, 0, 1);
    write(slave, address, channel);
  }
}

void EepromMaster::write_fmmus(std::size_t position) {
  Slave& slave = slaves_[position];
  std::vector<bool> taken(slave.fmmus.size());
  bool reads = false;
  bool writes = false;
  const auto map = [&](std::uint8_t use, std::size_t logical, std::size_t bits, std::uint16_t start) {
    std::size_t n = 0;
    while (n < taken.size() && (taken[n] || slave.fmmus[n] != use)) ++n;
    if (n == taken.size()) throw std::runtime_error("the EEPROM has no FMMU left");
    taken[n] = true;
    (use == kFmmuOutputs ? writes : reads) = true;
    Bytes fmmu;
    append(fmmu, kImageStart + logical, 4);
    append(fmmu, (bits + 7) / 8, 2);
    append(fmmu, 0, 1);               // first bit
    append(fmmu, (bits - 1) % 8, 1);  // last bit
    append(fmmu, start, 2);
    append(fmmu, 0, 1);
    append(fmmu, use == kFmmuOutputs ? 2 : 1, 1);
    append(fmmu, 1, 1);
    append(fmmu, 0, 3);
    write(position, static_cast<std::uint16_t>(kFmmu + kFmmuBytes * n), fmmu);
  };
  for (std::size_t n = 0; n < slave.sync_managers.size(); ++n) {
    const auto& manager = slave.sync_managers[n];
    if (!carries_process_data(manager)) continue;
    const std::size_t bits = manager.bits > 0 ? manager.bits : std::size_t{8} * manager.length;
    map(manager.use == kOutputs ? kFmmuOutputs : kFmmuInputs, slave.logical[n], bits, manager.start);
  }
  const bool shows_mailbox = std::find(slave.fmmus.begin(), slave.fmmus.end(), kFmmuMailboxState) != slave.fmmus.end();
  if (shows_mailbox) map(kFmmuMailboxState, slave.logical.back(), 8, kMailboxState);
  slave.working_counter = static_cast<std::uint16_t>((reads ? 1 : 0) + (writes ? 2 : 0));
}

EepromMaster::AlAnswer EepromMaster::request(std::size_t slave, std::uint16_t state, bool acknowledge) {
  const auto before = number(read(slave, kAlStatus, 2), 0, 2) & 0xFU;
  if (state == kPreOp && before == kInit) write_sync_managers(slave, true);
  if (state == kSafeOp && before == kPreOp) {
    write_sync_managers(slave, false);
    write_fmmus(slave);
  }
  Bytes control;
  append(control, state | (acknowledge ? kError : 0U), 2);
  write(slave, kAlControl, control);
  AlAnswer answer;
  for (int poll = 0; poll < kPatience; ++poll) {
    pause();
    if (state == kOp) exchange();
    const auto registers = read(slave, kAlStatus, 6);
    answer = {static_cast<std::uint16_t>(number(registers, 0, 2)), static_cast<std::uint16_t>(number(registers, 4, 2))};
    if (answer.status == state || (answer.status & kError) != 0) break;
  }
  return answer;
}

std::string EepromMaster::request_all(std::uint16_t state) {
  for (std::size_t i = 0; i < slaves_.size(); ++i) {
    const auto answer = request(i, state);
    if (answer.status != state) {
      return "slave " + std::to_string(i) + ": AL status " + std::to_string(answer.status) + ", AL status code " +
             std::to_string(answer.code);
    }
  }
  return {};
}

std::uint16_t EepromMaster::exchange() {
  return transfer(kLrw, kImageStart, image_);
}

std::size_t EepromMaster::run(std::size_t cycles, const std::function<void()>& after_each) {
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < cycles; ++i) {
    pause();
    if (exchange() != expected_working_counter()) ++wrong;
    if (after_each) after_each();
  }
  return wrong;
}

std::uint16_t EepromMaster::expected_working_counter() const noexcept {
  unsigned sum = 0;
  for (const auto& slave : slaves_) sum += slave.working_counter;
  return static_cast<std::uint16_t>(sum);
}

const EepromMaster::Entry& EepromMaster::find(std::size_t slave, std::uint16_t index, std::uint8_t subindex) const {
  for (const auto& entry : slaves_.at(slave).entries) {
    if (entry.index == index && entry.subindex == subindex) return entry;
  }
  throw std::runtime_error("the EEPROM maps no such entry");
}

std::size_t EepromMaster::first_bit(std::size_t slave, const Entry& entry) const {
  return 8 * slaves_[slave].logical[entry.sync_manager] + entry.bit;
}

std::uint64_t EepromMaster::get(std::size_t slave, std::uint16_t index, std::uint8_t subindex) const {
  const auto& entry = find(slave, index, subindex);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < entry.bits; ++i) {
    const auto bit = first_bit(slave, entry) + i;
    value |= static_cast<std::uint64_t>(image_[bit / 8] >> bit % 8 & 1U) << i;
  }
  return value;
}

void EepromMaster::set(std::size_t slave, std::uint16_t index, std::uint8_t subindex, std::uint64_t value) {
  const auto& entry = find(slave, index, subindex);
  for (std::size_t i = 0; i < entry.bits; ++i) {
    const auto bit = first_bit(slave, entry) + i;
    const auto mask = static_cast<std::uint8_t>(1U << bit % 8);
    image_[bit / 8] =
        static_cast<std::uint8_t>((value >> i & 1U) != 0 ? image_[bit / 8] | mask : image_[bit / 8] & ~mask);
  }
}

}  // namespace driveline::bus_test
