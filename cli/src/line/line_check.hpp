#pragma once

#include <nlohmann/json.hpp>

#include "line/line_view.hpp"

namespace driveline::cli {

/// Problems of a line beside its states and cables: unusable EEPROMs, duplicate aliases, differences from its
/// description.
struct LineCheck {
  std::vector<ecat_master::ExpectedSlave> planned;  ///< of the description; empty: there is none
  std::vector<ecat_master::SlaveInfo> found;
  ecat_master::LineComparison comparison;
  std::string not_compared;  ///< why nothing was compared with the description; empty: it was, or there is none

  /// Everything, one sentence each.
  [[nodiscard]] std::vector<std::string> sentences() const;
};

/// Compares the line with its description, when the bus options named one. `slaves` are all slaves of the line. Device
/// IDs are read where the description needs them and no master operates the line.
[[nodiscard]] Outcome<LineCheck> check_line(LineView& line, std::span<const SlaveView> slaves);

/// Adds `duplicate_aliases` and, when there is a description, `differences` to the document of a tool.
void add_json(nlohmann::json& document, const LineCheck& check);

}  // namespace driveline::cli
