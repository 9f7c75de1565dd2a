#pragma once

#include <filesystem>
#include <future>
#include <optional>
#include <vector>

#include "driveline/motion/cycle/flight_recorder.hpp"
#include "driveline/runtime/config/line_config.hpp"
#include "driveline/runtime/error.hpp"
#include "driveline/runtime/event/result_events.hpp"

namespace driveline::runtime {

/// Records the cycles around the faults of a run, one file per fault: flight_recorder.csv, flight_recorder.2.csv and so
/// on. Only the first kMaxFiles faults get a file; a fault that occurs before the record of the previous one is
/// complete is part of that record.
///
/// Belongs to the thread that supervises the line; only the cycle writes to the recorder.
class FaultRecords {
 public:
  static constexpr std::size_t kMaxFiles = 8;

  /// Files are in the output folder of `config`. `with_axes`: the axes of the line are moved, and have columns.
  /// `in_background`: another thread writes the files while the line continues.
  FaultRecords(const LineConfig& config, bool with_axes, bool in_background);

  /// Returns the recorder to which the cycle writes.
  [[nodiscard]] motion::FlightRecorder& recorder() noexcept { return recorder_; }
  /// Reports that a fault has occurred now.
  void note_fault() noexcept;
  /// Call regularly while the cycle runs. Returns the file completed since the last call, if there is one.
  [[nodiscard]] std::optional<events::FaultRecorded> poll();
  /// Call after the cycle has ended: writes what was recorded of the last fault. Returns the files completed since
  /// poll().
  [[nodiscard]] std::vector<events::FaultRecorded> finish();

  /// Returns the files written so far.
  [[nodiscard]] const std::vector<std::filesystem::path>& files() const noexcept { return files_; }
  /// Returns why a file could not be written; none: all were written.
  [[nodiscard]] const std::optional<Error>& problem() const noexcept { return problem_; }

 private:
  /// Result of writing a file: the reason of the failure, or nothing.
  using Writing = std::future<std::optional<Error>>;

  [[nodiscard]] std::filesystem::path next_file() const;
  void begin_writing();
  [[nodiscard]] std::optional<events::FaultRecorded> end_writing();

  std::filesystem::path directory_;
  std::vector<motion::FlightRecorder::AxisLabel> axes_;
  bool in_background_;
  motion::FlightRecorder recorder_;
  bool triggered_ = false;
  Writing writing_;
  std::vector<std::filesystem::path> files_;
  std::optional<Error> problem_;
};

}  // namespace driveline::runtime
