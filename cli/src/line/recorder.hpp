#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "driveline/bridge/sample_consumer.hpp"
#include "driveline/cli/line_config.hpp"

namespace driveline::cli {

/// Following error of one axis while it was in Operation enabled, in rad or m.
struct FollowingError {
  double maximum = 0.0;
  double sum_of_squares = 0.0;
  std::uint64_t samples = 0;
  std::uint64_t unavailable = 0;  ///< cycles in operation in which the axis was not there
  [[nodiscard]] double rms() const noexcept;
};

/// Watches all samples of a run: following errors of every cycle, and a CSV file of every n-th for the plots.
///
/// The file appears under its name only when it is complete, and only when there are rows in it. Functions run on the
/// drain thread; results are read after it has ended.
class Recorder final : public bridge::SampleConsumer {
 public:
  /// Longest recording; a longer run goes on without being recorded.
  static constexpr std::uint64_t kMaxRows = 120'000;

  /// `csv`: none, nothing is written. `every`: one row per so many cycles.
  Recorder(const std::vector<ecat_master::AxisConfig>& axes, std::optional<std::filesystem::path> csv,
           std::uint64_t every);
  /// Removes a file that has not been finished.
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Nothing will be worth keeping: no file at the end. Any thread.
  void discard() noexcept { discarded_.store(true, std::memory_order_relaxed); }

  /// The line is in operation from one grid time to the other: who is unavailable in between is missing. Any thread.
  void begin_operation(std::chrono::nanoseconds now) noexcept { operation_begin_.store(now.count()); }
  void end_operation(std::chrono::nanoseconds now) noexcept { operation_end_.store(now.count()); }

  void lines(std::span<const snapshot::LineSample> samples) override;
  void axes(std::span<const snapshot::AxisSample> samples) override;
  void finish(const bridge::DrainCounters& counters) override;

  [[nodiscard]] const std::vector<FollowingError>& following_errors() const noexcept { return errors_; }
  [[nodiscard]] std::uint64_t rows() const noexcept { return rows_; }
  /// Why the file could not be written; empty: it is there, unless rows() is 0.
  [[nodiscard]] const std::string& problem() const noexcept { return problem_; }

 private:
  void drop_file();
  void add_to_row(const snapshot::AxisSample& sample);
  void write_row();

  std::vector<FollowingError> errors_;
  std::optional<std::filesystem::path> csv_;
  std::uint64_t every_;
  std::ofstream stream_;
  std::vector<snapshot::AxisSample> row_;
  std::uint64_t rows_ = 0;
  std::optional<std::int64_t> first_time_ns_;
  std::string problem_;
  std::atomic<bool> discarded_{false};
  std::atomic<std::int64_t> operation_begin_{std::numeric_limits<std::int64_t>::max()};
  std::atomic<std::int64_t> operation_end_{std::numeric_limits<std::int64_t>::max()};
};

}  // namespace driveline::cli
