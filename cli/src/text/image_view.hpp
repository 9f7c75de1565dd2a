#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "line/group_watch.hpp"
#include "line/process_data_plan.hpp"
#include "line/wire_budget.hpp"

namespace driveline::cli {

/// How a group of the process image is laid out, and how it did while the cycle ran.
struct GroupView {
  std::string name;
  ecat_master::GroupSettings settings;
  std::size_t slaves = 0;
  std::size_t datagrams = 0;
  std::vector<std::size_t> frames;  ///< by number
  unsigned working_counter = 0;     ///< expected
  std::uint64_t exchanges = 0;
  std::uint64_t lost_frames = 0;
  std::uint64_t wkc_errors = 0;
  std::uint32_t longest_bad = 0;  ///< exchanges in a row that were not whole
  std::uint64_t zeroings = 0;     ///< how often the outputs were zeroed
};

/// The process image as a whole.
struct ImageView {
  std::string layout;
  std::size_t bytes = 0;
  std::size_t datagrams = 0;
  std::size_t frames = 0;
  WireBudget wire;
  std::vector<GroupView> groups;
};

/// After Master::configure(); the counters of the groups while the cycle runs and after.
[[nodiscard]] ImageView view_image(const LineConfig& config, const ecat_master::Master& master,
                                   std::span<const ecat_master::GroupCounters> counters = {},
                                   const GroupWatch* watch = nullptr);

/// A line on layout and wire time, and one for each group.
[[nodiscard]] std::string to_text(const ImageView& view);
[[nodiscard]] nlohmann::json to_json(const ImageView& view);

/// Everything about the image of a configured line: slaves with their logical addresses, entries with their names,
/// groups, datagrams with their working counters, copies, wire time.
[[nodiscard]] std::string image_text(const LineConfig& config, const ecat_master::Master& master,
                                     const NamedProcessData& named);
[[nodiscard]] nlohmann::json image_json(const LineConfig& config, const ecat_master::Master& master,
                                        const NamedProcessData& named);

}  // namespace driveline::cli
