#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/canopen_sample.hpp"
#include "support/scripted_node.hpp"

namespace driveline::slaves::cia301 {

using bytes_test::hex;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

/// A time for EXPECT_NEAR, which compares doubles.
[[nodiscard]] inline double nanos(nanoseconds time) {
  return static_cast<double>(time.count());
}

/// A sample device with node-ID 5 and a scripted master on a bus of 1 Mbit/s.
class DeviceRig {
 public:
  explicit DeviceRig(const DeviceOptions& options = {})
      : dictionary(sample_table()), device(dictionary, application, options) {
    bus.attach(master);
    bus.attach(device);
  }

  /// Lets time pass.
  void run(nanoseconds time) { bus.advance(bus.now() + time); }
  /// The master sends a frame; 1 ms later it has arrived and an answer, too.
  void send(const Frame& frame) {
    master.send_at(bus.now(), frame);
    run(1ms);
  }
  void send(std::uint32_t identifier, std::string_view payload) { send(Frame::of(identifier, hex(payload))); }
  void nmt(canopen::NmtCommand command) { send(canopen::NmtRequest{command, 5}.frame()); }
  void start() { nmt(canopen::NmtCommand::kStart); }
  void sync() { send(0x80, ""); }

  /// Sends an SDO request to node 5 and returns the answer; empty when there is none.
  std::vector<std::byte> ask(std::string_view request) {
    const std::size_t before = answers().size();
    send(0x605, request);
    const auto all = answers();
    return all.size() == before ? std::vector<std::byte>{} : all.back();
  }
  /// Writes an entry of `size` bytes; returns the abort code, 0 for none.
  std::uint32_t write(std::uint16_t index, std::uint8_t subindex, std::uint32_t value, std::size_t size) {
    const canopen::SdoMessage request{canopen::expedited_command(canopen::SdoRequest::kInitiateDownload, size), index,
                                      subindex, bytes::to_le_bytes(value)};
    const std::size_t before = answers().size();
    send(Frame::of(0x605, request.encode()));
    const auto all = answers();
    if (all.size() == before) return ~0U;
    return all.back()[0] == std::byte{0x80} ? bytes::load_le<std::uint32_t>(std::span(all.back()).subspan(4)) : 0;
  }
  /// Reads an entry of up to 4 bytes; the abort code where it cannot be read.
  std::uint32_t read(std::uint16_t index, std::uint8_t subindex) {
    send(Frame::of(0x605, canopen::SdoMessage{0x40, index, subindex, {}}.encode()));
    return bytes::load_le<std::uint32_t>(std::span(answers().back()).subspan(4));
  }
  /// Maps entries, given as in 1600h, into a PDO with the communication object `index` and activates it.
  void map(std::uint16_t index, std::initializer_list<std::uint32_t> entries, std::uint8_t type = 255) {
    const auto mapping = static_cast<std::uint16_t>(index + 0x200);
    const std::uint32_t cob_id = read(index, 1) & 0x7FFF'FFFFU;
    ASSERT_EQ(write(index, 1, cob_id | 0x8000'0000U, 4), 0U);
    ASSERT_EQ(write(index, 2, type, 1), 0U);
    ASSERT_EQ(write(mapping, 0, 0, 1), 0U);
    std::uint8_t sub = 0;
    for (const std::uint32_t entry : entries) ASSERT_EQ(write(mapping, ++sub, entry, 4), 0U);
    ASSERT_EQ(write(mapping, 0, sub, 1), 0U);
    ASSERT_EQ(write(index, 1, cob_id, 4), 0U);
  }

  /// Frames with this identifier that the master has seen.
  [[nodiscard]] std::vector<can::ScriptedNode::Seen> seen(std::uint32_t identifier) const {
    std::vector<can::ScriptedNode::Seen> out;
    for (const auto& one : master.received) {
      if (one.frame.identifier.value == identifier) out.push_back(one);
    }
    return out;
  }
  /// Their payloads.
  [[nodiscard]] std::vector<std::vector<std::byte>> payloads(std::uint32_t identifier) const {
    std::vector<std::vector<std::byte>> out;
    for (const auto& one : seen(identifier)) out.push_back(bytes_test::copy_of(one.frame.payload()));
    return out;
  }
  [[nodiscard]] std::vector<std::vector<std::byte>> answers() const { return payloads(0x585); }
  /// Value of an entry without the bus.
  [[nodiscard]] std::uint64_t value(std::uint16_t index, std::uint8_t subindex = 0) const {
    return dictionary.raw(*dictionary.table().find(index, subindex));
  }
  void set(std::uint16_t index, std::uint64_t raw) { dictionary.set_raw(dictionary.table().find(index, 0)->slot, raw); }

  can::Bus bus;
  can::ScriptedNode master;
  ObjectDictionary dictionary;
  SampleApplication application;
  Device device;
};

/// A device that is in Pre-operational when the test begins.
class CanopenDevice : public ::testing::Test {
 protected:
  CanopenDevice() { rig.run(2ms); }
  DeviceRig rig;
};

}  // namespace driveline::slaves::cia301
