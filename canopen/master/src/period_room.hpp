#pragma once

#include <cstdint>

namespace driveline::canopen {

/// What the bus can carry in a period besides the PDOs with SYNC, in bits of the worst case. One frame always fits: a
/// bus budget that is accepted has room for it, and on a bus without budget nothing else would ever be sent. \rtsafe
class PeriodRoom {
 public:
  /// `bits` may be negative.
  explicit PeriodRoom(std::int64_t bits) noexcept : left_(bits) {}

  /// Whether a frame fits.
  [[nodiscard]] bool fits(std::uint32_t bits) const noexcept { return unused_ || left_ >= std::int64_t{bits}; }
  /// A frame was sent.
  void use(std::uint32_t bits) noexcept {
    left_ -= bits;
    unused_ = false;
  }

 private:
  std::int64_t left_;
  bool unused_ = true;
};

}  // namespace driveline::canopen
