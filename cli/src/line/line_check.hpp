#pragma once

#include <nlohmann/json.hpp>

#include "line/line_view.hpp"

namespace driveline::cli {

/// Problems of a line other than states and cables: unusable EEPROMs, duplicate aliases, differences from its
/// description.
struct LineCheck {
  std::vector<ecat_master::ExpectedSlave> planned;  ///< slaves of the description; empty: there is no description
  std::vector<ecat_master::SlaveInfo> found;
  ecat_master::LineComparison comparison;
  std::string not_compared;  ///< why the line was not compared with the description; empty: it was, or there is none

  /// All problems, one sentence each.
  [[nodiscard]] std::vector<std::string> sentences() const;
};

/// Compares the line with its description, if the bus options name one. `slaves` are all slaves of the line. Device IDs
/// are read if the description needs them and no master operates the line.
[[nodiscard]] Outcome<LineCheck> check_line(LineView& line, std::span<const SlaveView> slaves);

/// Adds `duplicate_aliases` and, if there is a description, `differences` to the JSON document of a command.
void add_json(nlohmann::json& document, const LineCheck& check);

}  // namespace driveline::cli
