#pragma once

#include <stdexcept>
#include <string>

namespace driveline::bench {

/// The command line of every program here.
struct Options {
  bool json = false;      ///< one JSON document instead of a table
  bool quick = false;     ///< a tenth of the measurements: to see that it works
  std::string figures;    ///< folder for the curves behind the pictures of the documents, instead of a report
  double duration_s = 0;  ///< how long each way is measured; 0: as the program likes (jitter)
  std::string histogram;  ///< file that the measured histogram is written to
  /// Scales a number of measurements.
  [[nodiscard]] int count(int full) const noexcept { return quick ? full / 10 : full; }
};

/// Exit status of a program that cannot measure everything here; ctest takes it for "skipped".
constexpr int kSkippedStatus = 77;

/// The machine lacks something the measurement needs. Thrown after the report of what could be measured.
struct Skipped : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Runs the program: reads the command line, calls `measure` with it and turns what that throws into a sentence on
/// stderr. Returns the exit status: 0 done, 1 failed, 2 bad usage, kSkippedStatus.
int run(int argc, char** argv, const char* question, void (*measure)(const Options& options));

}  // namespace driveline::bench
