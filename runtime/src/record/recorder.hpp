#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/snapshot/sample_consumer.hpp"

namespace driveline::runtime {

/// Statistics of a following error.
struct ErrorFigures {
  double maximum = 0.0;  ///< largest magnitude
  double sum_of_squares = 0.0;
  std::uint64_t samples = 0;
  void add(double error) noexcept;
  [[nodiscard]] double rms() const noexcept;
};

/// Following error of one axis while it was in Operation enabled, in rad or m: as the master computes it.
struct FollowingError : ErrorFigures {
  ErrorFigures path;              ///< of the path at this instant, instead of the setpoint that the drive followed
  ErrorFigures drive;             ///< as the drive reports it (60F4h); no samples: the object is not mapped
  bool demand = false;            ///< the file has what the position loop of the drive follows (6062h)
  std::uint64_t unavailable = 0;  ///< cycles in operation in which the axis was unavailable
  std::optional<snapshot::AxisSample> last{};  ///< last sample in operation
};

/// Watches all samples of a run: following errors of every cycle, and a CSV file of every n-th for the plots. So that
/// no peak is missing there, each row also has the least and the greatest following error of all cycles since the row
/// before; like the summary's they are those in Operation enabled.
///
/// The file appears under its name only when it is complete, and only when there are rows in it. Functions run on the
/// drain thread; results are read after it has ended.
class Recorder final : public snapshot::SampleConsumer {
 public:
  /// Longest recording; a longer run goes on without being recorded.
  static constexpr std::uint64_t kMaxRows = 120'000;

  /// `csv`: none, nothing is written. `every`: one row per so many cycles. `increments`: beside what is in the units of
  /// the axes, behind everything else. `compensated`: setpoints lead the path by the dead times, so that the setpoint a
  /// drive has followed is that of the path at this instant.
  Recorder(const std::vector<ecat_master::AxisConfig>& axes, std::optional<std::filesystem::path> csv,
           std::uint64_t every, bool increments = false, bool compensated = false);
  /// Removes a file that has not been finished.
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Keeps no file at the end. Any thread.
  void discard() noexcept { discarded_.store(true, std::memory_order_relaxed); }

  /// The increments of that axis per rad or m, where they are not those given to the constructor; before the cycle.
  void set_scale(std::size_t axis, double increments_per_unit) noexcept {
    columns_[axis].increments_per_unit = increments_per_unit;
  }
  /// The line is in operation from one grid time to the other: axes that are unavailable in between are counted. Any
  /// thread.
  void begin_operation(std::chrono::nanoseconds now) noexcept { operation_begin_.store(now.count()); }
  void end_operation(std::chrono::nanoseconds now) noexcept { operation_end_.store(now.count()); }

  void lines(std::span<const snapshot::LineSample> samples) override;
  void axes(std::span<const snapshot::AxisSample> samples) override;
  void finish(const snapshot::DrainCounters& counters) override;

  [[nodiscard]] const std::vector<FollowingError>& following_errors() const noexcept { return errors_; }
  [[nodiscard]] std::uint64_t rows() const noexcept { return rows_; }
  /// Time of the last row, when the run went on behind it: the file was full.
  [[nodiscard]] std::optional<double> cut_off_at_s() const noexcept { return cut_off_at_s_; }
  /// Why the file could not be written; none: it is there, unless rows() is 0.
  [[nodiscard]] const std::optional<Error>& problem() const noexcept { return problem_; }

 private:
  [[nodiscard]] double path_error(const snapshot::AxisSample& sample) const noexcept;
  void drop_file();
  void note_problem(std::string_view what);
  void add_to_row(const snapshot::AxisSample& sample);
  void write_header(const std::vector<snapshot::AxisSample>& row);
  void take_row(const std::vector<snapshot::AxisSample>& row);
  void write_row(const std::vector<snapshot::AxisSample>& row);

  /// Of one axis, since the last row; in the order of the columns.
  struct Extremes {
    double least = std::numeric_limits<double>::quiet_NaN();
    double greatest = std::numeric_limits<double>::quiet_NaN();
    void add(double value) noexcept;
  };

  struct Column {
    std::string axis;
    bool linear = false;
    const trajectory::PositionUnit* unit = nullptr;
    double increments_per_unit = 1.0;  ///< per rad or m
  };
  std::vector<FollowingError> errors_;
  std::vector<Column> columns_;
  std::optional<std::filesystem::path> csv_;
  std::uint64_t every_;
  bool increments_;
  bool compensated_;
  std::ofstream stream_;
  std::vector<snapshot::AxisSample> row_;
  std::vector<snapshot::AxisSample> last_row_;  ///< complete, of a cycle behind the last row of the file
  std::vector<Extremes> extremes_;              ///< by axis
  std::uint64_t rows_ = 0;
  std::optional<std::int64_t> first_time_ns_;
  double last_time_s_ = 0.0;
  std::optional<double> cut_off_at_s_;
  std::optional<Error> problem_;
  std::atomic<bool> discarded_{false};
  std::atomic<std::int64_t> operation_begin_{std::numeric_limits<std::int64_t>::max()};
  std::atomic<std::int64_t> operation_end_{std::numeric_limits<std::int64_t>::max()};
};

}  // namespace driveline::runtime
