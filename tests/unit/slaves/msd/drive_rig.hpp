#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "driveline/slaves/msd/msd_drive.hpp"

namespace driveline::slaves::msd {

using std::chrono_literals::operator""us;
using std::chrono_literals::operator""ms;
using std::chrono_literals::operator""ns;
using std::chrono_literals::operator""s;
using wire::AlState;
using wire::AlStatusCode;

inline constexpr std::int32_t kRevolution = 1 << 20;  ///< increments of the motor's encoder
inline constexpr double kTurnRad = 2.0 * std::numbers::pi;
inline constexpr double kIncrementsPerRadian = kRevolution / kTurnRad;
inline constexpr double kCycleS = 125e-6;

inline constexpr std::uint16_t kEnabled = 0x0F;    ///< control word: operation enabled
inline constexpr std::uint16_t kHalt = 0x100;      ///< control word
inline constexpr std::uint16_t kReached = 0x0400;  ///< status word: target reached

/// A value to write to an object of the drive.
struct ObjectValue {
  std::uint16_t index;
  unsigned sub;
  std::uint32_t value;
  unsigned size;  ///< bytes
};
inline ObjectValue real_value(std::uint16_t index, unsigned sub, float value) {
  return {index, sub, std::bit_cast<std::uint32_t>(value), 4};
}

/// A drive with a manual master: SDOs as bytes, AL transitions, PDOs with a fixed layout, time in cycles of 125 us.
/// Layout: RxPDO1 control word, mode, 2807h filler, target position; RxPDO2 target velocity, target torque, torque
/// offset; RxPDO3 velocity offset. TxPDO1 status word, mode display, filler, position; TxPDO2 velocity, torque, error
/// code; TxPDO3 following error.
class DriveRig {
 public:
  explicit DriveRig(const MsdParameters& parameters = {}) : device(parameters) {
    device.advance(now);
    pass(2ms);  // the self-test
    to(AlState::kInit, AlState::kPreOp);
  }

  AlStatusCode to(AlState from, AlState next) {
    const auto code = device.transition(from, next);
    if (code == AlStatusCode::kNoError) state = next;
    return code;
  }

  /// Sends SDO request bytes (without CoE header); returns the response in the same form. Stores emergencies received
  /// meanwhile.
  std::vector<unsigned> sdo(std::vector<unsigned> request) { return coe(2, std::move(request)); }
  /// The same for any CoE service (ETG.1000.6 5.6.1): 2 SDO request, 8 SDO information.
  std::vector<unsigned> coe(unsigned service, std::vector<unsigned> request) {
    std::vector<std::byte> mailbox(512);
    const std::size_t length = request.size() + 2;
    counter_ = counter_ % 7 + 1;
    const std::vector<unsigned> header = {static_cast<unsigned>(length), 0,    0,           0, 0,
                                          0x03U | counter_ << 4,         0x00, service << 4};
    request.insert(request.begin(), header.begin(), header.end());
    for (std::size_t i = 0; i < request.size(); ++i) mailbox[i] = static_cast<std::byte>(request[i]);
    device.mailbox_request(mailbox);
    return receive();
  }
  /// Fetches mailbox messages up to the next SDO response.
  std::vector<unsigned> receive() {
    std::vector<std::byte> out(512);
    for (;;) {
      const std::size_t length = device.mailbox_reply(out);
      if (length == 0) return {};
      std::vector<unsigned> data;
      for (std::size_t i = 6; i < length; ++i) data.push_back(std::to_integer<unsigned>(out[i]));
      std::vector<unsigned> body(data.begin() + 2, data.end());
      if (data[1] == 0x10) {
        emergencies.push_back(body);
      } else {
        return body;
      }
    }
  }
  /// Expedited download; 0 or the abort code.
  std::uint32_t write(std::uint16_t index, unsigned sub, std::uint32_t value, unsigned size) {
    const auto answer = sdo({0x23 | (4 - size) << 2, index & 0xFFU, unsigned{index} >> 8, sub, value & 0xFF,
                             value >> 8 & 0xFF, value >> 16 & 0xFF, value >> 24});
    return answer.at(0) == 0x80 ? number(answer, 4) : 0;
  }
  std::uint32_t write_real(std::uint16_t index, unsigned sub, float value) {
    return write(index, sub, std::bit_cast<std::uint32_t>(value), 4);
  }
  /// Writes these values; fails the test if the drive refuses one.
  void set(const std::vector<ObjectValue>& values) {
    for (const auto& [index, sub, value, size] : values) {
      EXPECT_EQ(write(index, sub, value, size), 0U) << std::hex << index << ':' << sub;
    }
  }
  /// Expedited upload; fails the test if it is aborted.
  std::uint32_t read(std::uint16_t index, unsigned sub = 0) {
    const auto answer = sdo({0x40, index & 0xFFU, unsigned{index} >> 8, sub, 0, 0, 0, 0});
    EXPECT_NE(answer.at(0), 0x80U) << std::hex << index << ':' << sub << " abort " << number(answer, 4);
    return number(answer, 4);
  }
  static std::uint32_t number(const std::vector<unsigned>& bytes, std::size_t at) {
    return bytes.at(at) | bytes.at(at + 1) << 8 | bytes.at(at + 2) << 16 | bytes.at(at + 3) << 24;
  }
  void fetch_emergencies() { receive(); }

