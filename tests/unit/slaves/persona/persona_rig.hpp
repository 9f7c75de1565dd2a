#pragma once

#include <gmock/gmock.h>

#include <chrono>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "driveline/esi/esi_file.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/slaves/persona/persona_slave.hpp"
#include "driveline/wire/command.hpp"

namespace driveline::slaves {

using namespace std::chrono_literals;

/// A slave with personas, asked by single datagrams with plain numbers.
class PersonaRig {
 public:
  PersonaRig(const std::vector<Persona>& personas, std::unique_ptr<Device> device)
      : out_(device->profile().sync_managers.at(0)),
        in_(device->profile().sync_managers.at(1)),
        slave_(make_persona_slave(std::move(device), {}, personas)) {
    slave_->advance(now_);
  }

  void pass(std::chrono::nanoseconds time) {
    // In steps, as the frames of a master drive a slave.
    for (const auto end = now_ + time; now_ < end;) {
      now_ = std::min(end, now_ + 1ms);
      slave_->advance(now_);
    }
  }
  /// Sends one datagram; returns its working counter.
  std::uint16_t send(wire::Command command, std::uint32_t address, std::vector<std::byte>& data) {
    Datagram datagram;
    datagram.command = command;
    datagram.adp = static_cast<std::uint16_t>(address & 0xFFFF);
    datagram.ado = static_cast<std::uint16_t>(address >> 16);
    datagram.data = data;
    slave_->esc().begin_frame(++serial_);
    slave_->esc().process(datagram, now_);
    slave_->advance(now_);
    return datagram.working_counter;
  }
  std::vector<unsigned> read(std::uint16_t address, std::size_t length) {
    std::vector<std::byte> data(length);
    EXPECT_EQ(send(wire::Command::kAprd, std::uint32_t{address} << 16, data), 1) << address;
    std::vector<unsigned> result;
    for (const auto byte : data) result.push_back(std::to_integer<unsigned>(byte));
    return result;
  }
  unsigned word(std::uint16_t address) {
    const auto bytes = read(address, 2);
    return bytes[0] | bytes[1] << 8;
  }
  void write(std::uint16_t address, const std::vector<unsigned>& values) {
    std::vector<std::byte> data;
    for (const auto value : values) data.push_back(static_cast<std::byte>(value));
    EXPECT_EQ(send(wire::Command::kApwr, std::uint32_t{address} << 16, data), 1) << address;
  }

  /// AL status and AL status code after a request for a state: "0002 0000".
  std::string request(unsigned state, std::chrono::nanoseconds time = 10ms) {
    write(0x0120, {state, 0});
    pass(time);
    return hex(word(0x0130), 4) + " " + hex(word(0x0134), 4);
  }
  /// Sync managers 0 and 1, and PREOP.
  std::string pre_op(std::chrono::nanoseconds time = 10ms) {
    set_mailbox(0x0800, out_, 0x26);
    set_mailbox(0x0808, in_, 0x22);
    return request(2, time);
  }

  /// Sets the counter of the last request.
  void count_from(unsigned counter) { counter_ = counter; }
  /// Writes a mailbox message with these bytes after its header, as CoE.
  void mail(const std::vector<unsigned>& data) {
    counter_ = counter_ % 7 + 1;
    std::vector<unsigned> message = {static_cast<unsigned>(data.size()), 0, 0, 0, 0, 0x03U | counter_ << 4};
    message.insert(message.end(), data.begin(), data.end());
    message.resize(out_.default_length);
    write(out_.start_address, message);
  }
  /// The next mailbox message, header included, without the bytes after its length; empty: there is none.
  std::string next_mail() {
    if ((read(0x080D, 1)[0] & 0x08U) == 0) return "none";
    const auto message = read(in_.start_address, in_.default_length);
    return text({message.begin(), message.begin() + 6 + message[0]});
  }
  /// The counter of the next mailbox message; "-": there is none.
  std::string next_counter() {
    const auto message = next_mail();
    return message == "none" ? "-" : message.substr(15, 1);
  }
  /// SDO request without its CoE header; returns the answer, without mailbox and CoE header.
  std::string sdo(std::vector<unsigned> request) {
    request.insert(request.begin(), {0x00, 0x20});
    mail(request);
    pass(1ms);
    const auto message = next_mail();
    return message == "none" ? message : message.substr(24);
  }
  std::string upload(unsigned index, unsigned sub) { return sdo({0x40, index & 0xFFU, index >> 8, sub, 0, 0, 0, 0}); }
  /// Writes up to 4 bytes.
  std::string download(unsigned index, unsigned sub, const std::vector<unsigned>& value) {
    std::vector<unsigned> request = {0x23U | static_cast<unsigned>(4 - value.size()) << 2, index & 0xFFU, index >> 8,
                                     sub};
    request.insert(request.end(), value.begin(), value.end());
    request.resize(8);
    return sdo(request);
  }

  /// A read command of the EEPROM interface; returns the 8 data bytes, of which the controller may fill 4.
  std::vector<unsigned> eeprom(unsigned word_address) {
    write(0x0504, {word_address & 0xFFU, word_address >> 8, 0, 0});
    write(0x0502, {0x00, 0x01});
    return read(0x0508, 8);
  }
  unsigned eeprom_word(unsigned word_address) {
    const auto bytes = eeprom(word_address);
    return bytes[0] | bytes[1] << 8;
  }
  /// Word address of the content of the first category of this type; 0: there is none.
  unsigned category(unsigned type) {
    for (unsigned at = 0x40; at < 0x400;) {
      const auto header = eeprom(at);
      const unsigned found = header[0] | header[1] << 8;
      if (found == type) return at + 2;
      if (found == 0xFFFF) return 0;
      at += 2 + (header[2] | header[3] << 8);
    }
    return 0;
  }
  static std::string hex(unsigned value, int digits) {
    std::string result(static_cast<std::size_t>(digits), '0');
    for (auto digit = result.rbegin(); digit != result.rend(); ++digit, value >>= 4)
      *digit = "0123456789ABCDEF"[value & 15U];
    return result;
  }
  static std::string text(const std::vector<unsigned>& bytes) {
    std::string result;
    for (const auto byte : bytes) result += (result.empty() ? "" : " ") + hex(byte, 2);
    return result;
  }

 private:
  void set_mailbox(std::uint16_t address, const SyncManagerLayout& layout, unsigned control) {
    const unsigned start = layout.start_address;
    const unsigned length = layout.default_length;
    write(address, {start & 0xFFU, start >> 8, length & 0xFFU, length >> 8, control, 0, 1, 0});
  }

  std::chrono::nanoseconds now_ = 1s;
  std::uint64_t serial_ = 0;
  unsigned counter_ = 0;
  SyncManagerLayout out_;
  SyncManagerLayout in_;
  std::unique_ptr<Slave> slave_;
};

/// A drive, whose PDOs are empty at power-on.
inline std::unique_ptr<Device> drive() {
  return std::make_unique<msd::MsdDrive>();
}

/// A device of the example file, for its EEPROM with PDOs.
inline std::unique_ptr<Device> example_device(const std::string& name) {
  std::ifstream stream("examples/terminals.xml", std::ios::binary);  // tests run in the top folder of the project
  const std::string content{std::istreambuf_iterator<char>(stream), {}};
  const auto file = esi::read_esi(content, "terminals.xml").value();
  const auto model = generic::DeviceModel::create(**file.choose({name, {}, {}})).value();
  return std::make_unique<generic::GenericDevice>(model, generic::GenericOptions{});
}

}  // namespace driveline::slaves
