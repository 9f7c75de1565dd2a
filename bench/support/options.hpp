#pragma once

#include <stdexcept>
#include <string>

namespace driveline::bench {

/// The command line of every benchmark.
struct Options {
  bool json = false;      ///< one JSON document instead of a table
  bool quick = false;     ///< a tenth of the measurements: for checking that the program works
  bool shorter = false;   ///< fewer measurements, mostly a third: a report of all programs takes ten minutes at most
  std::string figures;    ///< folder for the curves behind the pictures of the documents, instead of a report
  double duration_s = 0;  ///< duration of each method; 0: default of the program (jitter, soak)
  std::string histogram;  ///< file for the measured histogram
  /// Scales a number of measurements.
  [[nodiscard]] int count(int full) const noexcept { return quick ? full / 10 : shorter ? full / 3 : full; }
  /// Duration of the measurement in s: as requested, else `full`, `in_short` or a tenth of that.
  [[nodiscard]] double duration(double full, double in_short) const noexcept {
    if (duration_s > 0.0) return duration_s;
    return quick ? in_short / 10 : shorter ? in_short : full;
  }
};

/// Exit status of a program that cannot measure everything here; ctest takes it for "skipped".
constexpr int kSkippedStatus = 77;

/// The machine lacks something that the measurement needs. Thrown after the report of the other measurements.
struct Skipped : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Exit status of a program whose measurement was disturbed by the machine in each attempt (EX_TEMPFAIL of sysexits.h).
constexpr int kDisturbedStatus = 75;

/// Runs the program: reads the command line, calls `measure` with it and turns its exceptions into a sentence on
/// stderr. Returns the exit status: 0 done, 1 failed, 2 bad usage, kDisturbedStatus,
/// kSkippedStatus.
int run(int argc, char** argv, const char* question, void (*measure)(const Options& options));

}  // namespace driveline::bench
