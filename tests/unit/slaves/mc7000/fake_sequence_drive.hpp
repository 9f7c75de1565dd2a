#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "driveline/slaves/mc7000/sequence_drive.hpp"

namespace driveline::slaves::mc7000::test {

/// Writes down what it is told. Moves with the speed of the order when advance() is called; a reference run takes 30 ms
/// and ends at position 7.
class FakeSequenceDrive final : public SequenceDrive {
 public:
  static constexpr double kReferenceMs = 30;
  static constexpr double kHome = 7;

  void advance(double elapsed_ms) {
    if (!state.moving || !released) return;
    if (reference_left_ms > 0) {
      reference_left_ms -= elapsed_ms;
      if (reference_left_ms > 0) return;
      is_referenced = true;
      position = kHome;
    } else {
      const double step = elapsed_ms * static_cast<double>(speed) / 5;
      position += std::clamp(target - position, -step, step);
      if (position != target) return;
    }
    state = {.moving = false, .in_position = true};
    orders.emplace_back("at " + std::to_string(static_cast<std::int64_t>(position)));
  }

  [[nodiscard]] MotionState motion() const noexcept override { return state; }
  [[nodiscard]] bool referenced() const noexcept override { return is_referenced; }
  void start_reference_run() noexcept override {
    orders.emplace_back("reference");
    reference_left_ms = kReferenceMs;
    state = {.moving = true};
  }
  [[nodiscard]] PosModLocation start_move(std::int32_t to, std::int32_t with_speed) noexcept override {
    if (refusal != PosModLocation::kNone) return refusal;
    orders.emplace_back("move " + std::to_string(to) + " " + std::to_string(with_speed));
    target = to;
    speed = with_speed;
    state = {.moving = true};
    return PosModLocation::kNone;
  }
  void release_feed(bool now) noexcept override {
    released = now;
    orders.emplace_back(now ? "feed" : "hold");
  }
  void jog(int direction) noexcept override { orders.emplace_back("jog " + std::to_string(direction)); }
  void stop() noexcept override {
    orders.emplace_back("stop");
    state = {};
    reference_left_ms = 0;
  }
  [[nodiscard]] std::optional<bool> input(ConditionSource source, std::uint8_t number) const noexcept override {
    const auto found =
        std::ranges::find_if(inputs, [&](const Input& one) { return one.source == source && one.number == number; });
    return found == inputs.end() ? std::nullopt : std::optional(found->on);
  }
  void set_output(std::uint8_t number, bool on) noexcept override {
    orders.emplace_back("OS0" + std::to_string(number) + (on ? "=1" : "=0"));
  }
  void tx_pdo_event(std::uint8_t tx_pdo) noexcept override { orders.emplace_back("TxPDO" + std::to_string(tx_pdo)); }

  /// Returns what has been written down since the call before.
  std::vector<std::string> take() { return std::exchange(orders, {}); }

  struct Input {
    ConditionSource source;
    std::uint8_t number;
    bool on;
  };
  std::vector<Input> inputs;
  std::vector<std::string> orders;
  MotionState state;
  PosModLocation refusal = PosModLocation::kNone;
  bool is_referenced = false;
  bool released = true;
  double position = 0;
  double target = 0;
  std::int32_t speed = 0;
  double reference_left_ms = 0;
};

}  // namespace driveline::slaves::mc7000::test
