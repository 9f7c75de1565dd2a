#include "driveline/slaves/msd/core/touch_probe.hpp"

namespace driveline::slaves::msd {
namespace {

// Bits of 60B8h and 60B9h of the first probe; those of the second are eight positions higher (MSD manual Tables 14.2,
// 14.3).
constexpr unsigned kProbeShift = 8;
constexpr unsigned kActivate = 0;
constexpr unsigned kContinuous = 1;
constexpr unsigned kZeroPulse = 2;
constexpr unsigned kPositiveEdge = 4;
constexpr unsigned kNegativeEdge = 5;
constexpr unsigned kStoredPositive = 1;
constexpr unsigned kStoredNegative = 2;
constexpr unsigned kTogglePositive = 6;
constexpr unsigned kToggleNegative = 7;

// Manufacturer's variants: bits 0-4 arm and report five latches, bits 8-11 select a latch to read. The table prints the
// selection as bits 8-12, the text and the status word as 8-11; every code fits in four bits.
constexpr std::size_t kInternalLatch = 4;
constexpr std::uint16_t kReadMask = 0x0F00;

}  // namespace

void TouchProbe::set_status(unsigned bit, bool on) noexcept {
  const unsigned mask = 1U << bit;
  status_ = static_cast<std::uint16_t>(on ? status_ | mask : status_ & ~mask);
}

void TouchProbe::control(Variant variant, std::uint16_t function) noexcept {
  if (variant != variant_) {
    variant_ = variant;
    function_ = 0;
    status_ = 0;
    armed_.fill(variant == Variant::kCia402);
  }
  if (variant_ == Variant::kCia402) control_standard(function);
  if (variant_ == Variant::kBeck2 || variant_ == Variant::kSpecific) control_vendor(function);
}

/// A latch is armed again by switching its probe or its edge off and on.
void TouchProbe::control_standard(std::uint16_t function) noexcept {
  if (function == function_) return;
  function_ = function;
  for (unsigned probe = 0; probe < 2; ++probe) {
    const unsigned shift = probe * kProbeShift;
    const bool active = function_bit(shift + kActivate);
    set_status(shift + kActivate, active);
    for (const bool negative : {false, true}) {
      if (active && function_bit(shift + (negative ? kNegativeEdge : kPositiveEdge))) continue;
      armed_[2 * probe + (negative ? 1 : 0)] = true;
      set_status(shift + (negative ? kStoredNegative : kStoredPositive), false);
      set_status(shift + (negative ? kToggleNegative : kTogglePositive), false);
    }
  }
}

void TouchProbe::latch_standard(std::size_t probe, bool rising, bool from_zero_pulse, std::int32_t position) noexcept {
  const auto shift = static_cast<unsigned>(probe) * kProbeShift;
  const std::size_t latch = 2 * probe + (rising ? 0 : 1);
  if (!function_bit(shift + kActivate) || function_bit(shift + kZeroPulse) != from_zero_pulse) return;
  if (!function_bit(shift + (rising ? kPositiveEdge : kNegativeEdge))) return;
  const bool continuous = function_bit(shift + kContinuous);
  if (!continuous && !armed_[latch]) return;
  armed_[latch] = false;
  values_[latch] = position;
  set_status(shift + (rising ? kStoredPositive : kStoredNegative), true);
  const unsigned toggle = shift + (rising ? kTogglePositive : kToggleNegative);
  if (continuous) set_status(toggle, (status_ >> toggle & 1U) == 0);
}

void TouchProbe::control_vendor(std::uint16_t function) noexcept {
  const auto rising = static_cast<std::uint16_t>(function & ~function_);
  function_ = function;
  for (unsigned latch = 0; latch < kLatches; ++latch) {
    if ((rising >> latch & 1U) != 0) armed_[latch] = true;
    if (!function_bit(latch)) {
      armed_[latch] = false;
      set_status(latch, false);
    }
  }
  status_ = static_cast<std::uint16_t>(status_ & ~kReadMask);
  const unsigned request = (function & kReadMask) >> 8U;
  if (request == 0 || request > kLatches || (status_ >> (request - 1) & 1U) == 0) return;
  const std::size_t latch = request - 1;
  // The internal latch has no object of its own in the SPECIFIC variant either: it is reported in 60BAh (ours).
  const bool first = variant_ == Variant::kBeck2 || latch == kInternalLatch;
  values_[first ? std::size_t{kFirstPositive} : latch] = latched_[latch];
  status_ = static_cast<std::uint16_t>(status_ | request << 8U);
}

void TouchProbe::latch_vendor(std::size_t latch, std::int32_t position) noexcept {
  if (!armed_[latch]) return;
  armed_[latch] = false;
  latched_[latch] = position;
  set_status(static_cast<unsigned>(latch), true);
}

void TouchProbe::edge(std::size_t probe, bool rising, std::int32_t position) noexcept {
  if (probe > 1) return;
  if (variant_ == Variant::kCia402) return latch_standard(probe, rising, false, position);
  if (variant_ != Variant::kOff) latch_vendor(2 * probe + (rising ? 0 : 1), position);
}

void TouchProbe::zero_pulse(std::int32_t position) noexcept {
  if (variant_ == Variant::kCia402) {
    latch_standard(0, true, true, position);
    latch_standard(1, true, true, position);
  } else if (variant_ != Variant::kOff) {
    latch_vendor(kInternalLatch, position);
  }
}

}  // namespace driveline::slaves::msd
