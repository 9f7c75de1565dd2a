#pragma once

#include <optional>
#include <string>
#include <vector>

#include "session.hpp"

namespace driveline::cli {

/// What `run` was asked for beside the bus.
struct RunOptions {
  std::optional<double> duration_s;
  std::string output_directory;  ///< empty: as configured
  std::string capture;           ///< empty: as configured
  bool no_plots = false;
  bool no_telemetry = false;
  bool json = false;
};

/// An object of a slave, and how its value is to be read or written.
struct ObjectOptions {
  std::size_t slave = 0;
  std::string index;
  std::string subindex = "0";
  std::string type;   ///< empty: raw bytes
  std::string value;  ///< download only
  bool json = false;
};

// Each returns the exit status 0, or a Failure with 1 or 2 (docs/command_line.md).
[[nodiscard]] Outcome<int> run_line(const BusOptions& bus, const RunOptions& options);
[[nodiscard]] Outcome<int> simulate(const BusOptions& bus);
[[nodiscard]] Outcome<int> list_slaves(const BusOptions& bus, bool json);
[[nodiscard]] Outcome<int> states(const BusOptions& bus, const std::string& wanted, bool json);
[[nodiscard]] Outcome<int> upload(const BusOptions& bus, const ObjectOptions& options);
[[nodiscard]] Outcome<int> download(const BusOptions& bus, const ObjectOptions& options);
// The ESI commands work on files, not on a bus.
[[nodiscard]] Outcome<int> generate_esi(const std::string& directory);
[[nodiscard]] Outcome<int> validate_esi(const std::string& name);
[[nodiscard]] Outcome<int> show_esi(const std::string& name);

}  // namespace driveline::cli
