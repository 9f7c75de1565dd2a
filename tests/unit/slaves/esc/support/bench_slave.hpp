#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <initializer_list>
#include <memory>
#include <vector>

#include "driveline/slaves/esc/slave.hpp"
#include "driveline/wire/fmmu.hpp"
#include "driveline/wire/registers.hpp"
#include "driveline/wire/sync_manager.hpp"
#include "test_device.hpp"

namespace driveline::slaves::test {

using wire::AlState;
using wire::AlStatusCode;
using wire::Command;
namespace reg = wire::reg;

inline std::vector<std::byte> bytes(std::initializer_list<unsigned> values) {
  std::vector<std::byte> result;
  for (const auto value : values) result.push_back(static_cast<std::byte>(value));
  return result;
}

/// A single slave: the test sends each datagram and advances the time.
class BenchSlave : public ::testing::Test {
 protected:
  static constexpr std::uint16_t kStation = 0x1001;

  /// Rebuilds the slave after the test has changed `device` and `options`.
  explicit BenchSlave(const SlaveOptions& options = {}) { rebuild(options); }

  void rebuild(const SlaveOptions& options = {}, std::unique_ptr<TestDevice> device = nullptr) {
    if (!device) device = std::make_unique<TestDevice>();
    device_ = device.get();
    slave_ = std::make_unique<Slave>(std::move(device), options);
    slave_->advance(now_);
  }

  Slave& slave() { return *slave_; }
  Esc& esc() { return slave_->esc(); }
  TestDevice& device() { return *device_; }

  struct Answer {
    std::vector<std::byte> data;
    std::uint16_t working_counter = 0;
    std::uint16_t adp = 0;
    std::uint16_t irq = 0;
  };

  /// Sends a datagram to the slave. Time does not advance, and the firmware does not run.
  Answer transfer(Command command, std::uint16_t adp, std::uint16_t ado, std::vector<std::byte> data) {
    Datagram datagram;
    datagram.command = command;
    datagram.adp = adp;
    datagram.ado = ado;
    datagram.data = data;
    esc().begin_frame(++serial_);
    esc().process(datagram, now_);
    return {std::move(data), datagram.working_counter, datagram.adp, datagram.irq};
  }
  Answer logical(Command command, std::uint32_t address, std::vector<std::byte> data) {
    return transfer(command, static_cast<std::uint16_t>(address & 0xFFFF), static_cast<std::uint16_t>(address >> 16),
                    std::move(data));
  }
  /// Reads `length` bytes at `address`; the data are initialised with 0xEE.
  Answer read(std::uint16_t address, std::size_t length) {
    return transfer(Command::kAprd, 0, address, std::vector<std::byte>(length, std::byte{0xEE}));
  }
  std::uint16_t write(std::uint16_t address, std::vector<std::byte> data) {
    return transfer(Command::kApwr, 0, address, std::move(data)).working_counter;
  }
  template <typename T>
  std::uint16_t write(const wire::Register<T>& r, std::type_identity_t<T> value, unsigned n = 0) {
    const auto raw = bytes::to_le_bytes(value);
    return write(r.at(n), std::vector<std::byte>(raw.begin(), raw.end()));
  }
  template <typename T>
  T get(const wire::Register<T>& r, unsigned n = 0) {
    const auto answer = read(r.at(n), sizeof(T));
    EXPECT_EQ(answer.working_counter, 1);
    return bytes::load_le<T>(answer.data);
  }

  /// Advances the time; the slave continues to run.
  void pass(std::chrono::nanoseconds time) {
    now_ += time;
    slave_->advance(now_);
  }
  std::chrono::nanoseconds now() const { return now_; }

  std::uint16_t set_sync_manager(unsigned n, const wire::SyncManagerChannel& channel) {
    std::vector<std::byte> raw(wire::SyncManagerChannel::kSize);
    channel.encode(std::span(raw).first<wire::SyncManagerChannel::kSize>());
    return write(static_cast<std::uint16_t>(reg::kSyncManager.address + 8 * n), raw);
  }
  std::uint16_t set_fmmu(unsigned n, const wire::FmmuEntity& entity) {
    std::vector<std::byte> raw(wire::FmmuEntity::kSize);
    entity.encode(std::span(raw).first<wire::FmmuEntity::kSize>());
    return write(static_cast<std::uint16_t>(reg::kFmmu.address + 16 * n), raw);
  }
  std::uint8_t sync_manager_status(unsigned n) {
    return std::to_integer<std::uint8_t>(read(static_cast<std::uint16_t>(0x0805 + 8 * n), 1).data[0]);
  }

  static wire::SyncManagerChannel mailbox_out() { return {kMailboxOutAddress, kMailboxLength, 0x26, 0, 1, 0}; }
  static wire::SyncManagerChannel mailbox_in() { return {kMailboxInAddress, kMailboxLength, 0x22, 0, 1, 0}; }
  static wire::SyncManagerChannel outputs(std::uint16_t length = 4) { return {kOutputsAddress, length, 0x64, 0, 1, 0}; }
  static wire::SyncManagerChannel inputs(std::uint16_t length = 6) { return {kInputsAddress, length, 0x20, 0, 1, 0}; }

  void configure_mailboxes() {
    set_sync_manager(0, mailbox_out());
    set_sync_manager(1, mailbox_in());
  }
  void configure_process_data() {
    set_sync_manager(2, outputs());
    set_sync_manager(3, inputs());
  }

  /// Requests a state and lets the firmware react.
  void request(AlState state, bool acknowledge = false, bool id = false) {
    write(reg::kAlControl, wire::AlControl{state, acknowledge, id}.raw());
    slave_->advance(now_);
  }
  wire::AlStatus status() { return wire::AlStatus::from_raw(get(reg::kAlStatus)); }
  AlStatusCode code() { return static_cast<AlStatusCode>(get(reg::kAlStatusCode)); }
  void expect_status(AlState state, AlStatusCode expected_code = AlStatusCode::kNoError) {
    EXPECT_EQ(to_text(status().state), to_text(state));
    EXPECT_EQ(status().error, expected_code != AlStatusCode::kNoError);
    EXPECT_EQ(code(), expected_code);
  }
  /// Requests a state and expects the status that follows.
  void expect_request(AlState asked, AlState then, AlStatusCode expected_code = AlStatusCode::kNoError) {
    request(asked);
    expect_status(then, expected_code);
  }
  /// The same with the acknowledgement of an error.
  void expect_acknowledged(AlState asked, AlState then, AlStatusCode expected_code = AlStatusCode::kNoError) {
    request(asked, true);
    expect_status(then, expected_code);
  }

  void write_outputs(std::vector<std::byte> data) { EXPECT_EQ(write(kOutputsAddress, std::move(data)), 1); }

  void go_to(AlState state) {
    if (state == AlState::kInit) return;
    configure_mailboxes();
    request(AlState::kPreOp);
    if (state == AlState::kPreOp) return;
    configure_process_data();
    request(AlState::kSafeOp);
    if (state == AlState::kSafeOp) return;
    write_outputs(bytes({1, 2, 3, 4}));
    request(AlState::kOp);
    expect_status(AlState::kOp);
  }

 private:
  std::chrono::nanoseconds now_ = 1s;
  std::uint64_t serial_ = 0;
  std::unique_ptr<Slave> slave_;
  TestDevice* device_ = nullptr;
};

}  // namespace driveline::slaves::test
