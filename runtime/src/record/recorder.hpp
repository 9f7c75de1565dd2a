#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/files/output_file.hpp"
#include "driveline/runtime/record/can_report.hpp"
#include "driveline/snapshot/sample_consumer.hpp"
#include "record/last_rows.hpp"

namespace driveline::runtime {

/// Statistics of a following error.
struct ErrorFigures {
  double maximum = 0.0;  ///< largest magnitude
  double sum_of_squares = 0.0;
  std::uint64_t samples = 0;
  void add(double error) noexcept;
  [[nodiscard]] double rms() const noexcept;
};

/// Following error of an axis while in Operation enabled, in rad or m, as computed by the master.
struct FollowingError : ErrorFigures {
  ErrorFigures path;    ///< error against the path at this instant, instead of the setpoint that the drive followed
  ErrorFigures drive;   ///< as reported by the drive (60F4h); no samples: the object is not mapped
  bool demand = false;  ///< the file contains the position demand of the drive (6062h)
  std::uint64_t unavailable = 0;               ///< cycles in operation in which the axis was unavailable
  std::optional<snapshot::AxisSample> last{};  ///< last sample in operation
};

/// Evaluates all samples of a run: following errors of every cycle, and a CSV file with every n-th cycle for the plots.
/// Each row also contains the lowest and highest following error of all cycles since the preceding row, so that no peak
/// is missing; as in the summary, these cover only cycles in Operation enabled.
///
/// The file holds the last minutes of a run, however long that lasts. It appears under its name only when it is
/// complete and has rows. Functions run on the drain thread; read the results after it has ended.
class Recorder final : public snapshot::SampleConsumer {
 public:
  /// Most rows in the file; of a longer run it has the last ones, at least three quarters of this number.
  static constexpr std::uint64_t kMaxRows = 120'000;

  /// `csv`: output file; none: no file. `every`: one row per `every` cycles. `increments`: adds drive increments after
  /// the columns in the units of the axes. `compensated`: setpoints lead the path by the dead times, so that the
  /// setpoint that a drive has followed is that of the path at this instant.
  Recorder(const std::vector<motion::AxisConfig>& axes, const std::optional<std::filesystem::path>& csv,
           std::uint64_t every, bool increments = false, bool compensated = false);
  /// Removes an unfinished file.
  ~Recorder() override = default;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Prevents the file at the end. Any thread.
  void discard() noexcept { discarded_.store(true, std::memory_order_relaxed); }

  /// Sets the increments of an axis per rad or m, if they differ from those given to the constructor; call before the
  /// cycle starts.
  void set_scale(std::size_t axis, double increments_per_unit) noexcept {
    columns_[axis].increments_per_unit = increments_per_unit;
  }
  /// Set the grid times between which the line is in operation; cycles in which axes are unavailable are counted only
  /// in between. Any thread.
  void begin_operation(std::chrono::nanoseconds now) noexcept { operation_begin_.store(now.count()); }
  void end_operation(std::chrono::nanoseconds now) noexcept { operation_end_.store(now.count()); }

  void lines(std::span<const snapshot::LineSample> samples) override;
  void axes(std::span<const snapshot::AxisSample> samples) override;
  void finish(const snapshot::DrainCounters& counters) override;

  [[nodiscard]] const std::vector<FollowingError>& following_errors() const noexcept { return errors_; }
  /// Load of the bus in operation, where it is measured.
  [[nodiscard]] const BusLoad& bus_load() const noexcept { return load_; }
  [[nodiscard]] std::uint64_t rows() const noexcept { return rows_ ? rows_->rows() : 0; }
  /// Time of the first row if earlier ones have been dropped.
  [[nodiscard]] std::optional<double> begins_at_s() const noexcept {
    return rows_ ? rows_->begins_at_s() : std::nullopt;
  }
  /// Why the file could not be written; none: the file exists, unless rows() is 0.
  [[nodiscard]] const std::optional<Error>& problem() const noexcept { return problem_; }

 private:
  [[nodiscard]] double path_error(const snapshot::AxisSample& sample) const noexcept;
  void add_to_row(const snapshot::AxisSample& sample);
  void write_header(const std::vector<snapshot::AxisSample>& row);
  void write_row(const std::vector<snapshot::AxisSample>& row);

  /// Extremes of an axis since the last row; in the order of the columns.
  struct Extremes {
    double least = std::numeric_limits<double>::quiet_NaN();
    double greatest = std::numeric_limits<double>::quiet_NaN();
    void add(double value) noexcept;
  };

  struct Column {
    std::string axis;
    bool linear = false;
    const trajectory::PositionUnit* unit = nullptr;
    double increments_per_unit = 1.0;  ///< increments per rad or m
  };
  std::vector<FollowingError> errors_;
  BusLoad load_;
  std::vector<Column> columns_;
  std::filesystem::path csv_name_;
  std::optional<OutputFile> csv_;
  std::optional<LastRows> rows_;  ///< rows of csv_
  std::uint64_t every_;
  bool increments_;
  bool compensated_;
  std::vector<snapshot::AxisSample> row_;
  std::vector<snapshot::AxisSample> last_row_;  ///< complete, from a cycle after the last row of the file
  std::vector<Extremes> extremes_;              ///< indexed by axis
  std::optional<std::int64_t> first_time_ns_;
  std::optional<Error> problem_;
  std::atomic<bool> discarded_{false};
  std::atomic<std::int64_t> operation_begin_{std::numeric_limits<std::int64_t>::max()};
  std::atomic<std::int64_t> operation_end_{std::numeric_limits<std::int64_t>::max()};
};

}  // namespace driveline::runtime
