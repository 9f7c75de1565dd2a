#pragma once

#include <algorithm>
#include <deque>
#include <vector>

#include "driveline/slaves/can/bus.hpp"
#include "support/bytes.hpp"

namespace driveline::slaves::can {

/// A node that sends what a test tells it at the times that the test names, and remembers what it sees.
class ScriptedNode : public Node {
 public:
  struct Seen {
    nanoseconds time;
    Frame frame;
    bool operator==(const Seen&) const = default;
  };

  void send_at(nanoseconds time, const Frame& frame) { script_.push_back({time, frame}); }

  void connected(Controller& controller) override { controller_ = &controller; }
  void receive(const Frame& frame, nanoseconds now) override { received.push_back({now, frame}); }
  void advance(nanoseconds now) override {
    while (!script_.empty() && script_.front().time <= now) {
      accepted += controller_->send(script_.front().frame) ? 1U : 0U;
      script_.pop_front();
    }
  }
  [[nodiscard]] nanoseconds next_wake() const noexcept override {
    return script_.empty() ? kNever : script_.front().time;
  }
  void transmitted(const Frame& frame, nanoseconds now) override { sent.push_back({now, frame}); }
  void error_state_changed(ErrorState state, nanoseconds /*now*/) override { states.push_back(state); }

  [[nodiscard]] std::vector<std::uint32_t> identifiers() const {
    std::vector<std::uint32_t> out;
    for (const Seen& one : received) out.push_back(one.frame.identifier.value);
    return out;
  }
  [[nodiscard]] Controller& controller() { return *controller_; }

  std::vector<Seen> received;
  std::vector<Seen> sent;
  std::vector<ErrorState> states;
  unsigned accepted = 0;

 private:
  std::deque<Seen> script_;
  Controller* controller_ = nullptr;
};

}  // namespace driveline::slaves::can
