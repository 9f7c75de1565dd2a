#pragma once

#include <gmock/gmock.h>

#include <fstream>
#include <initializer_list>
#include <iterator>
#include <memory>

#include "driveline/esi/esi_file.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/slaves/esc/slave.hpp"
#include "driveline/slaves/generic/generic_device.hpp"
#include "driveline/wire/fmmu.hpp"
#include "driveline/wire/registers.hpp"
#include "driveline/wire/sync_manager.hpp"

namespace driveline::slaves::generic {

using namespace std::chrono_literals;
using wire::AlState;
using wire::AlStatusCode;
using Use = esi::SyncManager::Use;

inline std::vector<std::byte> bytes(std::initializer_list<unsigned> values) {
  std::vector<std::byte> result;
  for (const auto value : values) result.push_back(static_cast<std::byte>(value));
  return result;
}

/// The example devices; tests run in the top folder of the project.
inline const esi::EsiFile& example_devices() {
  static const esi::EsiFile kFile = [] {
    std::ifstream stream("examples/terminals.xml", std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    auto file = esi::read_esi(text, "examples/terminals.xml");
    EXPECT_TRUE(file) << esi::to_text(file.error());
    return file.value_or(esi::EsiFile{});
  }();
  return kFile;
}

inline esi::DeviceDescription example(const std::string& name) {
  const auto device = example_devices().choose({name, {}, {}});
  EXPECT_TRUE(device) << describe(device.error());
  return device ? **device : esi::DeviceDescription{};
}

inline std::shared_ptr<const DeviceModel> model_of(const esi::DeviceDescription& description) {
  auto model = DeviceModel::create(description);
  EXPECT_TRUE(model) << describe(model.error());
  return model.value_or(nullptr);
}

inline ScriptedInput script(const DeviceModel& model, std::string_view input, const Signal& signal) {
  const auto row = model.find_input(input);
  EXPECT_TRUE(row) << describe(row.error());
  return {row.value_or(nullptr), signal};
}

/// A device behind its slave controller, driven by single datagrams. The bench knows it only through its EEPROM.
/// Process data go through FMMUs that map outputs and inputs of all sync managers to the same logical bytes.
class DeviceBench {
 public:
  explicit DeviceBench(const esi::DeviceDescription& description, const GenericOptions& options = {})
      : DeviceBench(model_of(description), options) {}
  DeviceBench(std::shared_ptr<const DeviceModel> model, const GenericOptions& options) {
    auto device = std::make_unique<GenericDevice>(std::move(model), options);
    device_ = device.get();
    slave_ = std::make_unique<Slave>(std::move(device));
    slave_->advance(now_);
    auto image = esi::decode_sii(device_->profile().sii_image);
    EXPECT_TRUE(image) << esi::to_text(image.error());
    description_ = esi::description_from_sii(image.value_or(esi::SiiImage{}));
  }

  GenericDevice& device() { return *device_; }
  Slave& slave() { return *slave_; }
  const esi::DeviceDescription& description() const { return description_; }

  void pass(std::chrono::nanoseconds time) {
    now_ += time;
    slave_->advance(now_);
  }
  std::uint16_t transfer(wire::Command command, std::uint32_t address, std::vector<std::byte>& data) {
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
  std::uint16_t write(std::uint16_t address, std::vector<std::byte> data) {
    return transfer(wire::Command::kApwr, std::uint32_t{address} << 16, data);
  }
  std::vector<std::byte> read(std::uint16_t address, std::size_t length) {
    std::vector<std::byte> data(length);
    EXPECT_EQ(transfer(wire::Command::kAprd, std::uint32_t{address} << 16, data), 1) << address;
    return data;
  }
  /// Exchanges outputs for inputs with an LRW and lets the device run a step; expects the working counter.
  std::vector<std::byte> exchange(std::vector<std::byte> data, unsigned working_counter) {
    data.resize(std::max(output_bytes_, input_bytes_));
    EXPECT_EQ(transfer(wire::Command::kLrw, kLogical, data), working_counter);
    pass(device_->process_data_period());
    return data;
  }

  void request(AlState state) {
    const auto raw = bytes::to_le_bytes(wire::AlControl{state, false, false}.raw());
    write(wire::reg::kAlControl.address, {raw.begin(), raw.end()});
  }
  wire::AlStatus status() {
    return wire::AlStatus::from_raw(bytes::load_le<std::uint16_t>(read(wire::reg::kAlStatus.address, 2)));
  }
  AlStatusCode code() {
    return static_cast<AlStatusCode>(bytes::load_le<std::uint16_t>(read(wire::reg::kAlStatusCode.address, 2)));
  }
  ::testing::AssertionResult is_in(AlState state) {
    const auto now = status();
    if (now.state == state && !now.error) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << to_text(now.state) << ", AL status code " << to_text(code());
  }

  void set_sync_manager(std::size_t number, std::uint16_t length) {
    const auto& manager = description_.sync_managers.at(number);
    wire::SyncManagerChannel channel;
    channel.start_address = manager.start_address;
    channel.length = length;
    channel.control = manager.control;
    channel.activate = length > 0 ? 1 : 0;
    std::vector<std::byte> raw(wire::SyncManagerChannel::kSize);
    channel.encode(std::span(raw).first<wire::SyncManagerChannel::kSize>());
    EXPECT_EQ(write(static_cast<std::uint16_t>(wire::reg::kSyncManager.at(static_cast<unsigned>(number))), raw), 1);
  }
  void enter_pre_op() {
    for (std::size_t n = 0; n < description_.sync_managers.size(); ++n) {
      const auto& manager = description_.sync_managers[n];
      if (manager.use == Use::kMailboxOut || manager.use == Use::kMailboxIn) set_sync_manager(n, manager.default_size);
    }
    request(AlState::kPreOp);
  }
  /// Configures the sync managers with the lengths that the device requires, and their FMMUs.
  void map_process_data() {
    output_bytes_ = input_bytes_ = 0;
    unsigned fmmu = 0;
    for (std::size_t n = 0; n < description_.sync_managers.size(); ++n) {
      const auto& manager = description_.sync_managers[n];
      if (manager.use != Use::kOutputs && manager.use != Use::kInputs) continue;
      const auto size = device_->process_data_size(n);
      set_sync_manager(n, static_cast<std::uint16_t>(size));
      auto& total = manager.use == Use::kOutputs ? output_bytes_ : input_bytes_;
      if (size > 0) {
        map(fmmu++, total, manager, size);
      }
      total += size;
    }
  }
  void go_to_op() {
    enter_pre_op();
    ASSERT_TRUE(is_in(AlState::kPreOp));
    map_process_data();
    request(AlState::kSafeOp);
    ASSERT_TRUE(is_in(AlState::kSafeOp));
    std::vector<std::byte> outputs(std::max(output_bytes_, input_bytes_));
    if (!outputs.empty()) transfer(wire::Command::kLrw, kLogical, outputs);
    request(AlState::kOp);
    pass(device_->process_data_period());
    ASSERT_TRUE(is_in(AlState::kOp));
  }
  std::size_t output_bytes() const { return output_bytes_; }
  std::size_t input_bytes() const { return input_bytes_; }

  /// Sends CoE service data in a mailbox message; returns the service data of the answer.
  std::vector<unsigned> coe(const std::vector<unsigned>& data) {
    const auto& out = description_.sync_managers.at(0);
    const auto& in = description_.sync_managers.at(1);
    std::vector<std::byte> mailbox(out.default_size);
    counter_ = counter_ % 7 + 1;
    mailbox[0] = static_cast<std::byte>(data.size());
    mailbox[5] = static_cast<std::byte>(0x03 | counter_ << 4);
    std::transform(data.begin(), data.end(), mailbox.begin() + 6, [](unsigned v) { return static_cast<std::byte>(v); });
    EXPECT_EQ(write(out.start_address, mailbox), 1);
    const auto answer = read(in.start_address, in.default_size);
    std::vector<unsigned> result;
    for (std::size_t i = 0; i < bytes::load_le<std::uint16_t>(answer); ++i) {
      result.push_back(std::to_integer<unsigned>(answer.at(6 + i)));
    }
    return result;
  }
  /// SDO request and answer without their CoE headers.
  std::vector<unsigned> sdo(std::initializer_list<unsigned> request) {
    std::vector<unsigned> with_header = {0x00, 0x20};
    with_header.insert(with_header.end(), request);
    auto answer = coe(with_header);
    if (answer.size() >= 2) answer.erase(answer.begin(), answer.begin() + 2);
    return answer;
  }

 private:
  static constexpr std::uint32_t kLogical = 0x10000;

  void map(unsigned number, std::size_t offset, const esi::SyncManager& manager, std::size_t size) {
    wire::FmmuEntity fmmu;
    fmmu.logical_start = kLogical + static_cast<std::uint32_t>(offset);
    fmmu.length = static_cast<std::uint16_t>(size);
    fmmu.physical_start = manager.start_address;
    fmmu.type = manager.use == Use::kOutputs ? wire::FmmuEntity::kTypeWrite : wire::FmmuEntity::kTypeRead;
    fmmu.active = true;
    std::vector<std::byte> raw(wire::FmmuEntity::kSize);
    fmmu.encode(std::span(raw).first<wire::FmmuEntity::kSize>());
    EXPECT_EQ(write(wire::reg::kFmmu.at(number), raw), 1);
  }

  std::chrono::nanoseconds now_ = 1s;
  std::uint64_t serial_ = 0;
  unsigned counter_ = 0;
  std::unique_ptr<Slave> slave_;
  GenericDevice* device_ = nullptr;
  esi::DeviceDescription description_;
  std::size_t output_bytes_ = 0;
  std::size_t input_bytes_ = 0;
};

}  // namespace driveline::slaves::generic
