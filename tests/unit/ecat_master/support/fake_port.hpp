#pragma once

#include <deque>
#include <functional>
#include <vector>

#include "driveline/port/port.hpp"
#include "driveline/rt/clock.hpp"
#include "driveline/wire/frame.hpp"

namespace driveline::ecat_master_test {

/// A port whose far end is a function of the test. Time advances only while the master waits.
class FakePort final : public port::Port {
 public:
  explicit FakePort(rt::VirtualClock& clock) : clock_(clock) {}

  /// Called for every frame that is sent.
  std::function<void(std::span<const std::byte> frame)> on_send = [](auto) {};
  /// Called when the master starts waiting.
  std::function<void()> on_wait = [] {};
  /// Results of the next sends instead of kSent; these frames are not sent.
  std::deque<port::SendStatus> refusals;
  std::vector<std::vector<std::byte>> sent;

  void arrive(std::vector<std::byte> frame, std::chrono::nanoseconds after = std::chrono::microseconds{10}) {
    incoming_.push_back({clock_.now() + after, std::move(frame)});
  }

  [[nodiscard]] port::SendStatus send(std::span<const std::byte> frame) noexcept override {
    if (!refusals.empty()) {
      const auto status = refusals.front();
      refusals.pop_front();
      return status;
    }
    sent.emplace_back(frame.begin(), frame.end());
    on_send(frame);
    return port::SendStatus::kSent;
  }
  [[nodiscard]] std::optional<port::ReceivedFrame> receive() noexcept override {
    const auto first = earliest();
    if (first == incoming_.end() || first->due > clock_.now()) return std::nullopt;
    held_ = std::move(first->bytes);
    incoming_.erase(first);
    return port::ReceivedFrame{held_, clock_.now()};
  }
  bool wait_readable(std::chrono::nanoseconds deadline) noexcept override {
    on_wait();
    const auto first = earliest();
    if (first == incoming_.end() || first->due > deadline) {
      clock_.sleep_until(deadline);
      return false;
    }
    clock_.sleep_until(first->due);
    return true;
  }
  [[nodiscard]] std::chrono::nanoseconds last_send_time() const noexcept override { return clock_.now(); }

 private:
  struct Incoming {
    std::chrono::nanoseconds due;
    std::vector<std::byte> bytes;
  };
  std::deque<Incoming>::iterator earliest() {
    return std::min_element(incoming_.begin(), incoming_.end(),
                            [](const Incoming& a, const Incoming& b) { return a.due < b.due; });
  }

  rt::VirtualClock& clock_;
  std::deque<Incoming> incoming_;
  std::vector<std::byte> held_;
};

/// A frame returning from a line where one slave has answered every datagram with bytes of `fill`.
[[nodiscard]] inline std::vector<std::byte> answered(std::span<const std::byte> frame, std::byte fill) {
  std::vector<std::byte> answer(frame.begin(), frame.end());
  answer[6] |= std::byte{0x02};
  auto cursor = wire::MutableDatagramCursor::open(answer);
  while (cursor && !cursor->done()) {
    auto datagram = cursor->next();
    if (!datagram) break;
    std::fill(datagram->data.begin(), datagram->data.end(), fill);
    datagram->working_counter_bytes[0] = std::byte{1};
  }
  return answer;
}

}  // namespace driveline::ecat_master_test
