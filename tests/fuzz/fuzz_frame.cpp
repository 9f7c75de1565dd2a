// Frames of every kind of malformation through a line of a drive, a mixed device and two terminals. Input: frames one
// after the other, each with its length in two bytes in front; the slaves keep their state in between, and time goes
// on.

#include <memory>

#include "driveline/rt/clock.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "driveline/slaves/line/line.hpp"
#include "driveline/slaves/msd/msd_drive.hpp"
#include "driveline/wire/al.hpp"
#include "driveline/wire/frame.hpp"
#include "driveline/wire/registers.hpp"
#include "fuzz_seeds.hpp"
#include "fuzz_target.hpp"

namespace driveline::fuzz {
namespace {

std::unique_ptr<slaves::Line> make_line(rt::Clock& clock) {
  using slaves::generic::DeviceModel;
  static const std::array kModels = {DeviceModel::create(example_device("MX4")).value(),
                                     DeviceModel::create(example_device("DO4")).value(),
                                     DeviceModel::create(example_device("DI8")).value()};
  std::vector<std::unique_ptr<slaves::Slave>> line;
  line.push_back(std::make_unique<slaves::Slave>(std::make_unique<slaves::msd::MsdDrive>()));
  for (const auto& model : kModels) {
    line.push_back(std::make_unique<slaves::Slave>(
        std::make_unique<slaves::generic::GenericDevice>(model, slaves::generic::GenericOptions{})));
  }
  return std::make_unique<slaves::Line>(clock, std::move(line));
}

void append_frame(Bytes& input, std::span<const std::byte> frame) {
  const auto length = wire::to_le_bytes(static_cast<std::uint16_t>(frame.size()));
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
  append_write(input, wire::reg::kAlControl.address, wire::to_le_bytes<std::uint16_t>(2));
  constexpr std::array<std::uint8_t, 16> kUpload{10, 0, 0, 0, 0, 0x13, 0, 0x20, 0x40, 0x18, 0x10, 1, 0, 0, 0, 0};
  append_write(input, 0x1000, std::as_bytes(std::span(kUpload)));
  append_write(input, 0x11FF, wire::to_le_bytes<std::uint8_t>(0));
  return input;
}

}  // namespace

void test_one_input(std::span<const std::byte> input) {
  rt::VirtualClock clock;
  const auto line = make_line(clock);
  while (input.size() >= 2) {
    const std::size_t length = std::min<std::size_t>(wire::load_le<std::uint16_t>(input), input.size() - 2);
    Bytes frame(input.begin() + 2, input.begin() + 2 + static_cast<std::ptrdiff_t>(length));
    input = input.subspan(2 + length);
    clock.advance(std::chrono::microseconds{125});
    const auto size = frame.size();
    static_cast<void>(line->process(frame, clock.now()));
    if (frame.size() != size) std::abort();
    if (line->send(frame) == port::SendStatus::kSent) {
      clock.advance(std::chrono::microseconds{50});
      if (const auto answer = line->receive(); answer && answer->bytes.size() != size) std::abort();
    }
  }
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> inputs = recorded_frames();
  inputs.push_back(all_commands());
  inputs.push_back(mailbox_start());
  return inputs;
}

}  // namespace driveline::fuzz
