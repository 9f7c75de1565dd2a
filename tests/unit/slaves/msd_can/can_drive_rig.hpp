#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "driveline/canopen_wire/emergency.hpp"
#include "driveline/canopen_wire/sdo.hpp"
#include "driveline/slaves/can/bus.hpp"
#include "driveline/slaves/msd/can/can_table.hpp"
#include "driveline/slaves/msd/can/msd_can_drive.hpp"
#include "support/scripted_node.hpp"

namespace driveline::slaves::msd {

using bytes_test::hex;
using canopen::Frame;
using canopen::NmtCommand;
using canopen::NmtState;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

inline constexpr std::int32_t kTurn = 1 << 20;  ///< increments of the motor's encoder
inline constexpr std::uint16_t kShutDown = 0x06;
inline constexpr std::uint16_t kSwitchOn = 0x07;
inline constexpr std::uint16_t kEnable = 0x0F;
inline constexpr std::uint16_t kReached = 0x0400;

// Entries of mappings.
inline constexpr std::uint32_t kTargetPosition = 0x607A'0020;
inline constexpr std::uint32_t kTargetVelocity = 0x60FF'0020;

/// S4 of the drive in the tests: node-ID 12.
inline constexpr DipSwitch kTwelve{0b0000'1100};

/// A drive and a master that a test moves by hand, on a bus of 1 Mbit/s. The drive has node-ID 12 unless its switches
/// say otherwise.
class CanDriveRig {
 public:
  explicit CanDriveRig(const MsdParameters& parameters = {}, const CanConnection& connection = {kTwelve, {}, 500us},
                       std::uint8_t node_id = 12)
      : node(node_id), drive(parameters, connection) {
    bus.attach(master);
    bus.attach(drive.device());
  }

  void run(std::chrono::nanoseconds time) { bus.advance(bus.now() + time); }
  void send(const Frame& frame, std::chrono::nanoseconds then = 2ms) {
    master.send_at(bus.now(), frame);
    run(then);
  }
  void send(std::uint32_t identifier, std::string_view payload, std::chrono::nanoseconds then = 2ms) {
    send(Frame::of(identifier, hex(payload)), then);
  }
  void nmt(NmtCommand command) { send(canopen::NmtRequest{command, node}.frame()); }
  void start() { nmt(NmtCommand::kStart); }
  void sync() { send(0x80, "", 1ms); }

  /// Sends an SDO request and returns the answer; empty when there is none.
  std::vector<std::byte> ask(std::span<const std::byte> request) {
    const std::size_t before = count(0x580U + node);
    send(Frame::of(0x600U + node, request), 5ms);
    const auto all = payloads(0x580U + node);
    return all.size() == before ? std::vector<std::byte>{} : all.back();
  }
  std::vector<std::byte> ask(std::string_view request) { return ask(hex(request)); }
  /// Writes an entry of `size` bytes; returns the abort code, 0 for none.
  std::uint32_t write(std::uint16_t index, std::uint8_t subindex, std::uint32_t value, std::size_t size) {
    const auto command = canopen::expedited_command(canopen::SdoRequest::kInitiateDownload, size);
    const auto answer = ask(canopen::SdoMessage{command, index, subindex, bytes::to_le_bytes(value)}.encode());
    if (answer.empty()) return ~0U;
    return answer[0] == std::byte{0x80} ? number(answer) : 0;
  }
  std::uint32_t write_real(std::uint16_t index, float value) {
    return write(index, 0, std::bit_cast<std::uint32_t>(value), 4);
  }
  /// Reads an entry of up to 4 bytes; the abort code where it cannot be read.
  std::uint32_t read(std::uint16_t index, std::uint8_t subindex = 0) {
    const auto answer = ask(canopen::SdoMessage{0x40, index, subindex, {}}.encode());
    return answer.empty() ? ~0U : number(answer);
  }
  /// Saves all parameters.
  std::uint32_t save() { return write(0x1010, 1, 0x65766173, 4); }

  /// Maps entries, given as in 1600h, into the PDO with the communication object `index`.
  void map(std::uint16_t index, std::initializer_list<std::uint32_t> entries, std::uint8_t type = 255) {
    const auto mapping = static_cast<std::uint16_t>(index + 0x200);
    const std::uint32_t cob_id = read(index, 1);
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
  [[nodiscard]] std::size_t count(std::uint32_t identifier) const { return seen(identifier).size(); }
  [[nodiscard]] std::vector<std::vector<std::byte>> payloads(std::uint32_t identifier) const {
    std::vector<std::vector<std::byte>> out;
    for (const auto& one : seen(identifier)) out.push_back(bytes_test::copy_of(one.frame.payload()));
    return out;
  }
  /// The EMCY messages.
  [[nodiscard]] std::vector<std::vector<std::byte>> emergencies() const { return payloads(0x080U + node); }
  /// Value of an entry without the bus.
  [[nodiscard]] std::uint64_t value(std::uint16_t index, std::uint8_t subindex = 0) const {
    const ObjectDictionary& dictionary = drive.core().complete_values();
    return dictionary.raw(*dictionary.table().find(index, subindex));
  }
  [[nodiscard]] std::uint16_t status() const { return static_cast<std::uint16_t>(value(0x6041)); }
  [[nodiscard]] std::int32_t position() const { return static_cast<std::int32_t>(value(0x6064)); }

  /// Sets the control word by the first RxPDO, which must map it alone.
  void control(std::uint16_t word) { send(Frame::of(0x200U + node, bytes::to_le_bytes(word)), 3ms); }
  /// Maps the control word into RxPDO 1 and makes the drive operational.
  void operate() {
    map(0x1400, {0x6040'0010});
    start();
  }
  void enable() {
    for (const std::uint16_t word : {kShutDown, kSwitchOn, kEnable}) control(word);
  }

  std::uint8_t node;
  can::Bus bus;
  can::ScriptedNode master;
  MsdCanDrive drive;

 private:
  static std::uint32_t number(const std::vector<std::byte>& answer) {
    return bytes::load_le<std::uint32_t>(std::span(answer).subspan(4));
  }
};

/// Tests that hold for each drive of the family. A suite is instantiated with kEachDrive and drive_name().
class EachCanDrive : public ::testing::TestWithParam<Variant> {
 protected:
  /// Parameters of the drive under test.
  [[nodiscard]] static MsdParameters parameters() {
    MsdParameters out;
    out.variant = GetParam();
    return out;
  }
};

inline const auto kEachDrive = ::testing::Values(Variant::kMsd, Variant::kServoOne, Variant::kServoOneJunior);

/// Name of a drive in the names of tests.
inline std::string drive_name(const ::testing::TestParamInfo<Variant>& drive) {
  switch (drive.param) {
    case Variant::kMsd:
      return "Msd";
    case Variant::kServoOne:
      return "ServoOne";
    case Variant::kServoOneJunior:
      return "ServoOneJunior";
  }
  return "unknown";
}

/// A drive with node-ID 12 that is in Pre-operational when the test begins.
class MsdCan : public EachCanDrive {
 protected:
  MsdCan() { rig.run(5ms); }
  CanDriveRig rig{parameters()};
};

}  // namespace driveline::slaves::msd
