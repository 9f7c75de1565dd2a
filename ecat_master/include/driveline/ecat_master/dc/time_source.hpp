#pragma once

#include <chrono>

namespace driveline::ecat_master::dc {

/// A time that the clocks can follow: that of the machine, of a PTP domain, of a test.
class TimeSource {
 public:
  virtual ~TimeSource() = default;
  /// Nanoseconds since 2000-01-01 00:00, where the system time of EtherCAT begins (ETG.1000.4 6.7). Any thread. \rtsafe
  [[nodiscard]] virtual std::chrono::nanoseconds now() const noexcept = 0;
};

/// The clock of this machine, whatever disciplines it.
class SystemTimeSource final : public TimeSource {
 public:
  /// Which of the kernel's clocks.
  enum class Scale {
    kUtc,  ///< CLOCK_REALTIME: repeats a second at a leap second
    kTai,  ///< CLOCK_TAI: even, as PTP counts; right only where the kernel has been told the offset (by ptp4l, chrony)
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
  std::chrono::nanoseconds external{0};  ///< as TimeSource::now() tells it
};

/// Both clocks read at once, or as nearly as several attempts come to it: between two readings a thread may be
/// suspended. `local` returns the local time.
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
