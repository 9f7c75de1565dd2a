#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "driveline/bytes/endian.hpp"
#include "driveline/esi/sii.hpp"
#include "driveline/slaves/device.hpp"

namespace driveline::slaves::test {

using namespace std::chrono_literals;

inline constexpr std::uint16_t kMailboxOutAddress = 0x1000;
inline constexpr std::uint16_t kMailboxInAddress = 0x1080;
inline constexpr std::uint16_t kMailboxLength = 0x40;
inline constexpr std::uint16_t kBootOutAddress = 0x1000;
inline constexpr std::uint16_t kBootInAddress = 0x1200;
inline constexpr std::uint16_t kOutputsAddress = 0x1400;
inline constexpr std::uint16_t kInputsAddress = 0x1800;

/// An EEPROM of 128 bytes with a valid configuration area; the words from 8 on count up.
inline std::vector<std::byte> test_image(std::uint16_t pdi_control = 0x0E05, std::uint16_t alias = 0) {
  std::vector<std::byte> image(128);
  for (std::size_t word = 0; word < image.size() / 2; ++word) {
    bytes::store_le(std::span(image).subspan(2 * word), static_cast<std::uint16_t>(word >= 8 ? 0x4000 + word : 0));
  }
  bytes::store_le(std::span(image), pdi_control);
  bytes::store_le(std::span(image).subspan(8), alias);
  image[14] = static_cast<std::byte>(esi::sii_checksum(std::span(image).first<esi::SiiConfigArea::kSize>()));
  image[15] = std::byte{0};
  return image;
}

/// A device that only records what happens to it. It has the four sync managers of a drive; the sizes of its process
/// data can be changed.
class TestDevice final : public Device {
 public:
  struct FallBack {
    wire::AlState from;
    wire::AlState to;
    wire::AlStatusCode reason;
    bool operator==(const FallBack&) const = default;
  };

  TestDevice() {
    using Use = SyncManagerLayout::Use;
    sync0_cycles.reserve(16);
    own_profile.sii_image = test_image();
    own_profile.sync_managers = {
        {Use::kMailboxOut, kMailboxOutAddress, 0x20, 0x80, kMailboxLength},
        {Use::kMailboxIn, kMailboxInAddress, 0x20, 0x80, kMailboxLength},
        {Use::kOutputs, kOutputsAddress, 0, 0, 4},
        {Use::kInputs, kInputsAddress, 0, 0, 6},
    };
  }

  const DeviceProfile& profile() const noexcept override { return own_profile; }
  std::size_t process_data_size(std::size_t sync_manager) const noexcept override {
    return sync_manager < sizes.size() ? sizes[sync_manager] : 0;
  }
  wire::AlStatusCode transition(wire::AlState from, wire::AlState to) noexcept override {
    transitions.emplace_back(from, to);
    return refusal;
  }
  void fall_back(wire::AlState from, wire::AlState to, wire::AlStatusCode reason) noexcept override {
    fall_backs.push_back({from, to, reason});
  }
  void restart() override { ++restarts; }
  void sync_started(std::chrono::nanoseconds sync0_cycle) noexcept override {
    if (sync0_cycles.size() < sync0_cycles.capacity()) sync0_cycles.push_back(sync0_cycle);
  }
  void sync_event(SyncSignal signal, std::chrono::nanoseconds time) noexcept override {
    if (sync_events.size() < sync_events.capacity()) sync_events.emplace_back(signal, time);
  }
  bool firmware_valid() const noexcept override { return firmware_complete; }
  wire::AlStatusCode check_mapping() const noexcept override { return mapping; }
  SyncDemand sync_demand() const noexcept override { return demand; }
  bool inputs_valid() const noexcept override { return sensor_present; }
  void write_outputs(std::size_t sync_manager, std::span<const std::byte> data) noexcept override {
    outputs[sync_manager].assign(data.begin(), data.end());
    ++output_count;
    outputs_at = local_time;
  }
  void read_inputs(std::size_t sync_manager, std::span<std::byte> data) noexcept override {
    const auto& source = inputs[sync_manager];
    for (std::size_t i = 0; i < data.size(); ++i) data[i] = i < source.size() ? source[i] : std::byte{0};
    ++input_count;
  }
  bool takes_mailbox(std::span<const std::byte> /*mailbox*/) const noexcept override { return !mailbox_full; }
  void mailbox_request(std::span<const std::byte> mailbox) override {
    if (echo) {
      echo_length = std::min(mailbox.size(), echo_buffer.size());
      std::copy_n(mailbox.begin(), echo_length, echo_buffer.begin());
      return;
    }
    requests.emplace_back(mailbox.begin(), mailbox.end());
  }
  std::size_t mailbox_reply(std::span<std::byte> out) override {
    if (echo) {
      std::copy_n(echo_buffer.begin(), std::min(echo_length, out.size()), out.begin());
      return std::exchange(echo_length, 0);
    }
    if (replies.empty()) return 0;
    const auto reply = replies.front();
    replies.pop_front();
    std::copy_n(reply.begin(), std::min(reply.size(), out.size()), out.begin());
    return reply.size();
  }
  void advance(std::chrono::nanoseconds now) noexcept override {
    went_back |= now < local_time;
    local_time = now;
    ++advance_count;
  }
  std::chrono::nanoseconds process_data_period() const noexcept override { return 125us; }

  DeviceProfile own_profile;
  std::array<std::size_t, 8> sizes{0, 0, 4, 6};
  wire::AlStatusCode refusal = wire::AlStatusCode::kNoError;
  wire::AlStatusCode mapping = wire::AlStatusCode::kNoError;
  bool firmware_complete = true;
  bool sensor_present = true;
  SyncDemand demand;
  std::vector<std::chrono::nanoseconds> sync0_cycles;  ///< as told when SAFEOP was entered or OP was requested
  int restarts = 0;
  /// At most as many as the test reserves.
  std::vector<std::pair<SyncSignal, std::chrono::nanoseconds>> sync_events;
  std::vector<std::pair<wire::AlState, wire::AlState>> transitions;
  std::vector<FallBack> fall_backs;
  std::array<std::vector<std::byte>, 8> outputs;
  std::array<std::vector<std::byte>, 8> inputs;
  std::vector<std::vector<std::byte>> requests;
  std::deque<std::vector<std::byte>> replies;
  bool mailbox_full = false;
  bool echo = false;  ///< returns each mailbox message instead of recording it, without allocation
  std::array<std::byte, 128> echo_buffer{};
  std::size_t echo_length = 0;
  int output_count = 0;
  int input_count = 0;
  int advance_count = 0;
  bool went_back = false;
  std::chrono::nanoseconds local_time{0};
  std::chrono::nanoseconds outputs_at{0};
};

}  // namespace driveline::slaves::test
