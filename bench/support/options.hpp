#pragma once

#include <string>

namespace driveline::bench {

/// The command line of every program here.
struct Options {
  bool json = false;      ///< one JSON document instead of a table
  bool quick = false;     ///< a tenth of the measurements: to see that it works
  std::string figures;    ///< folder for the curves behind the pictures of the documents, instead of a report
  std::string histogram;  ///< file that the measured histogram is written to
  /// Scales a number of measurements.
  [[nodiscard]] int count(int full) const noexcept { return quick ? full / 10 : full; }
};

/// Parses the command line, runs `measure` with it and turns what it throws into a sentence on stderr. Returns the exit
/// status: 0 done, 1 failed, 2 bad usage.
int run(int argc, char** argv, const char* question, void (*measure)(const Options& options));

}  // namespace driveline::bench
