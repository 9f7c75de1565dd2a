#include "driveline/slaves/position_servo/homing.hpp"

#include <algorithm>
#include <array>

namespace driveline::slaves::position_servo {
namespace {

constexpr std::int8_t kHere = 0;          ///< the current position is home
constexpr std::int8_t kHereAndMove = 35;  ///< the same, then a move to the new zero (lines 3891-3892)

/// Methods 15, 16, 20, 22, 24, 26, 28 and 30-32 are reserved (lines 3788-3816).
constexpr std::array<std::int8_t, 26> kMethods{kHere, 1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12,
                                               13,    14, 17, 18, 19, 21, 23, 25, 27, 29, 33, 34, kHereAndMove};

constexpr bool in_range(std::int32_t value, std::int32_t highest) noexcept {
  return value > 0 && value <= highest;
}

}  // namespace

bool Homing::supported(std::int8_t method) noexcept {
  return std::ranges::binary_search(kMethods, method);
}

bool Homing::start(const HomingSettings& settings, const HomingInputs& inputs) noexcept {
  if (!supported(settings.method) || !in_range(settings.fast, kMaxVelocity) || !in_range(settings.slow, kMaxVelocity) ||
      !in_range(settings.acceleration, kMaxAcceleration)) {
    return false;
  }
  settings_ = settings;
  shift_ = 0;
  demanded_ = {};
  generator_.reset({static_cast<double>(inputs.position), 0.0, 0.0});
  state_ = State::kSearching;
  sequence_.start(settings.method == kHere ? kHereAndMove : settings.method, inputs);
  follow(sequence_.demand());
  return true;
}

void Homing::stop() noexcept {
  if (state_ != State::kSearching && state_ != State::kMoving) return;
  sequence_.interrupt();
  generator_.run_at(0.0, limits());
  state_ = State::kIdle;
}

GeneratorLimits Homing::limits() const noexcept {
  const double acceleration = settings_.acceleration * kAccelerationUnit;
  return {settings_.fast * kVelocityUnit, acceleration, acceleration, 0.0};
}

/// Plans a new speed when the sequence demands another one.
void Homing::follow(HomingSequence::Demand demand) noexcept {
  if (demand.direction == demanded_.direction && demand.slow == demanded_.slow) return;
  demanded_ = demand;
  generator_.run_at(demand.direction * (demand.slow ? settings_.slow : settings_.fast) * kVelocityUnit, limits());
}

/// Zero is home plus the offset (lines 3592-3598), so that the home position gets the value -offset.
void Homing::set_home() noexcept {
  shift_ = -settings_.offset - sequence_.home().value_or(0);
  generator_.reset({generator_.state().position + static_cast<double>(shift_), 0.0, 0.0});
  state_ = State::kAttained;
  if (settings_.method != kHereAndMove) return;
  generator_.move_to(0.0, limits());
  state_ = State::kMoving;
}

void Homing::step(const HomingInputs& inputs, std::chrono::nanoseconds period) noexcept {
  if (state_ == State::kSearching) {
    HomingInputs seen = inputs;
    seen.standstill = generator_.finished() && demanded_.direction == 0;
    sequence_.step(seen, period, settings_.time_out);
    follow(sequence_.demand());
    if (sequence_.state() == HomingSequence::State::kFailed) state_ = State::kFailed;
    if (sequence_.state() == HomingSequence::State::kAttained) return set_home();
  }
  generator_.step(std::chrono::duration<double>(period).count());
  if (state_ == State::kMoving && generator_.finished()) state_ = State::kAttained;
}

}  // namespace driveline::slaves::position_servo
