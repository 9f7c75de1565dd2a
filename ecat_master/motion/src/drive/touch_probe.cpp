#include "driveline/motion/drive/touch_probe.hpp"

#include "drive/drive_entries.hpp"

namespace driveline::motion {
namespace {

// Bits of 60B8h and 60B9h for touch probe 1; those of touch probe 2 are eight bits higher (CiA 402-2, objects 60B8h and
// 60B9h; MSD manual Tables 14.2, 14.3).
constexpr unsigned kOn = 0x0001;
constexpr unsigned kByZeroPulse = 0x0004;
constexpr unsigned kAtRising = 0x0010;
constexpr unsigned kAtFalling = 0x0020;
constexpr unsigned kHasRising = 0x0002;
constexpr unsigned kHasFalling = 0x0004;
constexpr unsigned kSecondProbe = 8;

constexpr std::uint16_t kFirstValue = 0x60BA;

bool falling(ProbeTrigger trigger) noexcept {
  return trigger == ProbeTrigger::kFirstFalling || trigger == ProbeTrigger::kSecondFalling;
}

unsigned place_of(ProbeTrigger trigger) noexcept {
  return trigger == ProbeTrigger::kSecondRising || trigger == ProbeTrigger::kSecondFalling ? kSecondProbe : 0;
}

/// Index of the value object: 60BAh plus this number.
std::size_t object_of(ProbeTrigger trigger) noexcept {
  return trigger == ProbeTrigger::kZeroPulse ? 0 : static_cast<std::size_t>(trigger);
}

}  // namespace

TouchProbe::TouchProbe(const ImagePlace& place, const PdoConfiguration& pdos)
    : function_(entry<std::uint16_t>(pdos.outputs, place.output_offset, 0x60B8)),
      status_(entry<std::uint16_t>(pdos.inputs, place.input_offset, 0x60B9)) {
  for (std::size_t i = 0; i < positions_.size(); ++i) {
    const auto index = static_cast<std::uint16_t>(kFirstValue + i);
    positions_[i] = entry<std::int32_t>(pdos.inputs, place.input_offset, index);
  }
}

bool TouchProbe::possible(ProbeTrigger trigger) const noexcept {
  return trigger <= ProbeTrigger::kZeroPulse && function_ && status_ && positions_[object_of(trigger)];
}

void TouchProbe::arm(ProbeTrigger trigger) noexcept {
  trigger_ = trigger;
  phase_ = Phase::kClearing;
}

std::uint16_t TouchProbe::function() const noexcept {
  if (phase_ < Phase::kArming) return 0;
  unsigned bits = kOn | (falling(trigger_) ? kAtFalling : kAtRising);
  if (trigger_ == ProbeTrigger::kZeroPulse) bits |= kByZeroPulse;
  return static_cast<std::uint16_t>(bits << place_of(trigger_));
}

void TouchProbe::read(std::span<const std::byte> image, bool fresh) noexcept {
  if (phase_ == Phase::kOff || !fresh) return;
  const unsigned status = static_cast<unsigned>(take(status_, image)) >> place_of(trigger_);
  const bool on = (status & kOn) != 0;
  const bool has = (status & (falling(trigger_) ? kHasFalling : kHasRising)) != 0;
  if (phase_ == Phase::kClearing && !on && !has) {
    phase_ = Phase::kArming;
  } else if (phase_ == Phase::kArming && on) {
    phase_ = Phase::kArmed;
  }
  if (phase_ != Phase::kArmed || !has) return;
  phase_ = Phase::kLatched;
  value_ = take(positions_[object_of(trigger_)], image);
}

void TouchProbe::write(std::span<std::byte> image) const noexcept {
  if (function_) function_->set(image, function());
}

}  // namespace driveline::motion
