#pragma once

#include <chrono>

namespace driveline::ecat_master::dc {

/// A time that the clocks can follow: of the machine, a PTP domain, or a test.
class TimeSource {
 public:
  virtual ~TimeSource() = default;
  /// Nanoseconds since 2000-01-01 00:00, the epoch of the EtherCAT system time (ETG.1000.4 6.7). Any thread. \rtsafe
  [[nodiscard]] virtual std::chrono::nanoseconds now() const noexcept = 0;
};

/// The clock of this machine, as set and disciplined by the system.
class SystemTimeSource final : public TimeSource {
 public:
  /// The kernel clock to read.
  enum class Scale {
    kUtc,  ///< CLOCK_REALTIME: repeats a second at a leap second
    kTai,  ///< CLOCK_TAI: uniform, like PTP; correct only if ptp4l or chrony has set the kernel's TAI offset
  };
  /// Selects the clock.
  explicit SystemTimeSource(Scale scale) noexcept : scale_(scale) {}
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept override;

 private:
  Scale scale_;
};

/// The same instant on two clocks.
struct TimePair {
  std::chrono::nanoseconds local{0};     ///< on the local clock
  std::chrono::nanoseconds external{0};  ///< from TimeSource::now()
};

/// Reads both clocks at the same instant as closely as several attempts allow, because the thread may be preempted
/// between the two readings. `local` returns the local time.
template <typename Local>
[[nodiscard]] TimePair read_both(const TimeSource& source, Local&& local) noexcept {
  constexpr int kAttempts = 5;
  TimePair best;
  auto narrowest = std::chrono::nanoseconds::max();
  for (int i = 0; i < kAttempts; ++i) {
    const std::chrono::nanoseconds before = local();
    const auto external = source.now();
    const auto width = local() - before;
    if (width >= narrowest) continue;
    narrowest = width;
    best = {before + width / 2, external};
  }
  return best;
}

}  // namespace driveline::ecat_master::dc
