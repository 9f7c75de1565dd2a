#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace driveline::bench {

/// Lead of the wake-up over the instant in these runs (`wake_ahead_us`).
inline constexpr std::chrono::microseconds kWakeAhead{25};

/// The reader of the telemetry of a run.
enum class TelemetryReader : std::uint8_t { kFastDds, kCyclone };

/// A run of `driveline` on a simulated line, in its own process, on paths that keep all axes moving.
struct TelemetryPlan {
  std::size_t axes = 8;
  bool telemetry = true;
  std::optional<TelemetryReader> reader;  ///< another process on this machine, over UDP
  std::chrono::milliseconds duration{3000};
  bool stall = false;  ///< the bridge is stopped (SIGSTOP) for two seconds
};

/// The batches with every cycle, as a reader has received them.
struct ReceivedTelemetry {
  double cycles = 0.0;
  double lost_batches = 0.0;
  double skipped_cycles = 0.0;     ///< between two received cycles: in lost batches, or lost before DDS
  std::vector<double> latency_us;  ///< p50, p99, p99.9 and maximum: from the instant of a cycle until it was read
  double cpu_share = 0.0;          ///< share of a processor while the line ran
};

/// Figures from the report of a run, and resources of its processes.
struct TelemetryFigures {
  double cycle_cost_p50_us = 0.0;
  double cycle_cost_p999_us = 0.0;
  double wake_latency_p999_us = 0.0;
  double missed_periods = 0.0;
  double published = 0.0;
  double dropped = 0.0;
  double run_mib = 0.0;           ///< peak resident memory
  double bridge_mib = 0.0;        ///< peak resident memory
  double bridge_cpu_share = 0.0;  ///< share of a processor while the line ran
  std::optional<ReceivedTelemetry> received;
};

/// The line descriptions of such runs, in a folder that the destructor removes, and the programs beside this one.
class TelemetryRuns {
 public:
  TelemetryRuns();
  TelemetryRuns(const TelemetryRuns&) = delete;
  TelemetryRuns& operator=(const TelemetryRuns&) = delete;
  ~TelemetryRuns();

  /// Executes a run. Throws Disturbed if it failed: on a busy machine the master is away too long.
  [[nodiscard]] TelemetryFigures measure(const TelemetryPlan& plan);

 private:
  [[nodiscard]] std::filesystem::path describe(std::size_t axes) const;

  std::filesystem::path programs_;
  std::filesystem::path folder_;
  unsigned domain_;
};

}  // namespace driveline::bench
