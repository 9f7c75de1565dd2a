#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "driveline/motion/cycle/cycle.hpp"
#include "driveline/rt/realtime_thread.hpp"
#include "driveline/rt/thread_usage.hpp"

namespace driveline::motion {

/// Runs a cycle, either in a real-time thread of its own or in the caller's thread on a virtual
/// clock.
class CycleRunner {
 public:
  virtual ~CycleRunner() = default;
  /// Starts cycling. Error: the real-time setting that is not in effect.
  [[nodiscard]] virtual tl::expected<void, rt::RealtimeError> start() = 0;
  /// Lets `duration` pass while the cycle runs.
  virtual void pass(std::chrono::nanoseconds duration) = 0;
  /// Ends cycling; returns when no cycle runs any more.
  virtual void stop() = 0;
  /// Resources that the kernel has counted for the thread of the cycle, from before the first cycle until after the
  /// last; valid after stop(). None: the cycle has no thread of its own.
  [[nodiscard]] virtual std::optional<rt::ThreadUsage> usage() const noexcept { return std::nullopt; }
  /// Lead of the last wake-up before the grid time; valid after stop(). None: the runner does not sleep.
  [[nodiscard]] virtual std::optional<std::chrono::nanoseconds> wake_ahead() const noexcept { return std::nullopt; }
};

/// Runs the cycle in a real-time thread of its own.
class RealtimeRunner final : public CycleRunner, private rt::RealtimeTask {
 public:
  /// For `wake_ahead`, and for `early` of a port that holds frames back (Port::hold_until()), see rt::CycleTimer.
  RealtimeRunner(Cycle& cycle, rt::Clock& clock, rt::RealtimeConfig config,
                 std::optional<std::chrono::nanoseconds> wake_ahead, std::chrono::nanoseconds early = {});
  ~RealtimeRunner() override;

  [[nodiscard]] tl::expected<void, rt::RealtimeError> start() override;
  void pass(std::chrono::nanoseconds duration) override;
  void stop() override;
  [[nodiscard]] std::optional<rt::ThreadUsage> usage() const noexcept override { return usage_; }
  [[nodiscard]] std::optional<std::chrono::nanoseconds> wake_ahead() const noexcept override {
    return timer_.wake_ahead();
  }
  /// The settings in effect after start().
  [[nodiscard]] const rt::RealtimeReport& report() const noexcept { return report_; }

 private:
  void run(std::stop_token stop) noexcept override;

  Cycle& cycle_;
  rt::Clock& clock_;
  rt::RealtimeConfig config_;
  rt::CycleTimer timer_;
  rt::RealtimeThread thread_;
  rt::RealtimeReport report_;
  std::optional<rt::ThreadUsage> usage_;  ///< written by the thread at its end, read after it has been joined
};

/// Runs cycles in the caller's thread in pass(): deterministic on a virtual clock.
class InlineRunner final : public CycleRunner {
 public:
  /// Both must outlive this object; the grid starts at start().
  InlineRunner(Cycle& cycle, rt::Clock& clock);

  [[nodiscard]] tl::expected<void, rt::RealtimeError> start() override;
  void pass(std::chrono::nanoseconds duration) override;
  void stop() override {}

 private:
  Cycle& cycle_;
  rt::Clock& clock_;
  rt::CycleTimer timer_;
};

}  // namespace driveline::motion
