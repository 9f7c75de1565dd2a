#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <string>
#include <vector>

#include "driveline/canopen_client/bus_link.hpp"
#include "driveline/canopen_wire/candump.hpp"
#include "support/bytes.hpp"
#include "support/must.hpp"

namespace driveline::canopen {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using ::testing::ElementsAre;

/// A port whose other side is written down: each frame that is sent is followed by the answers that are next in the
/// script. Frames are in candump's notation.
class ScriptedPort final : public CanPort {
 public:
  struct Answer {
    nanoseconds delay;
    std::string frame;
  };

  explicit ScriptedPort(rt::VirtualClock& clock) : clock_(&clock) {}

  /// The next frame that is sent has this answer, 1 ms later.
  void answer(const std::string& frame) { script_.push_back({{1ms, frame}}); }
  /// The next frame that is sent has these answers.
  void answers(std::vector<Answer> answers) { script_.push_back(std::move(answers)); }
  /// The next frame that is sent has no answer.
  void silence() { script_.emplace_back(); }
  /// A frame arrives whatever is sent.
  void arrives(nanoseconds time, const std::string& frame) {
    arriving_.push_back({*candump::parse_frame(frame), time});
  }

  [[nodiscard]] SendStatus send(const Frame& frame) noexcept override {
    if (status != SendStatus::kSent) return status;
    const auto line = candump::line_of(frame, "", 0);
    sent.emplace_back(line.view().substr(line.view().rfind(' ') + 1));
    sent_at.push_back(clock_->now());
    if (script_.empty()) return status;
    for (const auto& [delay, text] : script_.front()) arrives(clock_->now() + delay, text);
    script_.pop_front();
    return status;
  }
  [[nodiscard]] std::optional<ReceivedFrame> receive() noexcept override {
    const auto next = first();
    if (next == arriving_.end() || next->time > clock_->now()) return std::nullopt;
    const ReceivedFrame frame{next->frame, next->time};
    arriving_.erase(next);
    return frame;
  }
  bool wait_readable(nanoseconds deadline) noexcept override {
    const auto next = first();
    const bool readable = next != arriving_.end() && next->time <= deadline;
    clock_->sleep_until(readable ? next->time : deadline);
    return readable;
  }
  [[nodiscard]] PortStatistics statistics() const noexcept override {
    PortStatistics statistics;
    statistics.down = status == SendStatus::kDown;
    return statistics;
  }

  std::vector<std::string> sent;
  std::vector<nanoseconds> sent_at;
  SendStatus status = SendStatus::kSent;

 private:
  [[nodiscard]] std::vector<ReceivedFrame>::iterator first() {
    return std::min_element(arriving_.begin(), arriving_.end(),
                            [](const ReceivedFrame& a, const ReceivedFrame& b) { return a.time < b.time; });
  }

  rt::VirtualClock* clock_;
  std::deque<std::vector<Answer>> script_;
  std::vector<ReceivedFrame> arriving_;
};

/// A link to a scripted port.
class ScriptedBus : public ::testing::Test {
 protected:
  rt::VirtualClock clock{1s};
  ScriptedPort port{clock};
  BusLink link{port, clock};
};

}  // namespace driveline::canopen