  /// Power-cycles the drive, and takes it to PREOP, where it has a mailbox.
  void restart() {
    device.restart();
    EXPECT_EQ(to(AlState::kInit, AlState::kPreOp), AlStatusCode::kNoError);
  }

  void map(std::uint16_t pdo, const std::vector<std::uint32_t>& entries) {
    ASSERT_EQ(write(pdo, 0, 0, 1), 0U);
    for (unsigned i = 0; i < entries.size(); ++i) ASSERT_EQ(write(pdo, i + 1, entries[i], 4), 0U);
    ASSERT_EQ(write(pdo, 0, static_cast<std::uint32_t>(entries.size()), 1), 0U);
  }
  /// Maps the layout above, sets a cycle of 125 us and goes to OP.
  void operate(unsigned cycle_us = 125) {
    map(0x1600, {0x60400010, 0x60600008, 0x28070008, 0x607A0020});
    map(0x1601, {0x60FF0020, 0x60710010, 0x60B20010});
    map(0x1602, {0x60B10020});
    map(0x1A00, {0x60410010, 0x60610008, 0x28070008, 0x60640020});
    map(0x1A01, {0x606C0020, 0x60770010, 0x603F0010});
    map(0x1A02, {0x60F40020});
    ASSERT_EQ(write(0x60C2, 1, cycle_us % 1000 == 0 ? cycle_us / 1000 : cycle_us, 1), 0U);
    ASSERT_EQ(write(0x60C2, 2, cycle_us % 1000 == 0 ? 0xFD : 0xFA, 1), 0U);
    ASSERT_EQ(write_real(0x2132, 0, static_cast<float>(cycle_us) * 1e-3F), 0U);
    ASSERT_EQ(device.process_data_size(2), 20U);
    ASSERT_EQ(to(AlState::kPreOp, AlState::kSafeOp), AlStatusCode::kNoError);
    ASSERT_EQ(to(AlState::kSafeOp, AlState::kOp), AlStatusCode::kNoError);
    cycle_ = std::chrono::microseconds(cycle_us);
    cycle();
  }

