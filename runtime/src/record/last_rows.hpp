#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <ostream>
#include <string_view>
#include <system_error>
#include <utility>

#include "files/spool_file.hpp"

namespace driveline::runtime {

/// The last rows of a file of any length: its newest rows are stored in several temporary files, of which the oldest is
/// dropped when the newest is full.
class LastRows {
 public:
  /// Number of files; all but one are complete when an old one is dropped.
  static constexpr std::uint64_t kParts = 4;

  /// Stores the last `most` rows, and at least 3/4 of them; `most`: a multiple of kParts. `folder`: place of the
  /// temporary files.
  LastRows(std::filesystem::path folder, std::uint64_t most) : folder_(std::move(folder)), part_(most / kParts) {}

  /// Adds a row, which ends with a line feed, and its time.
  void add(double time_s, std::string_view row);
  /// Returns the number of stored rows.
  [[nodiscard]] std::uint64_t rows() const noexcept { return rows_; }
  /// Returns the time of the first stored row if earlier rows were dropped.
  [[nodiscard]] std::optional<double> begins_at_s() const noexcept;
  /// Writes the stored rows. Error: they could not be stored, or not be read.
  [[nodiscard]] std::error_code write_to(std::ostream& to);

 private:
  struct Part {
    Part(const std::filesystem::path& folder, double begin) : file(folder), begin_s(begin) {}
    SpoolFile file;
    double begin_s;
    std::uint64_t rows = 0;
  };

  std::filesystem::path folder_;
  std::uint64_t part_;
  std::deque<Part> parts_;
  std::uint64_t rows_ = 0;
  bool dropped_ = false;
};

}  // namespace driveline::runtime
