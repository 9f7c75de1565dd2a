// Malformed frames of all kinds through a line of a drive, a mixed device and two terminals. Input: consecutive pieces;
// the slaves keep their state in between, and time advances. A piece is a frame after its length in two bytes or, with
// bit 15 of these set, a well-formed access to registers: a fuzzer that had to guess whole frames would not find errors
// deep inside a slave.

#include <memory>

#include "driveline/esi/sii.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "driveline/slaves/line/simulated_line.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/wire/al.hpp"
#include "driveline/wire/frame.hpp"
#include "driveline/wire/registers.hpp"
#include "fuzz_seeds.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {
namespace {

std::unique_ptr<slaves::SimulatedLine> make_line(rt::Clock& clock) {
  using slaves::generic::DeviceModel;
  struct Model {
    std::shared_ptr<const DeviceModel> device;
    slaves::generic::GenericOptions options;
  };
  // Creating an EEPROM image takes longer than many frames.
  static const auto kModels = [] {
    std::vector<Model> models;
    for (const char* name : {"MX4", "DO4", "DI8"}) {
      const auto description = example_device(name);
      auto& model = models.emplace_back(Model{DeviceModel::create(description).value(), {}});
      model.options.sii_image = esi::encode_sii(esi::make_sii(description));
    }
    return models;
  }();
  // Clocks as exact as that of the line would hide errors.
  slaves::SlaveOptions own;
  own.clock.drift_ppm = 50.0;
  own.clock.temperature_ppm_per_s = 1.0;
  own.clock.temperature_span_ppm = 5.0;
  std::vector<std::unique_ptr<slaves::Slave>> line;
  line.push_back(std::make_unique<slaves::Slave>(std::make_unique<slaves::msd::MsdDrive>(), own));
  own.clock.drift_ppm = -50.0;
  for (const auto& [device, options] : kModels) {
    line.push_back(
        std::make_unique<slaves::Slave>(std::make_unique<slaves::generic::GenericDevice>(device, options), own));
  }
  return std::make_unique<slaves::SimulatedLine>(clock, std::move(line));
}

void append_frame(Bytes& input, std::span<const std::byte> frame) {
  const auto length = bytes::to_le_bytes(static_cast<std::uint16_t>(frame.size()));
  input.insert(input.end(), length.begin(), length.end());
  input.insert(input.end(), frame.begin(), frame.end());
}

void append_write(Bytes& input, std::uint16_t address, std::span<const std::byte> data) {
  std::array<std::byte, 512> buffer{};
  wire::FrameBuilder builder(buffer, {});
  const auto place = builder.add(wire::Command::kBwr, 0, wire::DatagramAddress::physical(0, address), data.size());
  std::copy(data.begin(), data.end(), builder.data(*place).begin());
  append_frame(input, builder.finish());
}

/// All commands on a register and on the process data memory.
Bytes all_commands() {
  Bytes input;
  for (std::uint8_t command = 0; command <= 15; ++command) {
    for (const std::uint16_t address : {std::uint16_t{0x0130}, std::uint16_t{0x0502}, std::uint16_t{0x1000}}) {
      std::array<std::byte, 128> buffer{};
      wire::FrameBuilder builder(buffer, {});
      builder.add(static_cast<wire::Command>(command), command, wire::DatagramAddress::physical(0, address), 16);
      builder.add(wire::Command::kLrw, command, wire::DatagramAddress::logical(0), 32);
      append_frame(input, builder.finish());
    }
  }
  return input;
}

/// To PREOP with mailboxes, and an SDO upload.
Bytes mailbox_start() {
  Bytes input;
  constexpr std::array<std::uint8_t, 16> kManagers{0x00, 0x10, 0x00, 0x02, 0x26, 0, 1, 0,
                                                   0x00, 0x12, 0x00, 0x02, 0x22, 0, 1, 0};
  append_write(input, wire::reg::kSyncManager.address, std::as_bytes(std::span(kManagers)));
  append_write(input, wire::reg::kAlControl.address, bytes::to_le_bytes<std::uint16_t>(2));
  constexpr std::array<std::uint8_t, 16> kUpload{10, 0, 0, 0, 0, 0x13, 0, 0x20, 0x40, 0x18, 0x10, 1, 0, 0, 0, 0};
  append_write(input, 0x1000, std::as_bytes(std::span(kUpload)));
  append_write(input, 0x11FF, bytes::to_le_bytes<std::uint8_t>(0));
  return input;
}

/// A register access: 11 bytes.
///   0, 1   bits 0-12 address, bits 13-14 how the value counts, bit 15 set
///   2      bits 0-3 command, bits 4-7 its length in bytes
///   3-10   value
enum class Value : std::uint8_t {
  kPlain,
  kAheadOfTheClock,  ///< added to the first slave's system time
  /// That time plus a power of two (bits 0-5 of the value) minus the rest (bits 8-63); with bit 6: minus the power,
  /// plus the rest. Tests the edges of any range.
  kEdgeOfTheClock,
  kTimePasses,  ///< no access: this number of nanoseconds, at most 50 ms
};
constexpr std::size_t kAccessBytes = 11;
constexpr std::uint16_t kAccessFlag = 0x8000;
constexpr std::uint16_t kAddressMask = 0x1FFF;
constexpr unsigned kValueShift = 13;

void append_access(Bytes& input, wire::Command command, std::uint16_t address, std::size_t length, std::uint64_t value,
                   Value kind = Value::kPlain) {
  const auto head = bytes::to_le_bytes(
      static_cast<std::uint16_t>(kAccessFlag | address | static_cast<unsigned>(kind) << kValueShift));
  const auto bytes = bytes::to_le_bytes(value);
  input.insert(input.end(), head.begin(), head.end());
  input.push_back(static_cast<std::byte>(static_cast<unsigned>(command) | length << 4));
  input.insert(input.end(), bytes.begin(), bytes.end());
}

/// SYNC0 and SYNC1 of all slaves set up as by a master, reference times, time in between; then a start time at the edge
/// of the clock's range.
Bytes clock_set_up() {
  Bytes input;
  const auto write = [&input](const auto& r, std::uint64_t value, Value kind = Value::kPlain) {
    append_access(input, wire::Command::kBwr, r.address, sizeof(r.reset), value, kind);
  };
  const auto pass = [&input](std::uint64_t time) {
    append_access(input, wire::Command::kNop, 0, 0, time, Value::kTimePasses);
  };
  namespace reg = wire::reg;
  write(reg::kReceiveTimePort, 0);
  write(reg::kSystemTimeOffset, 1'000'000);
  write(reg::kSystemTimeDelay, 500);
  write(reg::kSpeedCounterStart, 0x1000);
  for (int i = 0; i < 4; ++i) {
    append_access(input, wire::Command::kBwr, reg::kSystemTime.address, 4, 0, Value::kAheadOfTheClock);
    pass(125'000);
  }
  write(reg::kSync0CycleTime, 125'000);
  write(reg::kSync1CycleTime, 125'000);
  write(reg::kStartTimeCyclic, 1'000'000, Value::kAheadOfTheClock);
  write(reg::kDcActivation, 0x07);
  pass(2'000'000);
  for (const std::uint64_t edge : {std::uint64_t{62}, 63 | std::uint64_t{1} << 38}) {
    write(reg::kDcActivation, 0x00);
    write(reg::kStartTimeCyclic, edge, Value::kEdgeOfTheClock);
    write(reg::kDcActivation, 0x03);
    pass(125'000);
  }
  return input;
}

/// The execution of an input on a line.
class FrameRun {
 public:
  void run(std::span<const std::byte> input) {
    while (input.size() >= 2) {
      const auto head = bytes::load_le<std::uint16_t>(input);
      if ((head & kAccessFlag) != 0) {
        const auto size = std::min(kAccessBytes, input.size());
        std::array<std::byte, kAccessBytes> piece{};
        std::copy_n(input.begin(), size, piece.begin());
        input = input.subspan(size);
        access(head, piece);
        continue;
      }
      const std::size_t length = std::min<std::size_t>(head, input.size() - 2);
      exchange(Bytes(input.begin() + 2, input.begin() + 2 + static_cast<std::ptrdiff_t>(length)));
      input = input.subspan(2 + length);
    }
  }

 private:
  void access(std::uint16_t head, std::span<const std::byte> piece) {
    const auto kind = static_cast<Value>(head >> kValueShift & 3U);
    const auto what = std::to_integer<unsigned>(piece[2]);
    const auto value = bytes::load_le<std::uint64_t>(piece.subspan(3));
    if (kind == Value::kTimePasses) {
      clock_.advance(std::chrono::nanoseconds{value % 50'000'000});
      line_->advance(clock_.now());
      return check_clocks();
    }
    std::array<std::byte, 128> buffer{};
    wire::FrameBuilder builder(buffer, {});
    const auto address = static_cast<std::uint16_t>(head & kAddressMask);
    const auto place = builder.add(static_cast<wire::Command>(what & 0xFU), 0,
                                   wire::DatagramAddress::physical(0, address), std::clamp(what >> 4, 1U, 8U));
    const auto bytes = bytes::to_le_bytes(meant(kind, value));
    const auto data = builder.data(*place);
    std::copy_n(bytes.begin(), data.size(), data.begin());
    const auto frame = builder.finish();
    exchange(Bytes(frame.begin(), frame.end()));
  }

  [[nodiscard]] std::uint64_t meant(Value kind, std::uint64_t value) const {
    const auto time = static_cast<std::uint64_t>(line_->slave(0).esc().clock().system_time(clock_.now()).count());
    if (kind == Value::kAheadOfTheClock) return time + value;
    if (kind != Value::kEdgeOfTheClock) return value;
    const auto power = std::uint64_t{1} << value % 64;
    const auto rest = value >> 8;
    return (value & 0x40) != 0 ? time - power + rest : time + power - rest;
  }

  void exchange(Bytes frame) {
    clock_.advance(std::chrono::microseconds{125});
    const auto size = frame.size();
    static_cast<void>(line_->process(frame, clock_.now()));
    if (frame.size() != size) std::abort();
    if (line_->send(frame) == port::SendStatus::kSent) {
      clock_.advance(std::chrono::microseconds{50});
      if (const auto answer = line_->receive(); answer && answer->bytes.size() != size) std::abort();
    }
    check_clocks();
  }

  /// Whatever the register values, a due pulse comes at its time, and time advances.
  void check_clocks() const {
    for (std::size_t i = 0; i < line_->size(); ++i) {
      const auto& clock = line_->slave(i).esc().clock();
      const auto next = clock.sync().next();
      const auto due = clock.sync_due();
      if (!next || due == slaves::DistributedClock::kNever) continue;
      const auto behind = [&](std::chrono::nanoseconds time) {
        return static_cast<std::int64_t>(static_cast<std::uint64_t>(clock.system_time(time).count()) - *next);
      };
      if (behind(due) < 0 || behind(due - std::chrono::nanoseconds{1}) >= 0) std::abort();
    }
  }

  rt::VirtualClock clock_;
  std::unique_ptr<slaves::SimulatedLine> line_ = make_line(clock_);
};

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  FrameRun().run(input);
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> inputs = recorded_frames();
  inputs.push_back(all_commands());
  inputs.push_back(mailbox_start());
  inputs.push_back(clock_set_up());
  return inputs;
}

}  // namespace driveline::fuzz
