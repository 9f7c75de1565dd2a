#pragma once

#include <string>
#include <vector>

#include "driveline/ecat_master/cyclic/cyclic_core.hpp"
#include "driveline/runtime/record/exchange_group_watch.hpp"
#include "driveline/runtime/setup/process_data_plan.hpp"
#include "driveline/runtime/setup/wire_budget.hpp"

namespace driveline::runtime {

/// Layout of a group of the process image, and its counters.
struct ExchangeGroupView {
  std::string name;
  ecat_master::ExchangeGroupSettings settings;
  std::size_t slaves = 0;
  std::size_t datagrams = 0;
  std::vector<std::size_t> frames;  ///< numbers of its frames
  unsigned working_counter = 0;     ///< expected working counter
  std::uint64_t exchanges = 0;
  std::uint64_t lost_frames = 0;
  std::uint64_t wkc_errors = 0;
  std::uint32_t longest_bad = 0;  ///< most consecutive incomplete exchanges
  std::uint64_t zeroings = 0;     ///< number of times the outputs were zeroed
};

/// The process image as a whole.
struct ImageView {
  std::string layout;
  std::size_t bytes = 0;
  std::size_t datagrams = 0;
  std::size_t frames = 0;
  WireBudget wire;
  std::vector<ExchangeGroupView> groups;
};

/// Returns the name of a group by its number; "line" if the description has none.
[[nodiscard]] std::string group_name(const LineConfig& config, std::size_t group);

/// Call after Master::configure(). The counters of the groups are valid while the cycle runs and afterwards.
[[nodiscard]] ImageView view_image(const LineConfig& config, const ecat_master::Master& master,
                                   std::span<const ecat_master::ExchangeGroupCounters> counters = {},
                                   const ExchangeGroupWatch* watch = nullptr);

}  // namespace driveline::runtime
