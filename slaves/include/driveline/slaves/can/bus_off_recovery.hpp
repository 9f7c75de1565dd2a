#pragma once

#include "driveline/slaves/can/node.hpp"

namespace driveline::slaves::can {

/// Recovery from bus off: 128 times 11 successive recessive bits must pass after it was asked for (ISO 11898-1,
/// 12.1.4.4). A frame ends with 11 of them, and an idle bus has nothing else. \rtsafe throughout.
class BusOffRecovery {
 public:
  /// Starts to count, or starts again.
  void start(nanoseconds now) noexcept;
  /// Stops to count.
  void stop() noexcept { left_ = 0; }
  /// Whether it has been started and not yet finished.
  [[nodiscard]] bool running() const noexcept { return left_ != 0; }
  /// The wire is recessive since `since`.
  void wire_recessive(nanoseconds since) noexcept { recessive_since_ = since; }
  /// The wire stays recessive no longer than until `now`.
  void wire_dominant(nanoseconds now, nanoseconds bit_time) noexcept {
    if (running()) count(now, bit_time);
    recessive_since_ = kNever;
  }
  /// When it is finished if the wire stays recessive; kNever when it is not running or the wire is busy.
  [[nodiscard]] nanoseconds finished_at(nanoseconds bit_time) const noexcept {
    return running() && recessive_since_ != kNever ? end(bit_time) : kNever;
  }

 private:
  void count(nanoseconds now, nanoseconds bit_time) noexcept;
  [[nodiscard]] nanoseconds end(nanoseconds bit_time) const noexcept;

  static constexpr int kSequences = 128;
  static constexpr int kBits = 11;

  int left_ = 0;  ///< sequences that are missing
  nanoseconds started_{0};
  nanoseconds recessive_since_ = kNever;
};

}  // namespace driveline::slaves::can
