#include "driveline/slaves/cia402/homing_sequence.hpp"

namespace driveline::slaves {
namespace {

constexpr std::int8_t kWithoutIndex = 16;  ///< methods 17-30 are 1-14 without the index pulse

constexpr bool current_position(std::int8_t method) noexcept {
  return method == 35 || method == 37;
}

}  // namespace

bool HomingSequence::supported(std::int8_t method) noexcept {
  return (method >= 1 && method <= 14) || (method >= 17 && method <= 30) || method == 33 || method == 34 ||
         current_position(method);
}

void HomingSequence::add(int direction, Until until, bool slow) noexcept {
  legs_[count_++] = {mirror_ * direction, until, slow};
}

/// Adds the search for the index pulse after the edge, in the same direction, if the method uses it.
void HomingSequence::finish_with(bool index) noexcept {
  if (!index) return;
  legs_[count_] = {legs_[count_ - 1].direction, Until::kIndex, true};
  ++count_;
}

/// Methods 1 and 17 (mirrored: 2, 18): moves onto the limit switch and off it again.
void HomingSequence::plan_limit(bool on) noexcept {
  if (!on) add(-1, Until::kActive, false);
  add(1, Until::kInactive, true);
}

/// Methods 3, 4 and 19, 20 (mirrored: 5, 6, 21, 22): a switch that is active on the whole positive side of its edge.
void HomingSequence::plan_half(int variant, bool on, bool index) noexcept {
  if (variant == 0) {  // home at the inactive side of the edge
    if (!on) add(1, Until::kActive, false);
    add(-1, Until::kInactive, true);
    return;
  }
  if (on) {
    add(-1, Until::kInactive, false);
    add(1, Until::kActive, true);
    return;
  }
  add(1, Until::kActive, false);
  if (index) return;
  add(-1, Until::kInactive, false);
  add(1, Until::kActive, true);
}

/// Methods 7-10 and 23-26 (mirrored: 11-14, 27-30): searches a cam, in positive direction first.
void HomingSequence::plan_cam(int variant, bool on, bool index) noexcept {
  switch (variant) {
    case 0:  // home beside the cam, at the near edge
      if (!on) add(1, Until::kActive, false);
      return add(-1, Until::kInactive, true);
    case 1:  // home on the cam, at the near edge
      if (on) {
        add(-1, Until::kInactive, false);
        return add(1, Until::kActive, true);
      }
      return plan_half(1, false, index);
    case 2:  // home on the cam, at the far edge
      if (!on) add(1, Until::kActive, false);
      add(1, Until::kInactive, false);
      return add(-1, Until::kActive, true);
    default:  // home beside the cam, at the far edge
      if (!on) add(1, Until::kActive, false);
      return add(1, Until::kInactive, true);
  }
}

/// The cam was not found up to the limit switch: searches it in the other direction.
void HomingSequence::turn_at_limit() noexcept {
  count_ = 0;
  current_ = 0;
  switch (cam_variant_) {
    case 0:
      add(-1, Until::kActive, false);
      add(-1, Until::kInactive, true);
      break;
    case 1:
      add(-1, Until::kActive, false);
      add(-1, Until::kInactive, false);
      add(1, Until::kActive, true);
      break;
    case 2:
      add(-1, Until::kActive, false);
      if (!with_index_) {
        add(1, Until::kInactive, false);
        add(-1, Until::kActive, true);
      }
      break;
    default:
      add(-1, Until::kActive, false);
      add(1, Until::kInactive, true);
      break;
  }
  finish_with(with_index_);
  cam_variant_ = -1;
}

void HomingSequence::plan(std::int8_t method, const HomingInputs& inputs) noexcept {
  with_index_ = method <= 14;
  const int number = with_index_ ? method : method - kWithoutIndex;
  mirror_ = number == 2 || number == 5 || number == 6 || number >= 11 ? -1 : 1;
  switch_ = number == 1 ? Switch::kNegativeLimit : number == 2 ? Switch::kPositiveLimit : Switch::kHome;
  const bool on = level(inputs);
  if (number <= 2) {
    plan_limit(on);
  } else if (number <= 6) {
    plan_half((number - 3) % 2, on, with_index_);
  } else {
    const int variant = (number - 7) % 4;
    plan_cam(variant, on, with_index_);
    if (!on) cam_variant_ = variant;
  }
  finish_with(with_index_);
}

void HomingSequence::start(std::int8_t method, const HomingInputs& inputs) noexcept {
  reset();
  state_ = supported(method) ? State::kSearching : State::kFailed;
  if (state_ == State::kFailed) return;
  if (current_position(method)) {
    home_ = inputs.position;
    state_ = State::kStopping;
    return;
  }
  if (method == 33 || method == 34) {
    edge_ = inputs.position;
    add(method == 33 ? -1 : 1, Until::kIndex, true);
    return;
  }
  plan(method, inputs);
  level_ = level(inputs);
}

void HomingSequence::interrupt() noexcept {
  if (running()) state_ = State::kInterrupted;
}

bool HomingSequence::level(const HomingInputs& inputs) const noexcept {
  switch (switch_) {
    case Switch::kNegativeLimit:
      return inputs.negative_limit;
    case Switch::kPositiveLimit:
      return inputs.positive_limit;
    case Switch::kHome:
      break;
  }
  return inputs.home_switch;
}

/// Whether a limit switch blocks the direction of the leg, unless it is the searched switch.
bool HomingSequence::blocked(const HomingInputs& inputs) const noexcept {
  const bool negative = inputs.negative_limit && switch_ != Switch::kNegativeLimit;
  const bool positive = inputs.positive_limit && switch_ != Switch::kPositiveLimit;
  return legs_[current_].direction < 0 ? negative : positive;
}

void HomingSequence::leg_done(std::int64_t position) noexcept {
  edge_ = position;
  if (++current_ < count_) return;
  home_ = position;
  state_ = State::kStopping;
}

void HomingSequence::step(const HomingInputs& inputs, std::chrono::nanoseconds dt,
                          std::chrono::nanoseconds time_out) noexcept {
  if (state_ == State::kStopping && inputs.standstill) state_ = State::kAttained;
  if (state_ != State::kSearching) return;
  elapsed_ += dt;
  const bool now = level(inputs);
  const Leg leg = legs_[current_];
  const bool on_the_way = inputs.travel == leg.direction;
  if (leg.until == Until::kIndex) {
    if (on_the_way && inputs.index_pulse && (*inputs.index_pulse - edge_) * leg.direction >= 0) {
      leg_done(*inputs.index_pulse);
    }
  } else if (on_the_way && now != level_ && now == (leg.until == Until::kActive)) {
    leg_done(inputs.position);
  }
  level_ = now;
  if (state_ != State::kSearching) return;
  if (blocked(inputs)) {
    if (cam_variant_ >= 0 && current_ == 0) return turn_at_limit();
    failure_ = Failure::kLimitSwitch;
    state_ = State::kFailed;
  } else if (elapsed_ > time_out) {
    failure_ = Failure::kTimeOut;
    state_ = State::kFailed;
  }
}

HomingSequence::Demand HomingSequence::demand() const noexcept {
  if (state_ != State::kSearching) return {};
  return {legs_[current_].direction, legs_[current_].slow};
}

}  // namespace driveline::slaves