  /// Runs a bus cycle: outputs, time, inputs.
  void cycle() { cycle(cycle_); }
  void cycle(std::chrono::nanoseconds time) {
    std::array<std::byte, 20> out{};
    const std::span bytes(out);
    bytes::store_le(bytes, control);
    bytes::store_le(bytes.subspan(2), mode);
    bytes::store_le(bytes.subspan(4), target_position);
    bytes::store_le(bytes.subspan(8), target_velocity);
    bytes::store_le(bytes.subspan(12), target_torque);
    bytes::store_le(bytes.subspan(14), torque_offset);
    bytes::store_le(bytes.subspan(16), velocity_offset);
    device.write_outputs(2, out);
    pass(time);
  }
  void cycles(int count) {
    for (int i = 0; i < count; ++i) cycle();
  }
  /// Sends this control word for `count` cycles.
  void command(std::uint16_t word, int count = 1) {
    control = word;
    cycles(count);
  }
  /// Sends this target velocity for `count` cycles.
  void turn(std::int32_t velocity_units, int count) {
    target_velocity = velocity_units;
    cycles(count);
  }
  /// Advances the time without a bus.
  void pass(std::chrono::nanoseconds time) {
    now += time;
    device.advance(now);
    std::array<std::byte, 20> in{};
    device.read_inputs(3, in);
    const std::span<const std::byte> bytes(in);
    status = bytes::load_le<std::uint16_t>(bytes);
    mode_display = bytes::load_le<std::int8_t>(bytes.subspan(2));
    position = bytes::load_le<std::int32_t>(bytes.subspan(4));
    velocity = bytes::load_le<std::int32_t>(bytes.subspan(8));
    torque = bytes::load_le<std::int16_t>(bytes.subspan(12));
    error_code = bytes::load_le<std::uint16_t>(bytes.subspan(14));
    following_error = bytes::load_le<std::int32_t>(bytes.subspan(16));
  }
  /// Enables operation in this mode, with the target position at the actual one.
  void enable(std::int8_t operation_mode) {
    mode = operation_mode;
    control = 0x00;
    cycles(2);
    target_position = position;
    for (const std::uint16_t word : {std::uint16_t{0x06}, std::uint16_t{0x07}, std::uint16_t{0x0F}}) command(word, 2);
    ASSERT_EQ(drive.state(), PowerState::kOperationEnabled);
  }
  /// Goes to OP and enables operation.
  void start(std::int8_t operation_mode, unsigned cycle_us = 125) {
    operate(cycle_us);
    enable(operation_mode);
  }
  /// Runs at a constant speed of this many increments per second (mode 9).
  void run_at(std::int32_t increments_s) {
    enable(9);
    target_velocity = increments_s;
    cycles(1600);
    ASSERT_NEAR(velocity, increments_s, 2000);
  }

  MsdDrive device;  ///< interface of the drive to the bus
  DriveCore& drive = device.core();
  AlState state = AlState::kInit;
  std::chrono::nanoseconds now{1'000'000'000};
  std::uint16_t control = 0;
  std::int8_t mode = 0;
  std::int32_t target_position = 0;
  std::int32_t target_velocity = 0;
  std::int16_t target_torque = 0;
  std::int16_t torque_offset = 0;
  std::int32_t velocity_offset = 0;
  std::uint16_t status = 0;
  std::int8_t mode_display = 0;
  std::int32_t position = 0;
  std::int32_t velocity = 0;
  std::int16_t torque = 0;
  std::uint16_t error_code = 0;
  std::int32_t following_error = 0;
  std::vector<std::vector<unsigned>> emergencies;

 private:
  std::chrono::nanoseconds cycle_ = 125us;
  unsigned counter_ = 0;
};

/// A rig in OP.
struct OperatingRig : DriveRig {
  explicit OperatingRig(unsigned cycle_us = 125) { operate(cycle_us); }
  explicit OperatingRig(const MsdParameters& parameters, unsigned cycle_us = 125) : DriveRig(parameters) {
    operate(cycle_us);
  }
};

/// A rig in OP with operation enabled in a mode.
struct EnabledRig : DriveRig {
  explicit EnabledRig(std::int8_t operation_mode, unsigned cycle_us = 125) { start(operation_mode, cycle_us); }
  EnabledRig(const MsdParameters& parameters, std::int8_t operation_mode, unsigned cycle_us = 125)
      : DriveRig(parameters) {
    start(operation_mode, cycle_us);
  }
};

}  // namespace driveline::slaves::msd
